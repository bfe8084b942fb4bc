"""A tick of the standard task, hand-written for this task only, as a reference for a general engine.

There are no collisions, no names, no noise, and every size is known beforehand. Robots are looked up in a grid of 2 m
cells, which is filled again every tick; reading, deciding and moving are one pass over the robots.
"""

from math import atan2, ceil, cos, inf, nan, pi, sin, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.jit.decorators import limit_threads, njit_entry, njit_inner, prange

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Ints32 = NDArray[np.int32]

TAU = 2.0 * pi
CELL = 2.0
LEAF, BELOW = 0, 1
BEACON_RANGE, BEACON_ANGLE, ROBOT_RANGE, ROBOT_ANGLE, SONAR = 0, 1, 2, 3, 4
READINGS = 7

__all__ = ["decide", "grid", "limit_threads", "sonar", "step"]


@njit_entry()
def grid(
    x: Floats, y: Floats, cells: int, first: Ints, members: Ints, grid_x: Floats, grid_y: Floats
) -> None:
    """Sort robots by cell: those of cell c become members[first[c]:first[c + 1]], their positions grid_x and grid_y."""
    first[:] = 0
    for i in range(len(x)):
        first[cell(y[i], cells) * cells + cell(x[i], cells) + 1] += 1
    for c in range(cells * cells):
        first[c + 1] += first[c]
    for i in range(len(x) - 1, -1, -1):
        c = cell(y[i], cells) * cells + cell(x[i], cells) + 1
        first[c] -= 1
        members[first[c]], grid_x[first[c]], grid_y[first[c]] = i, x[i], y[i]
    # Each cell's end was counted down to its beginning: move all by one.
    for c in range(cells * cells):
        first[c] = first[c + 1]
    first[cells * cells] = len(x)


@njit_inner(inline="always")
def cell(at: float, cells: int) -> int:
    """Return the row or column of a coordinate in m."""
    return min(max(int(at / CELL), 0), cells - 1)


@njit_inner()
def nearest_robot(
    i: int,
    x: float,
    y: float,
    cells: int,
    first: Ints,
    members: Ints,
    grid_x: Floats,
    grid_y: Floats,
    sight: float,
) -> tuple[float, float, float]:
    """Return offset (m) and squared range (m²) of the nearest other robot in sight; NaN and infinity if none is."""
    column, row = cell(x, cells), cell(y, cells)
    best, dx, dy = sight * sight, nan, nan
    for ring in range(1, ceil(sight / CELL) + 1):
        left, right = max(column - ring, 0), min(column + ring, cells - 1)
        for r in range(max(row - ring, 0), min(row + ring, cells - 1) + 1):
            for k in range(first[r * cells + left], first[r * cells + right + 1]):
                u, v = grid_x[k] - x, grid_y[k] - y
                squared = u * u + v * v
                if squared <= best and members[k] != i:
                    best, dx, dy = squared, u, v
        if best <= (ring * CELL) ** 2 and dx == dx:
            break
    return dx, dy, best if dx == dx else inf


@njit_inner()
def sonar(
    x: float,
    y: float,
    ahead_x: float,
    ahead_y: float,
    side: float,
    obstacles: Floats,
    radius: float,
    edges: Floats,
    most: float,
    out: Floats,
) -> None:
    """Write to `out` the distance in m from the robot's rim to the nearest obstacle or wall in each sector.

    The robot, with a radius in m, is at x, y and heads along the unit vector `ahead`. The walls are those of a square
    with a corner at 0, 0 and this `side`. `obstacles` [K, 3] are discs (x, y, radius); `edges` [S, 4] the unit
    vectors of each sector's two edges, relative to the heading. A sector with nothing within `most` gets `most`.
    """
    far = most + radius
    for s in range(len(edges)):
        e = edges[s]
        ax, ay = ahead_x * e[0] - ahead_y * e[1], ahead_y * e[0] + ahead_x * e[1]
        bx, by = ahead_x * e[2] - ahead_y * e[3], ahead_y * e[2] + ahead_x * e[3]
        best = far
        for k in range(len(obstacles)):
            dx, dy, size = obstacles[k, 0] - x, obstacles[k, 1] - y, obstacles[k, 2]
            squared = dx * dx + dy * dy
            if squared > (far + size) ** 2:
                continue
            if ax * dy - ay * dx >= 0.0 and dx * by - dy * bx >= 0.0:
                best = min(best, sqrt(squared) - size)
            else:
                best = min(best, ray(ax, ay, dx, dy, squared, size), ray(bx, by, dx, dy, squared, size))
        if x < far or y < far or x > side - far or y > side - far:
            best = min(best, to_wall(x, y, ax, ay, side), to_wall(x, y, bx, by, side))
            if ay < 0.0 < by:
                best = min(best, side - x)
            if ay > 0.0 > by:
                best = min(best, x)
            if ax < 0.0 < bx:
                best = min(best, y)
            if ax > 0.0 > bx:
                best = min(best, side - y)
        out[SONAR + s] = min(max(best - radius, 0.0), most)


