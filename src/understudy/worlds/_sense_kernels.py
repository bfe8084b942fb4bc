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
def nearest_object(x: float, y: float, objects: Any, classes: Any, index: int) -> Any:
    """Slot and squared distance of the nearest object of a class (food: with food left); -1 where none is."""
    kind = classes[index]
    best, best_squared = -1, math.inf
    for slot in range(kind.first, kind.end):
        thing = objects[slot]
        dx, dy = thing.x - x, thing.y - y
        squared = dx * dx + dy * dy
        if squared < best_squared and thing.present and (thing.amount > 0 or not kind.food):
            best, best_squared = slot, squared
    return best, best_squared


@njit(error_model="numpy")
def nearest_food(x: float, y: float, objects: Any, classes: Any) -> Any:
    """The same, of all classes of food."""
    best, best_squared = -1, math.inf
    for index in range(classes.shape[0]):
        if classes[index].food:
            slot, squared = nearest_object(x, y, objects, classes, index)
            if squared < best_squared:
                best, best_squared = slot, squared
    return best, best_squared


@njit(error_model="numpy")
def station_here(x: float, y: float, reach: float, objects: Any, classes: Any) -> bool:
    """Whether a home is within reach."""
    for index in range(classes.shape[0]):
        if classes[index].home:
            _, squared = nearest_object(x, y, objects, classes, index)
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
def _all_to_disc(plan: Any, step: Any, best: Any, x: float, y: float, radius: float) -> None:
    """Shorten the distances of all sectors of a step by a disc in the robot frame."""
    for k in range(step.first, step.end):
        s = plan.sectors[k]
        best[k - step.first] = sector_to_disc(
            x, y, radius, s.from_x, s.from_y, s.to_x, s.to_y, s.span, best[k - step.first]
        )


@njit(error_model="numpy")
def scan(row: int, world: int, plan: Any, step: Any, limit: float, state: Any, rules: Any, grid: Any, near: Any, best: Any) -> None:
    """The distance (m, from the robot's center, at most `limit`) to what is nearest in each sector of a step."""
    robot = state.robots[row]
    x, y = robot.x, robot.y
    cosine, sine = math.cos(robot.heading), math.sin(robot.heading)
    for k in range(step.first, step.end):
        best[k - step.first] = limit
    if step.sees & WALLS and min(x, y, rules.width - x, rules.height - y) < limit:
        for k in range(step.first, step.end):
            s = plan.sectors[k]
            best[k - step.first] = sector_to_bounds(
                x, y, cosine, sine, rules.width, rules.height,
                s.from_x, s.from_y, s.to_x, s.to_y, s.span, best[k - step.first],
            )  # fmt: skip
    begin, end = near_range(x, y, near, world)
    for at in range(begin, end):
        item = near.items[at]
        if item >= 0:
            if step.sees & OBSTACLES:
                disc = state.discs[world, item]
                dx, dy = disc.x - x, disc.y - y
                if dx * dx + dy * dy < (limit + disc.radius) ** 2:
                    _all_to_disc(plan, step, best, cosine * dx + sine * dy, cosine * dy - sine * dx, disc.radius)
            continue
        piece = state.segments[world, -1 - item]
        if step.sees & (WALLS if piece.wall else OBSTACLES):
            dx, dy, ex, ey = piece.x0 - x, piece.y0 - y, piece.x1 - x, piece.y1 - y
            x0, y0 = cosine * dx + sine * dy, cosine * dy - sine * dx
            x1, y1 = cosine * ex + sine * ey, cosine * ey - sine * ex
            for k in range(step.first, step.end):
                s = plan.sectors[k]
                best[k - step.first] = sector_to_segment(
                    x0, y0, x1, y1, s.from_x, s.from_y, s.to_x, s.to_y, s.span, best[k - step.first]
                )
    if step.sees & OBSTACLES:
        for index in range(rules.classes.shape[0]):
            kind = rules.classes[index]
            if kind.solid:
                for slot in range(kind.first, kind.end):
                    thing = state.objects[world, slot]
                    dx, dy = thing.x - x, thing.y - y
                    if thing.present and dx * dx + dy * dy < (limit + kind.radius) ** 2:
                        _all_to_disc(plan, step, best, cosine * dx + sine * dy, cosine * dy - sine * dx, kind.radius)
    if not step.sees & ROBOTS:
        return
    reach = limit + grid.most_radius
    first = world * rules.robots
    if grid.spots.shape[0] == 0:
        for other in range(first, first + rules.robots):
            dx, dy = state.robots[other].x - x, state.robots[other].y - y
            if dx * dx + dy * dy < reach * reach and other != row:
                radius = rules.types[state.robots[other].type].radius
                _all_to_disc(plan, step, best, cosine * dx + sine * dy, cosine * dy - sine * dx, radius)
        return
    low, high = max(int((x - reach) / grid.cell), 0), min(int((x + reach) / grid.cell), grid.columns - 1)
    for line in range(max(int((y - reach) / grid.cell), 0), min(int((y + reach) / grid.cell), grid.lines - 1) + 1):
        small = 2 * grid.shift
        begin = grid.start[(line * grid.columns + low) << small]
        for at in range(begin, grid.start[(line * grid.columns + high + 1) << small]):
            spot = grid.spots[at]
            dx, dy = spot.x - x, spot.y - y
            if dx * dx + dy * dy < reach * reach and spot.row != row:
                radius = rules.types[state.robots[spot.row].type].radius
                _all_to_disc(plan, step, best, cosine * dx + sine * dy, cosine * dy - sine * dx, radius)


