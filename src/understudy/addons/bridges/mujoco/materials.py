"""Choose how a scenario's colors are painted in physics, and which rendered pixels count as each color."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from colorsys import rgb_to_hsv
from types import MappingProxyType
from typing import NamedTuple
from zlib import crc32

from understudy.addons.robots.camera.color import Color


class Rgb(NamedTuple):
    """Red, green and blue, each from 0 to 1."""

    red: float
    green: float
    blue: float


PAINTS: Mapping[str, Rgb] = MappingProxyType(
    {
        "red": Rgb(0.85, 0.12, 0.12),
        "orange": Rgb(0.95, 0.45, 0.05),
        "brown": Rgb(0.45, 0.28, 0.16),
        "yellow": Rgb(0.95, 0.85, 0.08),
        "green": Rgb(0.10, 0.70, 0.22),
        "cyan": Rgb(0.05, 0.75, 0.75),
        "blue": Rgb(0.10, 0.30, 0.90),
        "purple": Rgb(0.50, 0.15, 0.80),
        "violet": Rgb(0.50, 0.15, 0.80),
        "magenta": Rgb(0.85, 0.10, 0.60),
        "pink": Rgb(0.95, 0.45, 0.65),
        "white": Rgb(0.97, 0.97, 0.97),
        "gray": Rgb(0.55, 0.56, 0.58),
        "grey": Rgb(0.55, 0.56, 0.58),
        "black": Rgb(0.06, 0.06, 0.06),
    }
)
"""The paint of each named color, purer than in pictures, so that cameras can distinguish them."""

HUE_DEG = 12.0
"""The largest difference of a pixel's hue from that of the paint, degrees; light is neutral in this simulation."""
HAZY = 0.12
"""The least saturation of something behind a film; that of everything else is SATURATED, and gray is below both."""
SATURATED = 0.45
DARKEST = 0.12
FILM, DEEP, SHADE = 0.25, 0.6, 0.55
"""The opacity of things that hang aloft, their darkness relative to their paint, and that of shaded sides of things.

Robots drive and see through things that hang aloft.
"""
HUELESS = 0.1


def choose_material_color(name: str | None) -> Rgb:
    """Return the paint of a scenario's color; an unknown name always gets the same one of the known pure colors."""
    if name is None:
        return PAINTS["gray"]
    named = PAINTS.get(name.lower())
    if named is not None:
        return named
    if len(name) == 7 and name.startswith("#"):
        return Rgb(*(int(name[at : at + 2], 16) / 255.0 for at in (1, 3, 5)))
    pure = [each for each in PAINTS.values() if _hsv(each)[1] > SATURATED]
    return pure[crc32(name.encode()) % len(pure)]


def choose_film_color(name: str | None) -> Rgb:
    """Return the paint of something that hangs aloft: darker, so that things behind it keep their color."""
    return Rgb(*(DEEP * part for part in choose_material_color(name)))


def derive_camera_color(name: str, *, film: bool = False, films: Iterable[str] = ()) -> Color:
    """Return the range of pixel colors that count as a color, in light and shade, bare or behind the `films`.

    If the thing itself is a `film`, paler pixels count too, because it lets through what is behind it.
    """
    own = choose_material_color(name)
    hue, saturation, value = _hsv(own)
    if saturation < HUELESS:
        return Color(saturation=(0.0, HUELESS), value=(max(0.0, value - 0.15), min(1.0, value + 0.15)))
    behind = [
        Rgb(
            *(
                (1 - FILM) * SHADE * thing + FILM * veil
                for thing, veil in zip(own, choose_film_color(each), strict=True)
            )
        )
        for each in films
    ]
    turned = [0.0, *((_hsv(each)[0] - hue + 0.5) % 1.0 - 0.5 for each in behind if not film)]
    palest = min([saturation, *(_hsv(each)[1] for each in behind)])
    ends = [
        (360.0 * (hue + turn) + margin) % 360.0
        for turn, margin in ((min(turned), -HUE_DEG), (max(turned), HUE_DEG))
    ]
    least = HAZY if film else min(SATURATED, 0.6 * palest)
    return Color(
        hue_deg=(round(ends[0], 1), round(ends[1], 1)), saturation=(least, 1.0), value=(DARKEST, 1.0)
    )


def _hsv(of: Rgb) -> tuple[float, float, float]:
    return rgb_to_hsv(*of)
