"""Kernels of boxes that robots pull together: grip, move with all robots that hold the box, deliver to a home.

A box and the robots that hold it move as one, by the step that is possible for all of them: none gets nearer to
another, and each is limited by the gaps like a single robot. Sums are of whole numbers, so the order of the robots
does not matter.
"""

import math
from typing import Any

from understudy.jit.decorators import inner
from understudy.sim.kernels.collisions import STUCK, limit_by_fixed
from understudy.sim.kernels.nearest import find_nearest_object

FINE = 2.0**40  # as of boxes that are pushed


@inner
def grip_box(c: Any, row: int, world: int, load: float, unload: float, still: Any) -> None:
    """Make a robot grip the nearest box within its reach, or release its box, according to its commands."""
    robot = c.robots[row]
    if robot.frozen or (unload > 0.0 and not load > 0.0):
        robot.holding = 0
        return
    if robot.holding != 0 or not (load > 0.0 and still):
        return
    best, best_squared = -1, math.inf
    for index in range(c.facts.class_count):
        if c.classes[index].pull > 0:
            slot, squared = find_nearest_object(c, world, robot.x, robot.y, index)
            if squared < best_squared:
                best, best_squared = slot, squared
    reach = c.types[robot.type].reach
    if best >= 0 and best_squared <= reach * reach:
        robot.holding = best + 1


@inner
def plan_pulled_boxes(c: Any, world: int) -> None:
    """Compute the intended step of each box: the mean of its holders' steps, at most as fast as the slowest holder.

    It is zero if too few robots hold the box.
    """
    first = world * c.facts.count
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if kind.pull > 0:
            for slot in range(kind.first, kind.end):
                box = c.pulls[slot]
                box.sum_x = box.sum_y = box.count = 0
                box.slowest = math.inf
    for row in range(first, first + c.facts.count):
        robot = c.robots[row]
        if robot.holding != 0:
            box, move = c.pulls[robot.holding - 1], c.moves[row - world * c.facts.count]
            box.sum_x += int(move.dx * FINE)
            box.sum_y += int(move.dy * FINE)
            box.count += 1
            box.slowest = min(box.slowest, c.types[robot.type].speed)
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if kind.pull > 0:
            for slot in range(kind.first, kind.end):
                box = c.pulls[slot]
                c.objects[world * c.facts.object_count + slot].hands = box.count
                box.dx = box.dy = 0.0
                if box.count >= kind.pull:
                    _pull_together(box)


@inner
def _pull_together(box: Any) -> None:
    box.dx, box.dy = box.sum_x / FINE / box.count, box.sum_y / FINE / box.count
    along = math.sqrt(box.dx * box.dx + box.dy * box.dy)
    if along > box.slowest:
        box.dx *= box.slowest / along
        box.dy *= box.slowest / along


@inner
def follow_pulled_box(c: Any, row: int, world: int) -> None:
    """Give a robot that holds a box the step of the box, limited by fixed things; it turns freely.

    If that step is tiny, the robot's own step remains the wanted one, so that the robot counts as stuck.
    """
    robot = c.robots[row]
    if robot.holding == 0:
        return
    box, move = c.pulls[robot.holding - 1], c.moves[row - world * c.facts.count]
    along = math.sqrt(box.dx * box.dx + box.dy * box.dy)
    if along >= STUCK * move.wanted:
        move.wanted = along
    move.dx, move.dy, move.scale = box.dx, box.dy, 1.0
    if along > 0.0:
        radius = c.types[robot.type].radius
        move.scale = limit_by_fixed(c, 1.0, robot.x, robot.y, radius, move, world)


@inner
def limit_pulled_boxes(c: Any, world: int) -> None:
    """Limit each box and all its holders to the step of whichever of them is limited most."""
    first = world * c.facts.count
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if kind.pull > 0:
            for slot in range(kind.first, kind.end):
                box, thing = c.pulls[slot], c.objects[world * c.facts.object_count + slot]
                box.scale = 1.0
                if box.dx != 0.0 or box.dy != 0.0:
                    box.scale = limit_by_fixed(c, 1.0, thing.x, thing.y, kind.radius, box, world)
    for row in range(first, first + c.facts.count):
        if c.robots[row].holding != 0:
            box = c.pulls[c.robots[row].holding - 1]
            box.scale = min(box.scale, c.moves[row - world * c.facts.count].scale)
    for row in range(first, first + c.facts.count):
        if c.robots[row].holding != 0:
            c.moves[row - world * c.facts.count].scale = c.pulls[c.robots[row].holding - 1].scale


@inner
def move_pulled_boxes(c: Any, world: int) -> None:
    """Move the boxes; a box whose center is in a home is gathered, and its holders release it."""
    gathered = False
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if kind.pull == 0:
            continue
        for slot in range(kind.first, kind.end):
            thing, box = c.objects[world * c.facts.object_count + slot], c.pulls[slot]
            if not thing.present:
                continue
            thing.x += box.scale * box.dx
            thing.y += box.scale * box.dy
            if _in_home(c, world, thing.x, thing.y):
                gathered = True
                thing.present = thing.hands = 0
                thing.gathered += 1
                thing.due = c.tick[world] + 1 if kind.respawn else -1
    if gathered:
        for row in range(world * c.facts.count, (world + 1) * c.facts.count):
            robot = c.robots[row]
            if robot.holding != 0 and not c.objects[world * c.facts.object_count + robot.holding - 1].present:
                robot.holding = 0


@inner
def _in_home(c: Any, world: int, x: float, y: float) -> Any:
    """Return whether a place is inside a home."""
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if kind.home:
            slot, squared = find_nearest_object(c, world, x, y, index)
            if slot >= 0 and squared <= kind.radius * kind.radius:
                return True
    return False
