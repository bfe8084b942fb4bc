"""The last moments of a run: where the robot was, and what its features were."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from understudy.training.trainee import SessionView

TRAIL_POINTS = 400
"""The number of places in the trail of a robot."""
READINGS = 60
"""The number of values of each feature."""


class RecentHistory:
    """The last moments of a run, cleared when a world begins."""

    def __init__(self) -> None:
        self.trail: deque[tuple[float, float]] = deque(maxlen=TRAIL_POINTS)
        self._readings: dict[str, deque[float]] = {}

    def append(self, x: float, y: float, view: SessionView) -> None:
        """Add a tick."""
        if not self.trail or (self.trail[-1][0] - x) ** 2 + (self.trail[-1][1] - y) ** 2 > 0.01:
            self.trail.append((x, y))
        for label, number in view.features.items():
            self._readings.setdefault(label, deque(maxlen=READINGS)).append(number)

    def readings(self, label: str) -> Sequence[float]:
        """Return the last values of a feature, oldest first."""
        return tuple(self._readings.get(label, ()))

    def clear(self) -> None:
        """Clear the history."""
        self.trail.clear()
        self._readings.clear()
