"""Kernels of the robots' grid: sorting them by cell, and finding who is nearest."""

import math
from typing import Any

from numba import njit

from understudy.sim.kernels.dtypes import INDEX, SPOT, WHOLE
from understudy.sim.kernels.memory import at, index_at, robot_at, type_at

CLOSE = 1e-9  # m; what rounding may do to the border between two cells
MANY = 8  # robots in a cell; where there are more, its small cells are looked at one by one

ANYONE, TEAMMATE, OPPONENT, TEAM = 0, 1, 2, 3
CROWDED = -2
SIGNALED = 1 << 32  # a relation to those who raise a signal is one to all of them + SIGNALED * the signal


@njit(error_model="numpy", forceinline=True)
def small_cell(c: Any, column: int, line: int) -> Any:
    """The index of the small cell in this column and line of small cells."""
    shift = c.shift
    mask = (1 << shift) - 1
    big = (line >> shift) * c.columns + (column >> shift)
    return (((big << shift) + (line & mask)) << shift) + (column & mask)


@njit(error_model="numpy", forceinline=True)
def big_cells(c: Any, x: float, y: float, reach: float) -> Any:
    """First and last column, first and last line of the cells that may hold robots within `reach` of a place."""
    reach += c.drift
    return (
        max(int((x - reach) * c.per_cell), 0),
        min(int((x + reach) * c.per_cell), c.columns - 1),
        max(int((y - reach) * c.per_cell), 0),
        min(int((y + reach) * c.per_cell), c.lines - 1),
    )


@njit(error_model="numpy", forceinline=True)
def spots_of_line(c: Any, line: int, low: int, high: int) -> Any:
    """Where the spots of the cells `low` to `high` of a line begin and end."""
    small = 2 * c.shift
    begin = index_at(c.start, (line * c.columns + low) << small)
    return begin, index_at(c.start, (line * c.columns + high + 1) << small)


@njit(error_model="numpy", forceinline=True)
def small_cells(c: Any, x: float, y: float, reach: float) -> Any:
    """First and last column, first and last line of the small cells that may hold robots within `reach` of a place."""
    reach += c.drift
    per_m = (1 << c.shift) * c.per_cell
    last_column, last_line = (c.columns << c.shift) - 1, (c.lines << c.shift) - 1
    return (
        min(max(int((x - reach) * per_m), 0), last_column),
        min(max(int((x + reach) * per_m), 0), last_column),
        min(max(int((y - reach) * per_m), 0), last_line),
        min(max(int((y + reach) * per_m), 0), last_line),
    )


@njit(error_model="numpy", forceinline=True)
def near_range(c: Any, x: float, y: float, world: int) -> Any:
    """Where the list of what stays near a place begins and ends."""
    column = min(max(int(x * c.near_per_cell), 0), c.near_columns - 1)
    line = min(max(int(y * c.near_per_cell), 0), c.near_lines - 1)
    cell = (world * c.near_lines + line) * c.near_columns + column
    return at(c.near_start, cell, WHOLE).v, at(c.near_start, cell + 1, WHOLE).v


@njit(error_model="numpy", forceinline=True)
def find_cell(c: Any, row: int, world: int) -> None:
    """Sorting, first: note the small cell of a robot where its spot will be noted."""
    robot = robot_at(c, row)
    column, _, line, _ = small_cells(c, robot.x, robot.y, 0.0)
    at(c.spot_of, row - world * c.count, INDEX).v = small_cell(c, column, line)


@njit(error_model="numpy")
def count(c: Any) -> None:
    """Sorting, second: count the robots of each cell, and give each its spot; in a cell they keep the rows' order."""
    cells, robots = (c.columns * c.lines) << (2 * c.shift), c.count
    start, spot_of = c.start, c.spot_of  # else they are looked up anew after every change
    for cell in range(cells):
        at(start, cell, INDEX).v = 0
    for k in range(robots):
        at(start, index_at(spot_of, k), INDEX).v += 1
    total = 0
    for cell in range(cells):
        total += index_at(start, cell)
        at(start, cell, INDEX).v = total
    at(start, cells, INDEX).v = robots
    for k in range(robots - 1, -1, -1):
        cell = index_at(spot_of, k)
        spot = index_at(start, cell) - 1
        at(start, cell, INDEX).v = at(spot_of, k, INDEX).v = spot


