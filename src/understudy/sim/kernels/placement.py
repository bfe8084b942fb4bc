"""Kernels that lay out worlds: random free places, checked with a grid of the things that were placed before."""

import math
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.jit.decorators import blank, inner, njit_entry
from understudy.sim.kernels.angles import compute_angle, compute_cosine_and_sine
from understudy.sim.kernels.clearance import (
    AMOUNT,
    ANGLE,
    ATTEMPTS,
    BESIDE,
    COUNT,
    DISC,
    DUE,
    FIRST_STREAM,
    OBJECT,
    POLYGON,
    ROBOT,
    STREAMS,
    X,
    Y,
    is_clear_of_segments,
    is_inside_polygons,
    measure_to_segment,
    scale_to_integer,
)
from understudy.sim.kernels.rng import FORMER, draw_uniform

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
        ("thing", "i4"),
        ("first", "i4"),  # its first slot among things of its kind
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
"""The record of a group of things that are placed alike; groups are sorted in order of placing."""

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
"""The record of a thing in a cell of the grid; a thing that overlaps several cells has an entry in each.

It is small because there are many.
"""


@inner
def _crosses(a: Any, b: Any) -> bool:
    """Return whether two segments cross; ends that only touch do not count."""
    a_x, a_y, b_x, b_y = a.x1 - a.x0, a.y1 - a.y0, b.x1 - b.x0, b.y1 - b.y0
    first = a_x * (b.y0 - a.y0) - a_y * (b.x0 - a.x0)
    second = a_x * (b.y1 - a.y0) - a_y * (b.x1 - a.x0)
    third = b_x * (a.y0 - b.y0) - b_y * (a.x0 - b.x0)
    fourth = b_x * (a.y1 - b.y0) - b_y * (a.x1 - b.x0)
    return bool(first * second < 0.0 and third * fourth < 0.0)


@inner
def _polygons_clear(
    segments: Records, first: int, end: int, other: int, end_other: int, apart: float
) -> bool:
    """Return whether a polygon is at least `apart` (m) away from another polygon or a wall."""
    for index in range(first, end):
        edge = segments[index]
        for index_other in range(other, end_other):
            edge_other = segments[index_other]
            if _crosses(edge, edge_other):
                return False
            if (
                measure_to_segment(
                    edge.x0, edge.y0, edge_other.x0, edge_other.y0, edge_other.x1, edge_other.y1
                )
                < apart
            ):
                return False
            if measure_to_segment(edge_other.x0, edge_other.y0, edge.x0, edge.y0, edge.x1, edge.y1) < apart:
                return False
            if measure_to_segment(edge_other.x1, edge_other.y1, edge.x0, edge.y0, edge.x1, edge.y1) < apart:
                return False
    edge, edge_other = segments[first], segments[other]
    return not is_inside_polygons(edge.x0, edge.y0, segments, other, end_other) and not is_inside_polygons(
        edge_other.x0, edge_other.y0, segments, first, end
    )


@inner
def _cells(low: float, high: float, cell: float, count: int) -> tuple[int, int]:
    """Return the indices of the first and last cell along an axis that the interval [low, high] (m) overlaps."""
    first = min(count - 1, max(0, int(low / cell)))
    return first, min(count - 1, max(0, int(high / cell)))


@inner
def insert_into_grid(grid: Any, x: float, y: float, reach_x: float, reach_y: float, thing: Records) -> Any:
    """Return the grid with a thing added to every cell of the box around (x, y) with these half sides (m)."""
    heads, entries, used, cell = grid
    column, end_column = _cells(x - reach_x, x + reach_x, cell, heads.shape[1])
    row, end_row = _cells(y - reach_y, y + reach_y, cell, heads.shape[0])
    needed = used + (end_column - column + 1) * (end_row - row + 1)
    if needed > entries.shape[0]:
        grown = blank(2 * needed, ENTRY)
        for k in range(used):
            grown[k] = entries[k]
        entries = grown
    for r in range(row, end_row + 1):
        for c in range(column, end_column + 1):
            entries[used] = thing[0]
            entries[used].next = int(heads[r, c])
            heads[r, c] = used
            used += 1
    return heads, entries, used, cell


@inner
def _keeps_off(
    thing: Any, groups: Records, x: float, y: float, group: Any, segments: Records, first: int, end: int
) -> bool:
    """Return whether a disc, or a polygon, keeps its distance from one thing in the grid."""
    if thing.group < 0:
        radius, apart, end_thing = 0.0, group.apart, thing.first + 1
    else:
        other = groups[thing.group]
        radius, apart = other.radius, max(other.apart, group.apart)
        end_thing = thing.first + other.end_point - other.point
        if thing.slot >= 0 and thing.slot == group.near:
            if other.solid == 0:
                return True
            apart = -1e-9  # right at its rim is free, in spite of rounding
    if thing.first < 0 and first < 0:
        dx, dy = x - thing.x, y - thing.y
        least = radius + group.radius + apart
        return bool(dx * dx + dy * dy >= least * least)
    if thing.first < 0:
        return bool(is_clear_of_segments(thing.x, thing.y, radius + apart, segments, first, end))
    if first < 0:
        return bool(is_clear_of_segments(x, y, group.radius + apart, segments, thing.first, end_thing))
    return bool(_polygons_clear(segments, first, end, thing.first, end_thing, apart))


