"""Mapping files (TOML): which columns of a recording are readings and commands of a robot, and in what units.

format = "understudy-recording-map/1"
time = "stamp_ms"
time_unit = "ms"

[[readings]]
column = "ball_cm"
name = "range"
target = "ball"
unit = "cm"

[[commands]]
column = "stick_y"
channel = "drive"

[behaviors.forward]
drive = 1.0
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import isfinite, pi
from pathlib import Path
from typing import Literal

from msgspec import field
from msgspec.structs import replace

from understudy.addons.robots.camera.config import CameraSpec
from understudy.addons.robots.robot_file import (
    FORMAT as ROBOT_FORMAT,
)
from understudy.addons.robots.robot_file import (
    FrameSpec,
    ReadingSpec,
    RobotFile,
    TargetPlaceSpec,
    find_source_problems,
    parse_robot,
)
from understudy.errors import FileError, KindError
from understudy.model.value_kinds import Kind, Toroidal, parse_kind
from understudy.records.messages import TWIST
from understudy.sim.scenario.squad_schema import StrictStruct
from understudy.sim.scenario.toml_decode import DecodeProblem, decode_toml_values, parse_toml

FORMAT = "understudy-recording-map/1"
UNITS: Mapping[str, tuple[str, float]] = {
    "": ("", 1.0),
    "m": ("m", 1.0),
    "cm": ("m", 0.01),
    "mm": ("m", 0.001),
    "km": ("m", 1000.0),
    "ft": ("m", 0.3048),
    "rad": ("rad", 1.0),
    "deg": ("rad", pi / 180),
    "m/s": ("m/s", 1.0),
    "cm/s": ("m/s", 0.01),
    "mm/s": ("m/s", 0.001),
    "km/h": ("m/s", 1 / 3.6),
    "rad/s": ("rad/s", 1.0),
    "deg/s": ("rad/s", pi / 180),
    "s": ("s", 1.0),
    "ms": ("s", 1e-3),
    "us": ("s", 1e-6),
    "ns": ("s", 1e-9),
    "%": ("", 0.01),
}
"""The units that a column can have, each with the unit of the reading or command and the factor to it."""
WIDEST_RAD = 13.0
"""The largest angle in radians, about two turns; a column with a larger one is refused, as it may be in degrees."""


class ReadingColumn(StrictStruct, frozen=True, kw_only=True):
    """A column that has a reading; `name` is that of the column if left out.

    `target` is the target that it is about. An angle is toroidal unless `kind` says otherwise, and texts are labels.

    In a recording of messages, the column is a topic and a field, such as /odom.pose.pose.position.x. Or else `topic`
    is given, with what a robot file can say of a topic: `field`, `sector_deg`, `offset_m`, `clear_m`. There a reading
    is as it last was, and absent when it is older than `stale_s`; in a table, a reading stands in for empty cells as
    long.
    """

    column: str = ""
    topic: str | None = None
    field: str | None = None
    sector_deg: tuple[float, float] | None = None
    offset_m: float = 0.0
    clear_m: float | None = None
    name: str | None = None
    target: str | None = None
    unit: str = ""
    kind: str | None = None
    stale_s: float | None = None
    doc: str = ""

    @property
    def quantity(self) -> str:
        """The name of the reading."""
        return self.name or self.column

    @property
    def value_kind(self) -> Kind | None:
        """The kind of the values; None if only the values themselves say it."""
        if self.kind is not None:
            return parse_kind(self.kind, where=self.quantity)
        return Toroidal() if UNITS.get(self.unit, ("", 1.0))[0] == "rad" else None


class CommandColumn(StrictStruct, frozen=True, kw_only=True):
    """A column that has the commands of a channel, each multiplied by `scale`; at rest the command is `rest`.

    A command holds until the next one, or for `hold_s`, after which the robot is at rest.
    """

    column: str
    channel: str | None = None
    unit: str = ""
    scale: float = 1.0
    rest: float = 0.0
    hold_s: float | None = None

    @property
    def name(self) -> str:
        """The name of the channel."""
        return self.channel or self.column


class RecordingMap(StrictStruct, frozen=True, kw_only=True):
    """The content of a mapping file.

    `time` is the column of the time of each row, or those of its seconds and nanoseconds; without it, rows are `tick_s`
    apart. Otherwise rows are resampled to `tick_s`, or to the usual time between them. Where no row comes for `gap_s`
    (1 s, or five usual times between rows), an episode ends. `behaviors` are basic behaviors by name, each a command
    by channel.

    `frames`, `targets` and `camera` are as in a robot file, for recordings of messages. `world` is the scenario whose
    behaviors and features are meant.
    """

    format: Literal["understudy-recording-map/1"]
    time: str | tuple[str, str] | None = None
    time_unit: Literal["s", "ms", "us", "ns"] = "s"
    tick_s: float | None = None
    gap_s: float | None = None
    readings: tuple[ReadingColumn, ...] = ()
    commands: tuple[CommandColumn, ...]
    behaviors: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    frames: FrameSpec | None = None
    targets: Mapping[str, TargetPlaceSpec] = field(default_factory=dict)
    camera: CameraSpec | None = None
    world: str | None = None

    def topic(self, name: str) -> str:
        """Return the full name of a topic.

        Parameters
        ----------
        name
            Its name; the slash before it may be left out.

        Returns
        -------
        str
            The name in a recording.
        """
        return complete_topic(name)

    def list_columns(self) -> list[str]:
        """List the columns that are named: of times, readings and commands.

        Returns
        -------
        list
            Their names.
        """
        times = [self.time] if isinstance(self.time, str) else [*(self.time or ())]
        return [*times, *(each.column for each in self.readings), *(each.column for each in self.commands)]


class InvalidMapping(FileError, json_type="InvalidMapping"):
    """A value of a mapping that no recording could be read with; `place` is its key, and `path` the recording's."""


