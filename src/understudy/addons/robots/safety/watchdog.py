"""The watchdog: a process that stops a robot if the program that drives it is killed, crashes or freezes.

There is one watchdog per robot. It has one thread and its own connection to the robot. On standard input it receives
a heartbeat every 20 ms from the guard's thread of the program, which says whether the robot may be moving; it answers
each on standard output.

- While the robot may be moving and no heartbeat came for `deadline_s` (0.12 s unless the robot's file sets another),
  it sends a stop every `PERIOD_S`, and cancels all goals of the robot's skills, until heartbeats come again and
  `LASTING_S` (1 s) more, or until the program reports with a heartbeat that it has taken over (`TAKEN_OVER`). Its
  next answer says that it intervened (`STOPPED`).
- When the pipe closes without a goodbye while the robot may be moving, it sends stops for `LASTING_S` and ends. A
  child that the program forked keeps the pipe open: then the missing heartbeats count, as above.
- While the robot is at rest (`RESTING`), it sends nothing, however long no heartbeat comes.
- When this process ends or hangs, the guard disarms the robot (`WatchdogClient.problem`). Should the program freeze
or
  be killed within the 0.5 s at most until then, only the robot's own command timeout stops it.
- If stops cannot be sent, it keeps trying, silently. If the log of stops cannot be written, it continues without;
  a write that blocks (a network file system) delays the stops after the first.
- Intervals are of `time.monotonic`, so that setting the date has no effect. A suspended computer sends nothing; on
  waking, missing heartbeats count for the time awake only (Linux).

A terminal's Ctrl-C does not reach it, because it is started in a session of its own.
"""

from __future__ import annotations

import contextlib
import os
import select
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import msgspec

from understudy.addons.robots.robot_file import RobotFile
from understudy.addons.robots.ros.open_transport import open_transport
from understudy.addons.robots.ros.transport import Publisher, Transport
from understudy.addons.robots.safety.emergency_stop import make_stop_sender
from understudy.addons.robots.safety.stop_log import append_stop, make_stop_event
from understudy.addons.robots.skills.cancel_all import make_cancel_sender
from understudy.clock import REAL_TIME, Clock

TAKEN_OVER, MOVING, RESTING, BYE = b"*", b"+", b"-", b"."
"""The heartbeats, one byte each.

TAKEN_OVER: the robot may be moving, and stops still being sent have to end, because it was armed just now, or the
program is back and has sent its own command. MOVING: it may be moving. RESTING: it is disarmed, and its stops were
repeated long enough. BYE: the program ends normally.
"""
WELL, STOPPED = b"+", b"!"
"""The answers to heartbeats, one byte each: nothing happened, or stops were sent since the last answer."""
READY = b"ready"
"""The line that reports that the watchdog is connected and has discovered the robot.

Any other line is an error message.
"""
PERIOD_S = 0.02
"""Time between two stops, s."""
LASTING_S = 1.0
"""Duration of repeating stops after the program has ended, or has come back, s, because a message may get lost."""
DISCOVERY_S = 5.0
"""Longest time for discovering the robot's publishers, s; then arming fails."""
SETTLING_S = 0.1
"""Time from having discovered the robot's publishers until its subscriber to commands was, too, s."""
PRIORITY = -10
"""Nice value of this process and of the guard's thread, where the system allows it (root, CAP_SYS_NICE)."""

Hear: TypeAlias = Callable[[float | None], bytes | None]
"""A function that waits for heartbeats, at most for a time (s; None: without limit).

It returns them, b"" if the pipe was closed, or None if none came.
"""


class WatchdogConfig(msgspec.Struct, frozen=True, kw_only=True):
    """The configuration of the process: robot, log of stops, and publishers to discover before it is ready."""

    file: RobotFile
    log: str
    peers: tuple[Publisher, ...]


Answer: TypeAlias = Callable[[bytes], None]
"""A function that answers heartbeats with WELL or STOPPED, or reports with READY or an error message."""