@inner
def is_place_free(
    grid: Any, groups: Records, x: float, y: float, group: Any, segments: Records, first: int, end: int
) -> bool:
    """Return whether a disc, or the polygon of segments `first` to `end`, keeps its distance from all in the grid."""
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


Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]

TAU = 2.0 * math.pi


@inner
def _compute_direction(angle: float, generator: int) -> tuple[float, float]:
    """Return the cosine and sine of an angle (rad); those of the computer's library for the former generator."""
    if generator == FORMER:
        return math.cos(angle), math.sin(angle)
    cosine, sine = compute_cosine_and_sine(angle)
    return cosine, sine


@inner
def _turn_polygon(
    x: float, y: float, turned: float, generator: int, corners: Floats, segments: Records, first: int
) -> None:
    """Write the edges of a polygon around (x, y), turned by `turned` (rad), into the segments of a world."""
    cosine, sine = _compute_direction(turned, generator)
    count = corners.shape[0]
    for index in range(count):
        a, b = corners[index], corners[(index + 1) % count]
        edge = segments[first + index]
        edge.x0, edge.y0 = x + cosine * a[0] - sine * a[1], y + sine * a[0] + cosine * a[1]
        edge.x1, edge.y1 = x + cosine * b[0] - sine * b[1], y + sine * b[0] + cosine * b[1]
        edge.wall = 0


@inner
def _in_bounds(
    x: float, y: float, group: Any, width: float, height: float, segments: Records, first: int
) -> bool:
    """Return whether a disc, or the polygon from segment `first` on, lies in the arena and its center in its region."""
    dx, dy = x - 0.5 * (group.x0 + group.x1), y - 0.5 * (group.y0 + group.y1)
    if dx * dx + dy * dy > group.circle * group.circle:
        return False
    if x < group.x0 or x > group.x1 or y < group.y0 or y > group.y1:
        return False
    if first < 0:
        away = group.radius + group.apart
        return bool(away <= x <= width - away and away <= y <= height - away)
    for index in range(first, first + group.end_point - group.point):
        edge = segments[index]
        if not (
            group.apart <= edge.x0 <= width - group.apart and group.apart <= edge.y0 <= height - group.apart
        ):
            return False
    return True


@inner
def _propose(
    group: Any,
    seed: int,
    item: int,
    attempt: int,
    generator: int,
    width: float,
    height: float,
    objects: Records,
) -> tuple[float, float]:
    """Return a random place (x, y) to try: in the group's region, or beside the object that the group is near."""
    streams = FIRST_STREAM + STREAMS * group.thing
    if group.near >= 0:
        near = objects[group.near]
        spread = TAU / 8.0 + (TAU - TAU / 8.0) * max(0, attempt - 50) / (ATTEMPTS - 50)
        turned = (draw_uniform(seed, item, attempt, streams + BESIDE) - 0.5) * spread
        dy, dx = 0.5 * height - near.y, 0.5 * width - near.x
        if generator == FORMER:
            angle = math.atan2(dy, dx) + turned
        else:
            angle = (compute_angle(dy, dx) if dx != 0.0 or dy != 0.0 else 0.0) + turned
        cosine, sine = _compute_direction(angle, generator)
        return near.x + group.near_m * cosine, near.y + group.near_m * sine
    away = group.apart + (group.radius if group.thing != POLYGON else 0.0)
    x0, x1 = max(group.x0, away), min(group.x1, width - away)
    y0, y1 = max(group.y0, away), min(group.y1, height - away)
    x = x0 + draw_uniform(seed, item, attempt, streams + X) * (x1 - x0)
    return x, y0 + draw_uniform(seed, item, attempt, streams + Y) * (y1 - y0)


@inner
def _fill(
    group: Any,
    item: int,
    seed: int,
    x: float,
    y: float,
    heading: float,
    robots: Records,
    objects: Records,
    discs: Records,
) -> None:
    """Write a thing at its place into the state of its world, and draw its remaining properties."""
    streams = FIRST_STREAM + STREAMS * group.thing
    if math.isnan(heading):
        heading = TAU * draw_uniform(seed, item, 0, streams + ANGLE)
    if group.thing == DISC:
        discs[item].x, discs[item].y, discs[item].radius = x, y, group.radius
        discs[item].height, discs[item].color = group.height, group.color
    elif group.thing == ROBOT:
        robot = robots[item]
        robot.x, robot.y, robot.heading = x, y, heading
        robot.id, robot.type, robot.stored = item, group.type, group.stored
    elif group.thing == OBJECT:
        thing = objects[item]
        thing.x, thing.y, thing.heading = x, y, heading
        thing.amount = scale_to_integer(
            group.amount_least, group.amount_most, draw_uniform(seed, item, 0, streams + AMOUNT)
        )
        thing.at_first = thing.amount
        thing.present = 1
        if not math.isnan(group.due_least):
            between = group.due_most - group.due_least
            thing.present = 0
            thing.due = max(1, round(group.due_least + between * draw_uniform(seed, item, 0, streams + DUE)))


