"""When robots of a new world fail, drawn by its seed alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from understudy.sim.kernels.rng import Seeds, draw_uniform_column
from understudy.sim.params import count_robots, get_count_range
from understudy.sim.scenario.schema import Breakdown, Scenario

Ticks = NDArray[np.int64]

NEVER = -1
"""The tick of a robot that never fails."""

STREAM, STREAMS = 1 << 29, 3
"""Streams of random draws: the number of robots that fail, which ones, and when; each breakdown has its own."""
COUNT, ORDER, TIME = 0, 1, 2


def draw_failure_ticks(scenario: Scenario, seeds: Seeds) -> Ticks:
    """Draw the tick from which each robot of new worlds has failed.

    Parameters
    ----------
    scenario
        The scenario.
    seeds
        The seed of each world [B].

    Returns
    -------
    array, shape [B, N]
        The ticks; `NEVER` for robots that do not fail. A robot of several breakdowns fails at the first.
    """
    counts = [count_robots(group.count, group.at) for group in scenario.robots]
    failure_ticks = np.full((len(seeds), sum(counts)), NEVER, np.int64)
    first, breakdowns = 0, 0
    for group, count in zip(scenario.robots, counts, strict=True):
        for breakdown in group.fails:
            stream = STREAM + STREAMS * breakdowns
            breakdowns += 1
            robots = range(first, first + count)
            ticks = _draw_ticks(breakdown, seeds, robots, scenario.tick_s, stream)
            own = failure_ticks[:, first : first + count]
            earlier = (ticks != NEVER) & ((own == NEVER) | (ticks < own))
            own[earlier] = ticks[earlier]
        first += count
    return failure_ticks


def _draw_ticks(
    breakdown: Breakdown, seeds: Seeds, robots: Sequence[int], tick_s: float, stream: int
) -> Ticks:
    """Draw the failure ticks of the robots of one group [B, n]."""
    least_s, most_s = (
        breakdown.at_s if isinstance(breakdown.at_s, tuple) else (breakdown.at_s, breakdown.at_s)
    )
    drawn = [draw_uniform_column(seeds, item=robot, tick=0, stream=stream + TIME) for robot in robots]
    times = least_s + (most_s - least_s) * np.stack(drawn, axis=1)
    ticks = np.rint(times / tick_s).astype(np.int64)
    if breakdown.robots is not None:
        fails = np.zeros(len(robots), np.bool_)
        fails[list(breakdown.robots)] = True
        return np.where(fails, ticks, NEVER)
    least, most = get_count_range(breakdown.count)
    share = draw_uniform_column(seeds, item=robots[0], tick=0, stream=stream + COUNT)
    count = least + np.floor(share * (most - least + 1)).astype(np.int64)
    order = np.stack(
        [draw_uniform_column(seeds, item=robot, tick=0, stream=stream + ORDER) for robot in robots], axis=1
    )
    rank = order.argsort(axis=1).argsort(axis=1)
    return np.where(rank < count[:, None], ticks, NEVER)
