"""Kernels of motion and collisions: the step that each robot would make in a tick, and the possible share of it.

A step is limited by the gap to each solid thing: along the line to its nearest point, robot and thing may together
close the gap and no more. All solid things are convex, so nothing overlaps and no step passes through anything,
for any order in which robots are processed. Along things that stay in place, a robot slides.
"""

import math
from typing import Any

from understudy.jit.decorators import inlined, inner, int64, uint64
from understudy.sim.kernels.angles import cache_heading_vector, compute_cosine_and_sine, wrap_angle
from understudy.sim.kernels.grid import (
    find_big_cells,
    find_line_spots,
    find_small_cells,
    find_static_range,
    index_small_cell,
)
from understudy.sim.kernels.rng import draw_normal

CROWD = 12  # robots in a line of cells; where there are more, small cells are looked at
STUCK = 0.1  # a robot that moved less than this share of its wanted way is stuck
CLEAR = 1e-9  # m; kept free, so that rounding never makes an overlap
DRIVING, TURNING = 16, 18  # streams of random draws, two each


@inlined
def propose_step(
    robot: Any, kind: Any, drive: float, turn: float, seed: int, tick: int, generator: int, move: Any
) -> None:
    """Compute a robot's step under its commands, without obstacles, into `move`: dx, dy (m), heading; scale is 1.

    The robot moves along the chord of the arc that its speeds describe. Its speeds approach the commanded ones as
    fast as its accelerations permit.
    """
    move.scale = 1.0
    move.wanted = 0.0
    if robot.frozen:
        robot.speed = robot.spin = 0.0
        move.dx = move.dy = 0.0
        move.heading = robot.heading
        return
    speed = min(1.0, max(-1.0, drive)) * kind.speed
    spin = min(1.0, max(-1.0, turn)) * kind.turning
    most, most_spin = kind.acceleration, kind.turning_acceleration
    robot.speed += min(most, max(-most, speed - robot.speed))
    robot.spin += min(most_spin, max(-most_spin, spin - robot.spin))
    distance, angle = robot.speed, robot.spin
    if kind.noise_drive > 0.0 and distance != 0.0:  # at most twice as far: how far is near is known before
        drawn = draw_normal(seed, robot.id, tick, DRIVING, generator)
        distance *= min(2.0, max(0.0, 1.0 + kind.noise_drive * drawn))
    if kind.noise_turn > 0.0 and angle != 0.0:
        angle *= 1.0 + kind.noise_turn * draw_normal(seed, robot.id, tick, TURNING, generator)
    move.dx = move.dy = 0.0
    if distance != 0.0:
        if angle == 0.0:
            cache_heading_vector(robot)
            move.dx, move.dy = distance * robot.cosine, distance * robot.sine
        else:
            half = 0.5 * angle
            _, sine = compute_cosine_and_sine(half)
            distance *= sine / half
            cosine, sine = compute_cosine_and_sine(robot.heading + half)
            move.dx, move.dy = distance * cosine, distance * sine
    move.wanted = abs(distance)
    move.heading = robot.heading
    if angle != 0.0:
        move.heading = wrap_angle(robot.heading + angle)


@inlined
def limit_by_gap(scale: float, nx: float, ny: float, gap: float, dx: float, dy: float, other: float) -> Any:
    """Return the share of a step (dx, dy) that a gap (m) to a thing permits, at most `scale`.

    (nx, ny) is the unit vector towards the thing. `other` is the distance by which the thing approaches the robot in
    the same tick, m.
    """
    closing = dx * nx + dy * ny
    if closing <= 0.0:
        return scale
    both = closing + max(0.0, other)
    if both <= gap - CLEAR:
        return scale
    return min(scale, max(0.0, gap - CLEAR) / both)


@inlined
def limit_by_disc(scale: float, x: float, y: float, radius: float, move: Any, disc: Any) -> Any:
    """Return the share of a step that a fixed `disc` (x, y, radius) permits a robot at (x, y), at most `scale`."""
    dx, dy = disc[0] - x, disc[1] - y
    reach = radius + disc[2] + math.sqrt(move.dx * move.dx + move.dy * move.dy)
    squared = dx * dx + dy * dy
    if squared >= reach * reach * 1.0001 or squared == 0.0:
        return scale
    distance = math.sqrt(squared)
    gap = distance - radius - disc[2]
    return limit_by_gap(scale, dx / distance, dy / distance, gap, move.dx, move.dy, 0.0)


@inlined
def find_nearest_on_segment(x: float, y: float, segment: Any) -> Any:
    """Return the point (x, y) of a segment that is nearest to a place."""
    ex, ey = segment.x1 - segment.x0, segment.y1 - segment.y0
    length = ex * ex + ey * ey
    along = 0.0
    if length > 0.0:
        along = min(1.0, max(0.0, ((x - segment.x0) * ex + (y - segment.y0) * ey) / length))
    return segment.x0 + along * ex, segment.y0 + along * ey


