"""Real robots on the command line: --robot, --team, --record; connected, and recorded unless that is not wanted."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from itertools import count
from pathlib import Path
from threading import current_thread, main_thread
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from understudy.errors import SettingError

if TYPE_CHECKING:
    from understudy.robots.twin import DigitalTwin

RobotFileOption: TypeAlias = Annotated[
    Path | None,
    typer.Option("--robot", metavar="FILE", help="On a real robot, by its file.", show_default=False),
]
TeamFileOption: TypeAlias = Annotated[
    Path | None,
    typer.Option("--team", metavar="FILE", help="On real robots, by their team's file.", show_default=False),
]
NoRecording: TypeAlias = Annotated[
    bool, typer.Option("--no-record", help="Do not record what real robots sense and do.")
]
SIGNALED = 128
"""What exit codes of programs begin at that a signal ended."""
FOLDER = "recordings"
"""Where recordings are kept, beside the robot's file."""


def find_robots_file(robot: Path | None, team: Path | None, *, world: str | None) -> Path | None:
    """The file of real robots that was named; None where none was, and SettingError where two things were."""
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


@contextmanager
def connect_twin(
    robot: Path | None, team: Path | None, *, record: Path | None, recorded: bool
) -> Iterator[DigitalTwin]:
    """The robots of a file, connected, in their world; stopped and left at the end.

    Where `recorded`, every message goes into a recording, `record` or one made beside the file; it says what is
    decided once `DigitalTwin.record` was called, and is not kept where that never was.
    """
    _see_record(record, recorded=recorded)
    with interrupt_on_termination():
        yield from _twin_of(robot, team, record=record, recorded=recorded)


def _twin_of(
    robot: Path | None, team: Path | None, *, record: Path | None, recorded: bool
) -> Iterator[DigitalTwin]:
    from understudy.robots.fleet import connect_robot, connect_team
    from understudy.robots.recording.recorder import RunRecorder
    from understudy.robots.twin import DigitalTwin

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
    """Who is told to end, or whose terminal is gone, leaves as on Ctrl-C: robots are stopped, and recordings whole.

    Ctrl-C itself counts even where a shell keeps it away; a hang-up that somebody wants ignored is.
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
    """Refuse a recording that is none, or is not wanted."""
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


def _place(path: Path) -> Path:
    """Where a recording that begins now is kept."""
    from understudy.storage.atomic_write import convert_os_errors

    folder = path.parent / FOLDER
    with convert_os_errors(
        folder, "making the folder of recordings", remedy="give --record PATH, or --no-record"
    ):
        folder.mkdir(exist_ok=True)
    name = f"{path.stem}-{datetime.now():%Y-%m-%dT%H-%M-%S}"
    again = (folder / f"{name}{'' if number == 1 else f'-{number}'}.mcap" for number in count(1))
    return next(place for place in again if not place.exists())
