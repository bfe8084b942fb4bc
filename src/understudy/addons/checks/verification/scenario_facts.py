"""What a check may assume of a world: ties between readings, the end of a run, and what a standing robot reads."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from math import inf, nextafter

from msgspec import UNSET

from understudy.addons.checks.verification.scenario_ties import (
    CLOSE,
    DOWN,
    NONE,
    UP,
    list_bound_features,
    list_scenario_ties,
    measures_exactly,
)
from understudy.addons.checks.verification.ties import Tie, make_presence_tie, make_range_tie
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Library
from understudy.model.squad import YES_OR_NO, Squad, Statistic
from understudy.model.tree_regions import ValueSet
from understudy.model.value_kinds import Toroidal
from understudy.sim.scenario.schema import ElapsedSensor, RandomSensor, Scenario, SensorBase, StallSensor
from understudy.sim.sensing.sensor_table import find_sensor_row

NOISE = ("dropout", "noise", "noise_deg", "noise_range", "noise_x", "noise_size", "misses", "ghosts")
"""The settings by which a sensor's readings vary while nothing moves."""


@dataclass(frozen=True, slots=True)
class ScenarioFacts:
    """What is assumed of the world in which automata run.

    Parameters
    ----------
    ties
        Ties between features that readings fulfill.
    goal_ties
        What readings do not do before the goal is reached. Nothing is reported of what happens only after it.
    still_readings
        Names of the readings that do not change while the robot idles.
    tick_s
        Length of a tick, s. None: findings that depend on it say which is assumed.
    """

    ties: Sequence[Tie] = ()
    goal_ties: Sequence[Tie] = ()
    still_readings: frozenset[str] = frozenset()
    tick_s: float | None = None


NOTHING_ASSUMED = ScenarioFacts()


def collect_scenario_facts(scenario: Scenario, library: Library, squad: Squad | None = None) -> ScenarioFacts:
    """Collect what a scenario guarantees to the robots of a library, or to the coordinators of a squad.

    Parameters
    ----------
    scenario
        The scenario.
    library
        The library, opened with its kit.
    squad
        The squad whose coordinators the library is for. None: it is for robots.

    Returns
    -------
    ScenarioFacts
        What a check of the library may assume.
    """
    if squad is not None:
        return ScenarioFacts(list_squad_ties(squad, library, scenario), tick_s=scenario.tick_s)
    return ScenarioFacts(
        list_scenario_ties(scenario, library),
        list(list_goal_ties(scenario, library)),
        list_still_readings(scenario),
        scenario.tick_s,
    )


def list_goal_ties(scenario: Scenario, library: Library) -> Iterator[Tie]:
    """Yield the readings that mean that the goal is reached; nothing if what robots read does not tell."""
    goal, features = scenario.goal, list_bound_features(library, scenario.targets)
    if goal is None or not measures_exactly(scenario):
        return
    alone = _has_one_robot(scenario)
    by_reading = {each.feature.reading: each for each in features if isinstance(each.feature, Feature)}
    left, stored = by_reading.get("food_left"), by_reading.get("food_stored")
    if goal.delivered and alone and left is not None and stored is not None:
        yield Tie(f"the run ends once {left} is no and {stored} is 0", {left: DOWN, stored: NONE})
    if goal.target is None or (goal.all and not alone):
        return
    for each in features:
        meant = scenario.targets.get(next(iter(each.binding.values()), ""))
        is_range = isinstance(each.feature, Feature) and each.feature.reading == "range"
        if is_range and meant is not None and goal.target in (meant.nearest, meant.object):
            near = ValueSet(((-inf, goal.within - CLOSE),), False)
            yield Tie(f"the run ends once {each} is at most {goal.within:g} m", {each: near})


def list_still_readings(scenario: Scenario) -> frozenset[str]:
    """List the readings that do not change while the only robot of a scenario idles.

    None, if there are other robots, or things that come, go or move by themselves, or if the robot slides on.
    """
    moves = any(each.walk or each.presence or each.capture for each in scenario.objects)
    types = scenario.types.values()
    slides = any(each.acceleration or each.turning_acceleration_deg for each in types)
    if moves or slides or not _has_one_robot(scenario):
        return frozenset()
    sensors = [sensor for each in types for sensor in each.sensors]
    varying = {name for each in sensors if _varies(each) for name in _list_readings(each)}
    return frozenset(name for each in sensors for name in _list_readings(each)) - varying


