"""Connection to real robots, and the recording of what they do."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from itertools import count
from pathlib import Path
from threading import current_thread, main_thread

import typer

from understudy.addons.robots.fleet import connect_robot, connect_team
from understudy.addons.robots.robot_file import is_team_file
from understudy.addons.robots.twin import DigitalTwin
from understudy.errors import SettingError
from understudy.records.recorder import RunRecorder
from understudy.storage.atomic_write import convert_os_errors

SIGNALED = 128
"""Offset of the exit code of a program that was ended by a signal."""
FOLDER = "recordings"
"""Name of the folder for recordings, beside the robot's file."""


def find_robots_file(robot: Path | None, team: Path | None, *, world: str | None) -> Path | None:
    """Return the file of the robot or team that was named, or None.

    Raises SettingError if both are named, or one of them and a world.
    """
    if robot is None and team is None:
        return None
    option = "--robot" if team is None else "--team"
    if robot is not None and team is not None:
        raise SettingError(
            where=option, setting="and --robot", problem="were both given", remedy="give one of them"
        )
    if world is not None:
        problem = f"is named by its file, and {world!r} by the command"
        raise SettingError(where=option, setting="its world", problem=problem, remedy="leave it out here")
    return team or robot


def split_robots_file(file: Path) -> tuple[Path | None, Path | None]:
    """Return a file as that of a robot, or as that of a team."""
    return (None, file) if is_team_file(file) else (file, None)


@contextmanager
def connect_twin(
    robot: Path | None, team: Path | None, *, record: Path | None, recorded: bool
) -> Iterator[DigitalTwin]:
    """Connect to the robots of a file and yield their digital twin; stop and disconnect them at the end.

    If `recorded`, every message is written to `record`, or to a new file beside the robot's file. Decisions are
    included from the call of `DigitalTwin.record` on; without that call, the recording is deleted.
    """
    _see_record(record, recorded=recorded)
    with interrupt_on_termination():
        yield from _twin_of(robot, team, record=record, recorded=recorded)


def _twin_of(
    robot: Path | None, team: Path | None, *, record: Path | None, recorded: bool
) -> Iterator[DigitalTwin]:
    path = team or robot or Path()
    recorder = RunRecorder(record or _place(path)) if recorded and path.is_file() else None
    twin = None
    try:
        with (
            connect_team(team, recorder=recorder)
            if team
            else connect_robot(path, recorder=recorder) as fleet,
        ):
            twin = DigitalTwin(fleet, recorder=recorder)
            yield twin
    finally:
        if recorder is not None:
            recorder.close()
            if twin is not None and twin.is_recording:
                typer.echo(f"Recorded in {recorder.path}", err=True)
            else:
                recorder.path.unlink(missing_ok=True)
                with suppress(OSError):  # others are in it, or it is not ours
                    (path.parent / FOLDER).rmdir()


@contextmanager
def interrupt_on_termination() -> Iterator[None]:
    """Handle SIGTERM and SIGHUP like Ctrl-C, so that robots are stopped and recordings closed.

    SIGINT is handled even if the shell disabled it, as for background jobs; an ignored SIGHUP stays ignored.
    """
    if current_thread() is not main_thread():  # signals are none of its business
        yield
        return
    before = {}
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and not (name == "SIGHUP" and signal.getsignal(number) == signal.SIG_IGN):
            leave = signal.default_int_handler if name == "SIGINT" else _leave
            before[number] = signal.signal(number, leave)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _leave(number: int, _: object) -> None:
    sys.exit(SIGNALED + number)


def _see_record(record: Path | None, *, recorded: bool) -> None:
    """Refuse a recording that does not end in .mcap, or that is combined with `--no-record`."""
    if record is None:
        return
    if not recorded:
        raise SettingError(
            where="--record", setting="and --no-record", problem="were both given", remedy="give one of them"
        )
    if record.suffix.lower() != ".mcap":
        problem = "is not a recording, and real robots are not drawn"
        raise SettingError(
            where="--record",
            setting=repr(str(record)),
            problem=problem,
            remedy="name a file that ends in .mcap",
        )


def choose_recording_path(record: Path, name: str) -> Path:
    """Return the path of a new recording: the file that was named, or an unused one in the folder that was."""
    return record if record.suffix.lower() == ".mcap" else _choose_unused_path(record, name)


def _place(path: Path) -> Path:
    """Return an unused path for a new recording, and make its folder."""
    return _choose_unused_path(path.parent / FOLDER, path.stem)


def _choose_unused_path(folder: Path, stem: str) -> Path:
    with convert_os_errors(
        folder, "making the folder of recordings", remedy="give --record PATH, or --no-record"
    ):
        folder.mkdir(exist_ok=True)
    name = f"{stem}-{datetime.now():%Y-%m-%dT%H-%M-%S}"
    again = (folder / f"{name}{'' if number == 1 else f'-{number}'}.mcap" for number in count(1))
    return next(place for place in again if not place.exists())