@inlined
def limit_by_segment(scale: float, x: float, y: float, radius: float, move: Any, segment: Any) -> Any:
    """Return the share of a step that a segment of a wall or polygon permits, at most `scale`."""
    near_x, near_y = find_nearest_on_segment(x, y, segment)
    return limit_by_disc(scale, x, y, radius, move, (near_x, near_y, 0.0))


@inlined
def limit_by_bounds(
    scale: float, x: float, y: float, radius: float, move: Any, width: float, height: float
) -> float:
    """Return the share of a step that the arena's outer walls permit, at most `scale`."""
    if move.dx < 0.0:
        scale = limit_by_gap(scale, -1.0, 0.0, x - radius, move.dx, move.dy, 0.0)
    elif move.dx > 0.0:
        scale = limit_by_gap(scale, 1.0, 0.0, width - radius - x, move.dx, move.dy, 0.0)
    if move.dy < 0.0:
        scale = limit_by_gap(scale, 0.0, -1.0, y - radius, move.dx, move.dy, 0.0)
    elif move.dy > 0.0:
        scale = limit_by_gap(scale, 0.0, 1.0, height - radius - y, move.dx, move.dy, 0.0)
    return scale


@inlined
def limit_by_robot(c: Any, scale: float, row: int, other: int, dx: float, dy: float, world: int) -> Any:
    """Return the share of a step that another robot, (dx, dy) away, permits, at most `scale`.

    Both are assumed to make their full steps. Robots that hold the same box do not limit each other.
    """
    own, them = c.robots[row], c.robots[other]
    if own.holding != 0 and own.holding == them.holding:
        return scale
    their_kind = c.types[them.type]
    if not their_kind.collides:
        return scale
    squared = dx * dx + dy * dy
    if squared == 0.0:
        return scale
    move, their_move = c.moves[row - world * c.facts.count], c.moves[other - world * c.facts.count]
    distance = math.sqrt(squared)
    nx, ny = dx / distance, dy / distance
    towards = -(their_move.dx * nx + their_move.dy * ny)
    gap = distance - c.types[own.type].radius - their_kind.radius
    return limit_by_gap(scale, nx, ny, gap, move.dx, move.dy, towards)


@inlined
def limit_by_robots(c: Any, scale: float, row: int, world: int) -> Any:
    """Return the share of a robot's step that all other robots of its world permit, at most `scale`."""
    own, move = c.robots[uint64(row)], c.moves[uint64(row - world * c.facts.count)]
    near = c.types[own.type].radius + c.facts.most_radius + c.facts.most_step
    near += math.sqrt(move.dx * move.dx + move.dy * move.dy)
    if not c.facts.gridded:
        for other in range(world * c.facts.count, (world + 1) * c.facts.count):
            dx, dy = c.robots[other].x - own.x, c.robots[other].y - own.y
            if dx * dx + dy * dy < near * near and other != row:
                scale = limit_by_robot(c, scale, row, other, dx, dy, world)
        return scale
    low, high, lowest, highest = find_big_cells(c, own.x, own.y, near)
    for line in range(lowest, highest + 1):
        begin, end = find_line_spots(c, line, low, high)
        if end - begin > CROWD:
            return _limited_in_crowd(c, scale, row, world, near)
        scale = _limited_by_spots(c, scale, row, world, near, begin, end)
    return scale


@inlined
def _limited_by_spots(c: Any, scale: float, row: int, world: int, near: float, begin: int, end: int) -> Any:
    """Return the share of a step that robots in grid spots `begin` to `end`, nearer than `near` (m), permit."""
    own = c.robots[row]
    x, y, near_squared = own.x, own.y, near * near
    for k in range(begin, end):
        spot = c.spots[uint64(k)]
        dx, dy = spot.x - x, spot.y - y
        if dx * dx + dy * dy < near_squared and spot.row != row:
            scale = limit_by_robot(c, scale, row, spot.row, dx, dy, world)
    return scale


@inner
def _limited_in_crowd(c: Any, scale: float, row: int, world: int, near: float) -> Any:
    """Return the share of a step that all other robots permit, searching small cells only."""
    own = c.robots[row]
    low, high, lowest, highest = find_small_cells(c, own.x, own.y, near)
    for line in range(lowest, highest + 1):
        for column in range(low, high + 1):
            cell = index_small_cell(c, column, line)
            begin, end = int64(c.start[cell]), int64(c.start[cell + 1])
            scale = _limited_by_spots(c, scale, row, world, near, begin, end)
    return scale