def watch_heartbeats(
    hear: Hear,
    answer: Answer,
    stop: Callable[[], None],
    log: Callable[[str], None],
    *,
    deadline_s: float,
    clock: Clock = REAL_TIME,
) -> None:
    """Read heartbeats until the program says goodbye or the pipe closes; send stops if none comes in time.

    Parameters
    ----------
    hear
        Function that waits for heartbeats, at most for a time (s). If several come at once, the last one counts, and
        any TAKEN_OVER.
    answer
        Function that answers heartbeats. It must not raise an exception.
    stop
        Function that sends one stop. It must not raise an exception.
    log
        Function that logs a stop with its cause. It must not raise an exception.
    deadline_s
        Time without heartbeats, s, after which stops are sent if the robot may be moving.
    clock
        Clock of intervals and waits, which `hear` waits by, too.
    """
    moving, frozen, until = False, False, 0.0
    while True:
        stopping = frozen or clock() < until
        words = hear(PERIOD_S if stopping else deadline_s if moving else None)
        if words == b"":
            break
        if words is not None:
            answer(STOPPED if frozen else WELL)
            if frozen:
                frozen, until = False, clock() + LASTING_S
            if words.endswith(BYE):
                return
            if TAKEN_OVER in words:
                until = 0.0
            moving = words.endswith((TAKEN_OVER, MOVING))
        elif moving and not stopping:
            frozen = True
        if frozen or clock() < until:
            stop()
        if frozen and not stopping:
            log(f"no sign for {deadline_s:g} s of the program that decides")
    if moving:
        stop()  # before the log is written, which may take a while
        log("the program that decides ended without a word")
        until = clock() + LASTING_S
    while clock() < until:
        stop()
        clock.sleep(PERIOD_S)


def run_watchdog_process() -> None:
    """Read a WatchdogConfig as a line of JSON, then heartbeats, from standard input; answer on standard output.

    An error before it is ready is reported as a sentence in place of READY, and ends the process.
    """
    with contextlib.suppress(OSError, AttributeError):
        os.setpriority(os.PRIO_PROCESS, 0, PRIORITY)  # it has little to do, but has to do it in time
    try:
        orders = msgspec.json.decode(_orders(), type=WatchdogConfig)
        transport = open_transport(orders.file)
    except Exception as error:  # any error: the program waits for an answer
        _answer(str(error).encode() + b"\n")
        return
    try:
        _watch(orders, transport)
    finally:
        transport.close()


def _watch(orders: WatchdogConfig, transport: Transport, clock: Clock = REAL_TIME) -> None:
    file = orders.file
    send, cancel = make_stop_sender(file, transport), make_cancel_sender(file, transport)

    def stop() -> None:
        with contextlib.suppress(Exception):  # the next one may get through
            send()

    def stop_and_cancel() -> None:
        stop()
        with contextlib.suppress(Exception):
            cancel()

    def log(cause: str) -> None:
        with contextlib.suppress(OSError):
            append_stop(Path(orders.log), make_stop_event(file.name, cause, "watchdog"))

    until = clock() + DISCOVERY_S
    while missing := set(orders.peers) - set(transport.peers()):
        if clock() > until:
            _answer(f"it does not find who publishes on {min(missing).topic}\n".encode())
            return
        clock.sleep(PERIOD_S)
    clock.sleep(SETTLING_S)
    stop()  # now, so that imports and connections that the first message needs delay no later one
    _answer(READY + b"\n")
    watch_heartbeats(_hear, _answer, stop_and_cancel, log, deadline_s=file.safety.deadline_s)


def _orders() -> bytes:
    line = b""
    while not line.endswith(b"\n"):
        byte = os.read(0, 1)
        if not byte:
            raise EOFError("it was given no orders")
        line += byte
    return line


def _hear(wait_s: float | None) -> bytes | None:
    # Looked at again after waiting in vain: heartbeats may have come while this process itself got no processor.
    if select.select([0], [], [], wait_s)[0] or select.select([0], [], [], 0.0)[0]:
        return os.read(0, 4096)
    return None


def _answer(words: bytes) -> None:
    with contextlib.suppress(OSError):  # the program has ended
        os.write(1, words)


if __name__ == "__main__":
    run_watchdog_process()
