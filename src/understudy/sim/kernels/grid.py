"""Kernels of the grid of robots: sort robots by cell, and find the nearest robot.

Cells are numbered by column and line, and each is divided into small cells. A spot is a robot's entry in the sorted
order; the spots of a cell are adjacent.
"""

import math
from typing import Any

from understudy.jit.decorators import inlined, inner, int64, uint64
from understudy.sim.kernels.dtypes import ANYONE, OPPONENT, TEAM, TEAMMATE

CLOSE = 1e-9  # m; what rounding may do to the border between two cells
MANY = 8  # robots in a cell; where there are more, its small cells are looked at one by one

CROWDED = -2
SIGNALED = 1 << 32  # a relation to robots that raise a signal: the relation + SIGNALED * the signal


@inlined
def index_small_cell(c: Any, column: int, line: int) -> Any:
    """Return the index of the small cell in this column and line of small cells."""
    shift = c.facts.shift
    mask = (1 << shift) - 1
    big = (line >> shift) * c.facts.columns + (column >> shift)
    return (((big << shift) + (line & mask)) << shift) + (column & mask)


@inlined
def find_big_cells(c: Any, x: float, y: float, reach: float) -> Any:
    """Return first and last column, first and last line of cells that may hold robots within `reach` (m) of a place."""
    reach += c.facts.drift
    return (
        max(int((x - reach) * c.facts.per_cell), 0),
        min(int((x + reach) * c.facts.per_cell), c.facts.columns - 1),
        max(int((y - reach) * c.facts.per_cell), 0),
        min(int((y + reach) * c.facts.per_cell), c.facts.lines - 1),
    )


@inlined
def find_line_spots(c: Any, line: int, low: int, high: int) -> Any:
    """Return the first spot, and one after the last, of the cells in columns `low` to `high` of a line."""
    small = 2 * c.facts.shift
    begin = int64(c.start[uint64((line * c.facts.columns + low) << small)])
    return begin, int64(c.start[uint64((line * c.facts.columns + high + 1) << small)])


@inlined
def find_small_cells(c: Any, x: float, y: float, reach: float) -> Any:
    """Return first and last column, first and last line of small cells that may hold robots within `reach` (m)."""
    reach += c.facts.drift
    per_m = (1 << c.facts.shift) * c.facts.per_cell
    last_column, last_line = (c.facts.columns << c.facts.shift) - 1, (c.facts.lines << c.facts.shift) - 1
    return (
        min(max(int((x - reach) * per_m), 0), last_column),
        min(max(int((x + reach) * per_m), 0), last_column),
        min(max(int((y - reach) * per_m), 0), last_line),
        min(max(int((y + reach) * per_m), 0), last_line),
    )


@inlined
def find_static_range(c: Any, x: float, y: float, world: int) -> Any:
    """Return the range (first, one after the last) in `near_items` of the fixed things near a place."""
    column = min(max(int(x * c.facts.near_per_cell), 0), c.facts.near_columns - 1)
    line = min(max(int(y * c.facts.near_per_cell), 0), c.facts.near_lines - 1)
    cell = (world * c.facts.near_lines + line) * c.facts.near_columns + column
    return c.near_start[cell], c.near_start[cell + 1]


@inlined
def note_robot_cell(c: Any, row: int, world: int) -> None:
    """Write the index of a robot's small cell to `spot_of`: the first step of sorting."""
    robot = c.robots[uint64(row)]
    column, _, line, _ = find_small_cells(c, robot.x, robot.y, 0.0)
    c.spot_of[row - world * c.facts.count] = index_small_cell(c, column, line)


@inner
def count_cells(c: Any) -> None:
    """Count the robots in each small cell and assign their spots: the second step of sorting.

    Robots of one cell keep the order of their rows.
    """
    cells, robots = (c.facts.columns * c.facts.lines) << (2 * c.facts.shift), c.facts.count
    start, spot_of = c.start, c.spot_of  # local names, else they are looked up again after every change
    for cell in range(cells):
        start[cell] = 0
    for k in range(robots):
        start[int64(spot_of[k])] += 1
    total = 0
    for cell in range(cells):
        total += int64(start[cell])
        start[cell] = total
    start[cells] = robots
    for k in range(robots - 1, -1, -1):
        cell = int64(spot_of[k])
        spot = int64(start[cell]) - 1
        start[cell] = spot_of[k] = spot


