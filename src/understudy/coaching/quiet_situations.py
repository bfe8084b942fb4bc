"""Quiet situations: how many in a row a robot that is taught live has mastered without a press.

A single situation that goes well says little. A demonstrator can stop when several in a row needed no press.
"""

from __future__ import annotations

LEAST_S = 10.0
"""The time, s, from which on a situation counts; it also counts once the robot has raised a flag."""


class QuietSituations:
    """The number of situations in a row, up to the last one that is over, in which nothing was pressed."""

    def __init__(self) -> None:
        self.count = 0
        self._begin()

    def _begin(self) -> None:
        self._watched_s, self._over, self._pressed = 0.0, False, False

    def note_tick(self, seconds: float, *, flag: str | None) -> None:
        """Note that the demonstrator watched the robot act for a time, s, and the flag that it has raised."""
        self._watched_s += seconds
        self._over |= flag is not None

    def note_press(self) -> None:
        """Note a press: from here on, the count begins again."""
        self._pressed, self.count = True, 0

    def begin_situation(self) -> None:
        """Begin another situation, as in another world, and count the present one if enough of it was seen."""
        if not self._pressed and (self._over or self._watched_s >= LEAST_S - 1e-9):
            self.count += 1
        self._begin()

    @property
    def sentence(self) -> str:
        """The count in words; empty for none."""
        return f"{self.count} in a row without a press" if self.count else ""
