"""Derive the readings, channels, targets and kit of a scenario: what its robots sense, obey and can be taught with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, SettingError, UnknownName
from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import Target
from understudy.model.features import AnyFeature, Feature, FlagFeature, TimeInState
from understudy.model.library import Kit
from understudy.model.value_kinds import Column, Continuous
from understudy.runtime.body import Channel, Reading
from understudy.sim.params import SIGNAL, list_signals
from understudy.sim.scenario.schema import (
    ElapsedSensor,
    RobotType,
    Scenario,
    TargetSpec,
)
from understudy.sim.sensing.sensor_table import find_sensor_row
from understudy.sim.skill_parts import SKILL_CHANNELS, has_skills, list_skill_readings, make_skill_behavior

FEATURES: Mapping[str, str] = {"range": "distance_to", "bearing": "angle_to"}
"""The names of the features of readings, where they differ from the readings' names."""
PARAMETER = "A"
"""The name of the target parameter of features."""
OWN_FEATURES = (FlagFeature("done"), FlagFeature("failed"), TimeInState())

MOVING = (
    Channel("drive", unit="forward speeds", doc="1 drives ahead at the robot's speed, -1 back."),
    Channel("turn", unit="turning speeds", doc="1 turns left at the robot's turning speed, -1 right."),
)
CARRYING = (
    Channel("load", doc="Above 0 loads food, standing still within reach of a source."),
    Channel("unload", doc="Above 0 unloads food, standing still within reach of a home."),
)
PULLING = (
    Channel("load", doc="Above 0 takes hold of the nearest box or loads food, standing still within reach."),
    Channel(
        "unload", doc="Above 0 lets go of the box, or unloads food, standing still within reach of a home."
    ),
)
SIGNALING = (Channel(SIGNAL, doc="Which signal it raises, counted from 1 in the order of the file; 0 none."),)
COLUMNS = tuple(channel.name for channel in (*MOVING, *CARRYING, *SIGNALING))
"""The columns of a table of commands, whether or not a scenario has these channels."""


def make_scenario_kit(scenario: Scenario) -> Kit:
    """Make the kit of a scenario: features of its readings, basic behaviors of its robot types, and its targets."""
    return Kit.from_parts(
        *make_features(scenario), *OWN_FEATURES, *make_behaviors(scenario).values(), *make_targets(scenario)
    )


def make_features(scenario: Scenario) -> tuple[Feature, ...]:
    """Make a feature for each reading, under the names that the scenario gives, or the usual name."""
    named: dict[str, list[Feature]] = {}
    readings = {reading.name: reading for reading in list_readings(scenario)}
    for name, feature in scenario.features.items():
        if feature.reading not in readings:
            raise _wrong(
                scenario,
                f"features.{name}.reading",
                f"is {feature.reading!r}, which no sensor reads",
                f"give one of {', '.join(readings)}",
            )
        named.setdefault(feature.reading, []).append(_feature(name, readings[feature.reading], feature.doc))
    usual = {name: [_feature(FEATURES.get(name, name), reading)] for name, reading in readings.items()}
    return tuple(feature for each in (usual | named).values() for feature in each)


def make_behaviors(scenario: Scenario) -> Mapping[str, Behavior]:
    """Make the basic behaviors of all types; raise SettingError if types give one name to different commands."""
    behaviors: dict[str, Behavior] = {}
    signals, pulls = list_signals(scenario), _pulls(scenario)
    skills = list(dict.fromkeys(name for robot_type in scenario.types.values() for name in robot_type.skills))
    for type_name, robot_type in scenario.types.items():
        for name, channels in robot_type.behaviors.items():
            command = {
                channel: 1.0 + signals.index(value) if isinstance(value, str) else value
                for channel, value in channels.items()
            }
            behavior = Behavior(name, Command(**command), doc=_doing(channels, pulls=pulls))
            if behaviors.setdefault(name, behavior) != behavior:
                raise _wrong(
                    scenario,
                    f"types.{type_name}.behaviors.{name}",
                    "is another command than the behavior of this name in a type before",
                    "rename one of the two",
                )
        for name, skill in robot_type.skills.items():
            behavior = make_skill_behavior(name, skill, number=1 + skills.index(name))
            if behaviors.setdefault(name, behavior) != behavior:
                raise _wrong(
                    scenario,
                    f"types.{type_name}.skills.{name}",
                    "differs from the behavior or skill of this name before",
                    "rename one of the two",
                )
    return behaviors


