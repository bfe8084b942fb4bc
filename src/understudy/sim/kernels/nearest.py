"""Kernels that find the nearest object of a class: among few by comparing all, among many in a list sorted by x."""

import math
from typing import Any

from understudy.jit.decorators import inlined, inner, uint64
from understudy.sim.kernels.signals import is_claimed

MANY = 64  # slots of a class; where there are more, they are kept in order


@inlined
def find_nearest_object(c: Any, world: int, x: float, y: float, index: int) -> Any:
    """Return slot and squared distance (m**2) of the nearest object of a class; -1 if there is none.

    Sources without food left do not count.
    """
    kind = c.classes[index]
    best, best_squared = -1, math.inf
    for slot in range(kind.first, kind.end):
        thing = c.objects[world * c.facts.object_count + slot]
        dx, dy = thing.x - x, thing.y - y
        squared = dx * dx + dy * dy
        if squared < best_squared and thing.present and (thing.amount > 0 or not kind.food):
            best, best_squared = slot, squared
    return best, best_squared


@inner
def gather_object_places(c: Any, world: int) -> None:
    """Copy the places of a world's objects into arrays for `find_nearest_gathered_object`; x is infinite if absent."""
    for index in range(c.facts.class_count):
        kind = c.classes[index]
        for slot in range(kind.first, kind.end):
            thing = c.objects[world * c.facts.object_count + slot]
            there = thing.present and (thing.amount > 0 or not kind.food)
            c.object_x[slot] = thing.x if there else math.inf
            c.object_y[slot] = thing.y
        if kind.end - kind.first > MANY:
            _put_in_order(c, kind)


@inner
def _put_in_order(c: Any, kind: Any) -> None:
    """Sort the slots of a class by x, by insertion: the order hardly changes from one tick to the next."""
    for k in range(kind.first + 1, kind.end):
        slot = c.object_order[k]
        x = c.object_x[slot]
        place = k
        while place > kind.first and c.object_x[c.object_order[place - 1]] > x:
            c.object_order[place] = c.object_order[place - 1]
            place -= 1
        c.object_order[place] = slot


@inlined
def find_nearest_gathered_object(c: Any, row: int, world: int, step: Any) -> Any:
    """Return slot and squared distance (m**2) of the nearest object of a step's class; -1 if there is none.

    It uses the places from `gather_object_places` in this tick.
    """
    kind, robot = c.classes[step.index], c.robots[row]
    if kind.end - kind.first > MANY:
        return _nearest_in_order(c, row, world, step, kind, 0)
    best, best_squared = -1, math.inf
    for slot in range(kind.first, kind.end):
        dx, dy = c.object_x[uint64(slot)] - robot.x, c.object_y[uint64(slot)] - robot.y
        squared = dx * dx + dy * dy
        if squared < best_squared:
            best, best_squared = slot, squared
    return best, best_squared


@inner
def find_nearest_unclaimed(c: Any, row: int, world: int, step: Any) -> Any:
    """Return slot and squared distance of the nearest object that no other robot claims by the step's signal."""
    kind, robot = c.classes[step.index], c.robots[row]
    if kind.end - kind.first > MANY:
        return _nearest_in_order(c, row, world, step, kind, step.signal)
    best, best_squared = -1, math.inf
    for slot in range(kind.first, kind.end):
        x, y = c.object_x[slot], c.object_y[slot]
        dx, dy = x - robot.x, y - robot.y
        squared = dx * dx + dy * dy
        if squared < best_squared and not is_claimed(c, row, world, x, y, step.signal, step.within):
            best, best_squared = slot, squared
    return best, best_squared


@inner
def _nearest_in_order(c: Any, row: int, world: int, step: Any, kind: Any, signal: int) -> Any:
    """Return slot and squared distance of the nearest object in a step's range, searching outwards from the robot.

    Of objects equally near, it is the first slot. With a signal other than 0, objects that another robot claims by it
    do not count.
    """
    robot = c.robots[row]
    x, y, above, end = robot.x, robot.y, kind.first, kind.end
    while above < end:  # where the first is that is not to the left
        middle = (above + end) // 2
        if c.object_x[c.object_order[middle]] < x:
            above = middle + 1
        else:
            end = middle
    below, best, best_squared = above - 1, -1, step.range * step.range
    left, right = below >= kind.first, above < kind.end
    while left or right:
        if right:
            best, best_squared, right = _nearer(c, row, world, step, signal, above, x, y, best, best_squared)
            above += 1
            right = right and above < kind.end
        if left:
            best, best_squared, left = _nearer(c, row, world, step, signal, below, x, y, best, best_squared)
            below -= 1
            left = left and below >= kind.first
    return best, best_squared if best >= 0 else math.inf


@inlined
def _nearer(
    c: Any, row: int, world: int, step: Any, signal: int, k: int, x: float, y: float, best: int, best_squared: float
) -> Any:  # fmt: skip
    """Return the nearer one of `best` and object k of the sorted order, and whether objects beyond k may be nearer."""
    slot = c.object_order[k]
    there_x, there_y = c.object_x[slot], c.object_y[slot]
    dx, dy = there_x - x, there_y - y
    if dx * dx > best_squared or there_x == math.inf:
        return best, best_squared, False
    squared = dx * dx + dy * dy
    nearer = squared < best_squared or (squared == best_squared and (best < 0 or slot < best))
    if nearer and (signal == 0 or not is_claimed(c, row, world, there_x, there_y, signal, step.within)):
        return slot, squared, True
    return best, best_squared, True