@contextmanager
def name_mapping_file(path: Path | str | None) -> Iterator[None]:
    """Name the mapping file, if there is one, in errors about its values that come while a recording is read."""
    try:
        yield
    except InvalidMapping as error:
        where = error.path if path is None else path
        raise FileError(path=where, place=error.place, problem=error.problem, remedy=error.remedy) from None


def complete_topic(name: str) -> str:
    """Return the full name of a topic of a recording, which is in no namespace."""
    return name if name.startswith("/") else f"/{name}"


def load_recording_map(path: Path | str) -> RecordingMap:
    """Load a mapping file.

    Parameters
    ----------
    path
        The TOML file.

    Returns
    -------
    RecordingMap
        Its content.

    Raises
    ------
    FileError
        If it cannot be read or something in it is invalid; the error names the key.
    """
    try:
        content = Path(path).read_text("utf-8-sig")
    except (OSError, ValueError) as error:
        gone = isinstance(error, FileNotFoundError)
        problem = "there is no such file" if gone else f"it cannot be read ({error})"
        raise FileError(path=path, place="", problem=problem, remedy="give a mapping file") from None
    document = parse_toml(content, path)
    if document.get("format") == ROBOT_FORMAT:
        return convert_robot_file(parse_robot(content, path))
    if document.get("format") != FORMAT:
        mark = document.get("format")
        problem = "is missing" if mark is None else f"is {mark!r:.60}, which is not that of a mapping file"
        raise FileError(path=path, place="format", problem=problem, remedy=f'write format = "{FORMAT}"')
    mapping = decode_toml_values(document, RecordingMap)
    wrong = mapping if isinstance(mapping, DecodeProblem) else next(_find_problems(mapping), None)
    if wrong is not None:
        raise FileError(path=path, place=wrong.key, problem=wrong.problem, remedy=wrong.remedy)
    if isinstance(mapping, DecodeProblem):
        raise AssertionError  # it is reported above
    return mapping


