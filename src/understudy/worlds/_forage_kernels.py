"""Kernels of the foraging world: motion, nearest source, bearings, loading."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

TAU = 2.0 * math.pi


@njit(cache=True)
def nearest(
    x: Floats, y: Floats, source_x: Floats, source_y: Floats, amount: Ints, out_index: Ints, out_range: Floats
) -> None:
    """Index [N] and range [N] (m) of the nearest source with food, of K per world; -1 and NaN where none is.

    Of sources equally near, the one with the lowest id.
    """
    for n in range(x.shape[0]):
        best, best_squared = -1, math.inf
        for k in range(source_x.shape[1]):
            if amount[n, k] > 0:
                dx, dy = source_x[n, k] - x[n], source_y[n, k] - y[n]
                squared = dx * dx + dy * dy
                if squared < best_squared:
                    best, best_squared = k, squared
        out_index[n] = best
        out_range[n] = math.sqrt(best_squared) if best >= 0 else math.nan


@njit(cache=True)
def ranges(x: Floats, y: Floats, to_x: Floats, to_y: Floats, out_range: Floats) -> None:
    """Range [N] (m) of one point per world."""
    for n in range(x.shape[0]):
        dx, dy = to_x[n] - x[n], to_y[n] - y[n]
        out_range[n] = math.sqrt(dx * dx + dy * dy)


@njit(cache=True)
def bearings(
    x: Floats,
    y: Floats,
    heading: Floats,
    points_x: Floats,
    points_y: Floats,
    index: Ints,
    out_bearing: Floats,
) -> None:
    """Bearing [N] (rad, robot frame, in [0, tau)) of point `index[n]` of K per world; NaN where that is -1.

    0 where robot and point coincide.
    """
    for n in range(x.shape[0]):
        k = index[n]
        if k < 0:
            out_bearing[n] = math.nan
            continue
        dx, dy = points_x[n, k] - x[n], points_y[n, k] - y[n]
        if dx == 0.0 and dy == 0.0:
            out_bearing[n] = 0.0
            continue
        bearing = (math.atan2(dy, dx) - heading[n]) % TAU
        out_bearing[n] = bearing if bearing < TAU else 0.0


@njit(cache=True)
def first_not_finite(column: Floats) -> int:
    """The first row whose value is NaN or infinite; -1 where all are finite."""
    for n in range(column.shape[0]):
        if not math.isfinite(column[n]):
            return n
    return -1


@njit(cache=True)
def move(
    x: Floats,
    y: Floats,
    heading: Floats,
    drive: Floats,
    turn: Floats,
    forward_m: float,
    turn_rad: float,
    low: float,
    high_x: float,
    high_y: float,
) -> None:
    """Move N robots for one tick, each along the arc of its commands, in place.

    `drive` and `turn` are commands in [-1, 1] (more is cut off), `forward_m` and `turn_rad` what 1 does in a
    tick. Walls stop what would cross them: x stays in [low, high_x], y in [low, high_y].
    """
    for n in range(x.shape[0]):
        distance = min(1.0, max(-1.0, drive[n])) * forward_m
        angle = min(1.0, max(-1.0, turn[n])) * turn_rad
        if distance != 0.0:
            half = 0.5 * angle
            chord = distance if half == 0.0 else distance * math.sin(half) / half
            x[n] = min(high_x, max(low, x[n] + chord * math.cos(heading[n] + half)))
            y[n] = min(high_y, max(low, y[n] + chord * math.sin(heading[n] + half)))
        if angle != 0.0:
            turned = (heading[n] + angle) % TAU
            heading[n] = turned if turned < TAU else 0.0


@njit(cache=True)
def transfer(
    index: Ints,
    food_range: Floats,
    station_range: Floats,
    reach: float,
    drive: Floats,
    turn: Floats,
    load: Floats,
    unload: Floats,
    load_ticks: int,
    unload_ticks: int,
    capacity: int,
    amount: Ints,
    stored: Ints,
    delivered: Ints,
    loading: Ints,
    unloading: Ints,
) -> None:
    """Load and unload N robots for one tick, in place; a unit moves when its last tick is done.

    Only a robot that stands still works, and only within reach. `loading` and `unloading` count the ticks
    spent on the unit at hand; work that is broken off is lost. A robot told to do both loads.
    """
    for n in range(index.shape[0]):
        still = drive[n] == 0.0 and turn[n] == 0.0
        at_food = index[n] >= 0 and food_range[n] <= reach
        at_station = station_range[n] <= reach
        loads = still and load[n] > 0.0 and at_food and stored[n] < capacity
        unloads = still and load[n] <= 0.0 and unload[n] > 0.0 and at_station and stored[n] > 0
        loading[n] = loading[n] + 1 if loads else 0
        unloading[n] = unloading[n] + 1 if unloads else 0
        if loading[n] >= load_ticks:
            loading[n] = 0
            amount[n, index[n]] -= 1
            stored[n] += 1
        if unloading[n] >= unload_ticks:
            unloading[n] = 0
            stored[n] -= 1
            delivered[n] += 1
