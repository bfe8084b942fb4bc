"""Progress towards a scenario's goal, and the times without any: what tells a run that is stuck from a slow one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import Column
from understudy.properties.goal_progress import GoalProgress
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
    """

    def __init__(self, world: World) -> None:
        self._world, self._goal = world, world.scenario.goal
        self._left = None if self._goal is None else GoalProgress(world)
        self._total = np.maximum(world.total.astype(np.float64), 1.0)
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
        world = self._world
        if self._goal is None or self._left is None:
            return np.zeros(world.worlds)
        share: Column = 1.0 - self._left.share_left()
        if self._goal.delivered:
            stored = world.state.robots["stored"].reshape(world.worlds, -1).sum(axis=1)
            share = np.minimum(share + 0.5 * stored / self._total, 1.0)
        return share
