"""The interface between an exported behavior and what it runs on: readings, channels and the tick length.

It is that of a body, of a library's kit, or of a real robot as its file describes it; nothing is connected.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from understudy.addons.robots.derived_readings import DerivedReadings
from understudy.addons.robots.inputs import TopicInput, make_topic_inputs
from understudy.addons.robots.robot import check_readings_fit, find_robot_scenario, find_robot_type
from understudy.addons.robots.robot_file import RobotFile
from understudy.errors import FileError
from understudy.model.features import Feature
from understudy.model.library import Library
from understudy.runtime.body import ISSUED, ORDER, Body, Channel, Reading
from understudy.sim.kit import MOVING, list_readings, make_channels
from understudy.sim.scenario.schema import Scenario
from understudy.sim.scenario.toml_decode import DecodeProblem
from understudy.sim.sensing.sensor_table import BLOBS, LOCATIONS

TICK_S = 0.1
"""The length of a tick, s, where no body says it."""
ORDER_CHANNELS = (
    Channel(ORDER, doc="Which order stands: the index of a basic behavior; 0 orders the members to idle."),
    Channel(ISSUED, doc="1 in the tick in which the order is given, otherwise 0."),
)
"""The channels of an exported coordinator."""


@dataclass(frozen=True, slots=True)
class BodyInterface:
    """The readings that a body offers, its channels with their values at rest, and the length of its tick, s.

    If `is_complete` is False, the body may have readings that are not listed.
    """

    readings: tuple[Reading, ...]
    channels: tuple[Channel, ...]
    tick_s: float = TICK_S
    is_complete: bool = True


def describe_body(body: Body) -> BodyInterface:
    """Describe a body to export for."""
    return BodyInterface(tuple(body.readings), tuple(body.channels), body.tick_s)


def describe_kit(library: Library, *, tick_s: float = TICK_S) -> BodyInterface:
    """Describe the body that a library's kit is for, if no body is at hand.

    Its readings are those of the kit's features. Its channels are those of the kit's commands, at rest 0; those of a
    squad's coordinator are `ORDER_CHANNELS`.
    """
    readings: dict[str, Reading] = {}
    for feature in library.kit.features.values():
        if isinstance(feature, Feature) and feature.reading is not None:
            of_targets = feature.of is not None
            readings[feature.reading] = Reading(
                feature.reading, feature.kind, feature.unit, of_targets, feature.doc
            )
    behaviors = library.kit.behaviors.values()
    if any(each.order is not None for each in behaviors):
        return BodyInterface(tuple(readings.values()), ORDER_CHANNELS, tick_s)
    channels = {channel: None for each in behaviors for channel in each.command}
    return BodyInterface(tuple(readings.values()), tuple(map(Channel, channels)), tick_s, is_complete=False)


@dataclass(frozen=True, slots=True)
class RobotInterface:
    """A robot's file, what it offers, and the body that behaviors see.

    `body` has the readings and channels of the robot's scenario, as a run on the robot has; those that the robot has
    not are absent and ignored. `offered` are the readings that it has, with `derived`, which are computed. `images` are
    the readings that only images give.
    """

    file: RobotFile
    sources: tuple[TopicInput, ...]
    derived: DerivedReadings
    offered: tuple[Reading, ...]
    images: frozenset[str]
    body: BodyInterface

    def has(self, reading: str, *, of_target: bool) -> bool:
        """Return whether the robot has a reading, of itself or of targets."""
        return any(each.name == reading and each.of_targets == of_target for each in self.offered)


def describe_robot(
    file: RobotFile, *, path: Path | str = "robot.toml", scenario: Scenario | None = None
) -> RobotInterface:
    """Describe a robot without connecting to it.

    `scenario` takes the place of the one that the file names. FileError is raised if the file asks for something that
    messages do not contain, or that differs from its scenario.
    """
    if scenario is None:
        scenario, kind = find_robot_scenario(file, path)
    else:
        kind = find_robot_type(file, scenario, path)
    sources = make_topic_inputs(file, None, ())
    if isinstance(sources, DecodeProblem):
        raise FileError(path=path, place=sources.key, problem=sources.problem, remedy=sources.remedy)
    senses = {each.name: each for source in sources for each in source.readings}
    if file.targets:
        senses.update({each.name: each for each in LOCATIONS})
    if file.camera is not None:
        senses.update({each.name: each for each in BLOBS})
    check_readings_fit(file, tuple(senses.values()), kind, path)
    derived = DerivedReadings(kind, tuple(senses.values()), tuple(file.targets))
    offered = (*senses.values(), *derived.readings)
    there = {} if scenario is None else {each.name: each for each in list_readings(scenario)}
    readings = {each.name: each for each in offered} | there
    channels = MOVING if scenario is None else make_channels(scenario)
    return RobotInterface(
        file,
        tuple(sources),
        derived,
        offered,
        frozenset(each.name for each in BLOBS) if file.camera is not None else frozenset(),
        BodyInterface(tuple(readings.values()), tuple(channels), file.tick_s),
    )
