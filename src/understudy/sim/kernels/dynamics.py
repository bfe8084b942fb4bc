"""Kernels of the second half of a tick: pushing boxes, limiting steps, loading, changing objects, the goal."""

import math
from typing import Any

from understudy.jit.decorators import inlined, inner, int64, uint64
from understudy.sim.kernels.angles import TAU, compute_cosine_and_sine
from understudy.sim.kernels.clearance import find_free_place
from understudy.sim.kernels.collisions import (
    CLEAR,
    limit_by_disc,
    limit_by_fixed,
    limit_by_gap,
    limit_by_robots,
)
from understudy.sim.kernels.rng import draw_uniform
from understudy.sim.kernels.sensing import find_nearest_food, is_station_near

FINE = 2.0**40  # pushes are summed as whole numbers, so that their order does not matter
APPEARS, STAYS, WALKS, PLACE = 1, 2, 3, 4  # streams of an object's draws
GOAL_DELIVERED, GOAL_NEAR, GOAL_ALL_NEAR, GOAL_GATHERED = 1, 2, 3, 4


@inner
def add_push(c: Any, row: int, world: int) -> None:
    """Add a robot's push, in its intended step, to every box that it would meet."""
    robot, move = c.robots[row], c.moves[row - world * c.facts.count]
    if move.scale == 0.0 or (move.dx == 0.0 and move.dy == 0.0):
        return
    radius = c.types[robot.type].radius
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if not kind.pushable:
            continue
        for slot in range(kind.first, kind.end):
            thing = c.objects[world * c.facts.object_count + slot]
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
                box = c.pushes[slot]
                box.sum_x += int(deep * dx / distance * FINE)
                box.sum_y += int(deep * dy / distance * FINE)
                box.count += 1


@inner
def plan_pushed_boxes(c: Any, world: int) -> None:
    """Compute the steps of pushed boxes: the mean of their pushes, limited by the gaps to everything solid."""
    first = world * c.facts.count
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if not kind.pushable:
            continue
        for slot in range(kind.first, kind.end):
            box = c.pushes[slot]
            box.dx = box.dy = 0.0
            if (
                box.count >= kind.pushers
                and box.count > 0
                and c.objects[world * c.facts.object_count + slot].present
            ):
                box.dx, box.dy = box.sum_x / FINE / box.count, box.sum_y / FINE / box.count
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if not kind.pushable:
            continue
        for slot in range(kind.first, kind.end):
            box, thing = c.pushes[slot], c.objects[world * c.facts.object_count + slot]
            box.scale = 1.0
            if box.dx == 0.0 and box.dy == 0.0:
                continue
            scale = limit_by_fixed(c, 1.0, thing.x, thing.y, kind.radius, box, world)
            for other_index in range(c.facts.class_count):
                other_kind = c.classes[other_index]
                if other_kind.pushable:
                    for other in range(other_kind.first, other_kind.end):
                        them = c.objects[world * c.facts.object_count + other]
                        dx, dy = them.x - thing.x, them.y - thing.y
                        squared = dx * dx + dy * dy
                        if other == slot or not them.present or squared == 0.0:
                            continue
                        distance = math.sqrt(squared)
                        nx, ny = dx / distance, dy / distance
                        towards = -(c.pushes[other].dx * nx + c.pushes[other].dy * ny)
                        gap = distance - kind.radius - other_kind.radius
                        scale = limit_by_gap(scale, nx, ny, gap, box.dx, box.dy, towards)
            for row in range(first, first + c.facts.count):
                robot, move = c.robots[row], c.moves[row - world * c.facts.count]
                dx, dy = robot.x - thing.x, robot.y - thing.y
                squared = dx * dx + dy * dy
                reach = kind.radius + c.facts.most_radius + 2.0 * c.facts.most_step
                reach += abs(box.dx) + abs(box.dy)
                if squared >= reach * reach or squared == 0.0:
                    continue
                distance = math.sqrt(squared)
                nx, ny = dx / distance, dy / distance
                towards = -move.scale * (move.dx * nx + move.dy * ny)
                gap = distance - kind.radius - c.types[robot.type].radius
                scale = limit_by_gap(scale, nx, ny, gap, box.dx, box.dy, towards)
            box.scale = scale


