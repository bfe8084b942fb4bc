"""Tracks: the true positions of all robots and objects at every tick, and measures computed from them.

Measures take and return columns; a time that never came is NaN.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, tau

import numpy as np
from numpy.typing import NDArray

from understudy.model.value_kinds import Column
from understudy.sim.world import World

Table = NDArray[np.float64]
Yes = NDArray[np.bool_]


@dataclass(frozen=True)
class GroundTruth:
    """True positions, m, at the start and after each tick: N robots [T+1, N] and K objects per world [T+1, B, K].

    The position of an absent object is NaN.
    """

    tick_s: float
    x: Table
    y: Table
    objects_x: Table
    objects_y: Table

    def first(self, holds: Yes) -> Column:
        """Return the time in s at which each column of [T+1, W] first holds; NaN if it never does."""
        return np.where(holds.any(axis=0), holds.argmax(axis=0) * self.tick_s, np.nan)

    def ticks(self, seconds: float) -> int:
        """Return the number of ticks in a time in s."""
        return round(seconds / self.tick_s)


def record(world: World, tick: Callable[[], None], seconds: float) -> GroundTruth:
    """Run worlds for a time in s, calling `tick` for each tick, and return their tracks."""
    ticks = round(seconds / world.tick_s)
    robots = np.empty((2, ticks + 1, world.agents))
    objects = np.empty((2, ticks + 1, *world.state.objects.shape))
    for now in range(ticks + 1):
        if now:
            tick()
        state = world.state
        absent = state.objects["present"] == 0
        for axis, name in enumerate("xy"):
            robots[axis, now] = state.robots[name]
            objects[axis, now] = np.where(absent, np.nan, state.objects[name])
    return GroundTruth(world.tick_s, *robots, *objects)


def has_held_for(holds: Yes, ticks: int) -> Yes:
    """Return whether a condition holds now and held for the last `ticks` ticks [T, W]."""
    counts = np.cumsum(np.vstack([np.zeros_like(holds[:1], np.int64), holds]), axis=0)
    held = np.zeros_like(holds)
    held[ticks:] = counts[ticks + 1 :] - counts[: len(counts) - ticks - 1] == ticks + 1
    return held


def count_turns(x: Table, y: Table, around_x: Column, around_y: Column) -> Table:
    """Return how often each track [T, W] has gone around a point [W] so far, counter-clockwise positive."""
    angle = np.unwrap(np.arctan2(y - around_y, x - around_x), axis=0)
    turned: Table = (angle - angle[0]) / tau
    return turned


def measure_gain(gone: Table, near: Yes) -> Table:
    """Return how much a measure [T, W] has grown since `near` [T, W] was last false; 0 while it is false."""
    rows = np.arange(len(gone))[:, None]
    begun = np.maximum.accumulate(np.where(near, -1, rows), axis=0) + 1
    since: Table = gone - np.take_along_axis(gone, np.minimum(begun, rows), axis=0)
    return since


def count_reached_in_turn(reached: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return how many places [T, W, K], to be reached in cyclic order, were reached by each tick [T, W]."""
    ticks, worlds, places = reached.shape
    count = np.zeros((ticks, worlds), np.int64)
    rows, now = np.arange(worlds), np.zeros(worlds, np.int64)
    for tick in range(ticks):
        now = now + reached[tick, rows, now % places]
        count[tick] = now
    return count


def medians(values: Table) -> Column:
    """Return the median of each column of [T, W] without NaN; NaN for a column of only NaN."""
    present = ~np.isnan(values).all(axis=0)
    middles = np.full(values.shape[1], np.nan)
    middles[present] = np.nanmedian(values[:, present], axis=0)
    return middles


def wrap_signed(angle: Column) -> Column:
    """Wrap angles to the range from -pi to pi, left positive."""
    return (angle + pi) % tau - pi


def distance_to_line(x: Table, y: Table, corners: Table) -> tuple[Table, Table]:
    """Return the distance of points from a closed line of corners [P, 2], and the nearest position along it, m."""
    following = np.roll(corners, -1, axis=0)
    edges = following - corners
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    begins = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    best, along = np.full(x.shape, np.inf), np.zeros(x.shape)
    for corner, edge, length, begin in zip(corners, edges, lengths, begins, strict=True):
        from_x, from_y = x - corner[0], y - corner[1]
        at = np.clip((from_x * edge[0] + from_y * edge[1]) / length, 0.0, length)
        far = np.hypot(from_x - at * edge[0] / length, from_y - at * edge[1] / length)
        nearer = far < best
        best, along = np.where(nearer, far, best), np.where(nearer, begin + at, along)
    return best, along


def length_of(corners: Table) -> float:
    """Return the length of a closed line of corners [P, 2], m."""
    edges = np.roll(corners, -1, axis=0) - corners
    return float(np.hypot(edges[:, 0], edges[:, 1]).sum())
