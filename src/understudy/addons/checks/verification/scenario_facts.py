"""What a check may assume of a world: ties between readings, the end of a run, and what a standing robot reads."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf

from msgspec import UNSET

from understudy.addons.checks.verification.scenario_ties import (
    CLOSE,
    DOWN,
    NONE,
    list_bound_features,
    list_scenario_ties,
    measures_exactly,
)
from understudy.addons.checks.verification.squad_ties import list_squad_ties
from understudy.addons.checks.verification.ties import Tie
from understudy.model.features import Feature
from understudy.model.library import Library
from understudy.model.squad import Squad
from understudy.model.tree_regions import ValueSet
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
