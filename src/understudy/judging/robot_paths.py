"""Paths of robots in the worlds of a run: where each was from time to time, and where everything stood at the start."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from understudy.judging.behavior_run import BehaviorRun
from understudy.judging.rollout import Instant, Monitor
from understudy.sim.view import WorldView


class PathMonitor(Monitor):
    """Recorder of where some robots of each world are, before the first tick and after each `stride` ticks.

    Parameters
    ----------
    run
        The behavior in B simulated worlds, before the first tick.
    robots
        The numbers of the robots in a world, from 0.
    stride
        The number of ticks between two looks.
    """

    def __init__(self, run: BehaviorRun, robots: Sequence[int], *, stride: int) -> None:
        super().__init__(run.worlds, stride=stride)
        self._run, self._world, self._robots = run, run.get_world(), list(robots)
        self.views: list[WorldView] = [self._world.view(world) for world in range(run.worlds)]
        """Each world before the first tick."""
        self.end_s = np.full(run.worlds, np.nan)
        """When each world ended [B], s since the run began."""
        self._times: list[float] = []
        self._places: list[NDArray[np.float64]] = []

    def look(self, now: Instant) -> None:
        """Record where the robots are."""
        robots = self._world.state.robots
        places = np.stack([robots["x"], robots["y"]], axis=1).reshape(self._run.worlds, -1, 2)
        self._times.append(now.time_s)
        self._places.append(places[:, self._robots])

    def end(self, ended: NDArray[np.bool_]) -> None:
        """Note when worlds ended."""
        self.end_s[ended] = self._run.time_s

    def list_paths(self, most: int) -> tuple[list[float], list[NDArray[np.float64]]]:
        """List the times of at most `most` looks, and the path of each world until its end.

        Parameters
        ----------
        most
            The largest number of looks, evenly spread over the longest run.

        Returns
        -------
        tuple
            The times, s since the run began, and for each world an array [S, N, 2]: places in m of the N robots at the
            first S of these times, of which the last is at or after its end.
        """
        taken = np.unique(np.linspace(0, len(self._times) - 1, most).round().astype(int))
        times = np.array(self._times)[taken]
        places = np.stack([self._places[look] for look in taken.tolist()])
        counts = np.minimum(np.searchsorted(times, self.end_s - 1e-9) + 1, len(times))
        paths = [places[:count, world] for world, count in enumerate(counts.tolist())]
        return times.tolist(), paths
