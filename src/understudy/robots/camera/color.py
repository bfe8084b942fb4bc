"""Colors by which cameras know things: ranges of hue, saturation and value, as a robot file holds them.

Why HSV, and not Lab: a thing in shade sends less of the same light. That scales red, green and blue alike, which moves
value and leaves hue and saturation where they are, so that one range holds a ball's lit and its shaded side. In Lab all
three coordinates shrink together, and a box wide enough for the shade takes in other colors. A person can also read
and correct a hue. What HSV is bad at, hue where there is hardly any color, is what the bound on saturation cuts away;
white, gray and black are ranges without a hue.
"""

from __future__ import annotations

from typing import TypeAlias

from understudy.errors import SettingError
from understudy.sim.scenario.squad_schema import StrictStruct

Share: TypeAlias = tuple[float, float]
"""(least, most), each from 0 to 1."""

Bound: TypeAlias = tuple[int, int, int]
"""Hue (256 steps around the circle), saturation and value (255 steps) in whole numbers."""

CIRCLE_DEG = 360.0
STEPS = 256


class Color(StrictStruct, frozen=True, kw_only=True):
    """The colors of a thing: an arc of hues (degrees; from > to crosses red), shares of saturation and of value.

    Red is 0, yellow 60, green 120, cyan 180, blue 240, magenta 300. Both ends belong to a range.
    """

    hue_deg: tuple[float, float] = (0.0, CIRCLE_DEG)
    saturation: Share = (0.0, 1.0)
    value: Share = (0.0, 1.0)


def check_color(color: Color, *, where: str) -> None:
    """SettingError, naming the key, where a color cannot be."""
    if not all(0.0 <= end <= CIRCLE_DEG for end in color.hue_deg):
        problem, remedy = f"is {list(color.hue_deg)}", "give two hues from 0 to 360 degrees"
        raise SettingError(where=where, setting="hue_deg", problem=problem, remedy=remedy)
    for key, (least, most) in (("saturation", color.saturation), ("value", color.value)):
        if not 0.0 <= least <= most <= 1.0:
            problem, remedy = f"is {[least, most]}", "give the least and the most, from 0 to 1"
            raise SettingError(where=where, setting=key, problem=problem, remedy=remedy)


def make_hsv_bounds(color: Color) -> list[tuple[Bound, Bound]]:
    """The boxes (lowest, highest, both within) of 8-bit HSV that a color is: two where its arc crosses the seam.

    Ends are rounded as pixels are, so that a pixel of a hue within the arc is within a box.
    """
    first, last = (_step(end) for end in color.hue_deg)
    if color.hue_deg[0] > color.hue_deg[1]:
        last += STEPS
    if last - first >= STEPS - 1:
        arcs = [(0, STEPS - 1)]
    elif last >= STEPS:
        arcs = [(first, STEPS - 1), (0, last - STEPS)] if first < STEPS else [(0, last - STEPS)]
    else:
        arcs = [(first, last)]
    (dullest, purest), (darkest, brightest) = (
        (round(255 * least), round(255 * most)) for least, most in (color.saturation, color.value)
    )
    return [((low, dullest, darkest), (high, purest, brightest)) for low, high in arcs]


def _step(hue_deg: float) -> int:
    return round(hue_deg * STEPS / CIRCLE_DEG)
