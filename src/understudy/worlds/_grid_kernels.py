"""Kernels of the robots' grid: sorting them by cell, and finding who is nearest."""

import math
from typing import Any

from numba import njit

from understudy.worlds._pointer_kernels import at, robot_at, type_at
from understudy.worlds.records import INDEX, SPOT, WHOLE

CLOSE = 1e-9  # m; what rounding may do to the border between two cells
MANY = 8  # robots in a cell; from there on its small cells are looked at one by one

ANYONE, TEAMMATE, OPPONENT, TEAM = 0, 1, 2, 3


@njit(error_model="numpy")
def small_cell(c: Any, column: int, line: int) -> Any:
    """The index of the small cell in this column and line of small cells."""
    shift = c.shift
    mask = (1 << shift) - 1
    big = (line >> shift) * c.columns + (column >> shift)
    return (((big << shift) + (line & mask)) << shift) + (column & mask)


@njit(error_model="numpy")
def small_cells(c: Any, x: float, y: float, reach: float) -> Any:
    """First and last column, first and last line of small cells within `reach` of a place."""
    per_m = (1 << c.shift) / c.cell
    last_column, last_line = (c.columns << c.shift) - 1, (c.lines << c.shift) - 1
    return (
        min(max(int((x - reach) * per_m), 0), last_column),
        min(max(int((x + reach) * per_m), 0), last_column),
        min(max(int((y - reach) * per_m), 0), last_line),
        min(max(int((y + reach) * per_m), 0), last_line),
    )


@njit(error_model="numpy")
def near_range(c: Any, x: float, y: float, world: int) -> Any:
    """Where the list of what stays near a place begins and ends."""
    column = min(max(int(x / c.near_cell), 0), c.near_columns - 1)
    line = min(max(int(y / c.near_cell), 0), c.near_lines - 1)
    cell = (world * c.near_lines + line) * c.near_columns + column
    return at(c.near_start, cell, WHOLE).v, at(c.near_start, cell + 1, WHOLE).v


@njit(error_model="numpy")
def sort(c: Any, first: int) -> None:
    """Sort the robots of a world, rows from `first` on, into the grid; a counting sort keeps the rows' order."""
    if not c.gridded:
        return
    cells = (c.columns * c.lines) << (2 * c.shift)
    for cell in range(cells):
        at(c.start, cell, INDEX).v = 0
    per_m = (1 << c.shift) / c.cell
    last_column, last_line = (c.columns << c.shift) - 1, (c.lines << c.shift) - 1
    for k in range(c.count):
        robot = robot_at(c, first + k)
        column = min(max(int(robot.x * per_m), 0), last_column)
        line = min(max(int(robot.y * per_m), 0), last_line)
        cell = small_cell(c, column, line)
        at(c.cell_of, k, INDEX).v = cell
        at(c.start, cell, INDEX).v += 1
    total = 0
    for cell in range(cells):
        total += at(c.start, cell, INDEX).v
        at(c.start, cell, INDEX).v = total
    at(c.start, cells, INDEX).v = c.count
    for k in range(c.count - 1, -1, -1):
        cell = at(c.cell_of, k, INDEX).v
        place = at(c.start, cell, INDEX).v - 1
        at(c.start, cell, INDEX).v = place
        spot, robot = at(c.spots, place, SPOT), robot_at(c, first + k)
        spot.x, spot.y = robot.x, robot.y
        spot.row, spot.id = first + k, robot.id


@njit(error_model="numpy")
def wanted(c: Any, robot: Any, own: Any, relation: int) -> Any:
    """Whether a robot is one that is looked for: anyone, a teammate, an opponent, or of team relation - TEAM."""
    if relation == ANYONE:
        return True
    team = type_at(c, robot.type).team
    if relation == TEAMMATE:
        return team == type_at(c, own.type).team
    if relation == OPPONENT:
        return team != type_at(c, own.type).team
    return team == relation - TEAM