@njit(error_model="numpy", forceinline=True)
def put_spot(c: Any, row: int, world: int) -> None:
    """Sorting, last: put a robot in its spot."""
    spot, robot = at(c.spots, index_at(c.spot_of, row - world * c.count), SPOT), robot_at(c, row)
    spot.x, spot.y = robot.x, robot.y
    spot.row, spot.id = row, robot.id


@njit(error_model="numpy", forceinline=True)
def wanted(c: Any, robot: Any, own: Any, relation: int) -> Any:
    """Whether a robot is one that is looked for: anyone, a teammate, an opponent, or of team relation - TEAM.

    From SIGNALED on, it must raise that signal too.
    """
    if relation >= SIGNALED:
        if robot.signal != relation // SIGNALED:
            return False
        relation = relation % SIGNALED
    if relation == ANYONE:
        return True
    team = type_at(c, robot.type).team
    if relation == TEAMMATE:
        return team == type_at(c, own.type).team
    if relation == OPPONENT:
        return team != type_at(c, own.type).team
    return team == relation - TEAM


@njit(error_model="numpy", forceinline=True)
def _nearer(c: Any, row: int, relation: int, begin: int, end: int, best: int, best_squared: float) -> Any:
    """The nearest so far (row, squared distance), or a nearer one among the spots from `begin` to `end`."""
    own = robot_at(c, row)
    x, y = own.x, own.y
    for k in range(begin, end):
        spot = at(c.spots, k, SPOT)
        dx, dy = spot.x - x, spot.y - y
        squared = dx * dx + dy * dy
        if squared <= best_squared and spot.row != row:
            if squared == best_squared and best >= 0 and robot_at(c, best).id < spot.id:
                continue
            if relation == ANYONE or wanted(c, robot_at(c, spot.row), own, relation):
                best, best_squared = spot.row, squared
    return best, best_squared


@njit(error_model="numpy")
def _nearer_in_crowd(
    c: Any, row: int, relation: int, column: int, line: int, best: int, best_squared: float
) -> Any:
    """The same, among the robots of one cell: of those small cells that can hold a nearer one."""
    own, shift = robot_at(c, row), c.shift
    reach = min(math.sqrt(best_squared), c.width + c.height) + CLOSE
    low, high, lowest, highest = small_cells(c, own.x, own.y, reach)
    low, high = max(low, column << shift), min(high, ((column + 1) << shift) - 1)
    if low <= high:
        for small in range(max(lowest, line << shift), min(highest, ((line + 1) << shift) - 1) + 1):
            begin = index_at(c.start, small_cell(c, low, small))
            end = index_at(c.start, small_cell(c, high, small) + 1)
            best, best_squared = _nearer(c, row, relation, begin, end, best, best_squared)
    return best, best_squared


@njit(error_model="numpy", forceinline=True)
def _nearer_in_line(
    c: Any, row: int, relation: int, line: int, low: int, high: int, best: int, best_squared: float
) -> Any:
    """The same, among the robots of the cells `low` to `high` of a line, where they lie side by side."""
    if line < 0 or line >= c.lines:
        return best, best_squared
    low, high = max(low, 0), min(high, c.columns - 1)
    small = 2 * c.shift
    begin = index_at(c.start, (line * c.columns + low) << small)
    end = index_at(c.start, (line * c.columns + high + 1) << small)
    if end - begin <= MANY * (high - low + 1) or c.shift == 0:
        return _nearer(c, row, relation, begin, end, best, best_squared)
    for column in range(low, high + 1):
        best, best_squared = _nearer_in_crowd(c, row, relation, column, line, best, best_squared)
    return best, best_squared


