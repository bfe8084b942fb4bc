"""The state of B worlds side by side as plain arrays: what kernels read and change, snapshots keep, frames show.

Robots are rows, world by world: world w has rows w*N to (w+1)*N. What every world has its own of is [B, …].
All is in m, s and rad; in TYPE, per tick. Records keep what is used together in one place of memory.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.sim.kernels.dtypes import CLASS, DISC, OBJECT, ROBOT, SEGMENT, TYPE

__all__ = ["CLASS", "DISC", "OBJECT", "ROBOT", "SEGMENT", "TYPE", "Records", "Rules", "State"]

Records = NDArray[Any]

GOAL_NONE, GOAL_DELIVERED, GOAL_NEAR, GOAL_ALL_NEAR, GOAL_GATHERED = range(5)


class Rules(NamedTuple):
    """What stays the same in every world of a scenario."""

    types: Records
    """TYPE [T]."""
    classes: Records
    """CLASS [C]; the slots of a class lie side by side, and a world's spare ones at the end of its class."""
    class_of: NDArray[np.int32]
    """The class of each object slot [K]."""
    width: float
    height: float
    tick_s: float
    robots: int
    """N, robots in each world."""
    goal: int
    goal_target: int
    """Index of a class of objects."""
    goal_within: float
    goal_count: int
    """Boxes to gather."""
    signals: int
    """How many signals there are."""


class State(NamedTuple):
    """Everything that changes, and everything that a seed lays out."""

    robots: Records
    """ROBOT [B*N]."""
    objects: Records
    """OBJECT [B, K]."""
    discs: Records
    """DISC [B, O]."""
    segments: Records
    """SEGMENT [B, S]: inner walls and edges of polygons; the arena's own bounds are not among them."""
    seeds: NDArray[np.int64]
    """[B]."""
    tick: NDArray[np.int64]
    """Ticks since the last reset [B]."""
    finished: NDArray[np.int64]
    """The tick at which the goal was first reached [B]; -1 not yet."""
    memory: NDArray[np.float64]
    """What sensors remember [B*N, H]: last answers, and ticks at which something was last there."""
