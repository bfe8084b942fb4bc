"""Kernels of boxes that robots pull together: taking hold, going where all holders drive, gathering.

A box and those who hold it move as one, by what all of them may: none of them gets nearer to another, and each step is
limited by the gaps as that of a robot alone. Sums are of whole numbers, so that the holders' order does not matter.
"""

import math
from typing import Any

from understudy._jit_kernels import inner, njit
from understudy.sim.kernels.collisions import STUCK, limit_by_fixed
from understudy.sim.kernels.nearest import find_nearest_object

FINE = 2.0**40  # as of boxes that are pushed


@inner
def grip_box(c: Any, row: int, world: int, load: float, unload: float, still: Any) -> None:
    """Let a robot take hold of the nearest box within reach, or let go, as its commands say."""
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
    """What the holders of each box mean to do together: the mean of their steps, at most the slowest one's.

    Nothing where they are too few.
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


@njit(error_model="numpy")
def _pull_together(box: Any) -> None:
    box.dx, box.dy = box.sum_x / FINE / box.count, box.sum_y / FINE / box.count
    along = math.sqrt(box.dx * box.dx + box.dy * box.dy)
    if along > box.slowest:
        box.dx *= box.slowest / along
        box.dy *= box.slowest / along


@inner
def follow_pulled_box(c: Any, row: int, world: int) -> None:
    """Give a robot that holds a box the step of all who do, as far as what stays in its way lets it.

    It turns as it likes. Its own step counts as wanted where nearly nothing comes of it, so that it knows it is stuck.
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
    """Let every box, and all who hold it, go as far as the one of them that may go least."""
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
    """Move the boxes with their holders; one whose center is in a home is gathered, and let go of."""
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
    """Whether a place is in a home."""
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        if kind.home:
            slot, squared = find_nearest_object(c, world, x, y, index)
            if slot >= 0 and squared <= kind.radius * kind.radius:
                return True
    return False
