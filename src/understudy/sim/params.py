"""Convert a scenario to arrays for kernels, the same for all its worlds, and to lists of the names behind indices."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf, nan, radians

import numpy as np

from understudy.sim.kernels.dtypes import CLASS, TYPE
from understudy.sim.scenario.schema import MOUSE, Goal, ObjectClass, Placement, RobotType, Scenario
from understudy.sim.state import (
    GOAL_ALL_NEAR,
    GOAL_DELIVERED,
    GOAL_GATHERED,
    GOAL_NEAR,
    GOAL_NONE,
    Records,
    WorldParams,
)

SIGNAL = "signal"
"""The name of the channel that raises a signal."""


@dataclass(frozen=True)
class ScenarioNames:
    """The names behind indices in arrays: classes of objects in order of slots, robot types, colors, teams, signals."""

    classes: tuple[str, ...]
    types: tuple[str, ...]
    colors: tuple[str, ...]
    teams: tuple[str, ...]
    signals: tuple[str, ...]

    def color(self, name: str | None) -> int:
        """Return the index of a color; -1 for None, or for a color that nothing in the scenario has."""
        return self.colors.index(name) if name in self.colors else -1


def collect_names(scenario: Scenario) -> ScenarioNames:
    """Collect the names in a scenario, in order of their indices."""
    kinds = scenario.types.values()
    colored = [
        *(obstacle.color for obstacle in scenario.obstacles),
        *(thing.color for thing in scenario.objects),
        *(kind.color for kind in kinds),
    ]
    return ScenarioNames(
        classes=(*(thing.name for thing in scenario.objects), MOUSE),
        types=tuple(scenario.types),
        colors=_distinct(color for color in colored if color is not None),
        teams=_distinct(kind.team or name for name, kind in scenario.types.items()),
        signals=list_signals(scenario),
    )


def list_signals(scenario: Scenario) -> tuple[str, ...]:
    """List the signals that behaviors raise, in the order of the file; the first is number 1 in commands and states."""
    behaviors = (each for kind in scenario.types.values() for each in kind.behaviors.values())
    return _distinct(word for each in behaviors if isinstance(word := each.get(SIGNAL), str))


def make_world_params(scenario: Scenario) -> WorldParams:
    """Convert a scenario to the arrays and numbers that all its worlds share."""
    names = collect_names(scenario)
    classes = _classes(scenario, names)
    goal = scenario.goal
    return WorldParams(
        types=_types(scenario, names),
        classes=classes,
        class_of=np.repeat(
            np.arange(len(classes), dtype=np.int32), (classes["end"] - classes["first"]).astype(np.intp)
        ),
        width=scenario.size[0],
        height=scenario.size[1],
        tick_s=scenario.tick_s,
        robots=sum(count_robots(robots.count, robots.at) for robots in scenario.robots),
        goal=_goal(goal),
        goal_target=names.classes.index(goal.target) if goal is not None and goal.target else -1,
        goal_within=goal.within if goal is not None else 0.0,
        goal_count=goal.gathered if goal is not None else 0,
        signals=len(names.signals),
        generator=scenario.generator,
    )


def _goal(goal: Goal | None) -> int:
    if goal is None:
        return GOAL_NONE
    if goal.delivered:
        return GOAL_DELIVERED
    if goal.gathered:
        return GOAL_GATHERED
    return GOAL_ALL_NEAR if goal.all else GOAL_NEAR


def count_robots(count: object, at: object) -> int:
    """Return the number of robots in a group: the number of places if they are given, else its count."""
    if isinstance(at, tuple):
        return len(at)
    return count if isinstance(count, int) else 1


def get_most_count(thing: Placement) -> int:
    """Return the largest number of things of a group in a new world."""
    if isinstance(thing.at, tuple):
        return len(thing.at)
    if isinstance(thing.count, tuple):
        return thing.count[1]
    return thing.count if isinstance(thing.count, int) else 1


def get_count_range(count: int | tuple[int, int]) -> tuple[int, int]:
    """Return a count, or a (least, most) pair of counts, as a pair."""
    return (count, count) if isinstance(count, int) else count


def _distinct(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(names))


def _types(scenario: Scenario, names: ScenarioNames) -> Records:
    rows = np.zeros(len(scenario.types), TYPE)
    for row, (name, kind) in zip(rows, scenario.types.items(), strict=True):
        row["radius"] = kind.radius
        row["height"] = 2.0 * kind.radius if kind.height is None else kind.height
        row["speed"] = kind.speed * scenario.tick_s
        row["turning"] = radians(kind.turning_deg) * scenario.tick_s
        row["acceleration"], row["turning_acceleration"] = _accelerations(kind, scenario.tick_s)
        row["noise_drive"], row["noise_turn"] = kind.noise_drive, kind.noise_turn
        row["reach"] = kind.reach
        row["color"] = names.color(kind.color)
        row["team"] = names.teams.index(kind.team or name)
        row["capacity"] = kind.capacity
        row["load_ticks"] = round(kind.load_s / scenario.tick_s)
        row["unload_ticks"] = round(kind.unload_s / scenario.tick_s)
        row["collides"] = kind.collides
    return rows


def _accelerations(robot_type: RobotType, tick_s: float) -> tuple[float, float]:
    along = inf if robot_type.acceleration is None else robot_type.acceleration * tick_s**2
    turning = robot_type.turning_acceleration_deg
    return along, inf if turning is None else radians(turning) * tick_s**2


def _classes(scenario: Scenario, names: ScenarioNames) -> Records:
    things: Sequence[ObjectClass] = (*scenario.objects, ObjectClass(name=MOUSE, radius=0.0, count=1))
    rows = np.zeros(len(things), CLASS)
    first = 0
    for row, thing in zip(rows, things, strict=True):
        spare = 0 if thing.name == MOUSE else scenario.spare_objects
        row["first"], row["end"] = first, first + get_most_count(thing) + spare
        first = row["end"]
        row["radius"] = thing.radius
        row["height"] = 2.0 * thing.radius if thing.height is None else thing.height
        row["capture_range"] = thing.capture.range if thing.capture else nan
        row["capture_ticks"] = round(thing.capture.after_s / scenario.tick_s) if thing.capture else 0
        row["walk"] = thing.walk.speed * scenario.tick_s if thing.walk else 0.0
        row["turn_ticks"] = max(1, round(thing.walk.turn_s / scenario.tick_s)) if thing.walk else 0
        presence = thing.presence
        row["away_least"], row["away_most"] = presence.away_s if presence else (nan, nan)
        stays = presence.stays_s if presence else None
        row["stays_least"], row["stays_most"] = stays or (nan, nan)
        row["apart"] = thing.apart
        row["region"] = get_region_box(scenario, thing.within)
        row["color"] = names.color(thing.color)
        row["food"] = thing.amount != 0
        row["home"], row["solid"], row["pushable"] = thing.home, thing.solid or thing.pushable, thing.pushable
        row["pushers"] = thing.pushers
        row["opaque"] = -1 if thing.aloft else row["solid"]
        if thing.pull is not None:
            row["pull"], row["respawn"] = thing.pull.robots, thing.pull.respawn
    return rows


def get_region_box(scenario: Scenario, region: str | None) -> tuple[float, float, float, float]:
    """Return the box (x0, y0, x1, y1) around a region, in m; the whole arena for None."""
    if region is None:
        return 0.0, 0.0, *scenario.size
    shape = scenario.regions[region]
    if shape.box is not None:
        return shape.box
    (x, y), radius = shape.center or (0.0, 0.0), shape.radius or 0.0
    return x - radius, y - radius, x + radius, y + radius