@inlined
def limit_by_fixed(c: Any, scale: float, x: float, y: float, radius: float, move: Any, world: int) -> Any:
    """Return the share of a disc's step that outer walls, walls, obstacles and fixed solid objects permit."""
    scale = limit_by_bounds(scale, x, y, radius, move, c.facts.width, c.facts.height)
    begin, end = find_static_range(c, x, y, world)
    for k in range(begin, end):
        item = int64(c.near_items[uint64(k)])
        if item >= 0:
            disc = c.discs[world * c.facts.disc_count + item]
            scale = limit_by_disc(scale, x, y, radius, move, (disc.x, disc.y, disc.radius))
        else:
            scale = limit_by_segment(
                scale, x, y, radius, move, c.segments[world * c.facts.segment_count - 1 - item]
            )
    if not c.facts.solids:
        return scale
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if kind.solid and not kind.pushable:
            for slot in range(kind.first, kind.end):
                thing = c.objects[world * c.facts.object_count + slot]
                if thing.present:
                    scale = limit_by_disc(scale, x, y, radius, move, (thing.x, thing.y, kind.radius))
    return scale


@inlined
def _slid(move: Any, nx: float, ny: float, gap: float) -> Any:
    """Remove from a step its part beyond the gap along the unit vector (nx, ny); return whether there was any."""
    deep = move.dx * nx + move.dy * ny - max(0.0, gap - CLEAR)
    if deep <= 0.0:
        return False
    move.dx -= deep * nx
    move.dy -= deep * ny
    return True


@inlined
def _slid_along(
    move: Any, x: float, y: float, radius: float, to_x: float, to_y: float, to_radius: float
) -> Any:
    """Remove from a step its part into a fixed disc, or a point (radius 0); return whether there was any."""
    dx, dy = to_x - x, to_y - y
    reach = radius + to_radius + move.wanted
    squared = dx * dx + dy * dy
    if squared >= reach * reach * 1.0001 or squared == 0.0:
        return False
    distance = math.sqrt(squared)
    return _slid(move, dx / distance, dy / distance, distance - radius - to_radius)


@inner
def slide_along_walls(c: Any, row: int, world: int) -> None:
    """Make a robot slide along walls, obstacles and fixed solid objects: only its motion into them is removed.

    A step longer than the robot's radius is shortened instead, because the first thing in its way is not searched for.
    """
    robot, move = c.robots[uint64(row)], c.moves[uint64(row - world * c.facts.count)]
    if move.dx == 0.0 and move.dy == 0.0:
        return
    x, y, radius = robot.x, robot.y, c.types[robot.type].radius
    if move.wanted > radius:
        move.scale = limit_by_fixed(c, 1.0, x, y, radius, move, world)
        return
    met = _slid(move, -1.0, 0.0, x - radius) or _slid(move, 1.0, 0.0, c.facts.width - radius - x)
    met = _slid(move, 0.0, -1.0, y - radius) or _slid(move, 0.0, 1.0, c.facts.height - radius - y) or met
    begin, end = find_static_range(c, x, y, world)
    for k in range(begin, end):
        item = int64(c.near_items[uint64(k)])
        if item >= 0:
            disc = c.discs[world * c.facts.disc_count + item]
            met = _slid_along(move, x, y, radius, disc.x, disc.y, disc.radius) or met
        else:
            piece = c.segments[world * c.facts.segment_count - 1 - item]
            near_x, near_y = find_nearest_on_segment(x, y, piece)
            met = _slid_along(move, x, y, radius, near_x, near_y, 0.0) or met
    if c.facts.solids:
        for index in range(c.facts.class_count):
            kind = c.classes[index]
            if kind.solid and not kind.pushable:
                for slot in range(kind.first, kind.end):
                    thing = c.objects[world * c.facts.object_count + slot]
                    if thing.present:
                        met = _slid_along(move, x, y, radius, thing.x, thing.y, kind.radius) or met
    if met:  # in a corner, what slides along one may lead into another
        move.scale = limit_by_fixed(c, 1.0, x, y, radius, move, world)


@inlined
def move_robot(c: Any, row: int, world: int) -> None:
    """Move a robot by the permitted share of its step, and count the ticks in which it is blocked."""
    robot, move = c.robots[uint64(row)], c.moves[uint64(row - world * c.facts.count)]
    if robot.frozen:
        return
    dx, dy = move.scale * move.dx, move.scale * move.dy
    robot.x += dx
    robot.y += dy
    robot.heading = move.heading
    if c.facts.gridded:
        spot = c.spots[int64(c.spot_of[row - world * c.facts.count])]
        spot.x, spot.y = robot.x, robot.y
    robot.blocked = 0 if move.wanted == 0.0 else robot.blocked
    if move.wanted > 0.0:
        share = math.sqrt(dx * dx + dy * dy) / move.wanted
        if share < 1.0 - CLEAR:
            robot.speed *= share
        robot.blocked = robot.blocked + 1 if share < STUCK else 0
