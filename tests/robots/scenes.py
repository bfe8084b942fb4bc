"""Images whose truth is known: discs with shaded rims and fine edges, on noise, in any size."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.addons.robots.camera.color import Color

Image: TypeAlias = NDArray[np.uint8]
Disc: TypeAlias = tuple[float, float, float, tuple[int, int, int]]
"""Middle across and down and radius (pixels of a 160 x 120 frame), and its color in full light."""

ORANGE, RED, GREEN, BLUE, YELLOW = (240, 120, 20), (210, 20, 30), (30, 160, 50), (30, 60, 200), (230, 210, 30)
GRAY, WHITE, BROWN = (120, 125, 118), (235, 235, 235), (110, 85, 65)
ORANGES = Color(hue_deg=(15.0, 40.0), saturation=(0.6, 1.0), value=(0.25, 1.0))
REDS = Color(hue_deg=(340.0, 12.0), saturation=(0.6, 1.0), value=(0.25, 1.0))
GREENS = Color(hue_deg=(90.0, 160.0), saturation=(0.4, 1.0), value=(0.15, 1.0))

FINE = 4
"""Rays per pixel, each way."""


def render(
    *discs: Disc,
    ground: tuple[int, int, int] = GRAY,
    shade: float = 0.0,
    noise: float = 0.0,
    times: float = 1.0,
    seed: int = 0,
) -> Image:
    """A frame of 160 x 120 pixels, `times` as fine; later discs are in front.

    Light falls from the upper left: `shade` is how much of it is lost at a disc's lower right rim. `noise` is the
    standard deviation of each channel of each pixel.
    """
    height, width = round(120 * times), round(160 * times)
    step = 1.0 / (times * FINE)
    y, x = np.mgrid[0 : height * FINE, 0 : width * FINE]
    x, y = (x + 0.5) * step, (y + 0.5) * step
    fine = np.empty((*x.shape, 3))
    fine[:] = ground
    for across, down, radius, color in discs:
        inside = np.hypot(x - across, y - down) <= radius
        lost = shade * np.clip(0.5 + (x - across + y - down) / (2.0 * 1.42 * radius), 0.0, 1.0)
        fine[inside] = (np.array(color) * (1.0 - lost)[..., None])[inside]
    image = fine.reshape(height, FINE, width, FINE, 3).mean(axis=(1, 3))
    image += np.random.default_rng(seed).normal(0.0, noise, image.shape)
    made: Image = np.clip(np.round(image), 0, 255).astype(np.uint8)
    return made
