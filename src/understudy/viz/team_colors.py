"""Which robots belong together, and in which color: teams, or types where there is one team only."""

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
"""From here on (of 255, in red, green and blue) a color is lost on the ground."""
CLOSE = 60
"""Colors that differ by less than this (of 255) in red, in green and in blue are taken for one."""
DARKEST, LIGHTEST = 0.65, 0.6
"""How much of a side's color is left in its darkest shade on ink, and in its lightest on paper."""


@dataclass(frozen=True, slots=True, eq=False)
class TeamColors:
    """The sides of a world: what each is called, its color, and `of` [N] the side of each robot."""

    names: tuple[str, ...]
    colors: tuple[str, ...]
    of: NDArray[np.integer[Any]]

    @property
    def robots(self) -> list[str]:
        """The color of each robot's side."""
        return [self.colors[side] for side in self.of.tolist()]

    @property
    def counts(self) -> list[str]:
        """'3 reds', for each side."""
        number = Counter(self.of.tolist())
        return [f"{format_thousands(number[at])} {name}" for at, name in enumerate(self.names)]

    @property
    def shades(self) -> list[str]:
        """A shade of its side's color for each robot, so that the ways of one side can be followed too."""
        made = self.robots
        for side, color in enumerate(self.colors):
            own = np.flatnonzero(self.of == side).tolist()
            for robot, light in zip(own, np.linspace(-1.0, 1.0, len(own) + 2)[1:-1].tolist(), strict=True):
                ground, most = (PAPER, LIGHTEST) if light > 0 else (INK, DARKEST)
                made[robot] = blend_color(color, ground, 1.0 - abs(light) * (1.0 - most))
        return made


def assign_team_colors(view: WorldView) -> TeamColors | None:
    """The sides of a world, in order of their first robots; None where all robots are of one."""
    robots = view.robots
    for column, names in ((robots.team, view.names.teams), (robots.type, view.names.types)):
        found, first, of = np.unique(column, return_index=True, return_inverse=True)
        if len(found) > 1:
            order = np.argsort(first)
            place = np.empty_like(order)
            place[order] = np.arange(len(order))
            own = choose_robot_colors(view)
            chosen = _apart([own[robot] for robot in first[order].tolist()])
            return TeamColors(
                tuple(names[at].replace("_", " ") for at in found[order].tolist()), chosen, place[of]
            )
    return None


def _apart(wished: list[str | None]) -> tuple[str, ...]:
    """Colors as wished, but told apart from each other and from the ground, as long as there are enough."""
    made: list[str] = []
    for at, wish in enumerate(wished):
        if wish is None or min(bytes.fromhex(wish[1:])) >= PALE or _close(wish, made):
            others = [*made, *filter(None, wished[at + 1 :])]
            free = (color for color in COLORS if not _close(color, others))
            wish = next(free, COLORS[at % len(COLORS)])
        made.append(wish)
    return tuple(made)


def _close(color: str, others: Iterable[str]) -> bool:
    """Whether a color looks much like one of the others."""
    one = bytes.fromhex(color[1:])
    return any(
        max(abs(a - b) for a, b in zip(one, bytes.fromhex(other[1:]), strict=True)) < CLOSE
        for other in others
    )
