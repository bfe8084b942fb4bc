"""Runs of a team in unseen worlds, in which robots fail at random."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from understudy.errors import SettingError
from understudy.runtime.team.team import Team
from understudy.sim.world import World

FAILING = 3
"""One robot of this many fails."""


def world_of(team: Team) -> World:
    """Return the simulated world of a team, or raise SettingError if it has none."""
    ground = getattr(team.ground, "world", team.ground)  # in physics: the one that says what there is
    if not isinstance(ground, World):
        raise SettingError(where="experiment", setting="team", problem="is in no world", remedy="give it one")
    return ground


def schedule_failures(worlds: Sequence[int], robots: int, within: tuple[int, int]) -> dict[int, list[int]]:
    """Return which robots fail, by the tick at which they do.

    `worlds` are the seeds of the worlds. In each, a random third of its robots fails, each at a random tick of a range.
    Robots are counted through all worlds: number `world * robots + robot`.
    """
    draws = np.random.default_rng(list(worlds))
    robots_by_tick: dict[int, list[int]] = {}
    for world in range(len(worlds)):
        for robot in draws.choice(robots, robots // FAILING, replace=False).tolist():
            robots_by_tick.setdefault(int(draws.integers(*within)), []).append(world * robots + robot)
    return robots_by_tick


def run_with_failures(team: Team, ticks: int, fails: Mapping[int, Sequence[int]]) -> None:
    """Run a team for a number of ticks; `fails` maps a tick to the robots that fail in it."""
    world, at = world_of(team), 0
    for tick in sorted({*fails, ticks}):
        team.run(tick - at)
        at = tick
        for robot in fails.get(tick, ()):
            world.freeze(robot)
