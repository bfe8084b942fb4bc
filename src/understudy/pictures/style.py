"""Colors of all pictures: few, apart also for color-blind eyes (after Okabe and Ito), on a light ground."""

from __future__ import annotations

from collections.abc import Iterable

INK, FAINT, LINE, PAPER, GROUND = "#1f2933", "#66727f", "#d5dbe1", "#ffffff", "#f6f8fa"
FOOD, FOOD_GONE, STATION = "#4a9c5d", "#c9d6cc", "#33475b"
COLORS = ("#0072b2", "#d55e00", "#8f4aa3", "#00806a", "#b8860b", "#c2407f", "#4d5b6a", "#3b8fd0")


def colors_for(names: Iterable[str]) -> dict[str, str]:
    """A color for each name, in the order in which they come first."""
    distinct = dict.fromkeys(names)
    return {name: COLORS[at % len(COLORS)] for at, name in enumerate(distinct)}
