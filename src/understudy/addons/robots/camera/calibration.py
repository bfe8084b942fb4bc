"""Calibration of colors from pixels that a person clicked, or from images of the object.

The color is the range that nearly all pixels of the object are in, widened: by a margin of hue, because other light
is a little redder or bluer, and down to duller and much darker, because other images have more shade. If masks say
what is not part of the object, the widest margins are used that take in none or the least of that.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.addons.robots.camera.blobs import BlobDetector, Image, Mask
from understudy.addons.robots.camera.color import CIRCLE_DEG, STEPS, Color
from understudy.errors import SettingError
from understudy.extras import import_opencv

Pixels: TypeAlias = NDArray[np.uint8]
"""Red, green and blue of pixels [K, 3]."""
PixelPoint: TypeAlias = tuple[int, int]
"""A pixel of an image: column, row."""

AROUND_PX = 2
"""The distance from a clicked pixel, in pixels, within which others are used too."""
MIDDLE = 0.2
"""The share of an image's width and height that the object fills if there is no mask; it is in the middle."""
TAIL = 0.02
"""The share of pixels at each end of a range that is ignored as glints, dust and edges."""
HUELESS = 0.2
"""The median saturation below which an object is white, gray or black."""
WIDEST_DEG = 100.0
"""The widest range of hues, in degrees, that can be one color."""
MOST_PIXELS = 20_000
"""The approximate number of pixels of an image that are used."""


class ColorMargins(NamedTuple):
    """The margins of a color around its pixels: degrees added to the hue, factors for lowest saturation and value."""

    hue_deg: float = 8.0
    saturation: float = 0.7
    value: float = 0.4


NARROWER: Sequence[ColorMargins] = tuple(
    ColorMargins(*each)
    for each in product((12.0, 8.0, 5.0, 2.0), (0.5, 0.7, 0.85, 0.95), (0.3, 0.4, 0.6, 0.8))
)
"""The margins that are tried if masks say what is not part of the object, the widest first."""


class LabeledImage(NamedTuple):
    """An image [H, W, 3] of an object; the mask [H, W] is not 0 where the object is, None if it fills the middle."""

    image: Image
    mask: Mask | None = None


def calibrate_from_clicks(image: Image, points: Iterable[PixelPoint], *, where: str = "clicks") -> Color:
    """Compute the color around pixels that a person clicked; raise SettingError if it is no single color."""
    height, width = image.shape[:2]
    patches = []
    for column, row in points:
        if not (0 <= column < width and 0 <= row < height):
            problem, remedy = f"is {(column, row)}", f"give a pixel of the image, which is {width} x {height}"
            raise SettingError(where=where, setting="a click", problem=problem, remedy=remedy)
        top, left = max(0, row - AROUND_PX), max(0, column - AROUND_PX)
        patch = image[top : row + AROUND_PX + 1, left : column + AROUND_PX + 1]
        patches.append(patch.reshape(-1, 3))
    return calibrate_from_pixels(_joined(patches, where), where=where)


def calibrate_from_images(labeled: Sequence[LabeledImage], *, where: str = "images") -> Color:
    """Compute the color of an object in images; raise SettingError if it is no single color or has no pixels."""
    inside = _joined([_inside(each) for each in labeled], where)
    if all(each.mask is None for each in labeled):
        return calibrate_from_pixels(inside, where=where)
    tried = {margins: calibrate_from_pixels(inside, margins, where=where) for margins in NARROWER}
    masked = [each for each in labeled if each.mask is not None]
    wrong = {margins: _mistaken(color, masked) for margins, color in tried.items()}
    best = min(NARROWER, key=lambda margins: round(wrong[margins], 3))  # of equals the first: the widest
    return tried[best]


