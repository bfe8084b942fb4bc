"""Kernels that pass the surroundings of a robot to its sonars, bumpers and camera."""

import math
from typing import Any

from understudy.jit.decorators import inlined, inner, int64, uint64
from understudy.sim.kernels.angles import cache_heading_vector
from understudy.sim.kernels.camera import measure_blob, project_objects, project_segments
from understudy.sim.kernels.dtypes import OBSTACLES, ROBOTS, WALLS
from understudy.sim.kernels.grid import find_big_cells, find_line_spots, find_static_range
from understudy.sim.kernels.sector_distances import (
    measure_sector_to_bounds,
    measure_sector_to_disc,
    measure_sector_to_segment,
)


@inner
def _to_disc(c: Any, step: Any, robot: Any, dx: float, dy: float, radius: float) -> None:
    """Shorten the distances of all sectors of a step to a disc at offset (dx, dy), in m."""
    cache_heading_vector(robot)
    cosine, sine = robot.cosine, robot.sine
    x, y = cosine * dx + sine * dy, cosine * dy - sine * dx
    for k in range(step.first, step.end):
        s, best = c.sectors[uint64(k)], c.a[uint64(k - step.first)]
        c.a[uint64(k - step.first)] = measure_sector_to_disc(
            x, y, radius, s.from_x, s.from_y, s.to_x, s.to_y, s.span, best
        )


@inner
def _to_segment(c: Any, step: Any, robot: Any, piece: Any) -> None:
    """Shorten the distances of all sectors of a step to a segment."""
    cache_heading_vector(robot)
    cosine, sine = robot.cosine, robot.sine
    dx, dy, ex, ey = piece.x0 - robot.x, piece.y0 - robot.y, piece.x1 - robot.x, piece.y1 - robot.y
    x0, y0 = cosine * dx + sine * dy, cosine * dy - sine * dx
    x1, y1 = cosine * ex + sine * ey, cosine * ey - sine * ex
    for k in range(step.first, step.end):
        s, best = c.sectors[uint64(k)], c.a[uint64(k - step.first)]
        best = measure_sector_to_segment(x0, y0, x1, y1, s.from_x, s.from_y, s.to_x, s.to_y, s.span, best)
        c.a[uint64(k - step.first)] = best


@inner
def _to_bounds(c: Any, step: Any, robot: Any) -> None:
    """Shorten the distances of all sectors of a step to the arena's outer walls."""
    cache_heading_vector(robot)
    x, y, cosine, sine = robot.x, robot.y, robot.cosine, robot.sine
    for k in range(step.first, step.end):
        s, best = c.sectors[uint64(k)], c.a[uint64(k - step.first)]
        c.a[uint64(k - step.first)] = measure_sector_to_bounds(
            x,
            y,
            cosine,
            sine,
            c.facts.width,
            c.facts.height,
            s.from_x,
            s.from_y,
            s.to_x,
            s.to_y,
            s.span,
            best,
        )


@inlined
def _to_fixed(c: Any, step: Any, robot: Any, world: int, limit: float) -> None:
    """Shorten the distances of all sectors of a step to walls, obstacles and solid objects, as the sensor sees them."""
    x, y = robot.x, robot.y
    if step.sees & WALLS and min(x, y, c.facts.width - x, c.facts.height - y) < limit:
        _to_bounds(c, step, robot)
    begin, end = find_static_range(c, x, y, world)
    for k in range(begin, end):
        item = int64(c.near_items[uint64(k)])
        if item < 0:
            piece = c.segments[world * c.facts.segment_count - 1 - item]
            if step.sees & (WALLS if piece.wall else OBSTACLES):
                _to_segment(c, step, robot, piece)
        elif step.sees & OBSTACLES:
            disc = c.discs[world * c.facts.disc_count + item]
            dx, dy = disc.x - x, disc.y - y
            reach = limit + disc.radius
            if dx * dx + dy * dy < reach * reach:
                _to_disc(c, step, robot, dx, dy, disc.radius)
    if not (c.facts.solids and step.sees & OBSTACLES):
        return
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if kind.solid:
            for slot in range(kind.first, kind.end):
                thing = c.objects[world * c.facts.object_count + slot]
                dx, dy = thing.x - x, thing.y - y
                reach = limit + kind.radius
                if thing.present and dx * dx + dy * dy < reach * reach:
                    _to_disc(c, step, robot, dx, dy, kind.radius)


