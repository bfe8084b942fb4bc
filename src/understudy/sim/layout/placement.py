"""Lay out new worlds: given places, and free places drawn by each world's seed alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import hypot, nan, radians, sqrt
from typing import Any

import numpy as np

from understudy.errors import SettingError
from understudy.sim.kernels import clearance as _space
from understudy.sim.kernels import placement as _crowd
from understudy.sim.kernels import placement as _kernels
from understudy.sim.kernels.dtypes import DISC, OBJECT, ROBOT, SEGMENT
from understudy.sim.kernels.rng import Seeds
from understudy.sim.layout.clearance import list_wall_segments, orient_counter_clockwise
from understudy.sim.params import (
    ScenarioNames,
    collect_names,
    count_robots,
    get_count_range,
    get_most_count,
    get_region_box,
)
from understudy.sim.scenario.schema import (
    ArenaPoint,
    ObjectClass,
    Obstacle,
    Placement,
    RobotGroup,
    Scenario,
)
from understudy.sim.state import Records, WorldParams, WorldState

CELLS_PER_THING = 0.5
"""The number of cells per thing in the grid that is used to find free places."""


def lay_out_worlds(scenario: Scenario, rules: WorldParams, seeds: Seeds) -> WorldState:
    """Lay out one world per seed; raise SettingError if there is no free place for something."""
    plan = _PlacementPlan(scenario, collect_names(scenario), rules)
    state = plan.empty(seeds)
    worlds = len(seeds)
    world, group, thing = _kernels.place_objects(
        plan.groups,
        plan.places,
        plan.corners,
        plan.walls,
        float(rules.width),
        float(rules.height),
        plan.cell(),
        state.seeds,
        rules.generator,
        state.robots.reshape(worlds, -1),
        state.objects,
        state.discs,
        state.segments,
    )
    if world >= 0:
        raise _full(scenario, plan.keys[group], thing, int(seeds[world]))
    return state


def _full(scenario: Scenario, key: str, thing: int, seed: int) -> SettingError:
    return SettingError(
        where=f"scenario {scenario.name!r}",
        setting=f"{key}.count",
        problem=f"does not fit: no free place was found for number {thing + 1} in the world of seed {seed}",
        remedy="give fewer or smaller things, less `apart`, or a larger size or region",
    )


@dataclass
class _PlacementPlan:
    """The things to place, as arrays for the kernel: those with given places first, then those with random places."""

    scenario: Scenario
    names: ScenarioNames
    rules: WorldParams
    keys: list[str] = field(default_factory=list)
    rows: list[Records] = field(default_factory=list)
    _places: list[tuple[float, float, float]] = field(default_factory=list)
    _corners: list[ArenaPoint] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.walls = np.array(
            [(*start, *end, 1) for start, end in list_wall_segments(self.scenario)], SEGMENT
        ).reshape(-1)
        self.discs, self.segments, robots = 0, len(self.walls), 0
        for index, obstacle in enumerate(self.scenario.obstacles):
            self._obstacle(f"obstacles[{index}]", obstacle)
        for index, thing in enumerate(self.scenario.objects):
            self._objects(f"objects[{index}]", index, thing)
        for index, group in enumerate(self.scenario.robots):
            robots = self._robots(f"robots[{index}]", robots, group)
        order = order_placements(self.rows)
        self.keys = [self.keys[index] for index in order]
        self.groups = np.array([self.rows[index] for index in order], _crowd.GROUP).reshape(-1)
        self.places = np.array(self._places, np.float64).reshape(-1, 3)
        self.corners = np.array(self._corners, np.float64).reshape(-1, 2)

    def empty(self, seeds: Seeds) -> WorldState:
        """Return the state of worlds with nothing in them."""
        worlds, rules = len(seeds), self.rules
        objects = np.zeros((worlds, len(rules.class_of)), OBJECT)
        objects["due"] = objects["captured"] = -1
        segments = np.zeros((worlds, self.segments), SEGMENT)
        for end in ("x0", "y0", "x1", "y1"):
            segments[end] = nan
        return WorldState(
            robots=np.zeros(worlds * rules.robots, ROBOT),
            objects=objects,
            discs=np.zeros((worlds, self.discs), DISC),
            segments=segments,
            seeds=np.array(seeds, np.int64),
            tick=np.zeros(worlds, np.int64),
            finished=np.full(worlds, -1, np.int64),
            memory=np.zeros((worlds * rules.robots, 0)),
        )

    def cell(self) -> float:
        """Return the side of a cell of the grid, m, such that few things are in each."""
        width, height = self.rules.width, self.rules.height
        things = max(1, int(self.groups["most"].sum()))
        return max(sqrt(width * height / things / CELLS_PER_THING), max(width, height) / 10_000)

    def _obstacle(self, key: str, obstacle: Obstacle) -> None:
        most = get_most_count(obstacle)
        row = self._row(key, obstacle, turned=0.0 if obstacle.points is not None else nan)
        row["solid"] = 1
        row["color"] = self.names.color(obstacle.color)
        if obstacle.points is None:
            row["thing"], row["first"], row["radius"] = _space.DISC, self.discs, obstacle.radius or 0.0
            row["height"] = 2.0 * row["radius"] if obstacle.height is None else obstacle.height
            self.discs += most
        else:
            corners = orient_counter_clockwise(obstacle.points)
            row["thing"], row["first"] = _space.POLYGON, self.segments
            row["radius"] = max(hypot(x, y) for x, y in corners)
            row["point"], row["end_point"] = len(self._corners), len(self._corners) + len(corners)
            row["segment"] = self.segments
            self._corners.extend(corners)
            self.segments += most * len(corners)

    def _objects(self, key: str, index: int, thing: ObjectClass) -> None:
        row = self._row(key, thing)
        kind = self.rules.classes[index]
        row["thing"], row["first"], row["radius"] = _space.OBJECT, kind["first"], thing.radius
        row["solid"] = kind["solid"]
        row["amount_least"], row["amount_most"] = get_count_range(thing.amount)
        if thing.presence is not None:
            due = np.array(thing.presence.first_s or thing.presence.away_s) / self.scenario.tick_s
            row["due_least"], row["due_most"] = due

    def _robots(self, key: str, first: int, group: RobotGroup) -> int:
        row = self._row(key, group)
        kind = self.scenario.types[group.type]
        row["thing"], row["first"], row["radius"] = _space.ROBOT, first, kind.radius
        row["type"], row["stored"] = self.names.types.index(group.type), group.stored
        row["solid"] = row["alone"] = kind.collides
        count = count_robots(group.count, group.at)
        row["least"] = row["most"] = count
        return first + count

    def _row(self, key: str, placing: Placement, *, turned: float = nan) -> Records:
        row: Records = np.zeros(1, _crowd.GROUP)[0]
        row["apart"], row["near_m"] = placing.apart, placing.near_m
        row["x0"], row["y0"], row["x1"], row["y1"] = get_region_box(self.scenario, placing.within)
        region = self.scenario.regions.get(placing.within or "")
        row["circle"] = nan if region is None or region.radius is None else region.radius
        row["due_least"] = row["due_most"] = nan
        row["place"], row["near"], row["alone"] = -1, -1, 1
        row["least"], row["most"] = (
            get_count_range(placing.count) if isinstance(placing.count, int | tuple) else (1, 1)
        )
        if isinstance(placing.at, tuple):
            row["place"] = len(self._places)
            row["least"] = row["most"] = len(placing.at)
            for x, y, *heading in placing.at:
                self._places.append((x, y, radians(heading[0]) % _kernels.TAU if heading else turned))
        elif placing.near is not None:
            row["near"] = self.rules.classes["first"][self.names.classes.index(placing.near)]
        self.keys.append(key)
        self.rows.append(row)
        return row


def order_placements(rows: Sequence[Any]) -> list[int]:
    """Return the order of placing: given places first, then each thing after the object that it is near."""
    left = sorted(range(len(rows)), key=lambda index: rows[index]["place"] < 0)
    order: list[int] = []
    objects = {int(rows[index]["first"]): index for index in left if rows[index]["thing"] == _space.OBJECT}
    while left:
        ready = (
            index
            for index in left
            if objects.get(int(rows[index]["near"]), index) not in left or rows[index]["near"] < 0
        )
        index = next(ready, left[0])
        order.append(index)
        left.remove(index)
    return order
