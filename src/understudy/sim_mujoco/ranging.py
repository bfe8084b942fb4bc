"""Sonar in physics: rays spread over each sector, the nearest counts, measured from the robot's rim."""

from __future__ import annotations

from math import ceil, cos, radians, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import Column
from understudy.sim.scenario.schema import RobotType, Sonar
from understudy.sim_mujoco.optional import mujoco
from understudy.sim_mujoco.shapes import OBSTACLES, ROBOTS, UNSEEN, WALLS

APART_DEG = 2.5
"""Rays are as far apart at most: 13 cm at 3 m, less than anything solid."""
HEIGHT = 0.7
"""Where rays begin: a share of the robot's radius above the floor, which is within its chassis."""


class Ranging:
    """The rays of one sonar of a type of robots; `names` are its readings, one for each sector."""

    def __init__(self, kind: RobotType, sonar: Sonar) -> None:
        self.names = tuple(sonar.sectors)
        self._radius, self._range = kind.radius, sonar.range
        rays, self._first = list[tuple[float, float, float]](), list[int]()
        for low, high in sonar.sectors.values():
            self._first.append(len(rays))
            width = high - low if high - low >= 360.0 else (high - low) % 360.0
            angles = np.linspace(radians(low), radians(low + width), ceil(width / APART_DEG) + 1)
            rays += [(cos(angle), sin(angle), 0.0) for angle in angles.tolist()]
        self._rays = np.array(rays)
        groups = {"walls": (WALLS,), "obstacles": (OBSTACLES, UNSEEN), "robots": (ROBOTS,)}
        self._groups = np.zeros(6, np.uint8)
        for each in sonar.sees:
            self._groups[list(groups[each])] = 1
        self._hit = np.zeros(len(rays), np.int32)
        self._far = np.zeros(len(rays))

    def distances(self, model: Any, data: Any, body: int) -> Column:
        """How far it is to the nearest thing in each sector, m; the sonar's range where there is none."""
        turn: NDArray[np.float64] = data.xmat[body].reshape(3, 3)
        flat = np.array([turn[0, 0], turn[1, 0], 0.0])
        ahead = flat / np.linalg.norm(flat)
        left = np.array([-ahead[1], ahead[0], 0.0])
        rays = self._rays[:, :1] * ahead + self._rays[:, 1:2] * left
        start = np.array([*data.xpos[body][:2], HEIGHT * self._radius])
        limit = self._range + self._radius
        mujoco().mj_multiRay(
            model,
            data,
            start,
            rays.ravel(),
            self._groups,
            1,
            body,
            self._hit,
            self._far,
            None,
            len(rays),
            limit,
        )
        reached = np.where(self._far < 0.0, limit, self._far)
        nearest: Column = np.minimum.reduceat(reached, self._first)
        return np.clip(nearest - self._radius, 0.0, self._range)
