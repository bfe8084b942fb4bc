"""Check names in a scenario: each has one meaning, and refers to something that exists."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from understudy.errors import join_names
from understudy.model.value_kinds import Categorical
from understudy.sim.kit import (
    CARRYING,
    MOVING,
    OWN_FEATURES,
    list_type_readings,
    make_behaviors,
    make_features,
    make_targets,
)
from understudy.sim.params import SIGNAL, collect_names, get_most_count
from understudy.sim.scenario.scenario_errors import ScenarioErrors
from understudy.sim.scenario.schema import (
    MOUSE,
    ElapsedSensor,
    Goal,
    ObjectClass,
    RobotType,
    Scenario,
    TargetLocator,
    TargetSpec,
)
from understudy.sim.scenario.validate_boxes import check_signal, list_raised_signals
from understudy.sim.sensing.sensor_table import find_sensor_row

NAME = re.compile(r"\w(?:[\w -]{0,58}\w)?")
_REFERENCES = ("nearest", "object", "team", "robot", "color", "signal")
_TOGETHER = (["robot", "signal"], ["signal", "team"])


def check_scenario_names(checker: ScenarioErrors) -> None:
    """Raise SettingError if a name is not valid, occurs twice, or refers to nothing."""
    scenario = checker.scenario
    _check_spelling(checker)
    _once(checker, "objects", [thing.name for thing in scenario.objects])
    if not scenario.types:
        checker.fail("types", "is empty", "give at least one type of robot")
    for name, robot_type in scenario.types.items():
        _check_sensors(checker, f"types.{name}", robot_type)
        _check_behaviors(checker, f"types.{name}.behaviors", robot_type)
        _check_skills(checker, f"types.{name}.skills", robot_type)
    for name, target in scenario.targets.items():
        _check_target(checker, f"targets.{name}", target)
    features = [feature.name for feature in make_features(scenario)] + [own.name for own in OWN_FEATURES]
    for name in features:
        if features.count(name) > 1:
            key = f"features.{name}" if name in scenario.features else _sensor_reading(scenario, name)
            checker.fail(key, f"is a second feature of the name {name!r}", "rename one of the two")
    make_behaviors(scenario)
    make_targets(scenario)
    if scenario.goal is not None:
        _check_goal(checker, scenario.goal)


def check_identifier(checker: ScenarioErrors, key: str, name: str) -> None:
    """Raise SettingError if a name contains forbidden characters or is too long."""
    if not NAME.fullmatch(name):
        remedy = "give up to 60 letters, digits, _, - and spaces inside"
        checker.fail(key, f"has {name!r:.80}, which is not a valid name", remedy)


def _check_spelling(checker: ScenarioErrors) -> None:
    """Raise SettingError if a name is not valid; names occur in tables, on buttons and in file names."""
    scenario = checker.scenario
    spelled: list[tuple[str, str]] = [("name", scenario.name)]
    tables: Mapping[str, Mapping[str, Any]] = {
        "regions": scenario.regions,
        "types": scenario.types,
        "targets": scenario.targets,
        "features": scenario.features,
    }
    spelled += [(key, name) for key, table in tables.items() for name in table]
    spelled += [(f"objects[{index}].name", thing.name) for index, thing in enumerate(scenario.objects)]
    spelled += [
        (f"obstacles[{index}].color", thing.color)
        for index, thing in enumerate(scenario.obstacles)
        if thing.color is not None
    ]
    spelled += [
        (f"objects[{index}].color", thing.color)
        for index, thing in enumerate(scenario.objects)
        if thing.color is not None
    ]
    for kind, robot in scenario.types.items():
        words = {"color": robot.color, "team": robot.team}
        spelled += [(f"types.{kind}.{key}", word) for key, word in words.items() if word is not None]
        spelled += [(f"types.{kind}.behaviors", name) for name in robot.behaviors]
        spelled += [
            (f"types.{kind}.behaviors.{name}.{SIGNAL}", signal) for name, signal in list_raised_signals(robot)
        ]
        for index, sensor in enumerate(robot.sensors):
            key = f"types.{kind}.sensors[{index}]"
            spelled += [(f"{key}.sectors", name) for name in getattr(sensor, "sectors", ())]
            spelled += [(f"{key}.name", sensor.name)] if hasattr(sensor, "name") else []
    for key, name in spelled:
        check_identifier(checker, key, name)
        if name == MOUSE and key.startswith("objects"):
            checker.fail(key, f"is {MOUSE!r}, which is the pointer's own", "give another name")


def _once(checker: ScenarioErrors, key: str, names: list[str]) -> None:
    for index, name in enumerate(names):
        first = names.index(name)
        if first < index:
            problem = f"is {name!r}, as is that of {key}[{first}]"
            checker.fail(f"{key}[{index}].name", problem, "rename one of the two")


def _check_sensors(checker: ScenarioErrors, key: str, robot_type: RobotType) -> None:
    """Raise SettingError for readings that occur twice, invalid sectors, or timed readings that do not exist."""
    read: dict[str, int] = {}
    for index, sensor in enumerate(robot_type.sensors):
        for setting, problem, remedy in find_sensor_row(sensor).check(sensor):
            checker.fail(f"{key}.sensors[{index}].{setting}", problem, remedy)
    _check_locators(checker, key, robot_type)
    for index, reading in list_type_readings(robot_type):
        both = (robot_type.sensors[index], robot_type.sensors[read.get(reading.name, index)])
        if reading.name in read and not all(isinstance(sensor, TargetLocator) for sensor in both):
            problem = f"reads {reading.name!r}, as does sensors[{read[reading.name]}]"
            checker.fail(f"{key}.sensors[{index}]", problem, "rename one of the two, or leave it out")
        read[reading.name] = index
    timed = [
        reading.name
        for index, reading in list_type_readings(robot_type)
        if not isinstance(robot_type.sensors[index], ElapsedSensor)
        and (reading.of_targets or isinstance(reading.kind, Categorical))
    ]
    for index, sensor in enumerate(robot_type.sensors):
        if isinstance(sensor, ElapsedSensor):
            at = f"{key}.sensors[{index}].of"
            checker.check_known(at, sensor.of, timed, what="reading of a target, or one that is yes or no")


def _check_locators(checker: ScenarioErrors, key: str, robot_type: RobotType) -> None:
    """Raise SettingError if two locators of a type measure the same target."""
    taken: dict[str | None, int] = {}
    for index, sensor in enumerate(robot_type.sensors):
        if not isinstance(sensor, TargetLocator):
            continue
        at = f"{key}.sensors[{index}]"
        if sensor.targets is not None and not sensor.targets:
            checker.fail(f"{at}.targets", "is empty", "leave it out for all targets, or name some")
        for target in sensor.targets or (None,):
            if target is not None:
                checker.check_known(f"{at}.targets", target, checker.scenario.targets, what="target")
            if target in taken:
                what = "all targets" if target is None else f"the target {target!r}"
                remedy = "give one of them other `targets`, or leave it out"
                checker.fail(at, f"reads the range of {what}, as does sensors[{taken[target]}]", remedy)
            taken[target] = index


def _check_behaviors(checker: ScenarioErrors, key: str, robot_type: RobotType) -> None:
    scenario = checker.scenario
    carries = any(each.capacity > 0 for each in scenario.types.values())
    carries = carries or any(thing.pull is not None for thing in scenario.objects)
    moving, carrying = [each.name for each in MOVING], [each.name for each in CARRYING]
    for name, channels in robot_type.behaviors.items():
        check_signal(checker, f"{key}.{name}", channels)
        for channel, value in channels.items():
            at = f"{key}.{name}.{channel}"
            if channel in carrying and not carries:
                remedy = "give some type a capacity above 0, or some object a pull"
                checker.fail(at, "needs a robot that carries food or pulls a box", remedy)
            checker.check_known(at, channel, [*moving, *carrying * carries, SIGNAL], what="channel")
            if isinstance(value, str):
                continue
            if not -1 <= value <= 1:
                checker.fail(
                    at, f"is {value}", "give a number from -1 to 1: a share of the robot's own speed"
                )


def _check_skills(checker: ScenarioErrors, key: str, robot_type: RobotType) -> None:
    targets = checker.scenario.targets
    for name, skill in robot_type.skills.items():
        for parameter in skill.parameters:
            if parameter in targets or list(skill.parameters).count(parameter) > 1:
                problem = f"has {parameter!r}, which is also the name of a target or of another parameter"
                checker.fail(f"{key}.{name}.parameters", problem, "give each a name of its own, as A and B")
        if skill.ends is not None:
            names = [*skill.parameters, *targets]
            checker.check_known(f"{key}.{name}.ends", skill.ends, names, what="parameter or target")


def _check_target(checker: ScenarioErrors, key: str, target: TargetSpec) -> None:
    scenario = checker.scenario
    names = collect_names(scenario)
    references = [name for name in _REFERENCES if getattr(target, name) is not None]
    if len(references) != 1 and sorted(references) not in _TOGETHER:
        remedy = f"give exactly one of {', '.join(_REFERENCES)}; a signal may be beside a team or a robot"
        checker.fail(key, f"has {join_names(references)}", remedy)
    for name in ("nearest", "object"):
        if name in references:
            checker.check_known(
                f"{key}.{name}", getattr(target, name), names.classes, what="class of objects"
            )
    if target.team is not None:
        checker.check_known(f"{key}.team", target.team, names.teams, what="team")
    if target.color is not None and target.color not in names.colors:
        remedy = f"give one that is there: {join_names(map(repr, names.colors))}"
        checker.fail(f"{key}.color", f"is {target.color!r}, a color nobody has", remedy)
    if target.index and target.object is None:
        checker.fail(f"{key}.index", "is given without an object", "leave it out, or give the object")
    if target.index:
        thing = next((thing for thing in scenario.objects if thing.name == target.object), None)
        most = 1 if thing is None else get_most_count(thing) + scenario.spare_objects
        if target.index >= most:
            problem = f"is {target.index}, and of {target.object!r} there are {most} at most"
            checker.fail(f"{key}.index", problem, f"give 0 to {most - 1}")


def _check_goal(checker: ScenarioErrors, goal: Goal) -> None:
    scenario = checker.scenario
    if [goal.delivered, goal.gathered > 0, goal.target is not None].count(True) != 1:
        remedy = "give either delivered = true, or how many boxes are to be gathered, or a target"
        checker.fail("goal", "is to deliver, to gather and to reach, or none of it", remedy)
    if goal.target is not None:
        checker.check_known(
            "goal.target", goal.target, collect_names(scenario).classes, what="class of objects"
        )
        return
    if goal.all:
        checker.fail("goal.all", "is given without a target", "leave it out, or give a target")
    if goal.gathered:
        return
    carriers = {name for name, kind in scenario.types.items() if kind.capacity > 0}
    if not any(robots.type in carriers for robots in scenario.robots):
        checker.fail("goal.delivered", "cannot be: no robot can carry food", "give a type a capacity above 0")
    if not any(thing.home for thing in scenario.objects):
        checker.fail("goal.delivered", "cannot be: there is no home", "give an object home = true")
    if not (_has_food(scenario.objects) or any(robots.stored for robots in scenario.robots)):
        checker.fail("goal.delivered", "cannot be: there is no food", "give an object an amount above 0")


def _has_food(things: Iterable[ObjectClass]) -> bool:
    return any(thing.amount not in (0, (0, 0)) for thing in things)


def _sensor_reading(scenario: Scenario, name: str) -> str:
    for kind, robot in scenario.types.items():
        for index, reading in list_type_readings(robot):
            if name == reading.name:
                return f"types.{kind}.sensors[{index}]"
    return "features"
