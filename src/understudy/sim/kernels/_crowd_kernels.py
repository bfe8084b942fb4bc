"""Kernels about what has been placed in a world so far: a grid of it, and whether more is free of it."""

from typing import Any, TypeAlias

import numpy as np
from numba import njit
from numpy.typing import NDArray

from understudy.sim.kernels.clearance import clear_of_segments, is_inside, to_segment

Records: TypeAlias = NDArray[Any]

GROUP = np.dtype(
    [
        ("radius", "f8"),
        ("apart", "f8"),
        ("near_m", "f8"),
        ("x0", "f8"),  # the box in which it is placed
        ("y0", "f8"),
        ("x1", "f8"),
        ("y1", "f8"),
        ("circle", "f8"),  # radius of the circle in that box; NaN for the box
        ("due_least", "f8"),  # ticks; NaN for what is there from the beginning
        ("due_most", "f8"),
        ("sort", "i4"),
        ("first", "i4"),  # its first slot among those of its sort
        ("least", "i4"),
        ("most", "i4"),
        ("place", "i4"),  # its first given place; -1 for random ones
        ("near", "i4"),  # slot of the object that it is beside; -1 for none
        ("point", "i4"),  # first corner of a polygon, and one after the last
        ("end_point", "i4"),
        ("segment", "i4"),  # first segment of the first polygon
        ("amount_least", "i4"),
        ("amount_most", "i4"),
        ("stored", "i4"),
        ("type", "i4"),
        ("color", "i4"),
        ("solid", "i4"),
        ("alone", "i4"),  # whether it keeps others of its like away, and they it
        ("height", "f8"),
    ],
    align=True,
)
"""Things that are placed alike, in the order of placing."""

ENTRY = np.dtype(
    [
        ("x", "f8"),
        ("y", "f8"),
        ("next", "i4"),  # the next entry of its cell
        ("group", "i4"),  # -1 for a wall
        ("first", "i4"),  # its first segment; -1 for a disc
        ("slot", "i4"),  # of an object; -1 for all else
    ],
    align=True,
)
"""A thing in a cell of the grid, small, since they are many; one that lies in several cells is in each of them."""


@njit(error_model="numpy")
def _crosses(a: Any, b: Any) -> bool:
    """Whether two segments have a point in common, other than an end that just touches."""
    a_x, a_y, b_x, b_y = a.x1 - a.x0, a.y1 - a.y0, b.x1 - b.x0, b.y1 - b.y0
    first = a_x * (b.y0 - a.y0) - a_y * (b.x0 - a.x0)
    second = a_x * (b.y1 - a.y0) - a_y * (b.x1 - a.x0)
    third = b_x * (a.y0 - b.y0) - b_y * (a.x0 - b.x0)
    fourth = b_x * (a.y1 - b.y0) - b_y * (a.x1 - b.x0)
    return bool(first * second < 0.0 and third * fourth < 0.0)


@njit(error_model="numpy")
def _polygons_clear(
    segments: Records, first: int, end: int, other: int, end_other: int, apart: float
) -> bool:
    """Whether a polygon keeps `apart` from another one, or from a wall."""
    for index in range(first, end):
        edge = segments[index]
        for index_other in range(other, end_other):
            edge_other = segments[index_other]
            if _crosses(edge, edge_other):
                return False
            if (
                to_segment(edge.x0, edge.y0, edge_other.x0, edge_other.y0, edge_other.x1, edge_other.y1)
                < apart
            ):
                return False
            if to_segment(edge_other.x0, edge_other.y0, edge.x0, edge.y0, edge.x1, edge.y1) < apart:
                return False
            if to_segment(edge_other.x1, edge_other.y1, edge.x0, edge.y0, edge.x1, edge.y1) < apart:
                return False
    edge, edge_other = segments[first], segments[other]
    return not is_inside(edge.x0, edge.y0, segments, other, end_other) and not is_inside(
        edge_other.x0, edge_other.y0, segments, first, end
    )


@njit(error_model="numpy")
def _cells(low: float, high: float, cell: float, count: int) -> tuple[int, int]:
    """The first and last cell along an axis that a stretch lies in."""
    first = min(count - 1, max(0, int(low / cell)))
    return first, min(count - 1, max(0, int(high / cell)))


@njit(error_model="numpy")
def insert(grid: Any, x: float, y: float, reach_x: float, reach_y: float, thing: Records) -> Any:
    """The grid with a thing in every cell of the box around (x, y)."""
    heads, entries, used, cell = grid
    column, end_column = _cells(x - reach_x, x + reach_x, cell, heads.shape[1])
    row, end_row = _cells(y - reach_y, y + reach_y, cell, heads.shape[0])
    needed = used + (end_column - column + 1) * (end_row - row + 1)
    if needed > entries.shape[0]:
        grown = np.empty(2 * needed, entries.dtype)
        grown[:used] = entries[:used]
        entries = grown
    for r in range(row, end_row + 1):
        for c in range(column, end_column + 1):
            entries[used] = thing[0]
            entries[used].next = heads[r, c]
            heads[r, c] = used
            used += 1
    return heads, entries, used, cell


@njit(error_model="numpy")
def _keeps_off(
    thing: Any, groups: Records, x: float, y: float, group: Any, segments: Records, first: int, end: int
) -> bool:
    """Whether a disc, or a polygon, keeps free of one thing in the grid."""
    if thing.group < 0:
        radius, apart, end_thing = 0.0, group.apart, thing.first + 1
    else:
        other = groups[thing.group]
        radius, apart = other.radius, max(other.apart, group.apart)
        end_thing = thing.first + other.end_point - other.point
        if thing.slot >= 0 and thing.slot == group.near:
            if other.solid == 0:
                return True
            apart = -1e-9  # right at its rim is free, whatever rounding does
    if thing.first < 0 and first < 0:
        dx, dy = x - thing.x, y - thing.y
        least = radius + group.radius + apart
        return bool(dx * dx + dy * dy >= least * least)
    if thing.first < 0:
        return bool(clear_of_segments(thing.x, thing.y, radius + apart, segments, first, end))
    if first < 0:
        return bool(clear_of_segments(x, y, group.radius + apart, segments, thing.first, end_thing))
    return bool(_polygons_clear(segments, first, end, thing.first, end_thing, apart))


@njit(error_model="numpy")
def is_free(
    grid: Any, groups: Records, x: float, y: float, group: Any, segments: Records, first: int, end: int
) -> bool:
    """Whether a disc, or a polygon of the segments from first to end, keeps free of all that is in the grid."""
    heads, entries, _, cell = grid
    reach = group.radius + group.apart
    column, end_column = _cells(x - reach, x + reach, cell, heads.shape[1])
    row, end_row = _cells(y - reach, y + reach, cell, heads.shape[0])
    for r in range(row, end_row + 1):
        for c in range(column, end_column + 1):
            at = heads[r, c]
            while at >= 0:
                if not _keeps_off(entries[at], groups, x, y, group, segments, first, end):
                    return False
                at = entries[at].next
    return True
