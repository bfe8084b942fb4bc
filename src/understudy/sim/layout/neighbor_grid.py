"""Make grids of the robots, and of the fixed things, near each place of a world; they are not part of its state."""

from __future__ import annotations

from math import ceil, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.sim.kernels.dtypes import SPOT
from understudy.sim.state import WorldParams, WorldState

Floats = NDArray[Any]

FEW = 24
"""The number of robots in a world up to which all pairs are compared, because a grid would take longer."""

MOST_CELLS = 1 << 24
DRIFT, MOST_KEPT = 0.125, 8
"""The share of a cell that robots may move before they are sorted again, and the largest number of ticks until then."""

FEW_THINGS, MOST_NEAR_CELLS = 6, 1 << 20
MOST_AT_ONCE = 1 << 16
"""The number of pairs of a cell and a thing that are compared at once, to bound memory."""


class RobotGrid(NamedTuple):
    """The robots of one world sorted by cells with sides of `cell` m.

    Each cell is divided into 2**shift x 2**shift small cells, adjacent in the order. With few robots in a cell a
    search reads them all; in a crowd it reads only the small cells that are near enough.
    """

    cell: float
    columns: int
    lines: int
    shift: int
    most_radius: float
    """The largest radius of a robot, m."""
    most_step: float
    """The longest step of a robot in a tick, m."""
    start: NDArray[np.int32]
    """The index of the first spot of each small cell [columns * lines * 4**shift + 1]."""
    spots: NDArray[Any]
    """SPOT [N], ordered by small cell, then by row."""
    spot_of: NDArray[np.int32]
    """The index of the spot of each robot [N]."""
    keep: int
    """The number of ticks between sorting; searches extend their range by the distance that robots move meanwhile."""


class StaticNeighbors(NamedTuple):
    """The fixed solid things near each cell of every world: k for disc k, -1 - k for segment k."""

    cell: float
    columns: int
    lines: int
    start: NDArray[np.int64]
    """The index of the first item of each cell of each world [B * columns * lines + 1]."""
    items: NDArray[np.int32]


def make_robot_grid(rules: WorldParams) -> RobotGrid:
    """Make an empty grid of robots for one world."""
    types = rules.types
    most_radius = float(types["radius"].max())
    noisy = np.where(types["noise_drive"] > 0, 2.0, 1.0)
    most_step = float((types["speed"] * noisy).max())
    touch = 2.0 * (most_radius + most_step) + 1e-6
    if rules.robots <= FEW:
        none = np.zeros(1, np.int32)
        cell = max(rules.width, rules.height)
        return RobotGrid(cell, 1, 1, 0, most_radius, most_step, none, np.zeros(0, SPOT), none, 1)
    area = rules.width * rules.height
    cell = max(sqrt(0.75 * area / rules.robots), touch)
    shift = 2 if cell >= 3 * touch else 1 if cell >= 1.5 * touch else 0
    cell = max(cell, sqrt(area * 4**shift / MOST_CELLS))
    columns, lines = ceil(rules.width / cell), ceil(rules.height / cell)
    start = np.zeros(columns * lines * 4**shift + 1, np.int32)
    spots, spot_of = np.zeros(rules.robots, SPOT), np.zeros(rules.robots, np.int32)
    keep = int(min(MOST_KEPT, max(1.0, DRIFT * cell / max(most_step, 1e-9))))
    return RobotGrid(cell, columns, lines, shift, most_radius, most_step, start, spots, spot_of, keep)


def make_static_neighbors(state: WorldState, rules: WorldParams, *, reach: float) -> StaticNeighbors:
    """Make lists of the fixed things within `reach` (m) of each cell, for every world."""
    worlds = len(state.seeds)
    things = state.discs.shape[1] + state.segments.shape[1]
    most = max(1, min(MOST_NEAR_CELLS // worlds, 4096))
    wish = 1 if things <= FEW_THINGS else min(most, 16 * things)
    cell = max(sqrt(rules.width * rules.height / wish), 1e-3)
    columns, lines = ceil(rules.width / cell - 1e-9), ceil(rules.height / cell - 1e-9)
    box = np.arange(columns * lines)
    half = 0.5 * cell
    center_x = (box % columns + 0.5) * cell
    center_y = (box // columns + 0.5) * cell
    number = np.concatenate(
        [np.arange(state.discs.shape[1]), -1 - np.arange(state.segments.shape[1])]
    ).astype(np.int32)
    counts, items = [np.zeros(0, np.int64)], [np.zeros(0, np.int32)]
    at_once = max(1, MOST_AT_ONCE // max(1, columns * lines * things))
    for first in range(0, worlds, at_once):
        some = slice(first, first + at_once)
        near = _find_near(state.discs[some], state.segments[some], center_x, center_y, half, reach)
        counts.append(near.sum(axis=2).ravel())
        items.append(number[np.nonzero(near)[2]])
    start = np.concatenate([[0], np.cumsum(np.concatenate(counts))]).astype(np.int64)
    return StaticNeighbors(cell, columns, lines, start, np.concatenate(items))


def _find_near(
    discs: NDArray[Any], segments: NDArray[Any], x: Floats, y: Floats, half: float, reach: float
) -> NDArray[np.bool_]:
    """Return which discs and segments of B worlds are within `reach` (m) of which of C cells [B, C, things].

    The cells have their centers at x and y, and sides of twice `half`.
    """
    x, y = x[:, None], y[:, None]
    discs, segments = discs[:, None, :], segments[:, None, :]
    there = (discs["radius"] > 0) & (
        _off(x, discs["x"] - half, discs["x"] + half) ** 2
        + _off(y, discs["y"] - half, discs["y"] + half) ** 2
        <= (reach + discs["radius"]) ** 2
    )
    x0, y0, x1, y1 = (segments[name] for name in ("x0", "y0", "x1", "y1"))
    ends = _to_segment(x, y, x0, y0, x1, y1) <= reach + half * sqrt(2.0)
    return np.concatenate([there, ends], axis=2)


def _off(values: Floats, low: Floats, high: Floats) -> Floats:
    outside: Floats = np.maximum(0.0, np.maximum(low - values, values - high))
    return outside


def _to_segment(x: Floats, y: Floats, x0: Floats, y0: Floats, x1: Floats, y1: Floats) -> Floats:
    """Return the distances of places from segments; NaN for segments with an end at NaN."""
    ex, ey = x1 - x0, y1 - y0
    length = np.maximum(ex * ex + ey * ey, 1e-300)
    along = np.clip(((x - x0) * ex + (y - y0) * ey) / length, 0.0, 1.0)
    distance: Floats = np.sqrt((x0 + along * ex - x) ** 2 + (y0 + along * ey - y) ** 2)
    return distance
