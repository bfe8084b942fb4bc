"""A table like the UCI wall-following data set: 24 sonar distances of a robot that follows walls, and what it does."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

ROWS, SONARS, FARTHEST_M = 5456, 24, 5.0
NOISE_M = 0.01
"""The spread of a sonar's error at all distances."""
TICK_S = 1 / 9
WALLS = np.array(
    [  # of a room of 8 by 6 m with a niche, a cupboard and a pillar: x and y of both ends
        *[(0, 0, 8, 0), (8, 0, 8, 6), (8, 6, 5, 6), (5, 6, 5, 5), (5, 5, 3.2, 5), (3.2, 5, 3.2, 6)],
        *[(3.2, 6, 0, 6), (0, 6, 0, 0), (0, 2.6, 1.0, 2.6), (1.0, 2.6, 1.0, 3.4), (1.0, 3.4, 0, 3.4)],
        *[(3.6, 2.4, 4.4, 2.4), (4.4, 2.4, 4.4, 3.2), (4.4, 3.2, 3.6, 3.2), (3.6, 3.2, 3.6, 2.4)],
    ]
)
FORWARD, SHARP_RIGHT, SLIGHT_RIGHT, SLIGHT_LEFT = range(4)
ACTIONS = ("Move-Forward", "Sharp-Right-Turn", "Slight-Right-Turn", "Slight-Left-Turn")
MOTIONS = ((0.3, 0.0), (0.05, -0.9), (0.2, -0.4), (0.2, 0.5))
"""The speed (m/s) and turn rate (rad/s) of each action."""
AHEAD, LEFT = (22, 23, 0, 1, 2), (3, 4, 5, 6, 7, 8)
"""The sonars whose nearest echo counts as the distance ahead and to the left; sonar n looks n times 15° to the left."""


def drive_along_walls(rows: int = ROWS, *, seed: int = 0) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Drive a robot along the walls on its left, by the rule of the data set.

    Parameters
    ----------
    rows
        The number of ticks, of a ninth of a second.
    seed
        The seed of the sonars' noise and of the wheels' slip.

    Returns
    -------
    values : array, shape [rows, 24]
        The distances that the sonars measure, in m, with three decimals.
    actions : int array, shape [rows]
        Indices of `ACTIONS`.
    """
    random = np.random.default_rng(seed)
    values, actions = np.empty((rows, SONARS)), np.empty(rows, np.int64)
    x, y, heading = 4.0, 0.8, pi
    for row in range(rows):
        angles = heading + np.arange(SONARS) * (2 * pi / SONARS)
        measured = measure_distances(x, y, angles) + random.normal(0.0, NOISE_M, SONARS)
        values[row] = np.round(np.clip(measured, 0.0, FARTHEST_M), 3)
        actions[row] = decide(values[row])
        speed, rate = MOTIONS[actions[row]]
        heading += (rate + random.normal(0.0, 0.1)) * TICK_S
        x, y = x + speed * TICK_S * np.cos(heading), y + speed * TICK_S * np.sin(heading)
    return values, actions


def measure_distances(x: float, y: float, angles: NDArray[Any]) -> NDArray[np.float64]:
    """Measure the distance (m) from a place to the nearest wall in each direction (rad), `FARTHEST_M` at most."""
    from_x, from_y, to_x, to_y = WALLS.T
    along = np.cos(angles)[:, None], np.sin(angles)[:, None]
    wall = to_x - from_x, to_y - from_y
    cross = along[0] * wall[1] - along[1] * wall[0]
    cross = np.where(np.abs(cross) < 1e-12, np.nan, cross)  # a wall along the ray is not hit
    away = from_x - x, from_y - y
    distance = (away[0] * wall[1] - away[1] * wall[0]) / cross
    place = (away[0] * along[1] - away[1] * along[0]) / cross
    hit = (distance > 0) & (place >= 0) & (place <= 1)
    return np.asarray(np.min(np.where(hit, distance, FARTHEST_M), axis=1), np.float64)


def decide(distances: NDArray[np.float64]) -> int:
    """Decide what to do by the data set's rule: keep 0.55 to 0.9 m from the wall on the left."""
    ahead, left = distances[list(AHEAD)].min(), distances[list(LEFT)].min()
    if ahead <= 0.9:
        return SHARP_RIGHT
    if left > 0.9:
        return SLIGHT_LEFT
    return SLIGHT_RIGHT if left < 0.55 else FORWARD
