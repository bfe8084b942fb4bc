"""Colors by which cameras recognize objects: ranges of hue, saturation and value, as in a robot file.

HSV is used and not Lab because an object in shade reflects less of the same light. That scales red, green and blue
alike, which changes the value and keeps hue and saturation, so that one range includes the lit and the shaded side of
a ball. In Lab all three coordinates shrink together, and a box wide enough for the shade includes other colors.
People can also read and correct a hue. The weakness of HSV, hue where there is hardly any color, is excluded by the
bound on saturation; white, gray and black are ranges without a hue.
"""

from __future__ import annotations

from typing import TypeAlias

from understudy.errors import SettingError
from understudy.sim.scenario.squad_schema import StrictStruct

Share: TypeAlias = tuple[float, float]
"""The lowest and highest share, each from 0 to 1."""

Bound: TypeAlias = tuple[int, int, int]
"""Hue (256 steps around the circle), saturation and value (0 to 255), as whole numbers."""

CIRCLE_DEG = 360.0
STEPS = 256


class Color(StrictStruct, frozen=True, kw_only=True):
    """The color range of an object: an arc of hues (degrees), and ranges of saturation and value (0 to 1).

    If the first hue is larger than the second, the arc crosses red. Red is 0, yellow 60, green 120, cyan 180, blue
    240, magenta 300. Both ends belong to a range.
    """

    hue_deg: tuple[float, float] = (0.0, CIRCLE_DEG)
    saturation: Share = (0.0, 1.0)
    value: Share = (0.0, 1.0)


def check_color(color: Color, *, where: str) -> None:
    """Refuse an invalid color with a SettingError that names the key."""
    if not all(0.0 <= end <= CIRCLE_DEG for end in color.hue_deg):
        problem, remedy = f"is {list(color.hue_deg)}", "give two hues from 0 to 360 degrees"
        raise SettingError(where=where, setting="hue_deg", problem=problem, remedy=remedy)
    for key, (least, most) in (("saturation", color.saturation), ("value", color.value)):
        if not 0.0 <= least <= most <= 1.0:
            problem, remedy = f"is {[least, most]}", "give the least and the most, from 0 to 1"
            raise SettingError(where=where, setting=key, problem=problem, remedy=remedy)


def make_hsv_bounds(color: Color) -> list[tuple[Bound, Bound]]:
    """Convert a color to boxes (lowest, highest, both included) of 8-bit HSV; two if its arc of hues crosses red.

    Ends are rounded like pixels, so that a pixel of a hue within the arc is within a box.
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