@njit(error_model="numpy")
def _put(things: Any, count: int, robot: Any, x: float, y: float, radius: float, height: float, color: int, opaque: int) -> int:
    """Add something at a place in the world to the things a camera may see."""
    cosine, sine = math.cos(robot.heading), math.sin(robot.heading)
    dx, dy = x - robot.x, y - robot.y
    thing = things[count]
    thing.x, thing.y = cosine * dx + sine * dy, cosine * dy - sine * dx
    thing.radius, thing.height, thing.color, thing.opaque = radius, height, color, opaque
    return count + 1


@njit(error_model="numpy")
def look(row: int, world: int, step: Any, state: Any, rules: Any, grid: Any, near: Any, scratch: Any) -> Any:
    """What a robot's camera has in view: how many VIEW and SCREEN of the scratch hold it."""
    robot, limit = state.robots[row], step.range
    count = 0
    for k in range(state.discs.shape[1]):
        disc = state.discs[world, k]
        if disc.radius > 0.0:
            count = _put(scratch.things, count, robot, disc.x, disc.y, disc.radius, disc.height, disc.color, 1)
    for index in range(rules.classes.shape[0]):
        kind = rules.classes[index]
        if kind.color >= 0 or kind.solid:
            for slot in range(kind.first, kind.end):
                thing = state.objects[world, slot]
                if thing.present:
                    count = _put(
                        scratch.things, count, robot, thing.x, thing.y, kind.radius, kind.height, kind.color, kind.solid
                    )
    first = world * rules.robots
    if grid.spots.shape[0] == 0 or limit > 8.0 * grid.cell:
        for other in range(first, first + rules.robots):
            if other != row:
                them = state.robots[other]
                kind = rules.types[them.type]
                count = _put(scratch.things, count, robot, them.x, them.y, kind.radius, kind.height, kind.color, 1)
    else:
        low, high = max(int((robot.x - limit) / grid.cell), 0), min(int((robot.x + limit) / grid.cell), grid.columns - 1)
        last = min(int((robot.y + limit) / grid.cell), grid.lines - 1)
        for line in range(max(int((robot.y - limit) / grid.cell), 0), last + 1):
            begin = grid.start[(line * grid.columns + low) << (2 * grid.shift)]
            for at in range(begin, grid.start[(line * grid.columns + high + 1) << (2 * grid.shift)]):
                spot = grid.spots[at]
                if spot.row != row:
                    kind = rules.types[state.robots[spot.row].type]
                    count = _put(scratch.things, count, robot, spot.x, spot.y, kind.radius, kind.height, kind.color, 1)
    views = project(scratch.things, count, step.tan_half, step.width_px, step.height_px, limit, scratch.views)
    cosine, sine = math.cos(robot.heading), math.sin(robot.heading)
    count = state.segments.shape[1]
    for k in range(count):
        piece, local = state.segments[world, k], scratch.segments[k]
        dx, dy, ex, ey = piece.x0 - robot.x, piece.y0 - robot.y, piece.x1 - robot.x, piece.y1 - robot.y
        local.x0, local.y0 = cosine * dx + sine * dy, cosine * dy - sine * dx
        local.x1, local.y1 = cosine * ex + sine * ey, cosine * ey - sine * ex
    return views, screen(scratch.segments, count, step.tan_half, scratch.screens)


@njit(error_model="numpy")
def own(robot: Any, world: int, step: Any, tick: int, state: Any, rules: Any) -> float:
    """A reading of the robot itself."""
    what = step.what
    if what == OWN_X:
        return robot.x
    if what == OWN_Y:
        return robot.y
    if what == OWN_HEADING:
        return robot.heading
    if what == OWN_SPEED:
        return robot.speed / rules.tick_s
    if what == OWN_TURNING:
        return robot.spin / rules.tick_s
    if what == STUCK:
        return 1.0 if robot.blocked >= step.ticks else 0.0
    if what == STORED:
        return float(robot.stored)
    objects, reach = state.objects[world], rules.types[robot.type].reach
    if what == STATION_HERE:
        return 1.0 if station_here(robot.x, robot.y, reach, objects, rules.classes) else 0.0
    slot, squared = nearest_food(robot.x, robot.y, objects, rules.classes)
    if what == FOOD_LEFT:
        return 1.0 if slot >= 0 else 0.0
    return float(objects[slot].amount) if slot >= 0 and squared <= reach * reach else 0.0