@inner
def limit_by_boxes(c: Any, row: int, world: int) -> None:
    """Limit a robot's step by the boxes, which move as `plan_pushed_boxes` computed."""
    robot, move = c.robots[row], c.moves[row - world * c.facts.count]
    if move.scale == 0.0 or (move.dx == 0.0 and move.dy == 0.0):
        return
    radius, scale = c.types[robot.type].radius, move.scale
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if not kind.pushable:
            continue
        for slot in range(kind.first, kind.end):
            thing, box = c.objects[world * c.facts.object_count + slot], c.pushes[slot]
            dx, dy = thing.x - robot.x, thing.y - robot.y
            squared = dx * dx + dy * dy
            if not thing.present or squared == 0.0:
                continue
            distance = math.sqrt(squared)
            nx, ny = dx / distance, dy / distance
            gap = distance - radius - kind.radius + box.scale * (box.dx * nx + box.dy * ny)
            scale = limit_by_gap(scale, nx, ny, gap, move.dx, move.dy, 0.0)
    move.scale = scale


@inner
def move_pushed_boxes(c: Any, world: int) -> None:
    """Move the pushed boxes by their permitted steps, and clear their pushes."""
    for slot in range(c.facts.object_count):
        box, thing = c.pushes[slot], c.objects[world * c.facts.object_count + slot]
        thing.x += box.scale * box.dx
        thing.y += box.scale * box.dy
        box.dx = box.dy = 0.0
        box.sum_x = box.sum_y = box.count = 0


@inlined
def limit_robot_step(c: Any, row: int, world: int) -> None:
    """Limit a robot's step by the other robots; fixed things have limited it before, boxes do so later."""
    move = c.moves[uint64(row - world * c.facts.count)]
    # Clear by more than rounding can add, so that a robot that is alone is out of reach of `limit_by_robots` too.
    apart = 2.0 * (c.facts.most_radius + c.facts.most_step) + CLEAR
    if move.alone >= apart * apart or (move.dx == 0.0 and move.dy == 0.0):
        return
    if move.scale > 0.0 and c.types[c.robots[row].type].collides:
        move.scale = limit_by_robots(c, move.scale, row, world)


@inner
def transfer_cargo(c: Any, world: int) -> None:
    """Load and unload food for one tick; a unit moves after its last tick, and interrupted work is lost.

    Only a robot that stands still and holds no box loads or unloads, within its reach. If several robots finish
    loading the last units of a source in one tick, those with the lowest ids get them. A robot commanded to do both
    loads.
    """
    first = world * c.facts.count
    for k in range(c.facts.count):
        robot, work = c.robots[first + k], c.works[k]
        work.slot = -1
        still = work.still != 0 and not robot.frozen and robot.holding == 0
        kind = c.types[robot.type]
        loads = unloads = False
        if still and work.load > 0.0:
            if robot.stored < kind.capacity:
                slot, squared = find_nearest_food(c, world, robot.x, robot.y)
                loads = slot >= 0 and squared <= kind.reach * kind.reach
                if loads and robot.loading + 1 >= kind.load_ticks:
                    work.slot = slot
        elif still and work.unload > 0.0 and robot.stored > 0:
            unloads = is_station_near(c, world, robot.x, robot.y, kind.reach)
        robot.loading = robot.loading + 1 if loads else 0
        robot.unloading = robot.unloading + 1 if unloads else 0
        if unloads and robot.unloading >= kind.unload_ticks:
            robot.unloading = 0
            robot.stored -= 1
            robot.delivered += 1
    for k in range(c.facts.count):
        slot = c.works[k].slot
        if slot >= 0:
            before = 0  # robots with lower ids that get a unit of the same source now
            for other in range(c.facts.count):
                if c.works[other].slot == slot and c.robots[first + other].id < c.robots[first + k].id:
                    before += 1
            c.works[k].order = before
    for k in range(c.facts.count):
        slot = c.works[k].slot
        if slot >= 0:
            c.works[k].slot = (
                slot if c.works[k].order < c.objects[world * c.facts.object_count + slot].amount else -1
            )
    for k in range(c.facts.count):
        robot, slot = c.robots[first + k], c.works[k].slot
        if slot >= 0:
            c.objects[world * c.facts.object_count + slot].amount -= 1
            robot.stored += 1
            robot.loading = 0


