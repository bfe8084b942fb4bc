"""Free space around robots in simulated worlds, and the ground that they have covered."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from understudy.model.value_kinds import Column
from understudy.sim.kernels.dtypes import TOUCH
from understudy.sim.world import World

CLEARANCE, COVERED = "clearance", "covered"
"""The names of both in conditions."""
UNITS = {CLEARANCE: "m", COVERED: "m²"}
"""Their units."""
_LATELY = re.compile(rf"{COVERED}\((\d+\.?\d*) s\)")
"""The ground covered in a time until now: "covered(12 s)"."""
TOUCHED = f"{CLEARANCE} is below {1000 * TOUCH:g} mm"
"""The condition that a robot touches something solid."""
CELL_M = 0.5
"""The side of the squares in which covered ground is counted, m."""


NONE = np.zeros((1, 1), np.bool_)
LONG_AGO = np.iinfo(np.int32).min


def find_space(
    subject: str, world: World, of: NDArray[np.bool_] | None
) -> tuple[Callable[[], Column], str] | None:
    """Find what a condition names: the free space, or the ground covered, since the start or lately.

    Parameters
    ----------
    subject
        The subject of a clause: "clearance", "covered", or "covered(12 s)" for the last 12 s.
    world
        The worlds.
    of
        Which robots of a world count [N]. None: all.

    Returns
    -------
    tuple[function, str] | None
        A function that returns the present values [B, n], to be called at each tick that counts, and their unit. None
        if the subject is something else.
    """
    if subject == CLEARANCE:
        return make_clearance(world, of), UNITS[CLEARANCE]
    lately = _LATELY.fullmatch(subject)
    if lately is None and subject != COVERED:
        return None
    return make_covered(world, of, last_s=float(lately[1]) if lately else None), UNITS[COVERED]


def make_clearance(world: World, of: NDArray[np.bool_] | None = None) -> Callable[[], Column]:
    """Make a function that measures the free space around each robot.

    Parameters
    ----------
    world
        The worlds.
    of
        Which robots of a world count [N]. None: all.

    Returns
    -------
    function
        Returns the distance from each robot's rim to the nearest wall, obstacle, solid object or other robot that can
        be run into, or to the edge of the arena [B, n], m; infinite for a robot that runs into nothing.
    """
    rules, chosen = world.rules, _list_chosen(world, of)
    slots = np.flatnonzero(rules.classes["solid"][rules.class_of] != 0)

    def read() -> Column:
        state, robots = world.state, world.state.robots.reshape(world.worlds, -1)
        collides, radius = rules.types["collides"][robots["type"]] != 0, rules.types["radius"][robots["type"]]
        x, y = robots["x"][:, chosen], robots["y"][:, chosen]
        others_x = np.where(collides, robots["x"], np.nan)
        edge = np.minimum(np.minimum(x, rules.width - x), np.minimum(y, rules.height - y))
        objects, discs = state.objects[:, slots], state.discs
        objects_x = np.where(objects["present"] != 0, objects["x"], np.nan)
        sizes = rules.classes["radius"][rules.class_of[slots]]
        own = np.eye(robots.shape[1], dtype=np.bool_)[chosen]
        nearest = reduce(
            np.fmin,
            [
                edge,
                _measure_to_segments(x, y, state.segments),
                _measure_to_discs(
                    x, y, np.where(discs["radius"] > 0, discs["x"], np.nan), discs["y"], discs["radius"]
                ),
                _measure_to_discs(x, y, objects_x, objects["y"], sizes),
                _measure_to_discs(x, y, others_x, robots["y"], radius, except_for=own),
            ],
        )
        return np.where(collides[:, chosen], nearest - radius[:, chosen], np.inf)

    return read


def _measure_to_discs(
    x: Column,
    y: Column,
    disc_x: Column,
    disc_y: Column,
    disc_radius: Column,
    *,
    except_for: NDArray[np.bool_] = NONE,
) -> Column:
    """Return the distances of points [B, n] from the rim of the nearest of discs [B, m], m; infinite without any."""
    apart = np.hypot(x[:, :, None] - disc_x[:, None], y[:, :, None] - disc_y[:, None])
    apart -= np.broadcast_to(disc_radius, disc_x.shape)[:, None]
    nearest: Column = np.fmin.reduce(np.where(except_for, np.nan, apart), axis=2, initial=np.inf)
    return nearest


def _measure_to_segments(x: Column, y: Column, segments: NDArray[np.void]) -> Column:
    """Return the distances of points [B, n] from the nearest of segments [B, S], m; infinite where there are none."""
    x0, y0 = segments["x0"][:, None], segments["y0"][:, None]
    dx, dy = segments["x1"][:, None] - x0, segments["y1"][:, None] - y0
    squared = dx * dx + dy * dy
    along = (x[:, :, None] - x0) * dx + (y[:, :, None] - y0) * dy
    along = np.clip(np.divide(along, squared, out=np.zeros_like(along), where=squared > 0), 0.0, 1.0)
    apart = np.hypot(x[:, :, None] - x0 - along * dx, y[:, :, None] - y0 - along * dy)
    nearest: Column = np.fmin.reduce(apart, axis=2, initial=np.inf)
    return nearest


def make_covered(
    world: World, of: NDArray[np.bool_] | None = None, *, last_s: float | None = None
) -> Callable[[], Column]:
    """Make a function that measures the ground that each robot has covered since the function was made, or lately.

    Parameters
    ----------
    world
        The worlds. The function has to be called at each tick that counts.
    of
        Which robots of a world count [N]. None: all.
    last_s
        How far back the ground counts, s. None: since the function was made.

    Returns
    -------
    function
        Returns the area of the squares, CELL_M wide, in which the center of each robot was [B, n], m².
    """
    across = int(np.ceil(world.rules.width / CELL_M))
    up = int(np.ceil(world.rules.height / CELL_M))
    chosen = _list_chosen(world, of)
    rows = np.arange(world.worlds * len(chosen))
    visited = np.full((len(rows), across * up), LONG_AGO, np.int32)  # the tick of the last visit
    ticks = None if last_s is None else round(last_s / world.tick_s)

    def read() -> Column:
        robots = world.state.robots.reshape(world.worlds, -1)[:, chosen].ravel()
        column = np.clip((robots["x"] / CELL_M).astype(np.int64), 0, across - 1)
        row = np.clip((robots["y"] / CELL_M).astype(np.int64), 0, up - 1)
        now = np.repeat(world.state.tick, len(chosen))
        visited[rows, row * across + column] = now
        counted = visited > (LONG_AGO if ticks is None else (now - ticks)[:, np.newaxis])
        area: Column = counted.sum(axis=1).reshape(world.worlds, -1) * CELL_M**2
        return area

    return read


def _list_chosen(world: World, of: NDArray[np.bool_] | None) -> NDArray[np.intp]:
    """List the robots of a world that count; all if None."""
    return np.arange(world.robots) if of is None else np.flatnonzero(of)
