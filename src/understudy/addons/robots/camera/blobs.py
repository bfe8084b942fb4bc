"""Detection of color blobs in real images, with the readings and units of the simulated camera.

For each color, the simulated camera (sensor kind "camera") reads the middle between the left and right edge of the
blob, in pixels from the left edge of a frame, and the area of its bounding box in pixels (paper section 4.2). A real
image has another size and perhaps another angle of view. So the simulated frame is centered on it and scaled so that
an object at the same distance has the same size. Anything outside the frame is ignored.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import nan, radians, tan
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.addons.robots.camera.color import Color, check_color, make_hsv_bounds
from understudy.errors import SettingError
from understudy.extras import import_opencv
from understudy.model.features import ReadingKey

Image: TypeAlias = NDArray[np.uint8]
"""Red, green and blue of each pixel [H, W, 3]."""
Mask: TypeAlias = NDArray[np.uint8]
"""A mask [H, W], 255 where something is, else 0."""

X, SIZE = "blob_x", "blob_size"
LEAST_PX = 9.0
"""The smallest area of a blob, in pixels of the frame (3 x 3); smaller ones are noise."""


class FrameGeometry(NamedTuple):
    """The frame of a simulated camera: width and height in pixels, and horizontal angle of view in degrees."""

    width_px: int = 160
    height_px: int = 120
    view_deg: float = 60.0


class Blob(NamedTuple):
    """The largest connected region of a color, in pixels of the frame.

    `x` is its middle from the left edge of the frame, and `size` the area of its bounding box.
    """

    x: float
    size: float


class BlobDetector:
    """A detector of objects in a camera's images by their colors.

    `view_deg` is the horizontal angle of view of the real camera; by default that of the frame. Blobs smaller than
    `least_px` pixels of the frame are absent.
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
        """Find the blob of each color in an image [H, W, 3]; None if none is large enough."""
        part, left_px, scale_x, scale_y = self._framed(image)
        hsv = self._cv.cvtColor(part, self._cv.COLOR_RGB2HSV_FULL)
        middle = 0.5 * image.shape[1]
        blobs: dict[str, Blob | None] = {}
        for name, boxes in self._boxes.items():
            box = self._largest(self._mask(hsv, boxes))
            blobs[name] = None
            if box is not None:
                left, width, height = box
                # From pixels of the part to those of the image, and from its middle to the frame's.
                across = self._scale(image) * (left_px + (left + 0.5 * width) / scale_x - middle)
                size = width * height * self._scale(image) ** 2 / (scale_x * scale_y)
                if size >= self._least_px:
                    blobs[name] = Blob(0.5 * self.frame.width_px + across, size)
        return blobs

    def readings(self, image: Image) -> dict[ReadingKey, float]:
        """Return the readings `blob_x` and `blob_size` of each color; both are NaN if its object is not seen."""
        readings: dict[ReadingKey, float] = {}
        for name, blob in self.detect(image).items():
            readings[X, name], readings[SIZE, name] = (nan, nan) if blob is None else blob
        return readings

    def masks(self, image: Image) -> dict[str, Mask]:
        """Return the mask of each color in an image [H, W, 3], at the image's own size, for display and calibration."""
        hsv = self._cv.cvtColor(image, self._cv.COLOR_RGB2HSV_FULL)
        return {name: self._mask(hsv, boxes) for name, boxes in self._boxes.items()}

    def _scale(self, image: Image) -> float:
        """Return the number of pixels of the frame per pixel of the image."""
        width: int = image.shape[1]
        return self.frame.width_px / width * self._widening

    def _framed(self, image: Image) -> tuple[Image, int, float, float]:
        """Return the part of an image within the frame, its left edge, and its pixels per image pixel across and down.

        The part is reduced to the resolution of the frame if it is finer.
        """
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
        """Return the mask of a color, in which each pixel follows the majority around it so that single ones vanish."""
        mask: Mask = self._cv.inRange(hsv, *boxes[0])
        for low, high in boxes[1:]:
            mask |= self._cv.inRange(hsv, low, high)
        smoothed: Mask = self._cv.medianBlur(mask, 3)
        return smoothed

    def _largest(self, mask: Mask) -> tuple[int, int, int] | None:
        """Return left edge, width and height of the connected region with the most pixels, the leftmost of equals."""
        count, _, regions, _ = self._cv.connectedComponentsWithStats(mask, connectivity=8)
        if count < 2:  # the first is what is not of the color
            return None
        left, _, width, height, pixels = regions[1:].T
        best = np.lexsort((left, -pixels))[0]
        return int(left[best]), int(width[best]), int(height[best])