@inner
def _to_robots(c: Any, step: Any, row: int, world: int, limit: float) -> None:
    """Shorten the distances of all sectors of a step to other robots."""
    robot, reach = c.robots[row], limit + c.facts.most_radius
    x, y = robot.x, robot.y
    if not c.facts.gridded:
        for other in range(world * c.facts.count, (world + 1) * c.facts.count):
            dx, dy = c.robots[other].x - x, c.robots[other].y - y
            if dx * dx + dy * dy < reach * reach and other != row:
                _to_disc(c, step, robot, dx, dy, c.types[c.robots[other].type].radius)
        return
    low, high, lowest, highest = find_big_cells(c, x, y, reach)
    for line in range(lowest, highest + 1):
        begin, end = find_line_spots(c, line, low, high)
        for k in range(begin, end):
            spot = c.spots[k]
            dx, dy = spot.x - x, spot.y - y
            if dx * dx + dy * dy < reach * reach and spot.row != row:
                _to_disc(c, step, robot, dx, dy, c.types[c.robots[spot.row].type].radius)


@inlined
def scan_sectors(c: Any, row: int, world: int, step: Any, limit: float) -> None:
    """Write the distance (m, from the robot's center, at most `limit`) to the nearest thing per sector to `c.a`."""
    for k in range(step.end - step.first):
        c.a[uint64(k)] = limit
    _to_fixed(c, step, c.robots[row], world, limit)
    if step.sees & ROBOTS:
        _to_robots(c, step, row, world, limit)


@inner
def _put(
    c: Any, count: int, robot: Any, x: float, y: float, radius: float, height: float, color: int, opaque: int
) -> Any:
    """Append a thing at (x, y) to the things before a robot's camera, in its frame; return the new count."""
    cosine, sine = robot.cosine, robot.sine
    dx, dy = x - robot.x, y - robot.y
    thing = c.things[count]
    thing.x, thing.y = cosine * dx + sine * dy, cosine * dy - sine * dx
    thing.radius, thing.height, thing.color, thing.opaque = radius, height, color, opaque
    return count + 1


@inner
def _put_robots(c: Any, count: int, row: int, world: int, limit: float) -> Any:
    """Append the other robots to the things before a robot's camera; return the new count."""
    robot = c.robots[row]
    if not c.facts.gridded or limit > 8.0 * c.facts.cell:
        for other in range(world * c.facts.count, (world + 1) * c.facts.count):
            if other != row:
                them = c.robots[other]
                kind = c.types[them.type]
                count = _put(c, count, robot, them.x, them.y, kind.radius, kind.height, kind.color, 1)
        return count
    low, high, lowest, highest = find_big_cells(c, robot.x, robot.y, limit + c.facts.most_radius)
    for line in range(lowest, highest + 1):
        begin, end = find_line_spots(c, line, low, high)
        for k in range(begin, end):
            spot = c.spots[k]
            if spot.row != row:
                kind = c.types[c.robots[spot.row].type]
                count = _put(c, count, robot, spot.x, spot.y, kind.radius, kind.height, kind.color, 1)
    return count


@inner
def detect_blobs(c: Any, row: int, world: int, step: Any) -> None:
    """Write the blobs of the colors of a camera step's parts to `c.a` (center x, pixels) and `c.b` (size, pixels)."""
    robot, count = c.robots[row], 0
    cache_heading_vector(robot)
    for k in range(c.facts.disc_count):
        disc = c.discs[world * c.facts.disc_count + k]
        if disc.radius > 0.0:
            count = _put(c, count, robot, disc.x, disc.y, disc.radius, disc.height, disc.color, 1)
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if kind.color >= 0 or kind.solid:
            for slot in range(kind.first, kind.end):
                thing = c.objects[world * c.facts.object_count + slot]
                if thing.present:
                    count = _put(
                        c, count, robot, thing.x, thing.y, kind.radius, kind.height, kind.color, kind.opaque
                    )
    count = _put_robots(c, count, row, world, step.range)
    cosine, sine = robot.cosine, robot.sine
    for k in range(c.facts.segment_count):
        piece, local = c.segments[world * c.facts.segment_count + k], c.pieces[k]
        dx, dy, ex, ey = piece.x0 - robot.x, piece.y0 - robot.y, piece.x1 - robot.x, piece.y1 - robot.y
        local.x0, local.y0 = cosine * dx + sine * dy, cosine * dy - sine * dx
        local.x1, local.y1 = cosine * ex + sine * ey, cosine * ey - sine * ex
    views = c.views[: count + c.facts.segment_count]
    things, pieces = c.things[:count], c.pieces[: c.facts.segment_count]
    discs = project_objects(things, count, step.tan_half, step.width_px, step.height_px, step.range, views)
    end = project_segments(pieces, c.facts.segment_count, step.tan_half, views, discs)
    for k in range(step.first, step.end):
        color = c.parts[k].color
        x, size = math.nan, math.nan
        if color >= 0:
            x, size = measure_blob(
                views, discs, end, color, step.tan_half, step.width_px, step.nearest != 0, step.least_px
            )
        c.a[k - step.first], c.b[k - step.first] = x, size