@njit(error_model="numpy")
def _nearer(c: Any, row: int, relation: int, begin: int, end: int, found: Any) -> Any:
    """The nearest so far (row, squared distance) or a nearer one among the spots from begin to end."""
    best, best_squared = found
    own = robot_at(c, row)
    for k in range(begin, end):
        spot = at(c.spots, k, SPOT)
        dx, dy = spot.x - own.x, spot.y - own.y
        squared = dx * dx + dy * dy
        if squared <= best_squared and spot.row != row:
            if squared == best_squared and best >= 0 and robot_at(c, best).id < spot.id:
                continue
            if wanted(c, robot_at(c, spot.row), own, relation):
                best, best_squared = spot.row, squared
    return best, best_squared


@njit(error_model="numpy")
def _off(value: float, low: float, high: float) -> Any:
    """How far a value is from an interval."""
    return max(0.0, low - CLOSE - value, value - high - CLOSE)


@njit(error_model="numpy")
def _nearer_in_cell(c: Any, row: int, relation: int, column: int, line: int, found: Any) -> Any:
    """The same, among the robots of one cell; in a crowd, of those small cells that can hold a nearer one."""
    shift, cell = c.shift, c.cell
    small = 1 << (2 * shift)
    first = (line * c.columns + column) * small
    begin, end = at(c.start, first, INDEX).v, at(c.start, first + small, INDEX).v
    if begin == end:
        return found
    x, y = robot_at(c, row).x, robot_at(c, row).y
    dx = _off(x, column * cell, (column + 1) * cell)
    dy = _off(y, line * cell, (line + 1) * cell)
    if dx * dx + dy * dy > found[1]:
        return found
    if end - begin <= MANY or shift == 0:
        return _nearer(c, row, relation, begin, end, found)
    fine = cell / (1 << shift)
    for k in range(small):
        low_x = column * cell + (k & ((1 << shift) - 1)) * fine
        low_y = line * cell + (k >> shift) * fine
        dx, dy = _off(x, low_x, low_x + fine), _off(y, low_y, low_y + fine)
        if dx * dx + dy * dy <= found[1]:
            begin, end = at(c.start, first + k, INDEX).v, at(c.start, first + k + 1, INDEX).v
            found = _nearer(c, row, relation, begin, end, found)
    return found


@njit(error_model="numpy")
def nearest_robot(c: Any, row: int, world: int, relation: int, limit: float) -> Any:
    """Row and squared distance of the nearest wanted robot within `limit`; -1 and infinite where none is.

    Of robots equally near, the one with the lowest id.
    """
    own = robot_at(c, row)
    if not c.gridded:
        best, best_squared = -1, limit * limit
        for k in range(world * c.count, (world + 1) * c.count):
            dx, dy = robot_at(c, k).x - own.x, robot_at(c, k).y - own.y
            squared = dx * dx + dy * dy
            if squared <= best_squared and k != row:
                if squared == best_squared and best >= 0 and robot_at(c, best).id < robot_at(c, k).id:
                    continue
                if wanted(c, robot_at(c, k), own, relation):
                    best, best_squared = k, squared
        return best, best_squared if best >= 0 else math.inf
    cell = c.cell
    column = min(max(int(own.x / cell), 0), c.columns - 1)
    line = min(max(int(own.y / cell), 0), c.lines - 1)
    inside = min(own.x - column * cell, (column + 1) * cell - own.x)
    inside = max(0.0, min(inside, own.y - line * cell, (line + 1) * cell - own.y))
    found = _nearer_in_cell(c, row, relation, column, line, (-1, limit * limit))
    for ring in range(1, max(c.columns, c.lines)):
        away = max(0.0, (ring - 1) * cell + inside - CLOSE)
        if away * away > found[1]:
            break
        for below in range(max(0, line - ring), min(c.lines - 1, line + ring) + 1):
            step = 1 if abs(below - line) == ring else 2 * ring
            for aside in range(column - ring, column + ring + 1, step):
                if 0 <= aside < c.columns:
                    found = _nearer_in_cell(c, row, relation, aside, below, found)
    return found[0], found[1] if found[0] >= 0 else math.inf