@inner
def _within(c: Any, world: int, x: float, y: float, reach: float) -> Any:
    """Return whether the center of any robot of a world is within `reach` (m) of a place."""
    first = world * c.facts.count
    for row in range(first, first + c.facts.count):
        dx, dy = c.robots[row].x - x, c.robots[row].y - y
        if dx * dx + dy * dy <= reach * reach:
            return True
    return False


@inner
def _drawn(least: float, most: float, seed: int, item: int, time: int, stream: int, tick_s: float) -> Any:
    """Return a random duration in ticks, at least 1, between `least` and `most` (s)."""
    return max(1, round((least + (most - least) * draw_uniform(seed, item, time, stream)) / tick_s))


@inner
def _new_place(c: Any, world: int, slot: int, turn: int, kind: Any) -> Any:
    """Find a free place for an object at its appearance number `turn`: whether there is one, x and y (m)."""
    return find_free_place(
        c.seeds[world], slot, turn, kind, c.types, c.classes, c.class_of, c.facts.width, c.facts.height,
        c.robots[world * c.facts.count : (world + 1) * c.facts.count],
        c.objects[world * c.facts.object_count : (world + 1) * c.facts.object_count],
        c.discs[world * c.facts.disc_count : (world + 1) * c.facts.disc_count],
        c.segments[world * c.facts.segment_count : (world + 1) * c.facts.segment_count],
    )  # fmt: skip


@inner
def update_objects(c: Any, world: int) -> None:
    """Make objects appear, vanish, be captured and walk for one tick, and gathered boxes appear again."""
    tick, seed = c.tick[world], c.seeds[world]
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        comes = kind.away_least == kind.away_least
        captured = kind.capture_range == kind.capture_range
        if not (comes or captured or kind.walk > 0.0 or kind.respawn):
            continue
        for slot in range(kind.first, kind.end):
            thing = c.objects[world * c.facts.object_count + slot]
            if thing.present:
                leaves = comes and thing.due == tick + 1
                if captured:
                    if thing.captured < 0 and _within(c, world, thing.x, thing.y, kind.capture_range):
                        thing.captured = tick
                    leaves = leaves or (thing.captured >= 0 and tick - thing.captured >= kind.capture_ticks)
                if leaves:
                    thing.present = 0
                    thing.due = -1
                    if comes:
                        away = _drawn(
                            kind.away_least,
                            kind.away_most,
                            seed,
                            slot,
                            thing.appeared,
                            APPEARS,
                            c.facts.tick_s,
                        )
                        thing.due = tick + 1 + away
                elif kind.walk > 0.0:
                    _walk(c, thing, slot, kind, tick, seed, world)
            elif (comes or kind.respawn) and thing.due == tick + 1:
                thing.appeared += 1
                has_place, x, y = _new_place(c, world, slot, thing.appeared, kind)
                if not has_place:
                    thing.due = tick + 2
                    continue
                thing.x, thing.y, thing.present, thing.captured = x, y, 1, -1
                thing.heading = TAU * draw_uniform(seed, slot, thing.appeared, WALKS)
                thing.due = -1
                if kind.stays_least == kind.stays_least:
                    stays = _drawn(
                        kind.stays_least, kind.stays_most, seed, slot, thing.appeared, STAYS, c.facts.tick_s
                    )
                    thing.due = tick + 1 + stays