def _varies(sensor: SensorBase) -> bool:
    varies_by_itself = isinstance(sensor, RandomSensor | ElapsedSensor | StallSensor)
    return varies_by_itself or sensor.rate_hz is not None or any(getattr(sensor, name, 0) for name in NOISE)


def _list_readings(sensor: SensorBase) -> list[str]:
    return [reading.name for reading in find_sensor_row(sensor).readings(sensor)]


def _has_one_robot(scenario: Scenario) -> bool:
    if len(scenario.robots) != 1:
        return False
    (robots,) = scenario.robots
    return len(robots.at) == 1 if isinstance(robots.at, tuple) else robots.count in (UNSET, 1)


def list_squad_ties(squad: Squad, library: Library, scenario: Scenario) -> list[Tie]:
    """List the ties between the features of coordinators, which follow from the definitions of their statistics.

    Parameters
    ----------
    squad
        The squad, with its statistics.
    library
        The library of its coordinators.
    scenario
        The scenario, whose targets features may be bound to.

    Returns
    -------
    list[Tie]
        The ties.
    """
    statistics = {each.name: each for each in squad.statistics}
    features = [
        (bound, statistics[bound.feature.reading])
        for bound in list_bound_features(library, scenario.targets)
        if isinstance(bound.feature, Feature) and bound.feature.reading in statistics
    ]
    ties: list[Tie] = []
    for bound, statistic in features:
        ties += _list_single(bound, statistic)
    for (first, one), (second, other) in permutations(features, 2):
        if dict(first.binding) == dict(second.binding):
            ties += _list_pairs(first, one, second, other)
    return ties


def _list_single(bound: BoundFeature, statistic: Statistic) -> Iterator[Tie]:
    if statistic.how in YES_OR_NO and not statistic.since:
        yield make_presence_tie(bound, f"{bound} is never absent")
    if statistic.how == "fraction":
        yield make_range_tie(bound, 0.0, nextafter(1.0, inf), f"{bound} is at least 0 and at most 1")
    if statistic.how in ("count", "spread") or statistic.since:
        yield make_range_tie(bound, 0.0, inf, f"{bound} is at least 0")


def _list_pairs(first: BoundFeature, one: Statistic, second: BoundFeature, other: Statistic) -> Iterator[Tie]:
    """Yield the ties between two statistics of the same members and the same condition."""
    if one.reading is None and one.flag is None:
        return
    if _is_told(one, other) and _get_condition(one) == _get_condition(other):
        if (one.how, other.how) == ("all", "any"):
            yield Tie(f"{first} is yes only while {second} is yes", {first: UP, second: DOWN})
        if (one.how, other.how) == ("any", "none"):
            sentence = f"{first} is yes exactly while {second} is no"
            yield Tie(sentence, {first: UP, second: UP})
            yield Tie(sentence, {first: DOWN, second: DOWN})
    is_recent = one.how == other.how == "any" and not one.is_timed and other.within_s is not None
    if is_recent and one.flag is None and _get_condition(one) == _get_condition(other):
        yield Tie(f"{first} is yes only while {second} is yes", {first: UP, second: DOWN})
    order = ("minimum", "mean", "maximum")
    alike = one.how in order and other.how in order and not one.is_timed and not other.is_timed
    same = (one.reading, one.role) == (other.reading, other.role)
    if alike and same and order.index(one.how) < order.index(other.how) and not _is_angle(first):
        yield Tie(f"{first} is at most {second}", {}, ((first, 1.0), (second, -1.0)), 0.0)


def _get_condition(statistic: Statistic) -> Statistic:
    """Return a statistic that is equal for all statistics of the same condition, now or lately."""
    return replace(statistic, name="", doc="", how="any", within_s=None)


def _is_told(one: Statistic, other: Statistic) -> bool:
    return one.how in YES_OR_NO and other.how in YES_OR_NO and not one.is_timed and not other.is_timed


def _is_angle(bound: BoundFeature) -> bool:
    return isinstance(bound.kind, Toroidal)
