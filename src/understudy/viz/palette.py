"""The colors of all pictures: few, distinct for color-blind people (after Okabe and Ito), on a light ground."""

from __future__ import annotations

from collections.abc import Iterable
from re import fullmatch
from zlib import crc32

INK, FAINT, LINE, PAPER, GROUND = "#1f2933", "#66727f", "#d5dbe1", "#ffffff", "#f6f8fa"
FOOD, HOME, SOLID, EDGE, THING = "#4a9c5d", "#33475b", "#c3cbd3", "#8e99a4", "#7c8894"
COLORS = ("#0072b2", "#d55e00", "#8f4aa3", "#00806a", "#b8860b", "#c2407f", "#4d5b6a", "#3b8fd0")
PAINTS = {
    "black": "#1f2933",
    "blue": "#2f74b5",
    "brown": "#8a5a3c",
    "cyan": "#2ba3b8",
    "gray": "#8a94a0",
    "green": "#4a9c5d",
    "grey": "#8a94a0",
    "magenta": "#c2407f",
    "orange": "#e08a2b",
    "pink": "#e38bb0",
    "purple": "#8f4aa3",
    "red": "#cf4446",
    "violet": "#8f4aa3",
    "white": "#ffffff",
    "yellow": "#e3b91f",
}
"""The drawing color of each color name in scenarios, less bright than the name suggests."""


def assign_name_colors(names: Iterable[str]) -> dict[str, str]:
    """Assign a color to each name, in order of first occurrence."""
    distinct = dict.fromkeys(names)
    return {name: COLORS[at % len(COLORS)] for at, name in enumerate(distinct)}


def choose_drawing_color(name: str) -> str:
    """Return the drawing color of a scenario's color; an unknown name always gets the same one."""
    if fullmatch("#[0-9a-fA-F]{6}", name):
        return name
    return PAINTS.get(name.lower(), COLORS[crc32(name.encode()) % len(COLORS)])


def blend_color(color: str, ground: str, share: float) -> str:
    """Mix a color with a ground: `share` 1 is the color, 0 the ground."""
    mixed = (
        round(share * int(color[at : at + 2], 16) + (1 - share) * int(ground[at : at + 2], 16))
        for at in (1, 3, 5)
    )
    return "#" + "".join(f"{value:02x}" for value in mixed)