def list_readings(scenario: Scenario) -> tuple[Reading, ...]:
    """List the readings of all types, each name once; raise SettingError if one name has different kinds."""
    readings: dict[str, Reading] = {}
    for type_name, robot_type in scenario.types.items():
        own = ((f"sensors[{index}]", reading) for index, reading in list_type_readings(robot_type))
        of_skills = ((f"skills.{name}", reading) for name, reading in list_skill_readings(robot_type))
        for place, reading in (*own, *of_skills):
            before = readings.setdefault(reading.name, reading)
            if before != reading and replace(before, doc="") != replace(reading, doc=""):
                raise _wrong(
                    scenario,
                    f"types.{type_name}.{place}",
                    f"reads {reading.name!r}, which is a different reading for an earlier type",
                    "rename one of the two",
                )
    return tuple(readings.values())


def make_channels(scenario: Scenario) -> tuple[Channel, ...]:
    """Make the channels of a scenario's robots: driving and, if it has these, loading, gripping, signals, skills."""
    carries = any(robot.capacity > 0 for robot in scenario.types.values())
    hands = PULLING if _pulls(scenario) else CARRYING if carries else ()
    signals = SIGNALING if list_signals(scenario) else ()
    return (*MOVING, *hands, *signals, *(SKILL_CHANNELS if has_skills(scenario) else ()))


def _pulls(scenario: Scenario) -> bool:
    """Return whether a scenario has boxes to pull."""
    return any(thing.pull is not None for thing in scenario.objects)


def make_targets(scenario: Scenario) -> tuple[Target, ...]:
    """Make the targets that readings can refer to."""
    return tuple(Target(name, target.doc or _meaning(target)) for name, target in scenario.targets.items())


def list_type_readings(robot: RobotType) -> Iterator[tuple[int, Reading]]:
    """List the readings of a type's sensors, each with the index of its sensor."""
    readings: dict[str, Reading] = {}
    later: list[tuple[int, ElapsedSensor]] = []
    for index, sensor in enumerate(robot.sensors):
        if isinstance(sensor, ElapsedSensor):
            later.append((index, sensor))
            continue
        for reading in find_sensor_row(sensor).readings(sensor):
            readings.setdefault(reading.name, reading)
            yield index, reading
    for index, sensor in later:
        of = readings.get(sensor.of)
        doc = f"Time since {sensor.of} was last there."
        yield (
            index,
            Reading(sensor.name, Continuous(), "s", of_targets=of is not None and of.of_targets, doc=doc),
        )


def _feature(name: str, reading: Reading, doc: str = "") -> Feature:
    of = PARAMETER if reading.of_targets else None
    return Feature(name, reading.kind, reading.name, of=of, unit=reading.unit, doc=doc or reading.doc)


def _doing(channels: Mapping[str, float | str], *, pulls: bool) -> str:
    """Describe a command in words."""
    phrases = _WORDS | _PULLING_WORDS if pulls else _WORDS
    words = [
        f"raise {value}" if isinstance(value, str) else phrases[channel][value < 0]
        for channel, value in channels.items()
        if value and (channel in phrases or isinstance(value, str))
    ]
    sentence = ", ".join(words)
    return f"{sentence[0].upper()}{sentence[1:]}." if sentence else "Stand still."


_WORDS = {
    "drive": ("drive ahead", "drive back"),
    "turn": ("turn left", "turn right"),
    "load": ("load food from the source within reach", "do not load"),
    "unload": ("unload food at the home within reach", "do not unload"),
}
_PULLING_WORDS = {
    "load": ("take hold of the box within reach", "do not take hold"),
    "unload": ("let go of the box", "do not let go"),
}


