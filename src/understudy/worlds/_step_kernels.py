"""Kernels of a tick after everyone has decided: pushing, moving, loading, what objects do, the goal."""

import math
from typing import Any

from numba import njit

from understudy.worlds._draw_kernels import uniform
from understudy.worlds._motion_kernels import (
    limited,
    limited_by_fixed,
    limited_by_robots,
)
from understudy.worlds._sense_kernels import nearest_food, station_here
from understudy.worlds._space_kernels import free_place

TAU = 2.0 * math.pi
FINE = 2.0**40  # pushes are summed as whole numbers, so that their order does not matter
APPEARS, STAYS, WALKS, PLACE = 1, 2, 3, 4  # streams of an object's draws
GOAL_DELIVERED, GOAL_NEAR, GOAL_ALL_NEAR = 1, 2, 3


@njit(error_model="numpy")
def push(row: int, world: int, state: Any, rules: Any, moves: Any, pushes: Any) -> None:
    """Add what a robot pushes in its step to every box that it meets."""
    robot, move = state.robots[row], moves[row - world * rules.robots]
    if move.scale == 0.0 or (move.dx == 0.0 and move.dy == 0.0):
        return
    radius = rules.types[robot.type].radius
    for index in range(rules.classes.shape[0]):
        kind = rules.classes[index]
        if not kind.pushable:
            continue
        for slot in range(kind.first, kind.end):
            thing = state.objects[world, slot]
            if not thing.present:
                continue
            dx, dy = thing.x - robot.x, thing.y - robot.y
            touch = radius + kind.radius
            squared = dx * dx + dy * dy
            reach = touch + abs(move.dx) + abs(move.dy)
            if squared >= reach * reach or squared == 0.0:
                continue
            distance = math.sqrt(squared)
            closing = move.scale * (move.dx * dx + move.dy * dy) / distance
            deep = closing - max(0.0, distance - touch)
            if deep > 0.0:
                box = pushes[slot]
                box.sum_x += int(deep * dx / distance * FINE)
                box.sum_y += int(deep * dy / distance * FINE)
                box.count += 1


@njit(error_model="numpy")
def shift_boxes(world: int, state: Any, rules: Any, grid: Any, near: Any, moves: Any, pushes: Any) -> None:
    """Where the boxes go that are pushed: as the mean of their pushers, as far as the free gaps let them."""
    first, objects = world * rules.robots, state.objects[world]
    for index in range(rules.classes.shape[0]):
        kind = rules.classes[index]
        if not kind.pushable:
            continue
        for slot in range(kind.first, kind.end):
            box = pushes[slot]
            box.dx = box.dy = 0.0
            if box.count >= kind.pushers and box.count > 0 and objects[slot].present:
                box.dx, box.dy = box.sum_x / FINE / box.count, box.sum_y / FINE / box.count
    for index in range(rules.classes.shape[0]):
        kind = rules.classes[index]
        if not kind.pushable:
            continue
        for slot in range(kind.first, kind.end):
            box, thing = pushes[slot], objects[slot]
            box.scale = 1.0
            if box.dx == 0.0 and box.dy == 0.0:
                continue
            scale = limited_by_fixed(1.0, thing.x, thing.y, kind.radius, box, world, state, rules, near)
            for c in range(rules.classes.shape[0]):
                other_kind = rules.classes[c]
                if other_kind.pushable:
                    for other in range(other_kind.first, other_kind.end):
                        them = objects[other]
                        dx, dy = them.x - thing.x, them.y - thing.y
                        squared = dx * dx + dy * dy
                        if other == slot or not them.present or squared == 0.0:
                            continue
                        distance = math.sqrt(squared)
                        nx, ny = dx / distance, dy / distance
                        towards = -(pushes[other].dx * nx + pushes[other].dy * ny)
                        gap = distance - kind.radius - other_kind.radius
                        scale = limited(scale, nx, ny, gap, box.dx, box.dy, towards)
            for row in range(first, first + rules.robots):
                robot, move = state.robots[row], moves[row - first]
                dx, dy = robot.x - thing.x, robot.y - thing.y
                squared = dx * dx + dy * dy
                reach = kind.radius + grid.most_radius + 2.0 * grid.most_step
                reach += abs(box.dx) + abs(box.dy)
                if squared >= reach * reach or squared == 0.0:
                    continue
                distance = math.sqrt(squared)
                nx, ny = dx / distance, dy / distance
                towards = -move.scale * (move.dx * nx + move.dy * ny)
                gap = distance - kind.radius - rules.types[robot.type].radius
                scale = limited(scale, nx, ny, gap, box.dx, box.dy, towards)
            box.scale = scale


