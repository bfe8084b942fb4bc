"""Kernels of sensing: what one robot measures in one tick, step by step of its sense plan (see `plans.py`)."""

import math
from typing import Any

from numba import njit

from understudy.worlds._camera_kernels import blob, project, screen
from understudy.worlds._draw_kernels import normal, uniform
from understudy.worlds._grid_kernels import near_range, nearest_robot
from understudy.worlds._sonar_kernels import sector_to_bounds, sector_to_disc, sector_to_segment

(
    TO_CLASS, TO_OBJECT, TO_ROBOT, SONAR, CAMERA, BUMPER,
    OWN_X, OWN_Y, OWN_HEADING, OWN_SPEED, OWN_TURNING,
    STUCK, STORED, FOOD_HERE, FOOD_LEFT, STATION_HERE, CHANCE, SINCE,
) = range(18)  # fmt: skip
WALLS, OBSTACLES, ROBOTS = 1, 2, 4

TAU = 2.0 * math.pi
TOUCH = 0.005  # m; nearer than this is touching
NOISE_A, NOISE_B, DROPOUT, MISS, GHOST, GHOST_X = 0, 2, 4, 5, 6, 7  # streams within a part's eight
GHOST_PX = 16.0  # the largest size of a blob that is not there, as wide and high


@njit(error_model="numpy")
def nearest_object(c: Any, x: float, y: float, index: int) -> Any:
    """Slot and squared distance of the nearest object of a class (food: with food left); -1 where none is."""
    kind = class_at(c, index)
    best, best_squared = -1, math.inf
    for slot in range(kind.first, kind.end):
        thing = object_at(c, world, slot)
        dx, dy = thing.x - x, thing.y - y
        squared = dx * dx + dy * dy
        if squared < best_squared and thing.present and (thing.amount > 0 or not kind.food):
            best, best_squared = slot, squared
    return best, best_squared


@njit(error_model="numpy")
def nearest_food(c: Any, x: float, y: float) -> Any:
    """The same, of all classes of food."""
    best, best_squared = -1, math.inf
    for index in range(c.class_count):
        if class_at(c, index).food:
            slot, squared = nearest_object(c, x, y, index)
            if squared < best_squared:
                best, best_squared = slot, squared
    return best, best_squared


@njit(error_model="numpy")
def station_here(c: Any, x: float, y: float, reach: float) -> bool:
    """Whether a home is within reach."""
    for index in range(c.class_count):
        if class_at(c, index).home:
            _, squared = nearest_object(c, x, y, index)
            if squared <= reach * reach:
                return True
    return False


@njit(error_model="numpy")
def bearing(robot: Any, x: float, y: float) -> float:
    """The bearing (rad, robot frame, [0, tau)) of a place; 0 where the robot is."""
    dx, dy = x - robot.x, y - robot.y
    if dx == 0.0 and dy == 0.0:
        return 0.0
    angle = (math.atan2(dy, dx) - robot.heading) % TAU
    return angle if angle < TAU else 0.0


@njit(error_model="numpy")
def _all_to_disc(c: Any, step: Any, best: Any, x: float, y: float, radius: float) -> None:
    """Shorten the distances of all sectors of a step by a disc in the robot frame."""
    for k in range(step.first, step.end):
        s = at(c.sectors, k, SECTOR)
        best[k - step.first] = sector_to_disc(
            x, y, radius, s.from_x, s.from_y, s.to_x, s.to_y, s.span, best[k - step.first]
        )