@njit_inner(inline="always")
def ray(ex: float, ey: float, dx: float, dy: float, squared: float, size: float) -> float:
    """Return the distance at which a ray in direction e hits a disc at offset d; infinite if it misses."""
    along = ex * dx + ey * dy
    beside = size * size - (squared - along * along)
    return along - sqrt(beside) if along > 0.0 and beside > 0.0 else inf


@njit_inner(inline="always")
def to_wall(x: float, y: float, ex: float, ey: float, side: float) -> float:
    """Return the distance to the arena's bounds in direction e."""
    across = (side - x) / ex if ex > 0.0 else -x / ex if ex < 0.0 else inf
    return min(across, (side - y) / ey if ey > 0.0 else -y / ey if ey < 0.0 else inf)


@njit_inner(inline="always")
def around(angle: float) -> float:
    """Return an angle, off by at most one turn, in [0, tau)."""
    angle += TAU if angle < 0.0 else 0.0
    angle += TAU if angle < 0.0 else 0.0
    return angle - TAU if angle >= TAU else angle


@njit_inner()
def decide(
    stack: Ints32,
    tests: Ints32,
    numbers: Floats,
    roots: Ints32,
    children: Ints32,
    flags: Ints32,
    starts: Ints32,
    values: Floats,
) -> int:
    """Update all levels as the interpreter does, and return the basic state that is reached."""
    level = 0
    while True:
        state = int(stack[level])
        up = flags[stack[level + 1]] if children[state] >= 0 else -1
        node = roots[state]
        following = state
        if node >= 0:
            while tests[node, 0] != LEAF:
                asked = tests[node, 1]
                if asked >= READINGS:
                    holds = up == asked - READINGS
                elif tests[node, 0] == BELOW:
                    holds = values[asked] < numbers[node, 1]
                else:
                    low, high, value = numbers[node, 0], numbers[node, 1], values[asked]
                    holds = low <= value < high if low <= high else value >= low or value < high
                node = tests[node, 2] if holds else tests[node, 3]
            following = int(tests[node, 2])
        if following != state:
            stack[level] = following
            if children[following] >= 0:
                stack[level + 1] = starts[children[following]]
        if children[following] < 0:
            return following
        level += 1


@njit_entry(parallel=True)
def step(
    chunks: int,
    place: Floats,
    moved: Floats,
    stack: Ints32,
    beacons: Floats,
    obstacles: Floats,
    edges: Floats,
    sizes: tuple[float, ...],
    table: tuple[Any, ...],
    gridded: tuple[Any, ...],
) -> None:
    """Run one tick for all robots, from `place` [3, N] to `moved`."""
    tests, numbers, roots, children, flags, starts, commands = table
    cells, first, members, grid_x, grid_y = gridded
    robots = place.shape[1]
    side, radius, sight, most, drive, turn = sizes
    for chunk in prange(chunks):
        values = np.empty(READINGS)
        for i in range(robots * chunk // chunks, robots * (chunk + 1) // chunks):
            x, y, heading = place[0, i], place[1, i], place[2, i]
            ahead_x, ahead_y = cos(heading), sin(heading)
            best, dx, dy = inf, nan, nan
            for k in range(len(beacons)):
                u, v = beacons[k, 0] - x, beacons[k, 1] - y
                squared = u * u + v * v
                if squared < best:
                    best, dx, dy = squared, u, v
            values[BEACON_RANGE], values[BEACON_ANGLE] = sqrt(best), around(atan2(dy, dx) - heading)
            dx, dy, best = nearest_robot(i, x, y, cells, first, members, grid_x, grid_y, sight)
            values[ROBOT_RANGE], values[ROBOT_ANGLE] = nan, nan
            if best < inf:
                values[ROBOT_RANGE], values[ROBOT_ANGLE] = sqrt(best), around(atan2(dy, dx) - heading)
            if len(edges):
                sonar(x, y, ahead_x, ahead_y, side, obstacles, radius, edges, most, values)
            state = decide(stack[i], tests, numbers, roots, children, flags, starts, values)
            along = commands[state, 0] * drive
            moved[0, i] = min(max(x + along * ahead_x, radius), side - radius)
            moved[1, i] = min(max(y + along * ahead_y, radius), side - radius)
            moved[2, i] = around(heading + commands[state, 1] * turn)
