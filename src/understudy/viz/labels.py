"""Place labels in a picture where they cover least."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.viz.appearance import ObjectMark
from understudy.viz.palette import GROUND

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Side: TypeAlias = Literal["center", "left", "right"]
LabelBox: TypeAlias = tuple[float, float, float, float]
LETTER_IN, LINE_IN, OFF_IN = 0.088, 0.14, 0.137  # of the labels' type, on paper
MOST_POINTS = 20_000


class Labels:
    """A placer of labels in an arena, which avoids what is drawn there and earlier labels."""

    def __init__(
        self, axes: Axes, size: tuple[float, float], crowd: NDArray[np.float64], *, inch: float
    ) -> None:
        """Avoid covering the points `crowd` [P, 2] (m); `inch` is the length (m) that one inch on paper shows."""
        self._axes, self._size, self._inch = axes, size, inch
        self._crowd = crowd[:: max(1, len(crowd) // MOST_POINTS)]
        self._taken: list[LabelBox] = []

    def keep_free(self, things: Sequence[ObjectMark]) -> None:
        """Avoid these objects in all later labels."""
        for thing in things:
            self._taken.append(
                (thing.x - thing.size, thing.y - thing.size, thing.x + thing.size, thing.y + thing.size)
            )

    def place_label(self, thing: ObjectMark, around: float) -> None:
        """Write an object's label below, above or beside it, at least `around` (m) from its center."""
        from matplotlib.patheffects import withStroke

        off = around + OFF_IN * self._inch
        beside = off - 0.4 * OFF_IN * self._inch
        sides: list[tuple[float, float, Side]] = [
            (thing.x, thing.y - off, "center"),
            (thing.x, thing.y + off, "center"),
            (thing.x + beside, thing.y, "left"),
            (thing.x - beside, thing.y, "right"),
        ]
        x, y, align = min(sides, key=lambda side: self._cost(self._box(thing.label, *side)))
        self._taken.append(self._box(thing.label, x, y, align))
        text = self._axes.text(
            x,
            y,
            thing.label,
            color=thing.color,
            fontsize=9.5,
            fontweight="bold",
            zorder=9,
            ha=align,
            va="center",
        )
        text.set_path_effects([withStroke(linewidth=3, foreground=GROUND)])

    def _box(self, label: str, x: float, y: float, align: Side) -> LabelBox:
        half = LETTER_IN * len(label) * self._inch / 2
        middle = x + {"center": 0.0, "left": half, "right": -half}[align]
        return middle - half, y - LINE_IN * self._inch / 2, middle + half, y + LINE_IN * self._inch / 2

    def _cost(self, box: LabelBox) -> tuple[bool, int, int]:
        left, low, right, high = box
        outside = left < 0 or low < 0 or right > self._size[0] or high > self._size[1]
        over = sum(
            left < other[2] and other[0] < right and low < other[3] and other[1] < high
            for other in self._taken
        )
        x, y = self._crowd.T
        wide = 0.06 * self._inch
        covered = (x > left - wide) & (x < right + wide) & (y > low - wide) & (y < high + wide)
        return outside, over, int(covered.sum())
