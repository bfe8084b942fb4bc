"""The log of stops: when each robot stopped by itself or was told to, and why, a line of JSON each.

The program that decides and its watchdog write to one file, each line whole: the end may be written by who survives.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from understudy.errors import FileError
from understudy.robots.robot_file import RobotFile

ENDING = ".stops.jsonl"


class StopEvent(msgspec.Struct, frozen=True, kw_only=True):
    """A stop: when, of which robot, for what cause, and who stopped it: the guard, the watchdog or a person."""

    time: datetime
    robot: str
    cause: str
    by: str


def make_stop_event(robot: str, cause: str, by: str) -> StopEvent:
    """A stop of this moment."""
    return StopEvent(time=datetime.now(UTC), robot=robot, cause=cause, by=by)


def find_stop_log(file: RobotFile, path: Path | str) -> Path:
    """Where the stops of a robot are written: the `log` of its file, beside it, or the file's name with an ending."""
    path = Path(path)
    return path.with_suffix(ENDING) if file.safety.log is None else path.parent / file.safety.log


def append_stop(path: Path, stop: StopEvent | None = None) -> None:
    """Write a stop at the end of a log, in one piece; without one, only see that it can be. OSError where it cannot."""
    line = b"" if stop is None else msgspec.json.encode(stop) + b"\n"
    log = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    try:
        if line:
            os.write(log, line)
    finally:
        os.close(log)


class StopLog:
    """The stops of one robot since it was connected, in memory and in a file if there is one."""

    def __init__(self, robot: str, path: Path | None = None) -> None:
        self._robot, self._path = robot, path
        self.stops: list[StopEvent] = []
        """Oldest first."""

    def begin(self) -> None:
        """See that it can be written; FileError where it cannot."""
        if self._path is not None:
            try:
                append_stop(self._path)
            except OSError as error:
                problem = f"cannot be written ({error.strerror}), and stops of {self._robot} are logged there"
                raise FileError(path=self._path, place="", problem=problem, remedy="correct that") from None

    def add(self, cause: str, by: str) -> None:
        """A stop of this moment; a full disk must not keep anything from stopping."""
        stop = make_stop_event(self._robot, cause, by)
        self.stops.append(stop)
        if self._path is not None:
            with contextlib.suppress(OSError):
                append_stop(self._path, stop)


def read_stops(path: Path) -> Sequence[StopEvent]:
    """All stops of a log, oldest first; none where there is no log yet. FileError where a line is no stop."""
    try:
        lines = path.read_bytes().splitlines()
    except FileNotFoundError:
        return ()
    stops = []
    for number, line in enumerate(lines, 1):
        try:
            stops.append(msgspec.json.decode(line, type=StopEvent))
        except msgspec.DecodeError as error:
            place, problem = f"line {number}", f"is no stop ({error})"
            raise FileError(path=path, place=place, problem=problem, remedy="remove that line") from None
    return tuple(stops)