@njit(error_model="numpy")
def limited_by_boxes(row: int, world: int, state: Any, rules: Any, moves: Any, pushes: Any) -> None:
    """Limit a robot's step by the boxes, which are going where `shift_boxes` lets them."""
    robot, move = state.robots[row], moves[row - world * rules.robots]
    if move.scale == 0.0 or (move.dx == 0.0 and move.dy == 0.0):
        return
    radius, scale = rules.types[robot.type].radius, move.scale
    for index in range(rules.classes.shape[0]):
        kind = rules.classes[index]
        if not kind.pushable:
            continue
        for slot in range(kind.first, kind.end):
            thing, box = state.objects[world, slot], pushes[slot]
            dx, dy = thing.x - robot.x, thing.y - robot.y
            squared = dx * dx + dy * dy
            if not thing.present or squared == 0.0:
                continue
            distance = math.sqrt(squared)
            nx, ny = dx / distance, dy / distance
            gap = distance - radius - kind.radius + box.scale * (box.dx * nx + box.dy * ny)
            scale = limited(scale, nx, ny, gap, move.dx, move.dy, 0.0)
    move.scale = scale


@njit(error_model="numpy")
def move_boxes(world: int, state: Any, rules: Any, pushes: Any) -> None:
    """Move the boxes, and forget what pushed them."""
    for slot in range(pushes.shape[0]):
        box, thing = pushes[slot], state.objects[world, slot]
        thing.x += box.scale * box.dx
        thing.y += box.scale * box.dy
        box.dx = box.dy = 0.0
        box.sum_x = box.sum_y = box.count = 0


@njit(error_model="numpy")
def limit(row: int, world: int, state: Any, rules: Any, grid: Any, near: Any, moves: Any) -> None:
    """How far a robot may go: as far as the gaps to all that is solid let it, boxes left aside."""
    first = world * rules.robots
    robot, move = state.robots[row], moves[row - first]
    if move.dx == 0.0 and move.dy == 0.0:
        return
    kind = rules.types[robot.type]
    scale = limited_by_fixed(1.0, robot.x, robot.y, kind.radius, move, world, state, rules, near)
    if scale > 0.0 and kind.collides:
        scale = limited_by_robots(
            scale, state.robots, row, first, first + rules.robots, rules.types, moves, grid
        )
    move.scale = scale


@njit(error_model="numpy")
def transfer(world: int, state: Any, rules: Any, moves: Any) -> None:
    """Load and unload for one tick: a unit moves when its last tick is done; work broken off is lost.

    Only a robot that stands still works, within reach. Of several that finish loading the last units of a source
    in one tick, those with the lowest ids get them. A robot told to do both loads.
    """
    first, objects = world * rules.robots, state.objects[world]
    for k in range(rules.robots):
        robot, move = state.robots[first + k], moves[k]
        move.slot = -1
        still = move.still != 0 and not robot.frozen
        kind = rules.types[robot.type]
        loads = unloads = False
        if still and move.load > 0.0:
            if robot.stored < kind.capacity:
                slot, squared = nearest_food(robot.x, robot.y, objects, rules.classes)
                loads = slot >= 0 and squared <= kind.reach * kind.reach
                if loads and robot.loading + 1 >= kind.load_ticks:
                    move.slot = slot
        elif still and move.unload > 0.0 and robot.stored > 0:
            unloads = station_here(robot.x, robot.y, kind.reach, objects, rules.classes)
        robot.loading = robot.loading + 1 if loads else 0
        robot.unloading = robot.unloading + 1 if unloads else 0
        if unloads and robot.unloading >= kind.unload_ticks:
            robot.unloading = 0
            robot.stored -= 1
            robot.delivered += 1
    for k in range(rules.robots):
        slot = moves[k].slot
        if slot >= 0:
            before = 0  # robots with lower ids that get a unit of the same source now
            for other in range(rules.robots):
                if moves[other].slot == slot and state.robots[first + other].id < state.robots[first + k].id:
                    before += 1
            moves[k].order = before
    for k in range(rules.robots):
        slot = moves[k].slot
        if slot >= 0:
            moves[k].slot = slot if moves[k].order < objects[slot].amount else -1
    for k in range(rules.robots):
        robot, slot = state.robots[first + k], moves[k].slot
        if slot >= 0:
            objects[slot].amount -= 1
            robot.stored += 1
            robot.loading = 0


@njit(error_model="numpy")
def _within(world: int, x: float, y: float, reach: float, state: Any, rules: Any) -> bool:
    """Whether a robot's center is within reach of a place."""
    first = world * rules.robots
    for row in range(first, first + rules.robots):
        dx, dy = state.robots[row].x - x, state.robots[row].y - y
        if dx * dx + dy * dy <= reach * reach:
            return True
    return False


@njit(error_model="numpy")
def _drawn(least: float, most: float, seed: int, item: int, time: int, stream: int, tick_s: float) -> int:
    """A time in ticks, drawn between two in seconds; at least one."""
    return max(1, int(round((least + (most - least) * uniform(seed, item, time, stream)) / tick_s)))


