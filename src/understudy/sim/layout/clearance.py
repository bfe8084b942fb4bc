"""Check whether a disc at a place would overlap something solid, with the geometry that this needs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import hypot, radians
from typing import TypeAlias

import numpy as np

from understudy.sim.kernels.angles import compute_cosine_and_sine
from understudy.sim.params import ScenarioNames
from understudy.sim.scenario.schema import ArenaPoint, Scenario
from understudy.sim.state import Records, WorldParams, WorldState

Segment: TypeAlias = tuple[ArenaPoint, ArenaPoint]


def orient_counter_clockwise(points: Sequence[ArenaPoint]) -> tuple[ArenaPoint, ...]:
    """Return the corners of a polygon in counter-clockwise order."""
    area = sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in list_edges(points))
    return tuple(points) if area > 0 else tuple(reversed(points))


def list_edges(points: Sequence[ArenaPoint]) -> tuple[Segment, ...]:
    """Return the edges of a polygon, one from each corner to the next."""
    return tuple(zip(points, (*points[1:], *points[:1]), strict=True))


def list_wall_segments(scenario: Scenario) -> Iterator[Segment]:
    """Yield the segments of all inner walls."""
    for wall in scenario.walls:
        yield from list_edges(wall.points) if wall.closed else list_edges(wall.points)[:-1]


def place_polygon(points: Sequence[ArenaPoint], place: Sequence[float]) -> tuple[ArenaPoint, ...]:
    """Return the corners of a polygon moved to a place (x, y), or (x, y, rotation in degrees)."""
    cosine, sine = compute_cosine_and_sine(radians(place[2]) if len(place) > 2 else 0.0)
    return tuple(
        (place[0] + cosine * x - sine * y, place[1] + sine * x + cosine * y)
        for x, y in orient_counter_clockwise(points)
    )


def measure_point_to_segment(point: ArenaPoint, segment: Segment) -> float:
    """Return the distance of a point from a segment."""
    (x, y), ((x0, y0), (x1, y1)) = point, segment
    dx, dy = x1 - x0, y1 - y0
    squared = dx * dx + dy * dy
    along = min(1.0, max(0.0, ((x - x0) * dx + (y - y0) * dy) / squared)) if squared else 0.0
    return hypot(x - x0 - along * dx, y - y0 - along * dy)


def is_point_in_polygon(point: ArenaPoint, corners: Sequence[ArenaPoint]) -> bool:
    """Return whether a point lies inside a polygon."""
    x, y = point
    inside = False
    for (x0, y0), (x1, y1) in list_edges(corners):
        if (y0 > y) != (y1 > y) and x < x0 + (y - y0) / (y1 - y0) * (x1 - x0):
            inside = not inside
    return inside


def have_common_point(first: Segment, second: Segment) -> bool:
    """Return whether two segments have a point in common."""
    touching = any(measure_point_to_segment(end, second) == 0.0 for end in first)
    touching = touching or any(measure_point_to_segment(end, first) == 0.0 for end in second)
    return touching or (_sides(first, second) and _sides(second, first))


def _sides(line: Segment, ends: Segment) -> bool:
    """Return whether the two ends of a segment lie strictly on different sides of a line."""
    (x0, y0), (x1, y1) = line
    left, right = ((x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) for x, y in ends)
    return (left < 0 < right) or (right < 0 < left)


def find_crossing_edges(points: Sequence[ArenaPoint]) -> tuple[int, int] | None:
    """Return the indices of two edges of a polygon that cross or touch, or twice that of an edge of length 0.

    None if there are none; neighboring edges may share their corner.
    """
    edges = list_edges(points)
    for a, first in enumerate(edges):
        if first[0] == first[1]:
            return a, a
        for b, second in enumerate(edges[:a]):
            if a - b == 1:
                meeting = (
                    measure_point_to_segment(first[1], second) == 0.0
                    or measure_point_to_segment(second[0], first) == 0.0
                )
            elif a - b == len(edges) - 1:
                meeting = (
                    measure_point_to_segment(first[0], second) == 0.0
                    or measure_point_to_segment(second[1], first) == 0.0
                )
            else:
                meeting = have_common_point(first, second)
            if meeting:
                return b, a
    return None


CLOSE = 1e-9
"""The largest rounding error of a distance, m."""


def find_overlap(
    state: WorldState,
    rules: WorldParams,
    names: ScenarioNames,
    world: int,
    x: float,
    y: float,
    radius: float,
    *,
    robot: int = -1,
    slot: int = -1,
    collides: bool = True,
    stays: bool = False,
) -> str | None:
    """Describe in words what a solid disc at (x, y) would overlap; None if the place is free.

    The disc is a robot (`robot` is its id in its world), the object in a `slot`, or something new. Robots that do not
    collide may overlap each other; an obstacle (`stays`) may overlap walls and other obstacles.
    """
    x, y = float(x), float(y)  # comparisons of NumPy numbers cannot be counted with
    least = radius - CLOSE
    if not stays:
        if not (least <= x <= rules.width - least and least <= y <= rules.height - least):
            return "the outer wall"
        discs = state.discs[world]
        if _hit(discs, discs["radius"] > 0, discs["radius"], x, y, least) is not None:
            return "an obstacle"
        overlap = _segment(state.segments[world], x, y, least)
        if overlap is not None:
            return overlap
    objects = state.objects[world]
    classes = rules.classes[rules.class_of]
    there = (objects["present"] != 0) & (classes["solid"] != 0) & (np.arange(len(objects)) != slot)
    hit = _hit(objects, there, classes["radius"], x, y, least)
    if hit is not None:
        return f"object {hit}, of class {names.classes[rules.class_of[hit]]!r}"
    robots = state.robots[world * rules.robots : (world + 1) * rules.robots]
    types = rules.types[robots["type"]]
    there = (robots["id"] != robot) & ((types["collides"] != 0) & collides if robot >= 0 else True)
    hit = _hit(robots, there, types["radius"], x, y, least)
    return None if hit is None else f"robot {hit}"


def _segment(segments: Records, x: float, y: float, radius: float) -> str | None:
    """Describe in words the wall or polygon that a disc overlaps; None if there is none."""
    winding = 0
    for piece in segments:
        (x0, y0, x1, y1), wall = (float(piece[name]) for name in ("x0", "y0", "x1", "y1")), piece["wall"]
        if measure_point_to_segment((x, y), ((x0, y0), (x1, y1))) < radius:
            return "a wall" if wall else "an obstacle"
        if not wall and (y0 <= y < y1 or y1 <= y < y0):
            left = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)
            winding += (left > 0) * (y1 > y0) - (left < 0) * (y1 < y0)
    return "an obstacle" if winding else None


def _hit(things: Records, there: Records, radii: Records, x: float, y: float, radius: float) -> int | None:
    """Return the index of the first of the `there` discs that a disc overlaps; None if there is none."""
    apart = np.sqrt((things["x"] - x) ** 2 + (things["y"] - y) ** 2) - radii
    hits = np.flatnonzero(there & (apart < radius))
    return int(hits[0]) if len(hits) else None
