"""What the trainer remembers of a run for the eye: where the robot was, and how its readings went."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from understudy.training.session_view import SessionView

TRAIL_POINTS = 400
READINGS = 60


class RecentHistory:
    """The last moments of a run, forgotten where the world begins anew."""

    def __init__(self) -> None:
        self.trail: deque[tuple[float, float]] = deque(maxlen=TRAIL_POINTS)
        self._readings: dict[str, deque[float]] = {}

    def see(self, x: float, y: float, screen: SessionView) -> None:
        """A tick passed."""
        if not self.trail or (self.trail[-1][0] - x) ** 2 + (self.trail[-1][1] - y) ** 2 > 0.01:
            self.trail.append((x, y))
        for label, number in screen.features.items():
            self._readings.setdefault(label, deque(maxlen=READINGS)).append(number)

    def readings(self, label: str) -> Sequence[float]:
        """The last values of a feature, oldest first."""
        return tuple(self._readings.get(label, ()))

    def forget(self) -> None:
        """Another world."""
        self.trail.clear()
        self._readings.clear()
