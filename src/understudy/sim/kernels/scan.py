"""Kernels that bring what is around a robot before its sonar, its bumpers and its camera."""

import math
from typing import Any

from numba import njit

from understudy.sim.kernels.camera import blob, project, screen
from understudy.sim.kernels.dtypes import NUMBER, PART, SEGMENT, SPOT, THING, VIEW
from understudy.sim.kernels.grid import big_cells, near_range, spots_of_line
from understudy.sim.kernels.memory import (
    array_at,
    at,
    class_at,
    disc_at,
    face,
    index_at,
    object_at,
    robot_at,
    segment_at,
    type_at,
)
from understudy.sim.kernels.sonar import sector_to_bounds, sector_to_disc, sector_to_segment
from understudy.sim.sensing.sectors import SECTOR

WALLS, OBSTACLES, ROBOTS = 1, 2, 4


@njit(error_model="numpy")
def _to_disc(c: Any, step: Any, robot: Any, dx: float, dy: float, radius: float) -> None:
    """Shorten the distances of all sectors of a step by a disc whose center is (dx, dy) off."""
    face(robot)
    cosine, sine = robot.cosine, robot.sine
    x, y = cosine * dx + sine * dy, cosine * dy - sine * dx
    for k in range(step.first, step.end):
        s, best = at(c.sectors, k, SECTOR), at(c.a, k - step.first, NUMBER)
        best.v = sector_to_disc(x, y, radius, s.from_x, s.from_y, s.to_x, s.to_y, s.span, best.v)


@njit(error_model="numpy")
def _to_segment(c: Any, step: Any, robot: Any, piece: Any) -> None:
    """Shorten them by a segment."""
    face(robot)
    cosine, sine = robot.cosine, robot.sine
    dx, dy, ex, ey = piece.x0 - robot.x, piece.y0 - robot.y, piece.x1 - robot.x, piece.y1 - robot.y
    x0, y0 = cosine * dx + sine * dy, cosine * dy - sine * dx
    x1, y1 = cosine * ex + sine * ey, cosine * ey - sine * ex
    for k in range(step.first, step.end):
        s, best = at(c.sectors, k, SECTOR), at(c.a, k - step.first, NUMBER)
        best.v = sector_to_segment(x0, y0, x1, y1, s.from_x, s.from_y, s.to_x, s.to_y, s.span, best.v)


@njit(error_model="numpy")
def _to_bounds(c: Any, step: Any, robot: Any) -> None:
    """Shorten them by the arena's own walls."""
    face(robot)
    x, y, cosine, sine = robot.x, robot.y, robot.cosine, robot.sine
    for k in range(step.first, step.end):
        s, best = at(c.sectors, k, SECTOR), at(c.a, k - step.first, NUMBER)
        best.v = sector_to_bounds(
            x, y, cosine, sine, c.width, c.height, s.from_x, s.from_y, s.to_x, s.to_y, s.span, best.v
        )


@njit(error_model="numpy", forceinline=True)
def _to_fixed(c: Any, step: Any, robot: Any, world: int, limit: float) -> None:
    """Shorten them by walls, obstacles and solid objects."""
    x, y = robot.x, robot.y
    if step.sees & WALLS and min(x, y, c.width - x, c.height - y) < limit:
        _to_bounds(c, step, robot)
    begin, end = near_range(c, x, y, world)
    for k in range(begin, end):
        item = index_at(c.near_items, k)
        if item < 0:
            piece = segment_at(c, world, -1 - item)
            if step.sees & (WALLS if piece.wall else OBSTACLES):
                _to_segment(c, step, robot, piece)
        elif step.sees & OBSTACLES:
            disc = disc_at(c, world, item)
            dx, dy = disc.x - x, disc.y - y
            if dx * dx + dy * dy < (limit + disc.radius) ** 2:
                _to_disc(c, step, robot, dx, dy, disc.radius)
    if not (c.solids and step.sees & OBSTACLES):
        return
    for index in range(c.class_count):
        kind = class_at(c, index)
        if kind.solid:
            for slot in range(kind.first, kind.end):
                thing = object_at(c, world, slot)
                dx, dy = thing.x - x, thing.y - y
                if thing.present and dx * dx + dy * dy < (limit + kind.radius) ** 2:
                    _to_disc(c, step, robot, dx, dy, kind.radius)