@inner
def _with_walls(grid: Any, walls: Records, segments: Records) -> Any:
    """Return the grid with the walls added, which become the first segments of a world."""
    thing = blank(1, ENTRY)
    thing[0].slot = thing[0].group = -1
    for index in range(walls.shape[0]):
        wall = walls[index]
        segments[index] = wall
        thing[0].first = index
        x, y = 0.5 * (wall.x0 + wall.x1), 0.5 * (wall.y0 + wall.y1)
        grid = insert_into_grid(grid, x, y, abs(wall.x1 - x), abs(wall.y1 - y), thing)
    return grid


@inner
def _find_place(
    grid: Any,
    groups: Records,
    group: Any,
    item: int,
    seed: int,
    generator: int,
    width: float,
    height: float,
    corners: Floats,
    objects: Records,
    segments: Records,
    first: int,
) -> tuple[bool, float, float]:
    """Find a free place for a thing of a group: whether there is one, x and y (m)."""
    end = first + corners.shape[0]
    for attempt in range(ATTEMPTS):
        x, y = _propose(group, seed, item, attempt, generator, width, height, objects)
        if first >= 0:
            turned = TAU * draw_uniform(seed, item, attempt, FIRST_STREAM + STREAMS * group.thing + ANGLE)
            _turn_polygon(x, y, turned, generator, corners, segments, first)
        if _in_bounds(x, y, group, width, height, segments, first) and (
            is_place_free(grid, groups, x, y, group, segments, first, end)
        ):
            return True, x, y
    return False, 0.0, 0.0


@inner
def _lay_out_world(
    grid: Any,
    groups: Records,
    places: Floats,
    points: Floats,
    width: float,
    height: float,
    seed: int,
    generator: int,
    robots: Records,
    objects: Records,
    discs: Records,
    segments: Records,
) -> tuple[int, int, Any]:
    """Lay out one world; return the group and the thing without a free place, -1 if all have one, and the grid."""
    thing = blank(1, ENTRY)
    for g in range(groups.shape[0]):
        group = groups[g]
        streams = FIRST_STREAM + STREAMS * group.thing
        corners = points[group.point : group.end_point]
        reach = group.radius + group.apart
        comes = not math.isnan(group.due_least)
        thing[0].group = g
        for k in range(
            scale_to_integer(group.least, group.most, draw_uniform(seed, group.first, 0, streams + COUNT))
        ):
            item = group.first + k
            first = group.segment + k * corners.shape[0] if group.thing == POLYGON else -1
            x, y, heading = 0.0, 0.0, math.nan
            if group.place >= 0:
                place = group.place + k
                x, y, heading = places[place, 0], places[place, 1], places[place, 2]
                if first >= 0:
                    _turn_polygon(x, y, heading, generator, corners, segments, first)
            elif not comes:
                has_place, x, y = _find_place(
                    grid,
                    groups,
                    group,
                    item,
                    seed,
                    generator,
                    width,
                    height,
                    corners,
                    objects,
                    segments,
                    first,
                )
                if not has_place:
                    return g, k, grid
            _fill(group, item, seed, x, y, heading, robots, objects, discs)
            if group.alone and not comes:
                thing[0].x, thing[0].y, thing[0].first = x, y, first
                thing[0].slot = item if group.thing == OBJECT else -1
                grid = insert_into_grid(grid, x, y, reach, reach, thing)
    return -1, -1, grid


@njit_entry(nogil=True, error_model="numpy")
def place_objects(
    groups: Records,
    places: Floats,
    points: Floats,
    walls: Records,
    width: float,
    height: float,
    cell: float,
    seeds: Ints,
    generator: int,
    robots: Records,
    objects: Records,
    discs: Records,
    segments: Records,
) -> tuple[int, int, int]:
    """Lay out every world, in place: ROBOT [B, N], OBJECT [B, K], DISC [B, O], SEGMENT [B, S].

    Return the world, group and thing for which no free place was found, -1 if all have one.
    """
    heads = np.empty((int(height / cell) + 1, int(width / cell) + 1), np.int32)
    entries = blank(max(16, 2 * robots.shape[1]), ENTRY)
    for w in range(seeds.shape[0]):
        heads[:] = -1
        grid = _with_walls((heads, entries, 0, cell), walls, segments[w])
        group, thing, grid = _lay_out_world(
            grid,
            groups,
            places,
            points,
            width,
            height,
            seeds[w],
            generator,
            robots[w],
            objects[w],
            discs[w],
            segments[w],
        )
        if group >= 0:
            return w, group, thing
        entries = grid[1]
    return -1, -1, -1
