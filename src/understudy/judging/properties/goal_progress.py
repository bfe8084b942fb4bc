"""Progress toward the goal of a scenario: how much of it is left in each world, and the times without any progress.

The latter tell a run that is stuck from a slow one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from understudy.judging.behavior_run import BehaviorRun
from understudy.judging.properties.margins import check_goal
from understudy.judging.properties.thing_positions import ROBOT, make_distance
from understudy.judging.rollout import Instant, Monitor
from understudy.model.value_kinds import Column
from understudy.sim.world import World

NEARER_M = 0.1
"""How much nearer than ever before robots have to come to a target, m, to count as progress."""


class GoalProgress:
    """How much of a scenario's goal is left in each of its worlds, since the object was made.

    What is left is food that is not delivered (units), boxes that are not gathered, or the distance (m) that the
    nearest robot, or with `all` the farthest, still has to go.

    Parameters
    ----------
    world
        The worlds, which have a goal; SettingError otherwise.
    """

    def __init__(self, world: World | None) -> None:
        self.world, self._goal = check_goal(world)
        self._total = self.world.total.astype(np.float64)
        self._first = self.measure_remainder()
        self.step = 1.0 if self._goal.target is None else NEARER_M
        """The least decrease of what is left that counts as progress."""

    def measure_remainder(self) -> NDArray[np.float64]:
        """Return what is left [B]: units, boxes or m; 0 where the goal is reached."""
        finished = self.world.state.finished >= 0
        return np.where(finished, 0.0, self._measure())

    def share_left(self) -> NDArray[np.float64]:
        """Return what is left as a share of what was left at first [B], from 0 to 1."""
        now = self.measure_remainder()
        share: NDArray[np.float64] = np.divide(now, self._first, out=np.ones_like(now), where=self._first > 0)
        return np.clip(share, 0.0, 1.0)

    def _measure(self) -> NDArray[np.float64]:
        if self._goal.target is not None:
            return self._measure_distance(self._goal.target)
        if self._goal.gathered:
            missing = float(self._goal.gathered) - self.world.gathered.astype(np.float64)
            return np.where(missing > 0.0, missing, 0.0)
        return self._total - self.world.delivered

    def _measure_distance(self, target: str) -> NDArray[np.float64]:
        nearest = make_distance(f"distance({ROBOT}, {target})", self.world)()
        of_robots = nearest.max(axis=1) if self._goal.all else np.fmin.reduce(nearest, axis=1)
        absent = float(np.hypot(*self.world.scenario.size))
        distance = np.where(np.isnan(of_robots), absent, of_robots)
        left: NDArray[np.float64] = np.maximum(0.0, distance - self._goal.within)
        return left


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