@njit(error_model="numpy")
def _to_robots(c: Any, step: Any, row: int, world: int, limit: float) -> None:
    """Shorten them by the other robots."""
    robot, reach = robot_at(c, row), limit + c.most_radius
    x, y = robot.x, robot.y
    if not c.gridded:
        for other in range(world * c.count, (world + 1) * c.count):
            dx, dy = robot_at(c, other).x - x, robot_at(c, other).y - y
            if dx * dx + dy * dy < reach * reach and other != row:
                _to_disc(c, step, robot, dx, dy, type_at(c, robot_at(c, other).type).radius)
        return
    low, high, lowest, highest = big_cells(c, x, y, reach)
    for line in range(lowest, highest + 1):
        begin, end = spots_of_line(c, line, low, high)
        for k in range(begin, end):
            spot = at(c.spots, k, SPOT)
            dx, dy = spot.x - x, spot.y - y
            if dx * dx + dy * dy < reach * reach and spot.row != row:
                _to_disc(c, step, robot, dx, dy, type_at(c, robot_at(c, spot.row).type).radius)


@njit(error_model="numpy", forceinline=True)
def scan(c: Any, row: int, world: int, step: Any, limit: float) -> None:
    """The distance (m, from the robot's center, at most `limit`) to what is nearest in each sector, to `c.a`."""
    for k in range(step.end - step.first):
        at(c.a, k, NUMBER).v = limit
    _to_fixed(c, step, robot_at(c, row), world, limit)
    if step.sees & ROBOTS:
        _to_robots(c, step, row, world, limit)


@njit(error_model="numpy")
def _put(
    c: Any, count: int, robot: Any, x: float, y: float, radius: float, height: float, color: int, opaque: int
) -> Any:
    """Add something at a place in the world to the things that a camera may see."""
    cosine, sine = robot.cosine, robot.sine
    dx, dy = x - robot.x, y - robot.y
    thing = at(c.things, count, THING)
    thing.x, thing.y = cosine * dx + sine * dy, cosine * dy - sine * dx
    thing.radius, thing.height, thing.color, thing.opaque = radius, height, color, opaque
    return count + 1


@njit(error_model="numpy")
def _put_robots(c: Any, count: int, row: int, world: int, limit: float) -> Any:
    """Add the other robots."""
    robot = robot_at(c, row)
    if not c.gridded or limit > 8.0 * c.cell:
        for other in range(world * c.count, (world + 1) * c.count):
            if other != row:
                them = robot_at(c, other)
                kind = type_at(c, them.type)
                count = _put(c, count, robot, them.x, them.y, kind.radius, kind.height, kind.color, 1)
        return count
    low, high, lowest, highest = big_cells(c, robot.x, robot.y, limit + c.most_radius)
    for line in range(lowest, highest + 1):
        begin, end = spots_of_line(c, line, low, high)
        for k in range(begin, end):
            spot = at(c.spots, k, SPOT)
            if spot.row != row:
                kind = type_at(c, robot_at(c, spot.row).type)
                count = _put(c, count, robot, spot.x, spot.y, kind.radius, kind.height, kind.color, 1)
    return count


@njit(error_model="numpy")
def look(c: Any, row: int, world: int, step: Any) -> None:
    """The blobs (x and size, pixels) of the colors that the parts of a camera's step ask for, to `c.a` and `c.b`."""
    robot, count = robot_at(c, row), 0
    face(robot)
    for k in range(c.disc_count):
        disc = disc_at(c, world, k)
        if disc.radius > 0.0:
            count = _put(c, count, robot, disc.x, disc.y, disc.radius, disc.height, disc.color, 1)
    for index in range(c.class_count):
        kind = class_at(c, index)
        if kind.color >= 0 or kind.solid:
            for slot in range(kind.first, kind.end):
                thing = object_at(c, world, slot)
                if thing.present:
                    count = _put(
                        c, count, robot, thing.x, thing.y, kind.radius, kind.height, kind.color, kind.opaque
                    )
    count = _put_robots(c, count, row, world, step.range)
    cosine, sine = robot.cosine, robot.sine
    for k in range(c.segment_count):
        piece, local = segment_at(c, world, k), at(c.pieces, k, SEGMENT)
        dx, dy, ex, ey = piece.x0 - robot.x, piece.y0 - robot.y, piece.x1 - robot.x, piece.y1 - robot.y
        local.x0, local.y0 = cosine * dx + sine * dy, cosine * dy - sine * dx
        local.x1, local.y1 = cosine * ex + sine * ey, cosine * ey - sine * ex
    views = array_at(c.views, count + c.segment_count, VIEW)
    things, pieces = array_at(c.things, count, THING), array_at(c.pieces, c.segment_count, SEGMENT)
    discs = project(things, count, step.tan_half, step.width_px, step.height_px, step.range, views)
    end = screen(pieces, c.segment_count, step.tan_half, views, discs)
    for k in range(step.first, step.end):
        color = at(c.parts, k, PART).color
        x, size = math.nan, math.nan
        if color >= 0:
            x, size = blob(
                views, discs, end, color, step.tan_half, step.width_px, step.nearest != 0, step.least_px
            )
        at(c.a, k - step.first, NUMBER).v, at(c.b, k - step.first, NUMBER).v = x, size
