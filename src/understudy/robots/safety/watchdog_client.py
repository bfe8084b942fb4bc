"""Our end of the watchdog: it is started here, told that all is well, and missed when it is gone."""

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

import msgspec

from understudy.errors import UnderstudyError
from understudy.robots.robot_file import RobotFile
from understudy.robots.ros.transport import Publisher
from understudy.robots.safety.watchdog import BYE, READY, RESTING, STOPPED, WatchdogConfig

STARTING_S = 15.0
"""For so long it may take to start, on a machine that is very busy."""
ANSWER_S = 0.5
"""A watchdog that does not answer for so long is none."""
ASKING_S = 0.005
LEAVING_S = 3.0
"""For so long it may take to end, which it does after it sent stop for a while."""


class WatchdogFailed(UnderstudyError, json_type="WatchdogFailed"):
    """The watchdog cannot be started."""

    def __init__(self, *, robot: str, problem: str) -> None:
        self.robot, self.problem = robot, problem
        super().__init__(
            f"robot {robot!r} stays disarmed: its watchdog did not start ({problem}); correct that, and arm again"
        )


class WatchdogClient:
    """The watchdog of one robot, started when it is first needed, and again where it is gone."""

    def __init__(self, file: RobotFile, *, log: Path) -> None:
        self._file, self._log = file, log
        self._process: subprocess.Popen[bytes] | None = None
        self._owner = 0
        self._answered_s, self._stopped = 0.0, False
        self._lock = Lock()

    _leaving: Thread | None = None
    """Sees one off that was dropped."""

    @property
    def alive(self) -> bool:
        """Whether it is there."""
        return self._process is not None and self._process.poll() is None

    @property
    def count(self) -> int:
        """How many are connected to the robot: one that was dropped still is for a while."""
        leaving = self._leaving is not None and self._leaving.is_alive()
        return int(self.alive) + int(leaving)

    @property
    def pid(self) -> int:
        """The number of its process; 0 where there is none."""
        return 0 if self._process is None else self._process.pid

    def start(self, peers: Sequence[Publisher]) -> None:
        """Start it unless it is there and answers, and wait until it has found these others; WatchdogFailed where it
        does not.
        """
        with self._lock:
            if self.alive and self._answers():
                return
            self._end()
            self._see_off()
            try:
                process = subprocess.Popen(
                    [sys.executable, "-P", "-m", "understudy.robots.safety.watchdog"],
                    env={**os.environ, "PYTHONPATH": _path()},
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.DEVNULL,
                    bufsize=0,  # what it says is read as it comes
                    start_new_session=True,  # the terminal's Ctrl-C is not meant for it
                )
            except OSError as error:
                raise WatchdogFailed(robot=self._file.name, problem=str(error)) from None
            orders = WatchdogConfig(file=self._file, log=str(self._log.absolute()), peers=tuple(set(peers)))
            try:
                _tell(process, msgspec.json.encode(orders) + b"\n")
                said = _line(process, STARTING_S)
            except OSError as error:
                said = str(error).encode()
            if said != READY:
                process.kill()
                process.communicate()
                problem = said.decode(errors="replace") or "it ended, or took too long"
                raise WatchdogFailed(robot=self._file.name, problem=problem)
            for end in (process.stdin, process.stdout):
                if end is not None:
                    os.set_blocking(end.fileno(), False)
            self._answered_s = time.monotonic()
            self._process, self._owner = process, os.getpid()

    def _answers(self) -> bool:
        """Whether it says anything, asked while the robot is disarmed."""
        asked_s = time.monotonic()
        while time.monotonic() - asked_s < ANSWER_S:
            self.send(RESTING)
            self.problem()
            if self._answered_s > asked_s:
                return True
            time.sleep(ASKING_S)
        return False

    def send(self, words: bytes) -> None:
        """All is well: ANEW, MOVING or RESTING."""
        if self._process is not None:
            with contextlib.suppress(OSError):  # `problem` tells of it
                _tell(self._process, words)

    def begin(self) -> None:
        """Forget what it said until now, or did not say: nobody spoke to it."""
        self.problem()
        self.poll_intervention()
        self._answered_s = time.monotonic()

    def problem(self) -> str:
        """Why it cannot be relied on; empty where all is well. Takes in what it answered."""
        process = self._process
        if process is None or process.stdout is None:
            return "there is no watchdog"
        now = time.monotonic()
        try:
            said = os.read(process.stdout.fileno(), 4096)
        except BlockingIOError:
            if now - self._answered_s > ANSWER_S:
                return "the watchdog does not answer"
            return ""
        except OSError:
            said = b""
        if not said:
            return "the watchdog died"
        self._answered_s = now
        self._stopped = self._stopped or STOPPED in said
        return ""

    def poll_intervention(self) -> bool:
        """Whether it said that it had to stop the robot, since this was asked last."""
        stopped, self._stopped = self._stopped, False
        return stopped

    def shut_down(self) -> None:
        """Say good-bye, and wait until it is gone."""
        process = self._process
        if self._owner == os.getpid():  # not: a fork of the program that decides
            if process is not None:
                with contextlib.suppress(OSError, ValueError):  # ValueError: somebody else said it just now
                    _tell(process, BYE)
            self._end()
            self._see_off()

    def abandon(self) -> None:
        """Leave without a good-bye: it stops the robot. Does not wait for that: whoever drops it may hold up others."""
        process, self._process = self._process, None
        if process is not None:
            _let_go(process)
            leaving = Thread(target=_wait_for, args=(process,), name="leash", daemon=True)
            try:
                leaving.start()
            except RuntimeError:  # at its very end a program has no new threads
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
    """Where this program finds modules, for another to find the same, whatever lies in its folder."""
    return os.pathsep.join(str(Path(each).absolute()) for each in sys.path)


def _tell(process: subprocess.Popen[bytes], words: bytes) -> None:
    if process.stdin is not None:
        os.write(process.stdin.fileno(), words)


def _line(process: subprocess.Popen[bytes], wait_s: float) -> bytes:
    """The next line, without its end; what came of it where it ends or takes too long."""
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