@inner
def _walk(c: Any, thing: Any, slot: int, kind: Any, tick: int, seed: int, world: int) -> None:
    """Move a walking object one step; it changes direction at random, and whenever something blocks it."""
    if tick % kind.turn_ticks == 0:
        thing.heading = TAU * draw_uniform(seed, slot, tick, WALKS)
    step, x, y = c.pushes[slot], thing.x, thing.y
    cosine, sine = compute_cosine_and_sine(thing.heading)
    step.dx, step.dy = kind.walk * cosine, kind.walk * sine
    scale = limit_by_region(1.0, x, y, step, kind)
    scale = limit_by_fixed(c, scale, x, y, kind.radius, step, world)
    if kind.solid:
        scale = limit_by_robots_and_boxes(c, scale, x, y, kind.radius, step, world)
    thing.x += scale * step.dx
    thing.y += scale * step.dy
    step.dx = step.dy = 0.0
    if scale < 1.0:
        thing.heading = TAU * draw_uniform(seed, slot, tick, PLACE)


@inner
def limit_by_region(scale: float, x: float, y: float, move: Any, kind: Any) -> Any:
    """Return the share of a step that keeps an object's center in its region, at most `scale`; it may always enter."""
    if move.dx < 0.0:
        scale = limit_by_gap(scale, -1.0, 0.0, x - kind.region[0], move.dx, move.dy, 0.0)
    elif move.dx > 0.0:
        scale = limit_by_gap(scale, 1.0, 0.0, kind.region[2] - x, move.dx, move.dy, 0.0)
    if move.dy < 0.0:
        scale = limit_by_gap(scale, 0.0, -1.0, y - kind.region[1], move.dx, move.dy, 0.0)
    elif move.dy > 0.0:
        scale = limit_by_gap(scale, 0.0, 1.0, kind.region[3] - y, move.dx, move.dy, 0.0)
    return scale


@inner
def limit_by_robots_and_boxes(
    c: Any, scale: float, x: float, y: float, radius: float, move: Any, world: int
) -> Any:
    """Return the share of a solid object's step that robots and boxes, taken as fixed, permit."""
    for row in range(world * c.facts.count, (world + 1) * c.facts.count):
        robot = c.robots[row]
        disc = (robot.x, robot.y, c.types[robot.type].radius)
        scale = limit_by_disc(scale, x, y, radius, move, disc)
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if kind.pushable:
            for slot in range(kind.first, kind.end):
                box = c.objects[world * c.facts.object_count + slot]
                if box.present:
                    scale = limit_by_disc(scale, x, y, radius, move, (box.x, box.y, kind.radius))
    return scale


@inner
def record_goal_tick(c: Any, world: int) -> None:
    """Record the tick at which a world first reaches its goal."""
    if c.facts.goal == 0 or c.finished[world] >= 0:
        return
    first = world * c.facts.count
    reached = False
    if c.facts.goal == GOAL_DELIVERED:
        left = 0
        for slot in range(c.facts.object_count):
            if c.classes[int64(c.class_of[slot])].food:
                left += c.objects[world * c.facts.object_count + slot].amount
        if left == 0:
            for row in range(first, first + c.facts.count):
                left += c.robots[row].stored
        reached = left == 0
    elif c.facts.goal == GOAL_GATHERED:
        gathered = 0
        for slot in range(c.facts.object_count):
            gathered += c.objects[world * c.facts.object_count + slot].gathered
        reached = gathered >= c.facts.goal_count
    else:
        kind = c.classes[c.facts.goal_target]
        every = c.facts.goal == GOAL_ALL_NEAR
        reached = every
        for row in range(first, first + c.facts.count):
            near = False
            for slot in range(kind.first, kind.end):
                dx, dy = (
                    c.objects[world * c.facts.object_count + slot].x - c.robots[row].x,
                    c.objects[world * c.facts.object_count + slot].y - c.robots[row].y,
                )
                if (
                    c.objects[world * c.facts.object_count + slot].present
                    and dx * dx + dy * dy <= c.facts.goal_within * c.facts.goal_within
                ):
                    near = True
            if near != every:
                reached = near
                break
    if reached:
        c.finished[world] = c.tick[world]


@inner
def freeze_failing_robots(c: Any, world: int) -> None:
    """Let the robots of a world fail whose tick has come."""
    for row in range(world * c.facts.count, (world + 1) * c.facts.count):
        if c.fails[row] == c.tick[world]:
            c.robots[row].frozen = 1
