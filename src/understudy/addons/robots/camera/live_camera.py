"""A robot's camera in use: its latest images, the colors it detects, and calibration of a color from clicks."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from understudy.addons.robots.camera.blobs import BlobDetector, Image
from understudy.addons.robots.camera.calibration import PixelPoint, calibrate_from_clicks
from understudy.addons.robots.camera.color import Color
from understudy.addons.robots.camera.config import CameraSpec, check_color_name
from understudy.addons.robots.camera.image_decoding import decode_compressed_image, decode_image
from understudy.errors import SettingError
from understudy.extras import import_opencv
from understudy.model.features import ReadingKey

KEPT = 40
"""The number of latest images that are kept, so that a person can click into one that is a moment old."""
OUTLINE = (255, 0, 255)
"""The color of outlines around detected objects; hardly any object is magenta."""


class CameraImage(NamedTuple):
    """An image [H, W, 3] and its number."""

    number: int
    image: Image


class LiveCamera:
    """The latest images of a camera, and the colors that are detected in them.

    The transport's thread adds images; any thread may read them.
    """

    def __init__(self, of: CameraSpec) -> None:
        self._of = of
        self._camera: BlobDetector = of.camera()
        self._seen: deque[CameraImage] = deque(maxlen=KEPT)
        self.colors: Mapping[str, Color] = dict(of.colors)

    @property
    def last_image(self) -> CameraImage | None:
        """The latest image; None if none has arrived."""
        return self._seen[-1] if self._seen else None

    def read_message(self, message: Any) -> Mapping[ReadingKey, float]:
        """Decode a message of the camera and return its readings; raise ImageError if it has no valid image."""
        if self._of.type.endswith("CompressedImage"):
            image = decode_compressed_image(message.data)
        else:
            size = {each: getattr(message, each) for each in ("encoding", "width", "height", "step")}
            image = decode_image(message.data, **size)
        self._seen.append(CameraImage(self._seen[-1].number + 1 if self._seen else 1, image))
        return self._camera.readings(image)

    def learn_color(self, name: str, number: int, points: Sequence[PixelPoint]) -> Color:
        """Calibrate a color from clicks (column, row) in the image with the given number, and detect it from now on."""
        check_color_name(name)
        image = next((latest.image for latest in self._seen if latest.number == number), None)
        if image is None:
            problem = f"is {number}, but that image is no longer kept"
            remedy = "click into one that came a moment ago"
            raise SettingError(where="the camera", setting="image", problem=problem, remedy=remedy)
        color = calibrate_from_clicks(image, points, where=f"color {name!r}")
        self.colors = {**self.colors, name: color}
        self._camera = BlobDetector(self.colors, view_deg=self._of.view_deg, least_px=self._of.least_px)
        return color

    def encode_annotated_image(self) -> tuple[int, bytes] | None:
        """Encode the latest image as JPEG with outlines around detected objects.

        The JPEG is returned after the number of the image; None if no image has arrived.
        """
        last = self.last_image
        if last is None:
            return None
        cv = import_opencv()
        drawn = last.image.copy()
        for mask in self._camera.masks(last.image).values():
            outlines, _ = cv.findContours(mask, cv.RETR_EXTERNAL, cv.CHAIN_APPROX_NONE)
            cv.drawContours(drawn, outlines, -1, OUTLINE, 1)
        _, jpeg = cv.imencode(".jpg", cv.cvtColor(drawn, cv.COLOR_RGB2BGR))
        return last.number, jpeg.tobytes()
