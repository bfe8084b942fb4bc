"""Client of a robot's watchdog process, which starts it, sends heartbeats, and detects its failures.

The pipes to the process do not block, once it is ready: heartbeats that a hanging watchdog does not read are dropped,
and `problem` reports it after `ANSWER_S`. The only thread here waits for the end of a watchdog that was abandoned.
Intervals are of a clock. Waiting for a process to start or to end takes real time.
"""

from __future__ import annotations

import contextlib
import os
import select
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from threading import Lock, Thread

from understudy.addons.robots.robot_file import RobotFile
from understudy.addons.robots.ros.transport import Publisher
from understudy.addons.robots.safety.watchdog import BYE, READY, RESTING, STOPPED, WatchdogConfig
from understudy.clock import REAL_TIME, Clock
from understudy.errors import UnderstudyError
from understudy.storage.json_text import encode_json

STARTING_S = 15.0
"""Longest time for starting, s, chosen for very busy computers; then WatchdogFailed is raised."""
ANSWER_S = 0.5
"""Time without an answer to heartbeats after which a watchdog counts as gone, s."""
ASKING_S = 0.005
"""Time between two heartbeats that test whether a watchdog still answers, before it is used again, s."""
LEAVING_S = 3.0
"""Longest time for the process to end, s, up to 1 s of which it sends stops; then it is killed."""


class WatchdogFailed(UnderstudyError, json_type="WatchdogFailed"):
    """A watchdog that cannot be started; the robot stays disarmed."""

    def __init__(self, *, robot: str, problem: str) -> None:
        self.robot, self.problem = robot, problem
        super().__init__(
            f"robot {robot!r} stays disarmed: its watchdog did not start ({problem}); correct that, and arm again"
        )


