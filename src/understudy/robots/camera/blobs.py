"""Blobs of color in real images: the readings of the simulated camera, in its units.

The simulated camera (`worlds`, kind "camera") reads of each color the blob's middle between its left and right edge, in
pixels from the left edge of a frame, and the pixels of its bounding box (as the paper's section 4.2 does). A real image
has another size and perhaps another angle of view; so the simulated frame is laid over it, middle on middle, scaled so
that a thing as far away is as large in it. What lies outside that frame does not count.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import nan, radians, tan
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.extras import import_opencv
from understudy.model.features import ReadingKey
from understudy.robots.camera.color import Color, check_color, make_hsv_bounds

Image: TypeAlias = NDArray[np.uint8]
"""Red, green and blue [H, W, 3]."""
Mask: TypeAlias = NDArray[np.uint8]
"""255 where something is, else 0 [H, W]."""

X, SIZE = "blob_x", "blob_size"
LEAST_PX = 9.0
"""What is smaller is taken for noise: 3 x 3 pixels of the frame."""


class FrameGeometry(NamedTuple):
    """The frame of a simulated camera: pixels across and down, and the angle that it sees across."""

    width_px: int = 160
    height_px: int = 120
    view_deg: float = 60.0


class Blob(NamedTuple):
    """The largest connected region of a color: its middle from the left edge, its box's size; pixels of the frame."""

    x: float
    size: float


class BlobDetector:
    """What a camera's images say of things that are known by their color.

    `view_deg` is the angle that the real camera sees across; left out, it is taken to be that of the frame.
    Blobs smaller than `least_px` pixels of the frame are absent.
    """

    def __init__(
        self,
        colors: Mapping[str, Color],
        *,
        view_deg: float | None = None,
        frame: FrameGeometry | None = None,
        least_px: float = LEAST_PX,
    ) -> None:
        for name, color in colors.items():
            check_color(color, where=f"color {name!r}")
        for key, angle in (("view_deg", view_deg), ("frame.view_deg", frame.view_deg if frame else None)):
            if angle is not None and not 0.0 < angle < 180.0:
                problem, remedy = f"is {angle}", "give degrees between 0 and 180"
                raise SettingError(where="camera", setting=key, problem=problem, remedy=remedy)
        self._cv = import_opencv()
        self.frame = frame or FrameGeometry()
        self._boxes = {name: make_hsv_bounds(color) for name, color in colors.items()}
        self._widening: float = (
            1.0
            if view_deg is None
            else tan(radians(view_deg) / 2.0) / tan(radians(self.frame.view_deg) / 2.0)
        )
        self._least_px = least_px

    def detect(self, image: Image) -> dict[str, Blob | None]:
        """The blob of each color in an image [H, W, 3]; None where none is large enough."""
        part, left_px, scale_x, scale_y = self._framed(image)
        hsv = self._cv.cvtColor(part, self._cv.COLOR_RGB2HSV_FULL)
        middle = 0.5 * image.shape[1]
        found: dict[str, Blob | None] = {}
        for name, boxes in self._boxes.items():
            box = self._largest(self._mask(hsv, boxes))
            found[name] = None
            if box is not None:
                left, width, height = box
                # From pixels of the part to those of the image, and from its middle to the frame's.
                across = self._scale(image) * (left_px + (left + 0.5 * width) / scale_x - middle)
                size = width * height * self._scale(image) ** 2 / (scale_x * scale_y)
                if size >= self._least_px:
                    found[name] = Blob(0.5 * self.frame.width_px + across, size)
        return found

    def readings(self, image: Image) -> dict[ReadingKey, float]:
        """The readings `blob_x` and `blob_size` of each color's thing; NaN, together, where it is not seen."""
        readings: dict[ReadingKey, float] = {}
        for name, blob in self.detect(image).items():
            readings[X, name], readings[SIZE, name] = (nan, nan) if blob is None else blob
        return readings

    def masks(self, image: Image) -> dict[str, Mask]:
        """Where in an image [H, W, 3] each color is, at its own size: to look at, and to calibrate by."""
        hsv = self._cv.cvtColor(image, self._cv.COLOR_RGB2HSV_FULL)
        return {name: self._mask(hsv, boxes) for name, boxes in self._boxes.items()}

    def _scale(self, image: Image) -> float:
        """Pixels of the frame per pixel of the image."""
        width: int = image.shape[1]
        return self.frame.width_px / width * self._widening

    def _framed(self, image: Image) -> tuple[Image, int, float, float]:
        """The part of an image that the frame covers, no finer than it; its left edge; its pixels per image's."""
        tall, wide = image.shape[:2]
        scale = self._scale(image)
        width = min(wide, max(1, round(self.frame.width_px / scale)))
        height = min(tall, max(1, round(self.frame.height_px / scale)))
        left, top = (wide - width) // 2, (tall - height) // 2
        part = image[top : top + height, left : left + width]
        if scale >= 1.0:
            return part, left, 1.0, 1.0
        across, down = max(1, round(width * scale)), max(1, round(height * scale))
        # Means over what becomes one pixel: they cost little, and even out the noise.
        part = self._cv.resize(part, (across, down), interpolation=self._cv.INTER_AREA)
        return part, left, across / width, down / height

    def _mask(self, hsv: NDArray[np.uint8], boxes: list[Any]) -> Mask:
        """Where a color is, as the majority of each pixel and its neighbors has it: lone pixels are noise."""
        mask: Mask = self._cv.inRange(hsv, *boxes[0])
        for low, high in boxes[1:]:
            mask |= self._cv.inRange(hsv, low, high)
        smoothed: Mask = self._cv.medianBlur(mask, 3)
        return smoothed

    def _largest(self, mask: Mask) -> tuple[int, int, int] | None:
        """Left edge, width and height of the connected region with the most pixels, the leftmost of equals."""
        count, _, regions, _ = self._cv.connectedComponentsWithStats(mask, connectivity=8)
        if count < 2:  # the first is what is not of the color
            return None
        left, _, width, height, pixels = regions[1:].T
        best = np.lexsort((left, -pixels))[0]
        return int(left[best]), int(width[best]), int(height[best])
