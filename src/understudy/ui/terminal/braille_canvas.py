"""A canvas of characters: dots, 2 x 4 per character as braille, with text on top."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import groupby
from math import cos, hypot, sin, tau
from operator import itemgetter
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

Floats: TypeAlias = NDArray[np.float64]
Bools: TypeAlias = NDArray[np.bool_]

BRAILLE = 0x2800
DOTS = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))
"""The bit of a dot, by its column and line within a character."""
DENSE = (2, 6)
"""The number of points in a character beyond which it is drawn as dense, and as densest."""


class BrailleCanvas:
    """A canvas of columns and lines that shows a rectangle `width` x `height`, in m, y upward."""

    def __init__(self, columns: int, lines: int, *, width: float, height: float) -> None:
        self.columns, self.lines = columns, lines
        self._width, self._height = width, height
        self._dots: dict[tuple[int, int], tuple[int, str]] = {}
        self._text: dict[tuple[int, int], tuple[str, str]] = {}

    def dot(self, x: float, y: float, style: str = "") -> None:
        """Draw a dot, unless it lies outside."""
        column = int(x / self._width * self.columns * 2)
        line = int((self._height - y) / self._height * self.lines * 4)
        if 0 <= column < self.columns * 2 and 0 <= line < self.lines * 4 and x >= 0 and y <= self._height:
            place = line // 4, column // 2
            bits, _ = self._dots.get(place, (0, ""))
            self._dots[place] = bits | DOTS[column % 2][line % 4], style

    def dots(self, points: Iterable[tuple[float, float]], style: str = "") -> None:
        """Draw a dot at each point."""
        for x, y in points:
            self.dot(x, y, style)

    def line(
        self, start: tuple[float, float], end: tuple[float, float], style: str = "", *, every: float
    ) -> None:
        """Draw a line of dots, `every` m apart."""
        length = hypot(end[0] - start[0], end[1] - start[1])
        for step in range(int(length / every) + 1):
            part = step * every / length if length else 0.0
            self.dot(start[0] + part * (end[0] - start[0]), start[1] + part * (end[1] - start[1]), style)

    def circle(self, x: float, y: float, radius: float, style: str = "") -> None:
        """Draw a circle of dots."""
        count = max(12, int(tau * radius / self._width * self.columns * 2))
        self.dots(
            (
                (x + radius * cos(tau * step / count), y + radius * sin(tau * step / count))
                for step in range(count)
            ),
            style,
        )

    def fill(self, inside: Callable[[Floats, Floats], Bools], style: str = "") -> None:
        """Draw a dot at each place that passes a test."""
        x = (np.arange(self.columns * 2) + 0.5) * self._width / (self.columns * 2)
        y = self._height - (np.arange(self.lines * 4) + 0.5) * self._height / (self.lines * 4)
        grid_x, grid_y = np.meshgrid(x, y)
        chosen = inside(grid_x, grid_y)
        self.dots(zip(grid_x[chosen].tolist(), grid_y[chosen].tolist(), strict=True), style)

    def disc(self, x: float, y: float, radius: float, style: str = "") -> None:
        """Draw a filled circle."""
        self.fill(lambda px, py: np.hypot(px - x, py - y) <= radius, style)

    def polygon(self, corners: Floats, style: str = "") -> None:
        """Draw a filled polygon [P, 2]."""

        def inside(x: Floats, y: Floats) -> Bools:
            odd = np.zeros(x.shape, np.bool_)
            for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
                if y0 != y1:
                    odd ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
            return odd

        self.fill(inside, style)

    def scatter(self, x: Floats, y: Floats, styles: Sequence[str]) -> None:
        """Draw a dot for each of many points [N], with a style per density, from thin to dense."""
        column = np.clip(x / self._width * self.columns * 2, 0, self.columns * 2 - 1).astype(np.int64)
        line = np.clip((self._height - y) / self._height * self.lines * 4, 0, self.lines * 4 - 1).astype(
            np.int64
        )
        cells, counts = np.unique(line // 4 * self.columns + column // 2, return_counts=True)
        bits = np.zeros(self.lines * self.columns, np.int64)
        np.bitwise_or.at(bits, line // 4 * self.columns + column // 2, np.array(DOTS)[column % 2, line % 4])
        dense = np.searchsorted(DENSE, counts).clip(max=len(styles) - 1)
        for cell, how in zip(cells.tolist(), dense.tolist(), strict=True):
            self._dots[cell // self.columns, cell % self.columns] = int(bits[cell]), styles[how]

    def text(self, x: float, y: float, text: str, style: str = "") -> None:
        """Write text whose first character is at a point, and keep it inside."""
        column = max(0, min(int(x / self._width * self.columns), self.columns - len(text)))
        line = max(0, min(int((self._height - y) / self._height * self.lines), self.lines - 1))
        for offset, character in enumerate(text):
            self._text[line, column + offset] = character, style

    def render(self) -> Text:
        """Return everything drawn so far."""
        drawn = Text(no_wrap=True, end="")
        for line in range(self.lines):
            cells = (self._cell(line, column) for column in range(self.columns))
            for style, alike in groupby(cells, key=itemgetter(1)):
                drawn.append("".join(character for character, _ in alike), style)
            if line < self.lines - 1:
                drawn.append("\n")
        return drawn

    def _cell(self, line: int, column: int) -> tuple[str, str]:
        if (line, column) in self._text:
            return self._text[line, column]
        bits, style = self._dots.get((line, column), (0, ""))
        return (chr(BRAILLE + bits), style) if bits else (" ", "")
