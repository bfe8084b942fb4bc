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
from math import isfinite, pi
from pathlib import Path
from typing import Literal

from msgspec import field

from understudy.errors import FileError, KindError
from understudy.model.value_kinds import Continuous, Kind, Toroidal, parse_kind
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


class ReadingColumn(StrictStruct, frozen=True, kw_only=True):
    """A column that has a reading; `name` is that of the column if left out.

    `target` is the target that it is about. An angle is toroidal unless `kind` says otherwise.
    """

    column: str
    name: str | None = None
    target: str | None = None
    unit: str = ""
    kind: str | None = None
    doc: str = ""

    @property
    def quantity(self) -> str:
        """The name of the reading."""
        return self.name or self.column

    @property
    def value_kind(self) -> Kind:
        """The kind of the values."""
        if self.kind is not None:
            return parse_kind(self.kind, where=self.column)
        return Toroidal() if UNITS[self.unit][0] == "rad" else Continuous()


class CommandColumn(StrictStruct, frozen=True, kw_only=True):
    """A column that has the commands of a channel, each multiplied by `scale`; at rest the command is `rest`."""

    column: str
    channel: str | None = None
    unit: str = ""
    scale: float = 1.0
    rest: float = 0.0

    @property
    def name(self) -> str:
        """The name of the channel."""
        return self.channel or self.column


class RecordingMap(StrictStruct, frozen=True, kw_only=True):
    """The content of a mapping file.

    `time` is the column of the time of each row; without it, rows are `tick_s` apart. Otherwise rows are resampled to
    `tick_s`, or to the usual time between them. Where no row comes for `gap_s`, an episode ends. `behaviors` are
    basic behaviors by name, each a command by channel.
    """

    format: Literal["understudy-recording-map/1"]
    time: str | None = None
    time_unit: Literal["s", "ms", "us", "ns"] = "s"
    tick_s: float | None = None
    gap_s: float = 1.0
    readings: tuple[ReadingColumn, ...] = ()
    commands: tuple[CommandColumn, ...]
    behaviors: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


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


def _find_problems(mapping: RecordingMap) -> Iterator[DecodeProblem]:
    """Yield the values that have the right types and still are invalid."""
    if not mapping.commands:
        yield DecodeProblem("commands", "are none", "give the column of each channel")
    if mapping.time is None and mapping.tick_s is None:
        yield DecodeProblem("time", "is missing", "name the column of times, or give tick_s")
    for key, value in (("tick_s", mapping.tick_s), ("gap_s", mapping.gap_s)):
        if value is not None and not (isfinite(value) and value > 0):
            yield DecodeProblem(key, f"is {value:g}", "give seconds above 0")
    units = [(f"readings[{index}].unit", each.unit) for index, each in enumerate(mapping.readings)]
    units += [(f"commands[{index}].unit", each.unit) for index, each in enumerate(mapping.commands)]
    for key, unit in units:
        if unit not in UNITS:
            yield DecodeProblem(key, f"is {unit!r:.60}", f"give one of {', '.join(filter(None, UNITS))}")
    for index, each in enumerate(mapping.readings):
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
