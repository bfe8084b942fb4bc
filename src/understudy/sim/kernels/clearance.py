"""Kernels of free space: distances from segments and polygons, and free places in a running world."""

import math
from typing import Any, TypeAlias

from numpy.typing import NDArray

from understudy.jit.decorators import inner
from understudy.sim.kernels.rng import draw_uniform

Records: TypeAlias = NDArray[Any]

ATTEMPTS = 1000
"""The number of random places that are tried for a thing before none is considered free."""

DISC, POLYGON, OBJECT, ROBOT = 0, 1, 2, 3
"""The kinds of things that are placed."""

FIRST_STREAM, STREAMS = 1 << 16, 16
X, Y, ANGLE, COUNT, AMOUNT, DUE, BESIDE, APPEAR_X, APPEAR_Y = 0, 1, 2, 3, 4, 5, 6, 7, 8
"""Stream numbers of random draws, by purpose; each kind of things has `STREAMS` of them from `FIRST_STREAM` on.

They differ from the streams of a running world.
"""


@inner
def scale_to_integer(low: int, high: int, drawn: float) -> int:
    """Return the whole number from `low` to `high` that a uniform draw in [0, 1) selects."""
    return low + math.floor(drawn * (high - low + 1))


@inner
def measure_to_segment(x: float, y: float, x0: float, y0: float, x1: float, y1: float) -> float:
    """Return the distance (m) of a point from a segment; NaN if an end of the segment is NaN."""
    dx, dy = x1 - x0, y1 - y0
    squared = dx * dx + dy * dy
    along = ((x - x0) * dx + (y - y0) * dy) / squared if squared > 0.0 else 0.0
    along = min(1.0, max(0.0, along))
    dx, dy = x - x0 - along * dx, y - y0 - along * dy
    return math.sqrt(dx * dx + dy * dy)


@inner
def is_inside_polygons(x: float, y: float, segments: Records, first: int, end: int) -> bool:
    """Return whether a point lies inside a polygon among the segments `first` to `end` (counter-clockwise edges)."""
    winding = 0
    for index in range(first, end):
        edge = segments[index]
        if edge.wall == 0:
            left = (edge.x1 - edge.x0) * (y - edge.y0) - (x - edge.x0) * (edge.y1 - edge.y0)
            if edge.y0 <= y < edge.y1 and left > 0.0:
                winding += 1
            elif edge.y1 <= y < edge.y0 and left < 0.0:
                winding -= 1
    return winding != 0


@inner
def is_clear_of_segments(x: float, y: float, radius: float, segments: Records, first: int, end: int) -> bool:
    """Return whether a disc touches none of the segments `first` to `end` and lies in none of their polygons."""
    for index in range(first, end):
        edge = segments[index]
        if measure_to_segment(x, y, edge.x0, edge.y0, edge.x1, edge.y1) < radius:
            return False
    return not is_inside_polygons(x, y, segments, first, end)


@inner
def find_free_place(
    seed: int,
    slot: int,
    turn: int,
    kind: Any,
    types: Records,
    classes: Records,
    class_of: Any,
    width: float,
    height: float,
    robots: Records,
    objects: Records,
    discs: Records,
    segments: Records,
) -> tuple[bool, float, float]:
    """Find a random free place in a running world for the object in a slot: whether there is one, x and y (m).

    `turn` counts its appearances, so that other places are drawn each time. `kind` is its class. Robots, objects, discs
    and segments are those of its world.
    """
    streams = FIRST_STREAM + STREAMS * OBJECT
    away = kind.radius + kind.apart
    x0, x1 = max(kind.region[0], away), min(kind.region[2], width - away)
    y0, y1 = max(kind.region[1], away), min(kind.region[3], height - away)
    if x1 < x0 or y1 < y0:
        return False, math.nan, math.nan
    for attempt in range(ATTEMPTS):
        key = turn * ATTEMPTS + attempt
        x = x0 + draw_uniform(seed, slot, key, streams + APPEAR_X) * (x1 - x0)
        y = y0 + draw_uniform(seed, slot, key, streams + APPEAR_Y) * (y1 - y0)
        if _is_free_now(x, y, slot, kind, types, classes, class_of, robots, objects, discs, segments):
            return True, x, y
    return False, math.nan, math.nan


@inner
def _is_free_now(
    x: float,
    y: float,
    slot: int,
    kind: Any,
    types: Records,
    classes: Records,
    class_of: Any,
    robots: Records,
    objects: Records,
    discs: Records,
    segments: Records,
) -> bool:
    """Return whether an object at (x, y) would keep its distance from everything that is in its world now."""
    away = kind.radius + kind.apart
    for n in range(robots.shape[0]):
        least = away + types[robots[n].type].radius
        dx, dy = x - robots[n].x, y - robots[n].y
        if (types[robots[n].type].collides or kind.solid) and dx * dx + dy * dy < least * least:
            return False
    for n in range(objects.shape[0]):
        other = classes[class_of[n]]
        least = kind.radius + other.radius + max(kind.apart, other.apart)
        dx, dy = x - objects[n].x, y - objects[n].y
        if objects[n].present and n != slot and dx * dx + dy * dy < least * least:
            return False
    for n in range(discs.shape[0]):
        least = away + discs[n].radius
        dx, dy = x - discs[n].x, y - discs[n].y
        if discs[n].radius > 0.0 and dx * dx + dy * dy < least * least:
            return False
    return bool(is_clear_of_segments(x, y, away, segments, 0, segments.shape[0]))