@njit(error_model="numpy")
def scan(c: Any, row: int, world: int, step: Any, limit: float, best: Any) -> None:
    """The distance (m, from the robot's center, at most `limit`) to what is nearest in each sector of a step."""
    robot = robot_at(c, row)
    x, y = robot.x, robot.y
    cosine, sine = math.cos(robot.heading), math.sin(robot.heading)
    for k in range(step.first, step.end):
        best[k - step.first] = limit
    if step.sees & WALLS and min(x, y, c.width - x, c.height - y) < limit:
        for k in range(step.first, step.end):
            s = at(c.sectors, k, SECTOR)
            best[k - step.first] = sector_to_bounds(
                x, y, cosine, sine, c.width, c.height,
                s.from_x, s.from_y, s.to_x, s.to_y, s.span, best[k - step.first],
            )  # fmt: skip
    begin, end = near_range(c, x, y, world)
    for at in range(begin, end):
        item = at(c.near_items, at, INDEX).v
        if item >= 0:
            if step.sees & OBSTACLES:
                disc = disc_at(c, world, item)
                dx, dy = disc.x - x, disc.y - y
                if dx * dx + dy * dy < (limit + disc.radius) ** 2:
                    _all_to_disc(c, step, best, cosine * dx + sine * dy, cosine * dy - sine * dx, disc.radius)
            continue
        piece = segment_at(c, world, -1 - item)
        if step.sees & (WALLS if piece.wall else OBSTACLES):
            dx, dy, ex, ey = piece.x0 - x, piece.y0 - y, piece.x1 - x, piece.y1 - y
            x0, y0 = cosine * dx + sine * dy, cosine * dy - sine * dx
            x1, y1 = cosine * ex + sine * ey, cosine * ey - sine * ex
            for k in range(step.first, step.end):
                s = at(c.sectors, k, SECTOR)
                best[k - step.first] = sector_to_segment(
                    x0, y0, x1, y1, s.from_x, s.from_y, s.to_x, s.to_y, s.span, best[k - step.first]
                )
    if step.sees & OBSTACLES:
        for index in range(c.class_count):
            kind = class_at(c, index)
            if kind.solid:
                for slot in range(kind.first, kind.end):
                    thing = object_at(c, world, slot)
                    dx, dy = thing.x - x, thing.y - y
                    if thing.present and dx * dx + dy * dy < (limit + kind.radius) ** 2:
                        _all_to_disc(c, step, best, cosine * dx + sine * dy, cosine * dy - sine * dx, kind.radius)
    if not step.sees & ROBOTS:
        return
    reach = limit + c.most_radius
    first = world * c.count
    if not c.gridded:
        for other in range(first, first + c.count):
            dx, dy = robot_at(c, other).x - x, robot_at(c, other).y - y
            if dx * dx + dy * dy < reach * reach and other != row:
                radius = type_at(c, robot_at(c, other).type).radius
                _all_to_disc(c, step, best, cosine * dx + sine * dy, cosine * dy - sine * dx, radius)
        return
    low, high = max(int((x - reach) / c.cell), 0), min(int((x + reach) / c.cell), c.columns - 1)
    for line in range(max(int((y - reach) / c.cell), 0), min(int((y + reach) / c.cell), c.lines - 1) + 1):
        small = 2 * c.shift
        begin = at(c.start, (line * c.columns + low) << small, INDEX).v
        for at in range(begin, at(c.start, (line * c.columns + high + 1) << small, INDEX).v):
            spot = at(c.spots, at, SPOT)
            dx, dy = spot.x - x, spot.y - y
            if dx * dx + dy * dy < reach * reach and spot.row != row:
                radius = type_at(c, robot_at(c, spot.row).type).radius
                _all_to_disc(c, step, best, cosine * dx + sine * dy, cosine * dy - sine * dx, radius)


@njit(error_model="numpy")
def _put(c: Any, things: Any, count: int, robot: Any, x: float, y: float, radius: float, height: float, color: int, opaque: int) -> int:
    """Add something at a place in the world to the things a camera may see."""
    cosine, sine = math.cos(robot.heading), math.sin(robot.heading)
    dx, dy = x - robot.x, y - robot.y
    thing = things[count]
    thing.x, thing.y = cosine * dx + sine * dy, cosine * dy - sine * dx
    thing.radius, thing.height, thing.color, thing.opaque = radius, height, color, opaque
    return count + 1