@njit(error_model="numpy")
def measure(row: int, world: int, plan: Any, index: int, state: Any, rules: Any, grid: Any, near: Any, scratch: Any) -> None:
    """Measure one step now, without noise: its parts' readings a and b go to scratch.a and scratch.b."""
    step, robot = plan.steps[index], state.robots[row]
    a, b = scratch.a, scratch.b
    a[0] = b[0] = math.nan
    if step.what == TO_CLASS or step.what == TO_OBJECT:
        objects = state.objects[world]
        slot, squared = step.index, 0.0
        if step.what == TO_CLASS:
            slot, squared = nearest_object(robot.x, robot.y, objects, rules.classes, step.index)
        elif objects[slot].present:
            dx, dy = objects[slot].x - robot.x, objects[slot].y - robot.y
            squared = dx * dx + dy * dy
        else:
            slot = -1
        if slot >= 0 and squared <= step.range * step.range:
            a[0] = math.sqrt(squared)
            if plan.parts[step.first].b >= 0:
                b[0] = bearing(robot, objects[slot].x, objects[slot].y)
    elif step.what == TO_ROBOT:
        first = world * rules.robots
        if step.index >= 0:
            other, squared = nearest_robot(
                state.robots, row, first, first + rules.robots, rules.types, step.index, step.range, grid
            )
            if other >= 0:
                a[0] = math.sqrt(squared)
                if plan.parts[step.first].b >= 0:
                    b[0] = bearing(robot, state.robots[other].x, state.robots[other].y)
    elif step.what == SONAR:
        radius = rules.types[robot.type].radius
        scan(row, world, plan, step, step.range + radius, state, rules, grid, near, a)
        for k in range(step.end - step.first):
            a[k] = min(step.range, max(0.0, a[k] - radius))
    elif step.what == BUMPER:
        radius = rules.types[robot.type].radius
        scan(row, world, plan, step, radius + TOUCH, state, rules, grid, near, a)
        for k in range(step.end - step.first):
            a[k] = 1.0 if a[k] < radius + TOUCH else 0.0
    elif step.what == CAMERA:
        views, screens = look(row, world, step, state, rules, grid, near, scratch)
        for k in range(step.first, step.end):
            a[k - step.first] = b[k - step.first] = math.nan
            if plan.parts[k].color >= 0:
                a[k - step.first], b[k - step.first] = blob(
                    scratch.views, views, scratch.screens, screens, plan.parts[k].color, step.tan_half,
                    step.width_px, step.nearest != 0, step.least_px, scratch.cuts,
                )  # fmt: skip
    elif step.what == CHANCE:
        a[0] = uniform(state.seeds[world], robot.id, state.tick[world] // step.ticks, step.stream + GHOST)
    else:
        a[0] = own(robot, world, step, state.tick[world], state, rules)


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
def sense(row: int, world: int, plan: Any, state: Any, rules: Any, grid: Any, near: Any, scratch: Any, out: Any, keep: bool) -> None:
    """The readings of one robot in this tick, to `out` [plan.width]; NaN where it has none.

    Where `keep`, what it has to remember of this tick is kept: once a tick, before it moves.
    """
    for column in range(plan.width):
        out[column] = math.nan
    robot, tick, seed = state.robots[row], state.tick[world], state.seeds[world]
    if robot.frozen:
        return
    for index in range(plan.of_type[robot.type, 0], plan.of_type[robot.type, 1]):
        step = plan.steps[index]
        if step.what == SINCE:
            part = plan.parts[step.first]
            source = out[step.index]
            there = source == 1.0 if step.nearest else source == source
            last = tick if there else state.memory[row, part.held]
            if part.a >= 0:
                out[part.a] = math.floor((tick - last) * rules.tick_s * 1e9 + 0.5) / 1e9
            if keep and there:
                state.memory[row, part.held] = tick
            continue
        due = tick % step.period == 0
        if due:
            measure(row, world, plan, index, state, rules, grid, near, scratch)
        for k in range(step.first, step.end):
            part = plan.parts[k]
            if due:
                a, b = scratch.a[k - step.first], scratch.b[k - step.first]
                a, b = disturb(step, part, seed, robot.id, tick, a, b)
                if keep and part.held >= 0:
                    state.memory[row, part.held], state.memory[row, part.held + 1] = a, b
            else:
                a, b = state.memory[row, part.held], state.memory[row, part.held + 1]
            if part.a >= 0:
                out[part.a] = a
            if part.b >= 0:
                out[part.b] = b
