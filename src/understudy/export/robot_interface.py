"""The interface of a real robot as its file describes it, for exports that run on it; nothing is connected."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from understudy.errors import FileError
from understudy.export.body_interface import BodyInterface
from understudy.robots.derived_readings import DerivedReadings
from understudy.robots.inputs import TopicInput, make_topic_inputs
from understudy.robots.robot import check_readings_fit, find_robot_scenario, find_robot_type
from understudy.robots.robot_file import RobotFile
from understudy.runtime.body import Reading
from understudy.sim.kit import MOVING, list_readings, make_channels
from understudy.sim.scenario.schema import Scenario
from understudy.sim.scenario.toml_decode import DecodeProblem
from understudy.sim.sensing.sensor_table import BLOBS, LOCATIONS


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