@njit(error_model="numpy")
def look(c: Any, row: int, world: int, step: Any) -> Any:
    """What a robot's camera has in view: how many VIEW and SCREEN of the scratch hold it."""
    robot, limit = robot_at(c, row), step.range
    count = 0
    for k in range(c.disc_count):
        disc = disc_at(c, world, k)
        if disc.radius > 0.0:
            count = _put(c, scratch.things, count, robot, disc.x, disc.y, disc.radius, disc.height, disc.color, 1)
    for index in range(c.class_count):
        kind = class_at(c, index)
        if kind.color >= 0 or kind.solid:
            for slot in range(kind.first, kind.end):
                thing = object_at(c, world, slot)
                if thing.present:
                    count = _put(c, 
                        scratch.things, count, robot, thing.x, thing.y, kind.radius, kind.height, kind.color, kind.solid
                    )
    first = world * c.count
    if not c.gridded or limit > 8.0 * c.cell:
        for other in range(first, first + c.count):
            if other != row:
                them = robot_at(c, other)
                kind = type_at(c, them.type)
                count = _put(c, scratch.things, count, robot, them.x, them.y, kind.radius, kind.height, kind.color, 1)
    else:
        low, high = max(int((robot.x - limit) / c.cell), 0), min(int((robot.x + limit) / c.cell), c.columns - 1)
        last = min(int((robot.y + limit) / c.cell), c.lines - 1)
        for line in range(max(int((robot.y - limit) / c.cell), 0), last + 1):
            begin = at(c.start, (line * c.columns + low) << (2 * c.shift), INDEX).v
            for at in range(begin, at(c.start, (line * c.columns + high + 1) << (2 * c.shift), INDEX).v):
                spot = at(c.spots, at, SPOT)
                if spot.row != row:
                    kind = type_at(c, robot_at(c, spot.row).type)
                    count = _put(c, scratch.things, count, robot, spot.x, spot.y, kind.radius, kind.height, kind.color, 1)
    views = project(scratch.things, count, step.tan_half, step.width_px, step.height_px, limit, scratch.views)
    cosine, sine = math.cos(robot.heading), math.sin(robot.heading)
    count = c.segment_count
    for k in range(count):
        piece, local = segment_at(c, world, k), scratch.segments[k]
        dx, dy, ex, ey = piece.x0 - robot.x, piece.y0 - robot.y, piece.x1 - robot.x, piece.y1 - robot.y
        local.x0, local.y0 = cosine * dx + sine * dy, cosine * dy - sine * dx
        local.x1, local.y1 = cosine * ex + sine * ey, cosine * ey - sine * ex
    return views, screen(scratch.segments, count, step.tan_half, scratch.screens)


@njit(error_model="numpy")
def own(c: Any, robot: Any, world: int, step: Any, tick: int) -> float:
    """A reading of the robot itself."""
    what = step.what
    if what == OWN_X:
        return robot.x
    if what == OWN_Y:
        return robot.y
    if what == OWN_HEADING:
        return robot.heading
    if what == OWN_SPEED:
        return robot.speed / c.tick_s
    if what == OWN_TURNING:
        return robot.spin / c.tick_s
    if what == STUCK:
        return 1.0 if robot.blocked >= step.ticks else 0.0
    if what == STORED:
        return float(robot.stored)
    objects, reach = state.objects[world], type_at(c, robot.type).reach
    if what == STATION_HERE:
        return 1.0 if station_here(c, robot.x, robot.y, reach) else 0.0
    slot, squared = nearest_food(c, robot.x, robot.y)
    if what == FOOD_LEFT:
        return 1.0 if slot >= 0 else 0.0
    return float(object_at(c, world, slot).amount) if slot >= 0 and squared <= reach * reach else 0.0


