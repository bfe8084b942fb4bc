"""Kernels of the robots' grid: sorting them by cell, and finding who is nearest."""

import math
from typing import Any

from numba import njit

MANY = 8  # robots in a cell; from there on its small cells are looked at one by one

ANYONE, TEAMMATE, OPPONENT, TEAM = 0, 1, 2, 3


@njit(error_model="numpy")
def small_cell(column: int, line: int, grid: Any) -> Any:
    """The index of the small cell in this column and line of small cells."""
    shift = grid.shift
    mask = (1 << shift) - 1
    big = (line >> shift) * grid.columns + (column >> shift)
    return (((big << shift) + (line & mask)) << shift) + (column & mask)


@njit(error_model="numpy")
def small_cells(x: float, y: float, reach: float, grid: Any) -> Any:
    """First and last column, first and last line of small cells within `reach` of a place."""
    per_m = (1 << grid.shift) / grid.cell
    last_column, last_line = (grid.columns << grid.shift) - 1, (grid.lines << grid.shift) - 1
    return (
        min(max(int((x - reach) * per_m), 0), last_column),
        min(max(int((x + reach) * per_m), 0), last_column),
        min(max(int((y - reach) * per_m), 0), last_line),
        min(max(int((y + reach) * per_m), 0), last_line),
    )


@njit(error_model="numpy")
def near_range(x: float, y: float, near: Any, world: int) -> Any:
    """Where the list of what stays near a place begins and ends."""
    column = min(max(int(x / near.cell), 0), near.columns - 1)
    line = min(max(int(y / near.cell), 0), near.lines - 1)
    at = (world * near.lines + line) * near.columns + column
    return near.start[at], near.start[at + 1]


@njit(error_model="numpy")
def sort(robots: Any, first: int, grid: Any) -> None:
    """Sort the robots of a world, rows from `first` on, into the grid; a counting sort keeps the rows' order."""
    start, cell_of, spots = grid.start, grid.cell_of, grid.spots
    count = spots.shape[0]
    if count == 0:
        return
    cells = start.shape[0] - 1
    for cell in range(cells + 1):
        start[cell] = 0
    per_m = (1 << grid.shift) / grid.cell
    last_column, last_line = (grid.columns << grid.shift) - 1, (grid.lines << grid.shift) - 1
    for k in range(count):
        column = min(max(int(robots[first + k].x * per_m), 0), last_column)
        line = min(max(int(robots[first + k].y * per_m), 0), last_line)
        at = small_cell(column, line, grid)
        cell_of[k] = at
        start[at] += 1
    total = 0
    for cell in range(cells):
        total += start[cell]
        start[cell] = total
    start[cells] = count
    for k in range(count - 1, -1, -1):
        at = cell_of[k]
        place = start[at] - 1
        start[at] = place
        spot = spots[place]
        robot = robots[first + k]
        spot.x, spot.y, spot.row, spot.id = robot.x, robot.y, first + k, robot.id


@njit(error_model="numpy")
def wanted(robot: Any, own: Any, types: Any, relation: int) -> Any:
    """Whether a robot is one that is looked for: anyone, a teammate, an opponent, or of team relation - TEAM."""
    if relation == ANYONE:
        return True
    team = types[robot.type].team
    if relation == TEAMMATE:
        return team == types[own.type].team
    if relation == OPPONENT:
        return team != types[own.type].team
    return team == relation - TEAM


@njit(error_model="numpy")
def _nearer(
    robots: Any, row: int, types: Any, relation: int, grid: Any, begin: int, end: int, found: Any
) -> Any:
    """The nearest so far (row, squared distance) or a nearer one among the spots from begin to end."""
    best, best_squared = found
    own = robots[row]
    for k in range(begin, end):
        spot = grid.spots[k]
        dx, dy = spot.x - own.x, spot.y - own.y
        squared = dx * dx + dy * dy
        if squared <= best_squared and spot.row != row:
            if squared == best_squared and best >= 0 and robots[best].id < spot.id:
                continue
            if wanted(robots[spot.row], own, types, relation):
                best, best_squared = spot.row, squared
    return best, best_squared


@njit(error_model="numpy")
def _off(value: float, low: float, high: float) -> float:
    """How far a value is from an interval."""
    return max(0.0, low - value, value - high)


@njit(error_model="numpy")
def _nearer_in_cell(
    robots: Any, row: int, types: Any, relation: int, grid: Any, column: int, line: int, found: Any
) -> Any:
    """The same, among the robots of one cell; in a crowd, of those small cells that can hold a nearer one."""
    shift, cell = grid.shift, grid.cell
    small = 1 << (2 * shift)
    first = (line * grid.columns + column) * small
    begin, end = grid.start[first], grid.start[first + small]
    if begin == end:
        return found
    x, y = robots[row].x, robots[row].y
    dx = _off(x, column * cell, (column + 1) * cell)
    dy = _off(y, line * cell, (line + 1) * cell)
    if dx * dx + dy * dy > found[1]:
        return found
    if end - begin <= MANY or shift == 0:
        return _nearer(robots, row, types, relation, grid, begin, end, found)
    fine = cell / (1 << shift)
    for k in range(small):
        low_x = column * cell + (k & ((1 << shift) - 1)) * fine
        low_y = line * cell + (k >> shift) * fine
        dx, dy = _off(x, low_x, low_x + fine), _off(y, low_y, low_y + fine)
        if dx * dx + dy * dy <= found[1]:
            begin, end = grid.start[first + k], grid.start[first + k + 1]
            found = _nearer(robots, row, types, relation, grid, begin, end, found)
    return found


@njit(error_model="numpy")
def nearest_robot(
    robots: Any, row: int, first: int, end: int, types: Any, relation: int, limit: float, grid: Any
) -> Any:
    """Row and squared distance of the nearest wanted robot within `limit`; -1 and infinite where none is.

    Of robots equally near, the one with the lowest id. The world's robots are rows `first` to `end`.
    """
    own = robots[row]
    if grid.spots.shape[0] == 0:
        best, best_squared = -1, limit * limit
        for k in range(first, end):
            dx, dy = robots[k].x - own.x, robots[k].y - own.y
            squared = dx * dx + dy * dy
            if squared <= best_squared and k != row:
                if squared == best_squared and best >= 0 and robots[best].id < robots[k].id:
                    continue
                if wanted(robots[k], own, types, relation):
                    best, best_squared = k, squared
        return best, best_squared if best >= 0 else math.inf
    cell = grid.cell
    column = min(max(int(own.x / cell), 0), grid.columns - 1)
    line = min(max(int(own.y / cell), 0), grid.lines - 1)
    inside = min(own.x - column * cell, (column + 1) * cell - own.x)
    inside = max(0.0, min(inside, own.y - line * cell, (line + 1) * cell - own.y))
    found = _nearer_in_cell(robots, row, types, relation, grid, column, line, (-1, limit * limit))
    for ring in range(1, max(grid.columns, grid.lines)):
        away = (ring - 1) * cell + inside
        if away * away > found[1]:
            break
        for below in range(max(0, line - ring), min(grid.lines - 1, line + ring) + 1):
            step = 1 if abs(below - line) == ring else 2 * ring
            for aside in range(column - ring, column + ring + 1, step):
                if 0 <= aside < grid.columns:
                    found = _nearer_in_cell(robots, row, types, relation, grid, aside, below, found)
    return found[0], found[1] if found[0] >= 0 else math.inf
