"""Worlds of scenarios that differ only in places and amounts, side by side, each as it would be alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from msgspec import UNSET
from msgspec.structs import replace

from understudy.sim.layout.breakdowns import draw_failure_ticks
from understudy.sim.layout.placement import lay_out_worlds
from understudy.sim.params import get_count_range
from understudy.sim.scenario.schema import ObjectClass, RobotGroup, Scenario
from understudy.sim.world import World
from understudy.storage.json_text import encode_json


class Trial(NamedTuple):
    """A world in which a behavior is run: a scenario and the seed that lays it out."""

    scenario: Scenario
    seed: int


def group_alike(trials: Sequence[Trial]) -> list[list[int]]:
    """Return the rows of the trials that can run side by side, in groups."""
    shapes: dict[int, bytes] = {}
    groups: dict[bytes, list[int]] = {}
    for row, trial in enumerate(trials):
        key = id(trial.scenario)
        if key not in shapes:
            shapes[key] = _describe_shape(trial.scenario)
        groups.setdefault(shapes[key], []).append(row)
    return list(groups.values())


def _describe_shape(scenario: Scenario) -> bytes:
    """Return all of a scenario but the places of objects and robots, the amounts of food, and which robots fail."""
    return encode_json(
        replace(
            scenario,
            objects=tuple(map(_strip_object, scenario.objects)),
            robots=tuple(map(_strip_robots, scenario.robots)),
        )
    )


def _strip_object(thing: ObjectClass) -> ObjectClass:
    amount = int(get_count_range(thing.amount)[1] > 0)
    if not isinstance(thing.at, tuple):
        return replace(thing, amount=amount)
    return replace(thing, amount=amount, at=UNSET, count=len(thing.at), within=None)


def _strip_robots(group: RobotGroup) -> RobotGroup:
    group = replace(group, fails=())
    if not isinstance(group.at, tuple):
        return group
    return replace(group, at=UNSET, count=len(group.at), within=None)


def lay_out_each(world: World, trials: Sequence[Trial]) -> None:
    """Lay out each of several worlds by its own scenario, before the first tick; they must be alike.

    SettingError if something finds no free place.
    """
    first = trials[0].scenario
    for row, (scenario, seed) in enumerate(trials):
        if scenario is first:
            continue
        state = lay_out_worlds(scenario, world.rules, np.array([seed], np.int64))
        state.robots["aim"] = np.nan
        world.state.robots[row * world.robots : (row + 1) * world.robots] = state.robots
        world.state.objects[row] = state.objects[0]
        own = slice(row * world.robots, (row + 1) * world.robots)
        world.failure_ticks[own] = draw_failure_ticks(scenario, np.array([seed], np.int64))[0]
        world.state.robots["frozen"][own] = world.failure_ticks[own] == 0
