"""The worlds that a scenario allows, as vectors of numbers from 0 to 1 that a search can vary.

A vector gives the places of robots, objects and round obstacles, the headings of robots, the numbers and amounts of
objects, how much noise and dropout there is, and how many robots fail when. What a scenario fixes stays fixed.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from math import degrees, tau

import numpy as np
from msgspec import UNSET
from msgspec.structs import replace

from understudy.addons.checks.falsification.disturbances import (
    BreakdownRange,
    Disturbance,
    apply_breakdowns,
    apply_disturbances,
    list_breakdown_ranges,
    list_disturbances,
)
from understudy.addons.checks.falsification.free_places import FreePlaces
from understudy.errors import SettingError
from understudy.model.value_kinds import Column
from understudy.sim.params import get_count_range, get_region_box
from understudy.sim.scenario.schema import MOUSE, ObjectClass, Obstacle, Placement, RobotGroup, Scenario
from understudy.sim.scenario.validate_places import list_placed, replace_placed
from understudy.sim.view import WorldView

PLACES, SIZES, DISTURBANCES = "places", "sizes", "disturbances"
ASPECTS = (PLACES, SIZES, DISTURBANCES)
"""The aspects that a search can vary: places and headings, numbers and amounts, noise, dropout and failing robots."""


@dataclass(frozen=True, slots=True)
class PlacedGroup:
    """Things of one kind whose random places are varied: `most` of them, each with two or three coordinates.

    `key` is that of the things in the scenario. `first` is the position of the first coordinate in the vector. `count`
    and `amount` are the positions of their number and amount, -1 if these are fixed.
    """

    key: str
    things: Placement
    least: int
    most: int
    radius: float
    box: tuple[float, float, float, float]
    circle: float | None
    first: int
    count: int = -1
    amount: int = -1

    @property
    def is_turned(self) -> bool:
        """True if the search varies the headings of the things, too: they are robots."""
        return isinstance(self.things, RobotGroup)

    @property
    def amounts(self) -> tuple[int, int]:
        """The least and the largest amount of the things."""
        return get_count_range(self.things.amount) if isinstance(self.things, ObjectClass) else (0, 0)

    @property
    def width(self) -> int:
        """The number of coordinates of each thing."""
        return 3 if self.is_turned else 2


class SearchSpace:
    """The worlds of a scenario as vectors [d] in [0, 1].

    Parameters
    ----------
    scenario
        The scenario.
    vary
        What is varied, of `ASPECTS`. The rest is drawn by the seed, or as the scenario has it.

    Raises
    ------
    SettingError
        If nothing can be varied.
    """

    def __init__(self, scenario: Scenario, vary: Collection[str] = ASPECTS) -> None:
        self.scenario = scenario
        self._names: list[str] = []
        self._groups = tuple(self._list_groups(vary)) if PLACES in vary or SIZES in vary else ()
        self._disturbances: dict[int, Disturbance] = {}
        for disturbance in list_disturbances(scenario) if DISTURBANCES in vary else ():
            self._disturbances[self._add(disturbance.name)] = disturbance
        self._breakdowns: dict[int, BreakdownRange] = {}
        for breakdown in list_breakdown_ranges(scenario) if DISTURBANCES in vary else ():
            self._breakdowns[self._add(breakdown.name)] = breakdown
        if not self._names:
            raise SettingError(
                where=f"scenario {scenario.name!r}",
                setting="falsify",
                problem="has nothing that can be varied: all places, numbers and noises are given",
                remedy="search at random, or give counts instead of places",
            )

    @property
    def names(self) -> tuple[str, ...]:
        """The meaning of each number of a vector."""
        return tuple(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def decode(self, vector: Column) -> Scenario:
        """Return the scenario of a vector, with given places; things that would overlap move to free places nearby."""
        free, placed = FreePlaces(self.scenario), self.scenario
        for group in self._groups:
            placed = replace_placed(placed, group.key, _place(group, vector, free))
        strengths = {each: float(vector[at]) for at, each in self._disturbances.items()}
        shares = {each: float(vector[at]) for at, each in self._breakdowns.items()}
        return apply_breakdowns(apply_disturbances(placed, strengths), shares)

    def encode(self, view: WorldView, rng: np.random.Generator) -> Column:
        """Return the vector of a world as it stands; what the world does not have is drawn at random."""
        vector = rng.random(len(self))
        for at, disturbance in self._disturbances.items():
            vector[at] = disturbance.default
        for at, breakdown in self._breakdowns.items():
            vector[at] = breakdown.find_share(self.scenario, view)
        robot = 0
        for group in self._groups:
            places, amounts = _find_places(view, group, robot)
            robot += len(places) if group.is_turned else 0
            x0, y0, x1, y1 = group.box
            for number, (x, y, heading) in enumerate(places[: group.most]):
                at = group.first + number * group.width
                vector[at] = np.clip((x - x0) / max(x1 - x0, 1e-9), 0.0, 1.0)
                vector[at + 1] = np.clip((y - y0) / max(y1 - y0, 1e-9), 0.0, 1.0)
                if group.is_turned:
                    vector[at + 2] = heading % tau / tau
            if group.count >= 0:
                vector[group.count] = (len(places) - group.least + 0.5) / (group.most - group.least + 1)
            if group.amount >= 0 and amounts:
                low, high = group.amounts
                vector[group.amount] = (np.mean(amounts) - low + 0.5) / (high - low + 1)
        return np.clip(vector, 0.0, np.nextafter(1.0, 0.0))

    def _add(self, name: str) -> int:
        self._names.append(name)
        return len(self._names) - 1

    def _list_groups(self, vary: Collection[str]) -> Iterator[PlacedGroup]:
        for key, things, radius in list_placed(self.scenario):
            if _is_placed_at_random(things):
                yield self._make_group(key, things, radius, vary)

    def _make_group(self, key: str, things: Placement, radius: float, vary: Collection[str]) -> PlacedGroup:
        scenario, label = self.scenario, key
        if isinstance(things, RobotGroup | ObjectClass):
            label = f"{key} ({things.type if isinstance(things, RobotGroup) else things.name})"
        least, most = get_count_range(things.count) if isinstance(things.count, int | tuple) else (1, 1)
        reach = radius + things.apart
        x0, y0, x1, y1 = get_region_box(scenario, things.within)
        region = scenario.regions.get(things.within or "")
        axes = ("x", "y", "heading") if isinstance(things, RobotGroup) else ("x", "y")
        first = len(self._names)
        for number in range(most):
            self._names += [f"{label}.at[{number}].{axis}" for axis in axes]
        amount = things.amount if isinstance(things, ObjectClass) else 0
        return PlacedGroup(
            key,
            things,
            least,
            most,
            radius,
            (
                max(x0, reach),
                max(y0, reach),
                min(x1, scenario.size[0] - reach),
                min(y1, scenario.size[1] - reach),
            ),
            None if region is None else region.radius,
            first,
            self._add(f"{label}.count") if most > least and SIZES in vary else -1,
            self._add(f"{label}.amount") if isinstance(amount, tuple) and SIZES in vary else -1,
        )


def _place(group: PlacedGroup, vector: Column, free: FreePlaces) -> Placement:
    """Return a group of things at the places that a vector says."""
    things = group.things
    count = group.most if group.count < 0 else _choose(vector[group.count], group.least, group.most)
    changed: dict[str, object] = {}
    if group.amount >= 0:
        changed["amount"] = _choose(vector[group.amount], *group.amounts)
    x0, y0, x1, y1 = group.box
    places = []
    for number in range(count):
        at = group.first + number * group.width
        wanted = x0 + float(vector[at]) * (x1 - x0), y0 + float(vector[at + 1]) * (y1 - y0)
        x, y = free.take(wanted, group.radius, things.apart, group.box, group.circle, key=group.key)
        heading = (degrees(float(vector[at + 2]) * tau) % 360.0,) if group.is_turned else ()
        places.append((x, y, *heading))
    if not places:
        return replace(things, count=0, **changed)
    return replace(things, count=UNSET, at=tuple(places), within=None, **changed)


def _choose(share: float, least: int, most: int) -> int:
    """Return the whole number from `least` to `most` at a share of the way, from 0 to 1."""
    return min(most, least + int(share * (most - least + 1)))


def _is_placed_at_random(thing: Placement) -> bool:
    """Return whether the places of things are drawn, once, independently of others, and can be given instead."""
    if isinstance(thing.at, tuple) or thing.near is not None or thing.count == 0:
        return False
    if isinstance(thing, Obstacle):
        return thing.radius is not None
    if isinstance(thing, ObjectClass):
        respawns = thing.pull is not None and thing.pull.respawn
        return thing.presence is None and not respawns and thing.walk is None and thing.name != MOUSE
    return True


def _find_places(
    view: WorldView, group: PlacedGroup, robot: int
) -> tuple[list[tuple[float, float, float]], list[int]]:
    """Return the places (x, y, heading) and the amounts of a group's things in a world."""
    if group.is_turned:
        rows = range(robot, robot + group.most)
        robots = view.robots
        return [
            (float(robots.x[each]), float(robots.y[each]), float(robots.heading[each])) for each in rows
        ], []
    if isinstance(group.things, ObjectClass):
        objects = view.objects
        kind = view.names.classes.index(group.things.name)
        rows_of = np.flatnonzero(objects.kind == kind).tolist()
        places = [(float(objects.x[each]), float(objects.y[each]), 0.0) for each in rows_of]
        return places, [int(objects.at_first[each]) for each in rows_of]
    discs = view.discs
    alike = np.flatnonzero(np.isclose(discs.radius, group.radius)).tolist()
    return [(float(discs.x[each]), float(discs.y[each]), 0.0) for each in alike], []
