"""The base task in plain NumPy, written to be read: what every peer must compute."""

from __future__ import annotations

import numpy as np

from understudy_lab.bench import standard_task
from understudy_lab.bench.standard_task import AHEAD, ARRIVED, PERSONAL, Column, StartLayout

TAU = 2 * np.pi


class Reference:
    """N robots; all pairs are measured."""

    def __init__(self, robots: int, seed: int = 0) -> None:
        self.side = standard_task.side(robots)
        self.start = StartLayout.of(robots, seed)
        self.x, self.y, self.heading = self.start.x, self.start.y, self.start.heading

    @property
    def places(self) -> Column:
        return np.column_stack([self.x, self.y, self.heading])

    @property
    def readings(self) -> Column:
        """Range and bearing of the nearest beacon, and of the nearest other robot within sight [N, 4]."""
        beacon = self._nearest(self.start.beacon_x, self.start.beacon_y, others=False)
        robot = self._nearest(self.x, self.y, others=True)
        robot[robot[:, 0] > standard_task.SIGHT] = np.nan
        return np.hstack([beacon, robot])

    def _nearest(self, x: Column, y: Column, *, others: bool) -> Column:
        dx, dy = x - self.x[:, None], y - self.y[:, None]
        distances = np.hypot(dx, dy)
        if others:
            np.fill_diagonal(distances, np.inf)
        rows, which = np.arange(len(self.x)), distances.argmin(1)
        bearing = (np.arctan2(dy[rows, which], dx[rows, which]) - self.heading) % TAU
        return np.column_stack([distances[rows, which], bearing])

    def run(self, ticks: int) -> None:
        for _ in range(ticks):
            decided = [decide(*row) for row in self.readings]
            drive = np.array([drive for drive, _ in decided]) * standard_task.STEP
            turn = np.array([turn for _, turn in decided]) * standard_task.TURN
            low, high = standard_task.RADIUS, self.side - standard_task.RADIUS
            self.x = np.clip(self.x + drive * np.cos(self.heading), low, high)
            self.y = np.clip(self.y + drive * np.sin(self.heading), low, high)
            self.heading = (self.heading + turn) % TAU


def decide(beacon: float, angle: float, robot: float, bearing: float) -> tuple[float, float]:
    """Drive and turn."""
    if robot < PERSONAL and (bearing < np.pi / 2 or bearing >= TAU - np.pi / 2):
        return 0.0, (-1.0 if bearing < np.pi else 1.0)
    if beacon < ARRIVED:
        return 0.0, 0.0
    if angle < AHEAD or angle >= TAU - AHEAD:
        return 1.0, 0.0
    return 0.0, (1.0 if angle < np.pi else -1.0)
