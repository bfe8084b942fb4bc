"""The log of stops: when each robot was stopped, why and by whom, as lines of JSON (`understudy robots stops`).

The driving program, its watchdog and `robots stop` append to one file, each line in a single write, so that the log
is complete even if one of them is killed. Times are of day, in UTC: only here, and only for people; after the clock
was set, lines need not be in order of time.

Logging never prevents a stop: it comes after the first stop was sent, and errors are ignored then. A write that
blocks does delay the stops after it, in the guard and in the watchdog: keep the log on a local disk.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import msgspec

from understudy.addons.robots.robot_file import RobotFile
from understudy.errors import FileError
from understudy.storage.json_text import convert_decode_errors, encode_json

ENDING = ".stops.jsonl"


class StopEvent(msgspec.Struct, frozen=True, kw_only=True):
    """A stop: its time (UTC), the robot, the cause, and the person or program that stopped it.

    `by` is "guard", "watchdog", "program" (which called `disarm`, `emergency_stop` or `close`), or the command that a
    person used, "robots stop".
    """

    time: datetime
    robot: str
    cause: str
    by: str


def make_stop_event(robot: str, cause: str, by: str) -> StopEvent:
    """Make the record of a stop that happens now."""
    return StopEvent(time=datetime.now(UTC), robot=robot, cause=cause, by=by)


def find_stop_log(file: RobotFile, path: Path | str) -> Path:
    """Return the path of a robot's log: `safety.log` relative to its file, or the file's name with ENDING."""
    path = Path(path)
    return path.with_suffix(ENDING) if file.safety.log is None else path.parent / file.safety.log


def append_stop(path: Path | str, stop: StopEvent | None = None) -> None:
    """Append a stop to a log in one write; without a stop, only test whether the log can be opened.

    OSError is raised if it cannot.
    """
    line = b"" if stop is None else encode_json(stop) + b"\n"
    log = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    try:
        if line:
            os.write(log, line)
    finally:
        os.close(log)


class StopLog:
    """The stops of one robot since it was connected, in memory and in a file if there is one."""

    def __init__(self, robot: str, path: Path | str | None = None) -> None:
        self._robot, self._path = robot, path
        self.stops: list[StopEvent] = []
        """The stops, oldest first."""

    def begin(self) -> None:
        """Test before arming whether the file can be written; raise FileError if it cannot."""
        if self._path is not None:
            try:
                append_stop(self._path)
            except OSError as error:
                problem = f"cannot be written ({error.strerror}), but it is the log of stops of {self._robot}"
                raise FileError(path=self._path, place="", problem=problem, remedy="correct that") from None

    def add(self, cause: str, by: str) -> None:
        """Record a stop that happens now, after it was sent; ignore a file that cannot be written."""
        stop = make_stop_event(self._robot, cause, by)
        self.stops.append(stop)
        if self._path is not None:
            with contextlib.suppress(OSError):
                append_stop(self._path, stop)


def read_stops(path: Path | str) -> Sequence[StopEvent]:
    """Read the stops of a log; return none if there is no log, and raise FileError if a line is no stop."""
    try:
        lines = Path(path).read_bytes().splitlines()
    except FileNotFoundError:
        return ()
    stops = []
    for number, line in enumerate(lines, 1):
        try:
            with convert_decode_errors():
                stops.append(msgspec.json.decode(line, type=StopEvent))
        except msgspec.DecodeError as error:
            place, problem = f"line {number}", f"is not an entry of a log of stops ({error})"
            raise FileError(path=path, place=place, problem=problem, remedy="remove that line") from None
    return tuple(stops)
