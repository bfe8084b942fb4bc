"""Draw the examples of a lesson as marks in a plane: shape and color say the next state, filling and size the kind."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from understudy.model.lesson import Example, ExampleKind
from understudy.viz.axes import escape_math
from understudy.viz.palette import COLORS, INK, PAPER

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
"""The marker of each next state, which tells states apart without colors."""
SIZE, SMALL, RING, MOST_RINGS = 7.5, 3.5, 4.5, 3
"""Sizes of marks, in points: of an example from a press, of a watched one, and the growth for each further example at
the same place, which ends after MOST_RINGS of them."""
WORDS = {
    ExampleKind.DIRECTIVE: "pressed",
    ExampleKind.CONFIRMATION: "confirmed",
    ExampleKind.DEFAULT: "default",
    ExampleKind.WATCHED: "watched",
}


def draw_examples(
    axes: Axes, examples: Sequence[Example], places: Sequence[tuple[float, float]], states: Sequence[str]
) -> list[Artist]:
    """Draw examples at their places, and return the entries of a legend; `states` are those of the automaton.

    Further examples at one place are drawn as larger rings around the first.
    """
    groups = defaultdict[tuple[ExampleKind, int, int], list[tuple[float, float]]](list)
    crossed: list[tuple[float, float]] = []
    before = Counter[tuple[float, float]]()
    for example, place in zip(examples, places, strict=True):
        groups[example.kind, states.index(example.next), min(before[place], MOST_RINGS)].append(place)
        before[place] += 1
        if example.quarantined:
            crossed.append(place)
    for (kind, outcome, ring), group in groups.items():
        look = _look(kind, outcome)
        if ring:
            look |= {"ms": SIZE + RING * ring, "mfc": "none"}
        axes.plot(*zip(*group, strict=True), ls="", zorder=4 - 0.1 * ring, clip_on=False, **look)
    if crossed:
        axes.plot(*zip(*crossed, strict=True), ls="", zorder=5, clip_on=False, **_CROSS)
    return _list_entries({(kind, outcome) for kind, outcome, _ in groups}, states, crossed=bool(crossed))


_CROSS: dict[str, Any] = {"marker": "x", "ms": 11, "color": INK, "mew": 1.4}


def _look(kind: ExampleKind, outcome: int) -> dict[str, Any]:
    color = COLORS[outcome % len(COLORS)]
    filled = kind in (ExampleKind.DIRECTIVE, ExampleKind.CONFIRMATION)
    size = SMALL if kind == ExampleKind.WATCHED else SIZE
    marker = MARKERS[outcome % len(MARKERS)]
    return {"marker": marker, "ms": size, "mfc": color if filled else PAPER, "mec": color, "mew": 1.4}


def _list_entries(
    kinds_and_outcomes: set[tuple[ExampleKind, int]], states: Sequence[str], *, crossed: bool
) -> list[Artist]:
    from matplotlib.lines import Line2D

    order = list(WORDS)
    entries: list[Artist] = [
        Line2D([], [], ls="", label=escape_math(f"{WORDS[kind]}: {states[outcome]}"), **_look(kind, outcome))
        for kind, outcome in sorted(kinds_and_outcomes, key=lambda each: (order.index(each[0]), each[1]))
    ]
    return [*entries, *([Line2D([], [], ls="", label="in quarantine", **_CROSS)] if crossed else [])]