class WatchdogClient:
    """A client of the watchdog process of one robot.

    The process is started when first needed, and again if it ended or hangs. `start` and `shut_down` block, and are
    called without the guard's lock; everything else returns at once, and is called with it while the robot is armed.
    """

    def __init__(self, file: RobotFile, *, log: Path | str, clock: Clock = REAL_TIME) -> None:
        self._file, self._log, self._clock = file, Path(log), clock
        self._process: subprocess.Popen[bytes] | None = None
        self._owner = 0
        self._answered_s, self._stopped = 0.0, False
        self._lock = Lock()

    _leaving: Thread | None = None
    """The thread that waits for the end of a process that was abandoned."""

    @property
    def alive(self) -> bool:
        """True if the process runs; it may hang nevertheless."""
        return self._process is not None and self._process.poll() is None

    @property
    def count(self) -> int:
        """The number of processes that may be connected to the robot.

        One that was abandoned counts until it ends.
        """
        leaving = self._leaving is not None and self._leaving.is_alive()
        return int(self.alive) + int(leaving)

    @property
    def pid(self) -> int:
        """The id of the process; 0 if there is none."""
        return 0 if self._process is None else self._process.pid

    def start(self, peers: Sequence[Publisher]) -> None:
        """Start the process unless it runs and answers; block until it has discovered these publishers, about 0.5 s.

        WatchdogFailed is raised if it does not start, or does not discover them within `watchdog.DISCOVERY_S` (5 s).
        """
        with self._lock:
            if self.alive and self._answers():
                return
            self._end()
            self._see_off()
            try:
                process = subprocess.Popen(
                    [sys.executable, "-P", "-m", "understudy.addons.robots.safety.watchdog"],
                    env={**os.environ, "PYTHONPATH": _path()},
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.DEVNULL,
                    bufsize=0,  # answers are read as they come
                    start_new_session=True,  # the terminal's Ctrl-C is not meant for it
                )
            except OSError as error:
                raise WatchdogFailed(robot=self._file.name, problem=str(error)) from None
            orders = WatchdogConfig(file=self._file, log=str(self._log.absolute()), peers=tuple(set(peers)))
            try:
                _tell(process, encode_json(orders) + b"\n")
                answer = _line(process, STARTING_S)
            except OSError as error:
                answer = str(error).encode()
            if answer != READY:
                process.kill()
                process.communicate()
                problem = answer.decode(errors="replace") or "it ended, or took too long"
                raise WatchdogFailed(robot=self._file.name, problem=problem)
            for end in (process.stdin, process.stdout):
                if end is not None:
                    os.set_blocking(end.fileno(), False)
            self._answered_s = self._clock()
            self._process, self._owner = process, os.getpid()

    def _answers(self) -> bool:
        """Return whether it answers heartbeats, trying for up to ANSWER_S; the robot has to be disarmed."""
        asked_s = self._clock()
        while self._clock() - asked_s < ANSWER_S:
            self.send(RESTING)
            self.problem()
            if self._answered_s > asked_s:
                return True
            self._clock.sleep(ASKING_S)
        return False

    def send(self, words: bytes) -> None:
        """Send a heartbeat: TAKEN_OVER, MOVING or RESTING.

        It never blocks or raises; the heartbeat is dropped if the pipe is full or closed.
        """
        if self._process is not None:
            with contextlib.suppress(OSError):  # `problem` reports it
                _tell(self._process, words)

    def begin(self) -> None:
        """Discard earlier answers, and expect new ones from now on, because heartbeats were not regular before."""
        self.problem()
        self.poll_intervention()
        self._answered_s = self._clock()

    def problem(self) -> str:
        """Read the answers, without blocking; return why the watchdog cannot be relied on, or an empty text."""
        process = self._process
        if process is None or process.stdout is None:
            return "there is no watchdog"
        now = self._clock()
        try:
            answers = os.read(process.stdout.fileno(), 4096)
        except BlockingIOError:
            if now - self._answered_s > ANSWER_S:
                return "the watchdog does not answer"
            return ""
        except OSError:
            answers = b""
        if not answers:
            return "the watchdog died"
        self._answered_s = now
        self._stopped = self._stopped or STOPPED in answers
        return ""

    def poll_intervention(self) -> bool:
        """Return whether the watchdog had to send stops, by the answers that `problem` has read since the last call."""
        stopped, self._stopped = self._stopped, False
        return stopped

    def shut_down(self) -> None:
        """Say goodbye, and wait for the process to end without sending stops; kill it after LEAVING_S.

        In a process that was forked from the one that started it, nothing happens.
        """
        process = self._process
        if self._owner == os.getpid():
            if process is not None:
                with contextlib.suppress(OSError, ValueError):  # ValueError: a thread closed it just now
                    _tell(process, BYE)
            self._end()
            self._see_off()

    def close_without_goodbye(self) -> None:
        """Close the pipes without a goodbye, so that the watchdog stops a robot that may be moving, and ends.

        A thread waits for its end, because the caller holds the guard's lock.
        """
        process, self._process = self._process, None
        if process is not None:
            _let_go(process)
            leaving = Thread(target=_wait_for, args=(process,), name="watchdog", daemon=True)
            try:
                leaving.start()
            except RuntimeError:  # no thread can be started while the interpreter shuts down
                _wait_for(process)
            else:
                self._leaving = leaving

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            _let_go(process)
            _wait_for(process)

    def _see_off(self) -> None:
        if self._leaving is not None:
            self._leaving.join()


def _let_go(process: subprocess.Popen[bytes]) -> None:
    for end in (process.stdin, process.stdout):
        if end is not None:
            end.close()


def _wait_for(process: subprocess.Popen[bytes]) -> None:
    try:
        process.wait(LEAVING_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _path() -> str:
    """Return this program's module search path, made absolute so that the watchdog imports the same modules."""
    return os.pathsep.join(str(Path(each).absolute()) for each in sys.path)


def _tell(process: subprocess.Popen[bytes], words: bytes) -> None:
    if process.stdin is not None:
        os.write(process.stdin.fileno(), words)


def _line(process: subprocess.Popen[bytes], wait_s: float) -> bytes:
    """Read the next line without its newline, or what has come if the pipe closes or `wait_s` (s) has passed."""
    line, until = b"", time.monotonic() + wait_s
    if process.stdout is None:
        return line
    while not line.endswith(b"\n"):
        if not select.select([process.stdout], [], [], max(0.0, until - time.monotonic()))[0]:
            break
        byte = os.read(process.stdout.fileno(), 1)
        if not byte:
            break
        line += byte
    return line.strip()
