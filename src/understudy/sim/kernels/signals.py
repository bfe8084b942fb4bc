"""Kernels of signals: which robots raise one, the nearest of them, and the things that they claim.

A signal raised in one tick is visible in the next. Few signaling robots are searched one by one; for many, the grid
of robots is faster. Both find the same.
"""

import math
from typing import Any

from understudy.jit.decorators import inlined, inner
from understudy.sim.kernels.grid import (
    SIGNALED,
    find_big_cells,
    find_line_spots,
    find_nearest_robot,
    matches_relation,
)

FEW = 32  # callers up to which it is quicker to go through all than to look around a thing


@inlined
def plan_signal(c: Any, row: int, world: int, command: float) -> None:
    """Store the signal that a robot will raise from this tick on, for `raise_signal`."""
    work = c.works[row - world * c.facts.count]
    work.signal = 0 if c.robots[row].frozen else int(min(max(command, 0.0), float(c.facts.signals)))


@inlined
def raise_signal(c: Any, row: int, world: int) -> None:
    """Raise the signal that `plan_signal` stored."""
    c.robots[row].signal = c.works[row - world * c.facts.count].signal


@inner
def list_signalers(c: Any, world: int) -> None:
    """List the robots of a world that raise each signal, with their places."""
    for signal in range(c.facts.signals):
        c.caller_counts[signal] = 0
    for row in range(world * c.facts.count, (world + 1) * c.facts.count):
        robot = c.robots[row]
        if robot.signal > 0:
            count = c.caller_counts[robot.signal - 1]
            caller = c.callers[(robot.signal - 1) * c.facts.count + count]
            caller.x, caller.y, caller.row, caller.id = robot.x, robot.y, row, robot.id
            c.caller_counts[robot.signal - 1] += 1


@inner
def find_nearest_signaler(c: Any, row: int, world: int, relation: int, signal: int, limit: float) -> Any:
    """Return row and squared distance (m**2) of the nearest other robot of a relation that raises a signal.

    -1 and infinity if there is none within `limit` (m); see `find_nearest_robot` for `relation`.
    """
    callers = c.callers[(signal - 1) * c.facts.count : signal * c.facts.count]
    count = c.caller_counts[signal - 1]
    if c.facts.gridded and count * count > 4 * c.facts.count:
        return find_nearest_robot(c, row, world, relation + SIGNALED * signal, limit)
    own = c.robots[row]
    best, best_id, best_squared = -1, -1, limit * limit
    for k in range(count):
        caller = callers[k]
        dx, dy = caller.x - own.x, caller.y - own.y
        squared = dx * dx + dy * dy
        if squared <= best_squared and caller.row != row:
            if squared == best_squared and best >= 0 and best_id < caller.id:
                continue
            if matches_relation(c, c.robots[caller.row], own, relation):
                best, best_id, best_squared = caller.row, caller.id, squared
    return best, best_squared if best >= 0 else math.inf


@inner
def is_claimed(c: Any, row: int, world: int, x: float, y: float, signal: int, within: float) -> Any:
    """Return whether another robot that is within `within` (m) of a place raises a signal."""
    callers = c.callers[(signal - 1) * c.facts.count : signal * c.facts.count]
    count = c.caller_counts[signal - 1]
    if not c.facts.gridded or count <= FEW:
        for k in range(count):
            caller = callers[k]
            dx, dy = caller.x - x, caller.y - y
            if dx * dx + dy * dy <= within * within and caller.row != row:
                return True
        return False
    low, high, lowest, highest = find_big_cells(c, x, y, within)
    for line in range(lowest, highest + 1):
        begin, end = find_line_spots(c, line, low, high)
        for k in range(begin, end):
            spot = c.spots[k]
            dx, dy = spot.x - x, spot.y - y
            near = dx * dx + dy * dy <= within * within and spot.row != row
            if near and c.robots[spot.row].signal == signal:
                return True
    return False
