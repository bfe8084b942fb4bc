"""Kernels that find the nearest object of a class: among few by comparing all, among many in the order of their x."""

import math
from typing import Any

from numba import njit

from understudy.sim.kernels.dtypes import NUMBER, WHOLE
from understudy.sim.kernels.memory import at, class_at, object_at, robot_at
from understudy.sim.kernels.signals import is_claimed

MANY = 64  # slots of a class; where there are more, they are kept in order


@njit(error_model="numpy", forceinline=True)
def nearest_object(c: Any, world: int, x: float, y: float, index: int) -> Any:
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
def line_up(c: Any, world: int) -> None:
    """Put the places of a world's objects side by side, for `nearest_lined_up`: infinitely far what is not there."""
    for index in range(c.class_count):
        kind = class_at(c, index)
        for slot in range(kind.first, kind.end):
            thing = object_at(c, world, slot)
            there = thing.present and (thing.amount > 0 or not kind.food)
            at(c.object_x, slot, NUMBER).v = thing.x if there else math.inf
            at(c.object_y, slot, NUMBER).v = thing.y
        if kind.end - kind.first > MANY:
            _put_in_order(c, kind)


@njit(error_model="numpy")
def _put_in_order(c: Any, kind: Any) -> None:
    """Sort the slots of a class by x: from one tick to the next hardly anything changes, so by insertion."""
    for k in range(kind.first + 1, kind.end):
        slot = at(c.object_order, k, WHOLE).v
        x = at(c.object_x, slot, NUMBER).v
        place = k
        while place > kind.first and at(c.object_x, at(c.object_order, place - 1, WHOLE).v, NUMBER).v > x:
            at(c.object_order, place, WHOLE).v = at(c.object_order, place - 1, WHOLE).v
            place -= 1
        at(c.object_order, place, WHOLE).v = slot


@njit(error_model="numpy", forceinline=True)
def nearest_lined_up(c: Any, row: int, world: int, step: Any) -> Any:
    """Slot and squared distance of the nearest object of a step's class, of the places lined up in this tick."""
    kind, robot = class_at(c, step.index), robot_at(c, row)
    if kind.end - kind.first > MANY:
        return _nearest_in_order(c, row, world, step, kind, 0)
    best, best_squared = -1, math.inf
    for slot in range(kind.first, kind.end):
        dx, dy = at(c.object_x, slot, NUMBER).v - robot.x, at(c.object_y, slot, NUMBER).v - robot.y
        squared = dx * dx + dy * dy
        if squared < best_squared:
            best, best_squared = slot, squared
    return best, best_squared


@njit(error_model="numpy")
def nearest_unclaimed(c: Any, row: int, world: int, step: Any) -> Any:
    """The same, of those that nobody else claims by the step's signal."""
    kind, robot = class_at(c, step.index), robot_at(c, row)
    if kind.end - kind.first > MANY:
        return _nearest_in_order(c, row, world, step, kind, step.signal)
    best, best_squared = -1, math.inf
    for slot in range(kind.first, kind.end):
        x, y = at(c.object_x, slot, NUMBER).v, at(c.object_y, slot, NUMBER).v
        dx, dy = x - robot.x, y - robot.y
        squared = dx * dx + dy * dy
        if squared < best_squared and not is_claimed(c, row, world, x, y, step.signal, step.within):
            best, best_squared = slot, squared
    return best, best_squared


@njit(error_model="numpy")
def _nearest_in_order(c: Any, row: int, world: int, step: Any, kind: Any, signal: int) -> Any:
    """The nearest in a step's range; from the robot's own x on to both sides, as far as one may be nearer.

    Of those equally near the first slot. Where a signal is given, those that nobody else claims by it.
    """
    robot = robot_at(c, row)
    x, y, above, end = robot.x, robot.y, kind.first, kind.end
    while above < end:  # where the first is that is not to the left
        middle = (above + end) // 2
        if at(c.object_x, at(c.object_order, middle, WHOLE).v, NUMBER).v < x:
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


@njit(error_model="numpy", forceinline=True)
def _nearer(
    c: Any, row: int, world: int, step: Any, signal: int, k: int, x: float, y: float, best: int, best_squared: float
) -> Any:  # fmt: skip
    """The nearest so far (slot, squared distance), or object k in the order; and whether one beyond may be nearer."""
    slot = at(c.object_order, k, WHOLE).v
    there_x, there_y = at(c.object_x, slot, NUMBER).v, at(c.object_y, slot, NUMBER).v
    dx, dy = there_x - x, there_y - y
    if dx * dx > best_squared or there_x == math.inf:
        return best, best_squared, False
    squared = dx * dx + dy * dy
    nearer = squared < best_squared or (squared == best_squared and (best < 0 or slot < best))
    if nearer and (signal == 0 or not is_claimed(c, row, world, there_x, there_y, signal, step.within)):
        return slot, squared, True
    return best, best_squared, True