def _meaning(target: TargetSpec) -> str:
    if target.nearest is not None:
        return f"The nearest {target.nearest}{' that nobody else claims' if target.unclaimed else ''}."
    if target.object is not None:
        return f"The {target.object}{f', number {target.index + 1}' if target.index else ''}."
    raising = f" that raises {target.signal}" if target.signal else ""
    if target.team is not None:
        return f"The nearest robot of the team {target.team}{raising}."
    if target.robot is not None or target.signal is not None:
        return f"The nearest {'robot' if target.robot in (None, 'any') else target.robot}{raising}."
    return f"Whatever is {target.color}."


def _wrong(scenario: Scenario, key: str, problem: str, remedy: str) -> SettingError:
    return SettingError(where=f"scenario {scenario.name!r}", setting=key, problem=problem, remedy=remedy)


def make_type_kits(scenario: Scenario, kit: Kit) -> Mapping[str, Kit]:
    """Make the kit of each robot type: `kit` without readings and behaviors that only other types have.

    It is `kit` itself for types that have everything.
    """
    return MappingProxyType({name: _of_type(scenario, name, kit) for name in scenario.types})


def have_different_kits(kits: Mapping[str, Kit]) -> bool:
    """Return whether types have different features or behaviors, so that each needs a library of its own."""
    parts = [(set(kit.features), set(kit.behaviors)) for kit in kits.values()]
    return any(each != parts[0] for each in parts)


def _of_type(scenario: Scenario, name: str, kit: Kit) -> Kit:
    robot_type = scenario.types[name]
    mine = {
        reading.name for _, reading in (*list_type_readings(robot_type), *list_skill_readings(robot_type))
    }
    others = {reading.name for reading in list_readings(scenario)} - mine
    foreign = set(make_behaviors(scenario)) - set(robot_type.behaviors) - set(robot_type.skills)
    parts = [part for part in kit.parts if not _is_of(part, others, foreign)]
    return kit if len(parts) == len(kit.parts) else Kit.from_parts(*parts)


def _is_of(part: AnyFeature | Behavior | Target, readings: set[str], behaviors: set[str]) -> bool:
    """Return whether a part is a feature of one of these readings, or one of these behaviors."""
    if isinstance(part, Behavior):
        return part.name in behaviors
    return isinstance(part, Feature) and part.reading in readings


def make_command_table(
    commands: Mapping[str, Column], *, agents: int, channels: Sequence[str], where: str
) -> NDArray[np.float64]:
    """Return commands as a table [N, 5] with columns `COLUMNS`, 0 if omitted; raise for invalid commands.

    The columns of skills are checked, and are not in the table.
    """
    table = np.zeros((agents, len(COLUMNS)))
    for channel, column in commands.items():
        if channel not in channels:
            raise UnknownName(what="channel", name=channel, where=where, known=channels)
        if channel not in COLUMNS:
            _column(channel, column, agents)
            continue
        table[:, COLUMNS.index(channel)] = _column(channel, column, agents)
    return table


def _column(channel: str, column: Column, agents: int) -> Column:
    try:
        values: Column = np.asarray(column, np.float64)
    except (TypeError, ValueError) as error:
        raise DefinitionError(
            what=f"command {channel!r}",
            problem=f"it is {column!r:.60}",
            remedy="give one finite number per robot",
        ) from error
    if values.shape != (agents,):
        raise DefinitionError(
            what=f"command {channel!r}",
            problem=f"it has shape {values.shape}",
            remedy=f"give one value per robot: shape ({agents},)",
        )
    finite = np.isfinite(values)
    if not finite.all():
        wrong = int(np.argmin(finite))
        raise DefinitionError(
            what=f"command {channel!r}",
            problem=f"it is {values[wrong]} for robot {wrong}",
            remedy="give finite numbers",
        )
    return values
