"""Check boxes to pull and signals in a scenario: enough robots for each box, and a behavior for each signal."""

from __future__ import annotations

from collections.abc import Mapping

from understudy.errors import join_names
from understudy.sim.params import SIGNAL, count_robots, get_most_count, list_signals
from understudy.sim.scenario.scenario_errors import ScenarioErrors
from understudy.sim.scenario.schema import ClaimSensor, Goal, ObjectClass, PullRule, RobotType, TargetSpec
from understudy.sim.sensing.sensor_row import list_claimable_targets

NOT_BESIDE = ("home", "solid", "pushable", "presence", "capture", "walk")


def check_boxes_and_signals(checker: ScenarioErrors) -> None:
    """Raise SettingError if a box cannot be pulled or gathered, or no behavior raises a signal that is used."""
    scenario = checker.scenario
    for index, thing in enumerate(scenario.objects):
        if thing.pull is not None:
            _check_box(checker, f"objects[{index}]", thing, thing.pull)
    for name, robot_type in scenario.types.items():
        for index, sensor in enumerate(robot_type.sensors):
            if isinstance(sensor, ClaimSensor):
                _check_claimed(checker, f"types.{name}.sensors[{index}]", sensor)
    for name, target in scenario.targets.items():
        _check_target(checker, f"targets.{name}", target)
    if scenario.goal is not None and scenario.goal.gathered:
        _check_goal(checker, scenario.goal)


def check_signal(checker: ScenarioErrors, key: str, channels: Mapping[str, float | str]) -> None:
    """Raise SettingError if the value of the channel `signal` is not a name, or that of another channel is text."""
    for channel, value in channels.items():
        if channel == SIGNAL and not isinstance(value, str):
            remedy = 'give the name of the signal that it raises: signal = "help"'
            checker.fail(f"{key}.{channel}", f"is {value}", remedy)
        if channel != SIGNAL and isinstance(value, str):
            checker.fail(f"{key}.{channel}", f"is {value!r:.60}, a text", "give a number from -1 to 1")


def _check_box(checker: ScenarioErrors, key: str, thing: ObjectClass, pull: PullRule) -> None:
    """Raise SettingError if a box has other uses, needs too many robots, or appears again in a circle."""
    others = [word for word in NOT_BESIDE if getattr(thing, word)]
    others += ["amount"] if thing.amount not in (0, (0, 0)) else []
    if others:
        problem = f"is given beside {join_names(others)}"
        checker.fail(f"{key}.pull", problem, "leave out one or the other: boxes to pull are nothing else")
    robots = sum(count_robots(each.count, each.at) for each in checker.scenario.robots)
    if pull.robots > robots:
        problem = f"is {pull.robots}, and there are {robots} robots"
        checker.fail(f"{key}.pull.robots", problem, f"give at most {robots}, or more robots")
    region = checker.scenario.regions.get(thing.within or "")
    if pull.respawn and region is not None and region.box is None:
        problem = "is a circle for boxes that appear again"
        checker.fail(f"{key}.within", problem, "give a region that is a box")


def _check_claimed(checker: ScenarioErrors, key: str, sensor: ClaimSensor) -> None:
    _check_raised(checker, f"{key}.signal", sensor.signal)
    claimable = list_claimable_targets(checker.scenario)
    if sensor.targets is not None and not sensor.targets:
        checker.fail(f"{key}.targets", "is empty", "leave it out for all targets, or name some")
    for name in sensor.targets or ():
        checker.check_known(
            f"{key}.targets", name, claimable, what="target that is an object and may be claimed"
        )


def _check_target(checker: ScenarioErrors, key: str, target: TargetSpec) -> None:
    for word in ("signal", "unclaimed"):
        signal = getattr(target, word)
        if signal is not None:
            _check_raised(checker, f"{key}.{word}", signal)
    if target.unclaimed is not None and target.nearest is None:
        remedy = "give the class of the objects as `nearest`"
        checker.fail(f"{key}.unclaimed", "is given without `nearest`", remedy)
    if (target.unclaimed is None) != (target.within is None):
        present, other = ("within", "unclaimed") if target.unclaimed is None else ("unclaimed", "within")
        remedy = f"give both or neither: {other} is {'the signal that claims' if present == 'within' else 'how near'}"
        checker.fail(f"{key}.{present}", f"is given without `{other}`", remedy)


def _check_raised(checker: ScenarioErrors, key: str, signal: str) -> None:
    checker.check_known(key, signal, list_signals(checker.scenario), what="signal that some behavior raises")


def _check_goal(checker: ScenarioErrors, goal: Goal) -> None:
    """Raise SettingError if there is no home for boxes, or there are too few boxes."""
    things = checker.scenario.objects
    boxes = [thing for thing in things if thing.pull is not None]
    if not boxes:
        checker.fail("goal.gathered", "cannot be: there is no box", "give an object a pull")
    if not any(thing.home and not thing.solid and not thing.pushable for thing in things):
        remedy = "give an object home = true that is not solid"
        checker.fail("goal.gathered", "cannot be: there is no home that a box can be brought into", remedy)
    most = sum(map(get_most_count, boxes))
    if goal.gathered > most and not any(thing.pull and thing.pull.respawn for thing in boxes):
        problem = f"is {goal.gathered}, and there are {most} boxes at most"
        checker.fail("goal.gathered", problem, f"give at most {most}, or let boxes respawn")


def list_raised_signals(robot_type: RobotType) -> list[tuple[str, str]]:
    """Return the behaviors of a type that raise a signal, each with its signal."""
    signals = ((name, each.get(SIGNAL)) for name, each in robot_type.behaviors.items())
    return [(name, signal) for name, signal in signals if isinstance(signal, str)]
