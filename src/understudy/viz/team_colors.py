"""Assign robots to sides and sides to colors: sides are teams, or types if there is only one team."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.sim.view import WorldView
from understudy.viz.appearance import choose_robot_colors, format_thousands
from understudy.viz.palette import COLORS, INK, PAPER, blend_color

PALE = 0xD8
"""The least value of red, green and blue (of 255) from which a color is invisible on the light ground."""
CLOSE = 60
"""The difference (of 255) in red, green and blue below which two colors count as alike."""
DARKEST, LIGHTEST = 0.65, 0.6
"""The share of a side's color in its darkest shade, mixed with INK, and in its lightest, mixed with PAPER."""


@dataclass(frozen=True, slots=True, eq=False)
class TeamColors:
    """The sides of a world: their names and colors, and `of` [N] the index of each robot's side."""

    names: tuple[str, ...]
    colors: tuple[str, ...]
    of: NDArray[np.integer[Any]]

    @property
    def robots(self) -> list[str]:
        """The color of each robot's side."""
        return [self.colors[side] for side in self.of.tolist()]

    @property
    def counts(self) -> list[str]:
        """The number of robots of each side in words, such as '3 reds'."""
        number = Counter(self.of.tolist())
        return [f"{format_thousands(number[at])} {name}" for at, name in enumerate(self.names)]

    @property
    def shades(self) -> list[str]:
        """A shade of its side's color for each robot, to distinguish the paths of robots of one side."""
        shades = self.robots
        for side, color in enumerate(self.colors):
            own = np.flatnonzero(self.of == side).tolist()
            for robot, light in zip(own, np.linspace(-1.0, 1.0, len(own) + 2)[1:-1].tolist(), strict=True):
                ground, most = (PAPER, LIGHTEST) if light > 0 else (INK, DARKEST)
                shades[robot] = blend_color(color, ground, 1.0 - abs(light) * (1.0 - most))
        return shades


def assign_team_colors(view: WorldView) -> TeamColors | None:
    """Return the sides of a world, in order of their first robots; None if all robots are on one side."""
    robots = view.robots
    for column, names in ((robots.team, view.names.teams), (robots.type, view.names.types)):
        sides, first, of = np.unique(column, return_index=True, return_inverse=True)
        if len(sides) > 1:
            order = np.argsort(first)
            place = np.empty_like(order)
            place[order] = np.arange(len(order))
            own = choose_robot_colors(view)
            chosen = _apart([own[robot] for robot in first[order].tolist()])
            return TeamColors(
                tuple(names[at].replace("_", " ") for at in sides[order].tolist()), chosen, place[of]
            )
    return None


def _apart(wished: list[str | None]) -> tuple[str, ...]:
    """Return the wished colors, replaced where they are alike or too pale, as long as there are other colors."""
    chosen: list[str] = []
    for at, wish in enumerate(wished):
        if wish is None or min(bytes.fromhex(wish[1:])) >= PALE or _close(wish, chosen):
            others = [*chosen, *filter(None, wished[at + 1 :])]
            free = (color for color in COLORS if not _close(color, others))
            wish = next(free, COLORS[at % len(COLORS)])
        chosen.append(wish)
    return tuple(chosen)


def _close(color: str, others: Iterable[str]) -> bool:
    """Return whether a color is like one of the others."""
    one = bytes.fromhex(color[1:])
    return any(
        max(abs(a - b) for a, b in zip(one, bytes.fromhex(other[1:]), strict=True)) < CLOSE
        for other in others
    )
