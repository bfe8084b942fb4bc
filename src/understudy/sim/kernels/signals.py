"""Kernels of signals: who raises one, who of them is nearest, and which things are claimed by one.

What is raised in a tick is seen in the next. Few callers are gone through one by one; for many, the robots' grid is
quicker. Both find the same.
"""

import math
from typing import Any

from numba import njit

from understudy.sim.kernels.dtypes import SPOT, WHOLE
from understudy.sim.kernels.grid import SIGNALED, big_cells, nearest_robot, spots_of_line, wanted
from understudy.sim.kernels.memory import at, robot_at, work_at

SPOT_SIZE = SPOT.itemsize
FEW = 32  # callers up to which it is quicker to go through all than to look around a thing


@njit(error_model="numpy", forceinline=True)
def mean_to_call(c: Any, row: int, world: int, command: float) -> None:
    """Note what a robot raises from this tick on."""
    work = work_at(c, row - world * c.count)
    work.signal = 0 if robot_at(c, row).frozen else int(min(max(command, 0.0), float(c.signals)))


@njit(error_model="numpy", forceinline=True)
def call(c: Any, row: int, world: int) -> None:
    """Raise what a robot means to."""
    robot_at(c, row).signal = work_at(c, row - world * c.count).signal


@njit(error_model="numpy")
def line_up_callers(c: Any, world: int) -> None:
    """List the robots of a world that raise each signal."""
    for signal in range(c.signals):
        at(c.caller_counts, signal, WHOLE).v = 0
    for row in range(world * c.count, (world + 1) * c.count):
        robot = robot_at(c, row)
        if robot.signal > 0:
            count = at(c.caller_counts, robot.signal - 1, WHOLE)
            caller = at(c.callers, (robot.signal - 1) * c.count + count.v, SPOT)
            caller.x, caller.y, caller.row, caller.id = robot.x, robot.y, row, robot.id
            count.v += 1


@njit(error_model="numpy")
def nearest_caller(c: Any, row: int, world: int, relation: int, signal: int, limit: float) -> Any:
    """Row and squared distance of the nearest other robot that raises a signal; as `nearest_robot`."""
    callers = c.callers + SPOT_SIZE * (signal - 1) * c.count
    count = at(c.caller_counts, signal - 1, WHOLE).v
    if c.gridded and count * count > 4 * c.count:
        return nearest_robot(c, row, world, relation + SIGNALED * signal, limit)
    own = robot_at(c, row)
    best, best_id, best_squared = -1, -1, limit * limit
    for k in range(count):
        caller = at(callers, k, SPOT)
        dx, dy = caller.x - own.x, caller.y - own.y
        squared = dx * dx + dy * dy
        if squared <= best_squared and caller.row != row:
            if squared == best_squared and best >= 0 and best_id < caller.id:
                continue
            if wanted(c, robot_at(c, caller.row), own, relation):
                best, best_id, best_squared = caller.row, caller.id, squared
    return best, best_squared if best >= 0 else math.inf


@njit(error_model="numpy")
def is_claimed(c: Any, row: int, world: int, x: float, y: float, signal: int, within: float) -> Any:
    """Whether another robot within so many m of a place raises a signal."""
    callers = c.callers + SPOT_SIZE * (signal - 1) * c.count
    count = at(c.caller_counts, signal - 1, WHOLE).v
    if not c.gridded or count <= FEW:
        for k in range(count):
            caller = at(callers, k, SPOT)
            dx, dy = caller.x - x, caller.y - y
            if dx * dx + dy * dy <= within * within and caller.row != row:
                return True
        return False
    low, high, lowest, highest = big_cells(c, x, y, within)
    for line in range(lowest, highest + 1):
        begin, end = spots_of_line(c, line, low, high)
        for k in range(begin, end):
            spot = at(c.spots, k, SPOT)
            dx, dy = spot.x - x, spot.y - y
            near = dx * dx + dy * dy <= within * within and spot.row != row
            if near and robot_at(c, spot.row).signal == signal:
                return True
    return False