@njit(error_model="numpy")
def measure(c: Any, row: int, world: int, index: int) -> None:
    """Measure one step now, without noise: its parts' readings a and b go to scratch.a and scratch.b."""
    step, robot = at(c.steps, index, STEP), robot_at(c, row)
    a, b = scratch.a, scratch.b
    a[0] = b[0] = math.nan
    if step.what == TO_CLASS or step.what == TO_OBJECT:
        objects = state.objects[world]
        slot, squared = step.index, 0.0
        if step.what == TO_CLASS:
            slot, squared = nearest_object(c, robot.x, robot.y, step.index)
        elif object_at(c, world, slot).present:
            dx, dy = object_at(c, world, slot).x - robot.x, object_at(c, world, slot).y - robot.y
            squared = dx * dx + dy * dy
        else:
            slot = -1
        if slot >= 0 and squared <= step.range * step.range:
            a[0] = math.sqrt(squared)
            if at(c.parts, step.first, PART).b >= 0:
                b[0] = bearing(robot, object_at(c, world, slot).x, object_at(c, world, slot).y)
    elif step.what == TO_ROBOT:
        first = world * c.count
        if step.index >= 0:
            other, squared = nearest_robot(c, 
                state.robots, row, first, first + c.count, step.index, step.range, grid
            )
            if other >= 0:
                a[0] = math.sqrt(squared)
                if at(c.parts, step.first, PART).b >= 0:
                    b[0] = bearing(robot, robot_at(c, other).x, robot_at(c, other).y)
    elif step.what == SONAR:
        radius = type_at(c, robot.type).radius
        scan(c, row, world, step, step.range + radius, a)
        for k in range(step.end - step.first):
            a[k] = min(step.range, max(0.0, a[k] - radius))
    elif step.what == BUMPER:
        radius = type_at(c, robot.type).radius
        scan(c, row, world, step, radius + TOUCH, a)
        for k in range(step.end - step.first):
            a[k] = 1.0 if a[k] < radius + TOUCH else 0.0
    elif step.what == CAMERA:
        views, screens = look(c, row, world, step)
        for k in range(step.first, step.end):
            a[k - step.first] = b[k - step.first] = math.nan
            if at(c.parts, k, PART).color >= 0:
                a[k - step.first], b[k - step.first] = blob(
                    scratch.views, views, scratch.screens, screens, at(c.parts, k, PART).color, step.tan_half,
                    step.width_px, step.nearest != 0, step.least_px, scratch.cuts,
                )  # fmt: skip
    elif step.what == CHANCE:
        a[0] = uniform(at(c.seeds, world, WHOLE).v, robot.id, at(c.tick, world, WHOLE).v // step.ticks, step.stream + GHOST)
    else:
        a[0] = own(c, robot, world, step, at(c.tick, world, WHOLE).v)


@njit(error_model="numpy")
def disturb(step: Any, part: Any, seed: int, item: int, tick: int, a: float, b: float) -> Any:
    """The readings a and b of a part as they come out: with noise, misdetection and dropout."""
    stream = step.stream + 8 * part.number
    if step.dropout > 0.0 and uniform(seed, item, tick, stream + DROPOUT) < step.dropout:
        return math.nan, math.nan
    if step.what == CAMERA:
        if step.misses > 0.0 and uniform(seed, item, tick, stream + MISS) < step.misses:
            a = b = math.nan
        if a != a and step.ghosts > 0.0 and uniform(seed, item, tick, stream + GHOST) < step.ghosts:
            a = step.width_px * uniform(seed, item, tick, stream + GHOST_X)
            b = step.least_px + (GHOST_PX * GHOST_PX) * uniform(seed, item, tick, stream + NOISE_B)
            return a, b
    if step.noise_a > 0.0:
        a += step.noise_a * normal(seed, item, tick, stream + NOISE_A)
        if step.what == SONAR:
            a = min(step.range, max(0.0, a))
        elif step.what == CAMERA:
            a = min(step.width_px, max(0.0, a))
        elif step.what == OWN_HEADING:
            a = a % TAU % TAU
        elif step.what == TO_CLASS or step.what == TO_OBJECT or step.what == TO_ROBOT:
            a = max(0.0, a)
    if step.noise_b > 0.0:
        drawn = step.noise_b * normal(seed, item, tick, stream + NOISE_B)
        b = max(0.0, b * (1.0 + drawn)) if step.what == CAMERA else (b + drawn) % TAU % TAU
    return a, b


@njit(error_model="numpy")
def sense(c: Any, row: int, world: int, out: Any, keep: bool) -> None:
    """The readings of one robot in this tick, to `out` [plan.width]; NaN where it has none.

    Where `keep`, what it has to remember of this tick is kept: once a tick, before it moves.
    """
    for column in range(plan.width):
        out[column] = math.nan
    robot, tick, seed = robot_at(c, row), at(c.tick, world, WHOLE).v, at(c.seeds, world, WHOLE).v
    if robot.frozen:
        return
    for index in range(plan.of_type[robot.type, 0], plan.of_type[robot.type, 1]):
        step = at(c.steps, index, STEP)
        if step.what == SINCE:
            part = at(c.parts, step.first, PART)
            source = out[step.index]
            there = source == 1.0 if step.nearest else source == source
            last = tick if there else at(c.memory, row * c.memory_count + part.held, NUMBER).v
            if part.a >= 0:
                out[part.a] = math.floor((tick - last) * c.tick_s * 1e9 + 0.5) / 1e9
            if keep and there:
                at(c.memory, row * c.memory_count + part.held, NUMBER).v = tick
            continue
        due = tick % step.period == 0
        if due:
            measure(c, row, world, index)
        for k in range(step.first, step.end):
            part = at(c.parts, k, PART)
            if due:
                a, b = scratch.a[k - step.first], scratch.b[k - step.first]
                a, b = disturb(step, part, seed, robot.id, tick, a, b)
                if keep and part.held >= 0:
                    at(c.memory, row * c.memory_count + part.held, NUMBER).v, at(c.memory, row * c.memory_count + part.held + 1, NUMBER).v = a, b
            else:
                a, b = at(c.memory, row * c.memory_count + part.held, NUMBER).v, at(c.memory, row * c.memory_count + part.held + 1, NUMBER).v
            if part.a >= 0:
                out[part.a] = a
            if part.b >= 0:
                out[part.b] = b