def calibrate_from_pixels(
    pixels: Pixels, margins: ColorMargins | None = None, *, where: str = "pixels"
) -> Color:
    """Compute the color of the pixels [K, 3] of an object; raise SettingError if they have several colors."""
    hue_by, saturation_by, value_by = margins or ColorMargins()
    cv = import_opencv()
    hsv = cv.cvtColor(np.ascontiguousarray(pixels[None]), cv.COLOR_RGB2HSV_FULL)[0].astype(np.float64)
    hues_deg, saturations, values = hsv[:, 0] * CIRCLE_DEG / STEPS, hsv[:, 1] / 255.0, hsv[:, 2] / 255.0
    dullest, purest = np.quantile(saturations, (TAIL, 1.0 - TAIL))
    darkest, brightest = np.quantile(values, (TAIL, 1.0 - TAIL))
    if np.median(saturations) < HUELESS or brightest < HUELESS:
        return _hueless(purest, darkest, brightest, value_by)
    # What is dull or dark has little to say of its hue.
    angles = np.deg2rad(hues_deg)
    mean_deg = np.rad2deg(np.angle(np.sum(saturations * values * np.exp(1j * angles))))
    aside_deg = np.mod(hues_deg - mean_deg + 180.0, CIRCLE_DEG) - 180.0
    first, last = np.quantile(aside_deg, (TAIL, 1.0 - TAIL))
    if last - first > WIDEST_DEG:
        problem = f"are of hues {last - first:.0f} degrees apart"
        raise SettingError(where=where, setting="pixels", problem=problem, remedy="show one color at a time")
    return Color(
        hue_deg=(_hue(mean_deg + first - hue_by), _hue(mean_deg + last + hue_by)),
        saturation=(_down(dullest * saturation_by), 1.0),
        value=(_down(darkest * value_by), 1.0),
    )


def _hueless(purest: float, darkest: float, brightest: float, value_by: float) -> Color:
    """Make a color without a hue (white, gray or black), defined by its brightness and low saturation."""
    aside = 0.5 * (1.0 - value_by)  # shade and light are all there is to tell them apart
    return Color(
        saturation=(0.0, _up(min(1.0, purest + 0.1)) if brightest >= HUELESS else 1.0),
        value=(_down(darkest * (1.0 - aside)), _up(min(1.0, brightest * (1.0 + aside)))),
    )


def _inside(labeled: LabeledImage) -> Pixels:
    """Return pixels of the object [K, 3], thinned out if they are many."""
    image, mask = labeled
    if mask is None:
        height, width = image.shape[:2]
        tall, wide = max(1, round(height * MIDDLE)), max(1, round(width * MIDDLE))
        top, left = (height - tall) // 2, (width - wide) // 2
        pixels = image[top : top + tall, left : left + wide].reshape(-1, 3)
    else:
        pixels = image[mask > 0]
    return pixels[:: max(1, len(pixels) // MOST_PIXELS)]


def _joined(parts: Sequence[Pixels], where: str) -> Pixels:
    pixels: Pixels = np.concatenate([np.empty((0, 3), np.uint8), *parts])
    if not len(pixels):
        remedy = "click into the thing, or mask it in white in one image at least"
        raise SettingError(where=where, setting="pixels", problem="are none", remedy=remedy)
    return pixels


def _mistaken(color: Color, labeled: Sequence[LabeledImage]) -> float:
    """Compute the share of the object that a color misses plus the share wrongly included, averaged over images.

    Both are relative to the size of the object.
    """
    camera = BlobDetector({"it": color})
    shares = []
    for image, mask in labeled:
        matches, there = camera.masks(image)["it"] > 0, np.asarray(mask) > 0
        missed = np.mean(~matches[there]) if there.any() else 0.0
        # Against the thing's own size: what else is in the image is mostly background, easily told apart.
        taken = np.count_nonzero(matches & ~there) / max(1, int(np.count_nonzero(there)))
        shares.append(float(missed + taken))
    return float(np.mean(shares))


def _hue(degrees: float) -> float:
    return round(float(np.mod(degrees, CIRCLE_DEG)), 1)


def _down(share: float) -> float:
    return float(np.floor(share * 100.0) / 100.0)


def _up(share: float) -> float:
    return float(np.ceil(share * 100.0) / 100.0)