@inlined
def place_in_spot(c: Any, row: int, world: int) -> None:
    """Copy a robot's place, row and id into its spot: the last step of sorting."""
    spot, robot = c.spots[int64(c.spot_of[row - world * c.facts.count])], c.robots[row]
    spot.x, spot.y = robot.x, robot.y
    spot.row, spot.id = row, robot.id


@inlined
def matches_relation(c: Any, robot: Any, own: Any, relation: int) -> Any:
    """Return whether a robot has a relation to `own`: ANYONE, TEAMMATE, OPPONENT, or TEAM + its team's index.

    A relation of SIGNALED * signal or more also requires that the robot raises this signal.
    """
    if relation >= SIGNALED:
        if robot.signal != relation // SIGNALED:
            return False
        relation = relation % SIGNALED
    if relation == ANYONE:
        return True
    team = c.types[robot.type].team
    if relation == TEAMMATE:
        return team == c.types[own.type].team
    if relation == OPPONENT:
        return team != c.types[own.type].team
    return team == relation - TEAM


@inlined
def _nearer(c: Any, row: int, relation: int, begin: int, end: int, best: int, best_squared: float) -> Any:
    """Return row and squared distance (m**2) of the nearer one of `best` and the robots in spots `begin` to `end`."""
    own = c.robots[uint64(row)]
    x, y = own.x, own.y
    for k in range(begin, end):
        spot = c.spots[uint64(k)]
        dx, dy = spot.x - x, spot.y - y
        squared = dx * dx + dy * dy
        if squared <= best_squared and spot.row != row:
            if squared == best_squared and best >= 0 and c.robots[best].id < spot.id:
                continue
            if relation == ANYONE or matches_relation(c, c.robots[spot.row], own, relation):
                best, best_squared = spot.row, squared
    return best, best_squared


@inner
def _nearer_in_crowd(
    c: Any, row: int, relation: int, column: int, line: int, best: int, best_squared: float
) -> Any:
    """Return the nearer one of `best` and the robots of one cell, searching only small cells that are near enough."""
    own, shift = c.robots[row], c.facts.shift
    reach = min(math.sqrt(best_squared), c.facts.width + c.facts.height) + CLOSE
    low, high, lowest, highest = find_small_cells(c, own.x, own.y, reach)
    low, high = max(low, column << shift), min(high, ((column + 1) << shift) - 1)
    if low <= high:
        for small in range(max(lowest, line << shift), min(highest, ((line + 1) << shift) - 1) + 1):
            begin = int64(c.start[index_small_cell(c, low, small)])
            end = int64(c.start[index_small_cell(c, high, small) + 1])
            best, best_squared = _nearer(c, row, relation, begin, end, best, best_squared)
    return best, best_squared


@inlined
def _nearer_in_line(
    c: Any, row: int, relation: int, line: int, low: int, high: int, best: int, best_squared: float
) -> Any:
    """Return row and squared distance of the nearest of `best` and the robots in columns `low` to `high` of a line."""
    if line < 0 or line >= c.facts.lines:
        return best, best_squared
    low, high = max(low, 0), min(high, c.facts.columns - 1)
    small = 2 * c.facts.shift
    begin = int64(c.start[uint64((line * c.facts.columns + low) << small)])
    end = int64(c.start[uint64((line * c.facts.columns + high + 1) << small)])
    if end - begin <= MANY * (high - low + 1) or c.facts.shift == 0:
        return _nearer(c, row, relation, begin, end, best, best_squared)
    for column in range(low, high + 1):
        best, best_squared = _nearer_in_crowd(c, row, relation, column, line, best, best_squared)
    return best, best_squared