@njit(error_model="numpy", forceinline=True)
def _nearest_around(c: Any, row: int, column: int, line: int, limit_squared: float) -> Any:
    """The nearest of all others in a cell and the eight around it, without a guess on the way: that is quick.

    CROWDED where those are many, or two are equally near, and a closer look is needed. None may be in the same place.
    """
    low, high = max(column - 1, 0), min(column + 1, c.columns - 1)
    first, end = spots_of_line(c, line, low, high)
    below, below_end = spots_of_line(c, line - 1, low, high) if line > 0 else (0, 0)
    above, above_end = spots_of_line(c, line + 1, low, high) if line + 1 < c.lines else (0, 0)
    # One loop over all three lines: a processor guesses wrong where a loop ends, and goes back.
    count, count_below = end - first, below_end - below
    both = count + count_below
    total = both + above_end - above
    own = robot_at(c, row)
    x, y, best, best_squared, second = own.x, own.y, -1, limit_squared, math.inf
    if total > 9 * MANY:
        return CROWDED, limit_squared
    below, above = below - count, above - both
    for k in range(total):
        place = (first if k < count else below if k < both else above) + k
        spot = at(c.spots, place, SPOT)
        dx, dy = spot.x - x, spot.y - y
        squared = dx * dx + dy * dy
        squared = squared if squared > 0.0 else math.inf  # itself
        second = min(second, max(squared, best_squared))
        best = place if squared < best_squared else best
        best_squared = min(best_squared, squared)
    if second == best_squared:
        return CROWDED, limit_squared
    return at(c.spots, best, SPOT).row if best >= 0 else -1, best_squared


@njit(error_model="numpy", forceinline=True)
def _nearer_in_ring(
    c: Any, row: int, relation: int, column: int, line: int, ring: int, best: int, best_squared: float
) -> Any:
    """The nearest so far, or a nearer one in the cells that are `ring` cells away."""
    low, high = column - ring, column + ring
    best, best_squared = _nearer_in_line(c, row, relation, line - ring, low, high, best, best_squared)
    best, best_squared = _nearer_in_line(c, row, relation, line + ring, low, high, best, best_squared)
    for between in range(line - ring + 1, line + ring):
        if low >= 0:
            best, best_squared = _nearer_in_line(c, row, relation, between, low, low, best, best_squared)
        if high < c.columns:
            best, best_squared = _nearer_in_line(c, row, relation, between, high, high, best, best_squared)
    return best, best_squared


@njit(error_model="numpy", forceinline=True)
def nearest_robot(c: Any, row: int, world: int, relation: int, limit: float) -> Any:
    """Row and squared distance of the nearest wanted robot within `limit`; -1 and infinite where none is.

    Of robots equally near, the one with the lowest id.
    """
    own = robot_at(c, row)
    best, best_squared = -1, limit * limit
    if not c.gridded:
        for k in range(world * c.count, (world + 1) * c.count):
            them = robot_at(c, k)
            dx, dy = them.x - own.x, them.y - own.y
            squared = dx * dx + dy * dy
            if squared <= best_squared and k != row:
                if squared == best_squared and best >= 0 and robot_at(c, best).id < them.id:
                    continue
                if wanted(c, them, own, relation):
                    best, best_squared = k, squared
        return best, best_squared if best >= 0 else math.inf
    cell = c.cell
    column = min(max(int(own.x * c.per_cell), 0), c.columns - 1)
    line = min(max(int(own.y * c.per_cell), 0), c.lines - 1)
    inside = min(own.x - column * cell, (column + 1) * cell - own.x)
    inside = max(0.0, min(inside, own.y - line * cell, (line + 1) * cell - own.y))
    looked = -1
    quick = relation == ANYONE and not c.passable
    if quick:
        looked, around = _nearest_around(c, row, column, line, best_squared)
        if looked != CROWDED:
            best, best_squared = looked, around
    if not quick or looked == CROWDED:
        best, best_squared = _nearer_in_line(c, row, relation, line, column, column, best, best_squared)
        best, best_squared = _nearer_in_ring(c, row, relation, column, line, 1, best, best_squared)
    for away in range(1, max(c.columns, c.lines)):
        least = max(0.0, away * cell + inside - CLOSE - c.drift)
        if least * least > best_squared:
            break
        best, best_squared = _nearer_in_ring(c, row, relation, column, line, away + 1, best, best_squared)
    return best, best_squared if best >= 0 else math.inf
