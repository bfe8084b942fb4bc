"""Progress towards a scenario's goal, and the times without any: what tells a run that is stuck from a slow one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import Column
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World

LEAST_STEP = 1e-3
"""The least increase of the share of the goal that counts as progress."""


class ProgressRecord:
    """The largest share of the goal that each of B worlds has reached so far, and when it last grew.

    Loading a unit of food counts half of delivering it. Without a goal the share stays 0.

    Parameters
    ----------
    world
        The worlds, before the first tick.
    scenario
        Their scenario.
    """

    def __init__(self, world: World, scenario: Scenario) -> None:
        self._world, self._goal = world, scenario.goal
        self._total = np.maximum(world.total.astype(np.float64), 1.0)
        self._first_m = self._measure_distance()
        self.best: Column = np.zeros(world.worlds)
        """The largest share so far [B], from 0 to 1."""
        self.last_s: Column = np.zeros(world.worlds)
        """The time at which the share last grew [B], s."""
        self._marked = self._measure_share()

    def update(self, time_s: float, *, running: NDArray[np.bool_]) -> None:
        """Look at the worlds at a time (s); those that are not `running` [B] have ended."""
        share = self._measure_share()
        self.best = np.maximum(self.best, share)
        grew = running & (share > self._marked + LEAST_STEP)
        self.last_s[grew], self._marked[grew] = time_s, share[grew]

    def _measure_share(self) -> Column:
        world, goal = self._world, self._goal
        if goal is None:
            return np.zeros(world.worlds)
        if goal.delivered:
            stored = world.state.robots["stored"].reshape(world.worlds, -1).sum(axis=1)
            share: Column = (world.delivered + 0.5 * stored) / self._total
            return share
        if goal.gathered:
            gathered: Column = np.minimum(world.gathered / goal.gathered, 1.0)
            return gathered
        return np.clip(1.0 - self._measure_distance() / self._first_m, 0.0, 1.0)

    def _measure_distance(self) -> Column:
        """Return the distance that is left to the goal's target [B], m, and 1 without one."""
        world, goal = self._world, self._goal
        if goal is None or goal.target is None:
            return np.ones(world.worlds)
        kind = world.rules.classes[world.names.classes.index(goal.target)]
        things = world.state.objects[:, kind["first"] : kind["end"]]
        robots = world.state.robots.reshape(world.worlds, -1)
        apart = np.hypot(
            robots["x"][:, :, None] - things["x"][:, None, :],
            robots["y"][:, :, None] - things["y"][:, None, :],
        )
        apart = np.where(things["present"][:, None, :] != 0, apart, np.inf).min(axis=2)
        left = apart.max(axis=1) if goal.all else apart.min(axis=1)
        diagonal = float(np.hypot(world.rules.width, world.rules.height))
        distance: Column = np.clip(left - goal.within, 1e-9, diagonal)
        return distance
