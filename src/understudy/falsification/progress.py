"""Progress towards a scenario's goal, and the times without any: what tells a run that is stuck from a slow one."""

from __future__ import annotations

import numpy as np

from understudy.analysis.behavior_run import BehaviorRun
from understudy.analysis.rollout import Instant, Monitor
from understudy.model.kinds import Column
from understudy.properties.goal_progress import GoalProgress

LEAST_STEP = 1e-3
"""The least increase of the share of the goal that counts as progress."""


class ProgressMonitor(Monitor):
    """The largest share of the goal that each of B worlds has reached so far, and when it last grew.

    Loading a unit of food counts half of delivering it. Without a goal the share stays 0.

    Parameters
    ----------
    run
        The behavior in the worlds, before the first tick.
    stride
        The number of ticks between two looks.
    """

    def __init__(self, run: BehaviorRun, *, stride: int = 50) -> None:
        super().__init__(run.worlds, stride=stride)
        self._world = world = run.get_world()
        self._goal = world.scenario.goal
        self._left = None if self._goal is None else GoalProgress(world)
        self._total = np.maximum(world.total.astype(np.float64), 1.0)
        self.best: Column = np.zeros(world.worlds)
        """The largest share so far [B], from 0 to 1."""
        self.last_s: Column = np.zeros(world.worlds)
        """The time at which the share last grew [B], s."""
        self._marked = self._measure_share()

    def look(self, now: Instant) -> None:
        """Measure the share of the goal that is reached, after the first tick."""
        if now.tick == 0:
            return
        share = self._measure_share()
        self.best = np.maximum(self.best, share)
        grew = now.running & (share > self._marked + LEAST_STEP)
        self.last_s[grew], self._marked[grew] = now.time_s, share[grew]

    def _measure_share(self) -> Column:
        world = self._world
        if self._goal is None or self._left is None:
            return np.zeros(world.worlds)
        share: Column = 1.0 - self._left.share_left()
        if self._goal.delivered:
            stored = world.state.robots["stored"].reshape(world.worlds, -1).sum(axis=1)
            share = np.minimum(share + 0.5 * stored / self._total, 1.0)
        return share