def convert_robot_file(robot: RobotFile) -> RecordingMap:
    """Make the mapping of the recordings of a robot: what its file says of topics holds for what they recorded."""
    commands = robot.commands
    stem = "" if commands.type == TWIST else "twist."
    topic = robot.topic(commands.topic)
    return RecordingMap(
        format="understudy-recording-map/1",
        time=None,
        tick_s=robot.tick_s,
        readings=tuple(_convert_reading(robot, name, each) for name, each in robot.readings.items()),
        commands=(
            CommandColumn(column=f"{topic}.{stem}linear.x", channel="drive", scale=1 / commands.drive_m_s),
            CommandColumn(column=f"{topic}.{stem}angular.z", channel="turn", scale=1 / commands.turn_rad_s),
        ),
        frames=None
        if robot.frames is None
        else replace(
            robot.frames, topic=robot.topic(robot.frames.topic), static=robot.topic(robot.frames.static)
        ),
        targets={
            name: each if each.topic is None else replace(each, topic=robot.topic(each.topic))
            for name, each in robot.targets.items()
        },
        camera=None if robot.camera is None else replace(robot.camera, topic=robot.topic(robot.camera.topic)),
        world=robot.world,
    )


def _convert_reading(robot: RobotFile, name: str, reading: ReadingSpec) -> ReadingColumn:
    return ReadingColumn(
        topic=robot.topic(reading.topic),
        field=reading.field,
        sector_deg=reading.sector_deg,
        offset_m=reading.offset_m,
        clear_m=reading.clear_m,
        name=name,
        unit=reading.unit,
        stale_s=reading.stale_s,
        doc=reading.doc,
    )


def _find_problems(mapping: RecordingMap) -> Iterator[DecodeProblem]:
    """Yield the values that have the right types and still are invalid."""
    if not mapping.commands:
        yield DecodeProblem("commands", "are none", "give the column of each channel")
    if mapping.time is None and mapping.tick_s is None:
        yield DecodeProblem("time", "is missing", "name the column of times, or give tick_s")
    ages = [(f"readings[{index}].stale_s", each.stale_s) for index, each in enumerate(mapping.readings)]
    ages += [(f"commands[{index}].hold_s", each.hold_s) for index, each in enumerate(mapping.commands)]
    for key, value in (("tick_s", mapping.tick_s), ("gap_s", mapping.gap_s), *ages):
        if value is not None and not (isfinite(value) and value > 0):
            yield DecodeProblem(key, f"is {value:g}", "give seconds above 0")
    units = [(f"readings[{index}].unit", each.unit) for index, each in enumerate(mapping.readings)]
    units += [(f"commands[{index}].unit", each.unit) for index, each in enumerate(mapping.commands)]
    for key, unit in units:
        if unit not in UNITS:
            yield DecodeProblem(key, f"is {unit!r:.60}", f"give one of {', '.join(filter(None, UNITS))}")
    for index, each in enumerate(mapping.readings):
        if bool(each.column) == bool(each.topic):
            yield DecodeProblem(
                f"readings[{index}]", "has to have either column or topic", "give one of the two"
            )
        if each.topic and not each.name:
            yield DecodeProblem(f"readings[{index}].name", "is missing", "name the reading")
        if each.column and any((each.field, each.sector_deg, each.offset_m, each.clear_m)):
            problem, remedy = "is given for a column", "give topic in place of column"
            yield DecodeProblem(f"readings[{index}].field", problem, remedy)
        try:
            each.value_kind  # noqa: B018
        except KindError as error:
            yield DecodeProblem(f"readings[{index}].kind", error.problem, error.remedy)
        others = [(other.quantity, other.target) for other in mapping.readings[:index]]
        if (each.quantity, each.target) in others:
            yield DecodeProblem(f"readings[{index}]", "is a reading given before", "rename one of the two")
        if any(
            name == each.quantity and (target is None) != (each.target is None) for name, target in others
        ):
            problem = "is about a target here, and about none elsewhere"
            yield DecodeProblem(f"readings[{index}]", problem, "rename one of the two")
    yield from find_source_problems(mapping)
    channels = [each.name for each in mapping.commands]
    for index, name in enumerate(channels):
        if name in channels[:index]:
            yield DecodeProblem(f"commands[{index}]", f"is channel {name!r} again", "rename one of the two")
        if not isfinite(mapping.commands[index].scale) or not mapping.commands[index].scale:
            yield DecodeProblem(f"commands[{index}].scale", "is 0 or not finite", "give another number")
    for behavior, command in mapping.behaviors.items():
        for channel in command:
            if channel not in channels:
                yield DecodeProblem(
                    f"behaviors.{behavior}.{channel}", "is no channel", f"give one of {', '.join(channels)}"
                )