@njit(error_model="numpy")
def live(world: int, state: Any, rules: Any) -> None:
    """Objects that come and go, are captured or walk do so, for one tick."""
    tick, seed, objects = state.tick[world], state.seeds[world], state.objects[world]
    for index in range(rules.classes.shape[0]):
        kind = rules.classes[index]
        comes = kind.away_least == kind.away_least
        captured = kind.capture_range == kind.capture_range
        if not (comes or captured or kind.walk > 0.0):
            continue
        for slot in range(kind.first, kind.end):
            thing = objects[slot]
            if thing.present:
                leaves = comes and thing.due == tick + 1
                if captured:
                    if thing.captured < 0 and _within(world, thing.x, thing.y, kind.capture_range, state, rules):
                        thing.captured = tick
                    leaves = leaves or (thing.captured >= 0 and tick - thing.captured >= kind.capture_ticks)
                if leaves:
                    thing.present = 0
                    thing.due = -1
                    if comes:
                        away = _drawn(
                            kind.away_least, kind.away_most, seed, slot, thing.appeared, APPEARS, rules.tick_s
                        )
                        thing.due = tick + 1 + away
                elif kind.walk > 0.0:
                    _walk(thing, slot, kind, tick, seed, world, state, rules)
            elif comes and thing.due == tick + 1:
                thing.appeared += 1
                robots = state.robots[world * rules.robots : (world + 1) * rules.robots]
                found, x, y = free_place(
                    seed, slot, thing.appeared, kind, rules.types, rules.classes, rules.class_of, rules.width,
                    rules.height, robots, objects, state.discs[world], state.segments[world],
                )  # fmt: skip
                if not found:
                    thing.due = tick + 2
                    continue
                thing.x, thing.y, thing.present, thing.captured = x, y, 1, -1
                thing.heading = TAU * uniform(seed, slot, thing.appeared, WALKS)
                thing.due = -1
                if kind.stays_least == kind.stays_least:
                    stays = _drawn(
                        kind.stays_least, kind.stays_most, seed, slot, thing.appeared, STAYS, rules.tick_s
                    )
                    thing.due = tick + 1 + stays


@njit(error_model="numpy")
def _walk(
    thing: Any, slot: int, kind: Any, tick: int, seed: int, world: int, state: Any, rules: Any
) -> None:
    """An object walks a step, in a new direction every now and then and wherever something is in its way."""
    if tick % kind.turn_ticks == 0:
        thing.heading = TAU * uniform(seed, slot, tick, WALKS)
    x = thing.x + kind.walk * math.cos(thing.heading)
    y = thing.y + kind.walk * math.sin(thing.heading)
    low_x, low_y, high_x, high_y = kind.region[0], kind.region[1], kind.region[2], kind.region[3]
    clear = low_x + kind.radius <= x <= high_x - kind.radius and low_y + kind.radius <= y <= high_y - kind.radius
    clear = clear and not blocked(x, y, kind.radius, world, state, rules, kind.solid != 0)
    if clear:
        thing.x, thing.y = x, y
    else:
        thing.heading = TAU * uniform(seed, slot, tick, PLACE)


@njit(error_model="numpy")
def blocked(x: float, y: float, radius: float, world: int, state: Any, rules: Any, solid: bool) -> bool:
    """Whether a disc at a place would overlap obstacles or walls, or (if it is solid) robots."""
    for k in range(state.discs.shape[1]):
        disc = state.discs[world, k]
        dx, dy = disc.x - x, disc.y - y
        if disc.radius > 0.0 and dx * dx + dy * dy < (disc.radius + radius) ** 2:
            return True
    for k in range(state.segments.shape[1]):
        piece = state.segments[world, k]
        ex, ey = piece.x1 - piece.x0, piece.y1 - piece.y0
        length = ex * ex + ey * ey
        if length > 0.0:
            along = min(1.0, max(0.0, ((x - piece.x0) * ex + (y - piece.y0) * ey) / length))
            dx, dy = piece.x0 + along * ex - x, piece.y0 + along * ey - y
            if dx * dx + dy * dy < radius * radius:
                return True
    return solid and _within(world, x, y, radius + 0.5, state, rules)


@njit(error_model="numpy")
def judge(world: int, state: Any, rules: Any) -> None:
    """Note the tick at which the goal is first reached."""
    if rules.goal == 0 or state.finished[world] >= 0:
        return
    first, objects = world * rules.robots, state.objects[world]
    reached = False
    if rules.goal == GOAL_DELIVERED:
        left = 0
        for slot in range(objects.shape[0]):
            if rules.classes[rules.class_of[slot]].food:
                left += objects[slot].amount
        if left == 0:
            for row in range(first, first + rules.robots):
                left += state.robots[row].stored
        reached = left == 0
    else:
        kind = rules.classes[rules.goal_target]
        every = rules.goal == GOAL_ALL_NEAR
        reached = every
        for row in range(first, first + rules.robots):
            near = False
            for slot in range(kind.first, kind.end):
                dx, dy = objects[slot].x - state.robots[row].x, objects[slot].y - state.robots[row].y
                if objects[slot].present and dx * dx + dy * dy <= rules.goal_within**2:
                    near = True
            if near != every:
                reached = near
                break
    if reached:
        state.finished[world] = state.tick[world]
