"""The state of B worlds side by side as plain arrays: what kernels read and change, snapshots keep, frames show.

Robots are rows, world by world: world w has rows w*N to (w+1)*N. What every world has its own of is [B, …].
All is in m, s and rad; in TYPE, per tick. Records keep what is used together in one place of memory.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Records = NDArray[Any]

ROBOT = np.dtype(
    [
        ("x", "f8"),
        ("y", "f8"),
        ("heading", "f8"),  # [0, tau)
        ("speed", "f8"),  # m per tick, along the heading, as its wheels would have it
        ("spin", "f8"),  # rad per tick
        ("id", "i4"),  # within its world
        ("type", "i4"),
        ("stored", "i4"),  # units of food
        ("loading", "i4"),  # ticks spent on the unit at hand
        ("unloading", "i4"),
        ("delivered", "i4"),
        ("blocked", "i4"),  # ticks in a row that it drove and got nowhere
        ("frozen", "i4"),  # 1: neither senses nor moves (a robot that failed)
    ],
    align=True,
)

TYPE = np.dtype(
    [
        ("radius", "f8"),
        ("height", "f8"),
        ("speed", "f8"),  # m per tick of drive = 1
        ("turning", "f8"),  # rad per tick of turn = 1
        ("acceleration", "f8"),  # m per tick, per tick; infinite where there is no limit
        ("turning_acceleration", "f8"),
        ("noise_drive", "f8"),  # share of the motion of a tick
        ("noise_turn", "f8"),
        ("reach", "f8"),
        ("color", "i4"),  # index, -1 none
        ("team", "i4"),  # index
        ("capacity", "i4"),
        ("load_ticks", "i4"),
        ("unload_ticks", "i4"),
        ("collides", "i4"),
        ("first_step", "i4"),  # its steps of the sense plan: first, and one after the last
        ("end_step", "i4"),
    ],
    align=True,
)

OBJECT = np.dtype(
    [
        ("x", "f8"),
        ("y", "f8"),
        ("heading", "f8"),  # of one that walks
        ("present", "i4"),
        ("amount", "i4"),
        ("at_first", "i4"),
        ("appeared", "i4"),  # times it has appeared, which keys the next draw of a place
        ("due", "i8"),  # tick at which it appears or leaves; -1 never
        ("captured", "i8"),  # tick at which a robot first came within range; -1 not yet
    ],
    align=True,
)

CLASS = np.dtype(
    [
        ("radius", "f8"),
        ("height", "f8"),
        ("capture_range", "f8"),  # NaN: cannot be captured
        ("walk", "f8"),  # m per tick; 0 stays
        ("away_least", "f8"),  # s; NaN: always present
        ("away_most", "f8"),
        ("stays_least", "f8"),  # s; NaN: until captured
        ("stays_most", "f8"),
        ("apart", "f8"),
        ("region", "f8", 4),  # box in which it appears and walks
        ("first", "i4"),  # its slots among the objects of a world: first, and one after the last
        ("end", "i4"),
        ("color", "i4"),
        ("food", "i4"),
        ("home", "i4"),
        ("solid", "i4"),
        ("pushable", "i4"),
        ("pushers", "i4"),
        ("capture_ticks", "i4"),
        ("turn_ticks", "i4"),
    ],
    align=True,
)

DISC = np.dtype([("x", "f8"), ("y", "f8"), ("radius", "f8"), ("height", "f8"), ("color", "i4")], align=True)
"""A round obstacle; radius 0 is none."""

SEGMENT = np.dtype([("x0", "f8"), ("y0", "f8"), ("x1", "f8"), ("y1", "f8"), ("wall", "i4")], align=True)
"""A piece of a wall, or (wall 0) an edge of a polygonal obstacle; an end on NaN is none."""

GOAL_NONE, GOAL_DELIVERED, GOAL_NEAR, GOAL_ALL_NEAR = 0, 1, 2, 3


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