@inlined
def _nearest_around(c: Any, row: int, column: int, line: int, limit_squared: float) -> Any:
    """Return row and squared distance of the nearest robot in a cell and the eight around it, with few branches.

    Returns CROWDED instead of a row if there are many robots or two are equally near, so that a full search is
    needed. No two robots may be at the same place.
    """
    low, high = max(column - 1, 0), min(column + 1, c.facts.columns - 1)
    first, end = find_line_spots(c, line, low, high)
    below, below_end = find_line_spots(c, line - 1, low, high) if line > 0 else (0, 0)
    above, above_end = find_line_spots(c, line + 1, low, high) if line + 1 < c.facts.lines else (0, 0)
    # One loop over all three lines: a processor guesses wrong where a loop ends, and goes back.
    count, count_below = end - first, below_end - below
    both = count + count_below
    total = both + above_end - above
    own = c.robots[uint64(row)]
    x, y, best, best_squared, second = own.x, own.y, -1, limit_squared, math.inf
    if total > 9 * MANY:
        return CROWDED, limit_squared
    below, above = below - count, above - both
    for k in range(total):
        place = (first if k < count else below if k < both else above) + k
        spot = c.spots[uint64(place)]
        dx, dy = spot.x - x, spot.y - y
        squared = dx * dx + dy * dy
        squared = squared if squared > 0.0 else math.inf  # itself
        second = min(second, max(squared, best_squared))
        best = place if squared < best_squared else best
        best_squared = min(best_squared, squared)
    if second == best_squared:
        return CROWDED, limit_squared
    return c.spots[best].row if best >= 0 else -1, best_squared


@inlined
def _nearer_in_ring(
    c: Any, row: int, relation: int, column: int, line: int, ring: int, best: int, best_squared: float
) -> Any:
    """Return the nearer one of `best` and the robots in the cells that are `ring` cells away."""
    low, high = column - ring, column + ring
    best, best_squared = _nearer_in_line(c, row, relation, line - ring, low, high, best, best_squared)
    best, best_squared = _nearer_in_line(c, row, relation, line + ring, low, high, best, best_squared)
    for between in range(line - ring + 1, line + ring):
        if low >= 0:
            best, best_squared = _nearer_in_line(c, row, relation, between, low, low, best, best_squared)
        if high < c.facts.columns:
            best, best_squared = _nearer_in_line(c, row, relation, between, high, high, best, best_squared)
    return best, best_squared


@inlined
def find_nearest_robot(c: Any, row: int, world: int, relation: int, limit: float) -> Any:
    """Return row and squared distance (m**2) of the nearest robot of a relation within `limit` (m).

    The row is -1 and the distance infinite if there is none. Of robots equally near, it is the one with the lowest
    id.
    """
    own = c.robots[uint64(row)]
    best, best_squared = -1, limit * limit
    if not c.facts.gridded:
        for k in range(world * c.facts.count, (world + 1) * c.facts.count):
            them = c.robots[k]
            dx, dy = them.x - own.x, them.y - own.y
            squared = dx * dx + dy * dy
            if squared <= best_squared and k != row:
                if squared == best_squared and best >= 0 and c.robots[best].id < them.id:
                    continue
                if matches_relation(c, them, own, relation):
                    best, best_squared = k, squared
        return best, best_squared if best >= 0 else math.inf
    cell = c.facts.cell
    column = min(max(int(own.x * c.facts.per_cell), 0), c.facts.columns - 1)
    line = min(max(int(own.y * c.facts.per_cell), 0), c.facts.lines - 1)
    inside = min(own.x - column * cell, (column + 1) * cell - own.x)
    inside = max(0.0, min(inside, own.y - line * cell, (line + 1) * cell - own.y))
    looked = -1
    quick = relation == ANYONE and not c.facts.passable
    if quick:
        looked, around = _nearest_around(c, row, column, line, best_squared)
        if looked != CROWDED:
            best, best_squared = looked, around
    if not quick or looked == CROWDED:
        best, best_squared = _nearer_in_line(c, row, relation, line, column, column, best, best_squared)
        best, best_squared = _nearer_in_ring(c, row, relation, column, line, 1, best, best_squared)
    for away in range(1, max(c.facts.columns, c.facts.lines)):
        least = max(0.0, away * cell + inside - CLOSE - c.facts.drift)
        if least * least > best_squared:
            break
        best, best_squared = _nearer_in_ring(c, row, relation, column, line, away + 1, best, best_squared)
    return best, best_squared if best >= 0 else math.inf
