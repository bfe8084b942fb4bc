"""How fast the world goes: ticks that are due, and the demonstrator's time, which stops while paused."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil
from typing import TypeAlias

Wall: TypeAlias = Callable[[], float]
"""A clock that only goes forward, s."""

SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
LONGEST_STALL_S = 0.25
"""What is made up for after a stall; a longer one is let go, so that the world never races."""


class Pace:
    """The world's clockwork; it stands still at first."""

    def __init__(self, wall: Wall, *, tick_s: float) -> None:
        self.speed = 1.0
        self._wall, self._tick_s = wall, tick_s
        self._going = False
        self._last = wall()
        self._time_s = self._owed_s = 0.0

    @property
    def time_s(self) -> float:
        """The demonstrator's time, s: real time, without the pauses."""
        self._advance()
        return self._time_s

    def go(self) -> None:
        """Let time pass."""
        self._advance()
        self._going = True

    def stop(self) -> None:
        """Let time stand still."""
        self._advance()
        self._going = False
        self._owed_s = 0.0

    def step(self) -> None:
        """One tick is taken while time stands still."""
        self._time_s += self._tick_s

    def due(self) -> int:
        """Ticks to take now."""
        self._advance()
        ticks = int(self._owed_s / self._tick_s + 1e-6)
        most = max(1, ceil(LONGEST_STALL_S * self.speed / self._tick_s))
        self._owed_s = 0.0 if ticks > most else self._owed_s - ticks * self._tick_s
        return min(ticks, most)

    def faster(self) -> None:
        """The next higher speed, if there is one."""
        self.speed = SPEEDS[min(SPEEDS.index(self.speed) + 1, len(SPEEDS) - 1)]

    def slower(self) -> None:
        """The next lower speed, if there is one."""
        self.speed = SPEEDS[max(SPEEDS.index(self.speed) - 1, 0)]

    def _advance(self) -> None:
        now = self._wall()
        passed, self._last = now - self._last, now
        if self._going:
            self._time_s += passed
            self._owed_s += passed * self.speed
