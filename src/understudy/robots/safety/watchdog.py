"""The watchdog: a small process of its own, which stops a robot when the program that decides is killed or frozen.

It hears over a pipe, each few hundredths of a second, that the program is well, and whether the robot may move. When
nothing comes for too long, or the pipe closes without a good-bye, it sends stop itself, again and again, since a
message may get lost. Whatever it does for a frozen program it says when that goes on.
"""

from __future__ import annotations

import contextlib
import os
import select
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import msgspec

from understudy.robots.robot_file import RobotFile
from understudy.robots.ros.open_transport import open_transport
from understudy.robots.ros.transport import Publisher, Transport
from understudy.robots.safety.emergency_stop import make_stop_sender
from understudy.robots.safety.stop_log import append_stop, make_stop_event

ANEW, MOVING, RESTING, BYE = b"*", b"+", b"-", b"."
"""What it is told: the robot may move anew, since it was armed, or stopped by the program itself after that had been
frozen; it may move; it is disarmed; the program ends as it should."""
WELL, STOPPED = b"+", b"!"
"""What it answers to each word: all was well, or that it has sent stop since the last one."""
READY = b"ready"
PERIOD_S = 0.02
"""From one stop to the next."""
LASTING_S = 1.0
"""For so long it sends stop after the program is gone, or goes on."""
DISCOVERY_S = 5.0
"""For so long it may look for the robot."""
SETTLING_S = 0.1
"""From seeing who publishes to be sure that who listens was seen, too."""
PRIORITY = -10

Hear: TypeAlias = Callable[[float | None], bytes | None]
"""Waits so long (s; None: for ever) for words; b"" when there will be none any more, None when nothing came."""


class WatchdogConfig(msgspec.Struct, frozen=True, kw_only=True):
    """What it has to know: the robot, where to log stops, and who it must have discovered before it is ready."""

    file: RobotFile
    log: str
    peers: tuple[Publisher, ...]


Answer: TypeAlias = Callable[[bytes], None]


def watch_heartbeats(
    hear: Hear,
    answer: Answer,
    stop: Callable[[], None],
    log: Callable[[str], None],
    *,
    deadline_s: float,
    clock: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> None:
    """Wait for words, until good-bye or the end; `stop` where none comes in time while the robot may move."""
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
            if ANEW in words:
                until = 0.0
            moving = words.endswith((ANEW, MOVING))
        elif moving and not stopping:
            frozen = True
        if frozen or clock() < until:
            stop()
        if frozen and not stopping:
            log(f"no sign for {deadline_s:g} s of the program that decides")
    if moving:
        stop()  # before anything else
        log("the program that decides ended without a word")
        until = clock() + LASTING_S
    while clock() < until:
        stop()
        sleep(PERIOD_S)


def run_watchdog_process() -> None:
    """The process: orders come as a line of JSON, then words; both on standard input, answers on standard output."""
    with contextlib.suppress(OSError, AttributeError):
        os.setpriority(
            os.PRIO_PROCESS, 0, PRIORITY
        )  # where it may: it has next to nothing to do, but at once
    try:
        orders = msgspec.json.decode(_orders(), type=WatchdogConfig)
        transport = open_transport(orders.file)
    except Exception as error:  # whatever it is, somebody waits for a word of it
        _answer(str(error).encode() + b"\n")
        return
    try:
        _watch(orders, transport)
    finally:
        transport.close()


def _watch(orders: WatchdogConfig, transport: Transport) -> None:
    file = orders.file
    send = make_stop_sender(file, transport)

    def stop() -> None:
        with contextlib.suppress(Exception):  # the next one may get through
            send()

    def log(cause: str) -> None:
        with contextlib.suppress(OSError):
            append_stop(Path(orders.log), make_stop_event(file.name, cause, "watchdog"))

    until = time.monotonic() + DISCOVERY_S
    while missing := set(orders.peers) - set(transport.peers()):
        if time.monotonic() > until:
            _answer(f"it does not find who publishes on {min(missing).topic}\n".encode())
            return
        time.sleep(PERIOD_S)
    time.sleep(SETTLING_S)
    stop()  # what it does first must not be its first time
    _answer(READY + b"\n")
    watch_heartbeats(_hear, _answer, stop, log, deadline_s=file.safety.deadline_s)


def _orders() -> bytes:
    line = b""
    while not line.endswith(b"\n"):
        byte = os.read(0, 1)
        if not byte:
            raise EOFError("it was given no orders")
        line += byte
    return line


def _hear(wait_s: float | None) -> bytes | None:
    # Asked again after waiting in vain: who did not get the processor for a while must not blame others.
    if select.select([0], [], [], wait_s)[0] or select.select([0], [], [], 0.0)[0]:
        return os.read(0, 4096)
    return None


def _answer(words: bytes) -> None:
    with contextlib.suppress(OSError):  # nobody there any more
        os.write(1, words)


if __name__ == "__main__":
    run_watchdog_process()
