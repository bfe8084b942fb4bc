"""Eyes: what a robot's camera sees, the colors it is looked at with, and learning a color from clicks into an image."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from understudy.errors import SettingError
from understudy.extras import import_opencv
from understudy.model.features import ReadingKey
from understudy.robots.camera.blobs import BlobDetector, Image
from understudy.robots.camera.calibration import PixelPoint, calibrate_from_clicks
from understudy.robots.camera.color import Color
from understudy.robots.camera.config import CameraSpec, check_color_name
from understudy.robots.camera.image_decoding import decode_compressed_image, decode_image

KEPT = 40
"""Images that can still be clicked into: a person looks at one for a moment."""
OUTLINE = (255, 0, 255)
"""What the outline of what has a color is drawn in; hardly anything is magenta."""


class CameraImage(NamedTuple):
    """An image [H, W, 3], counted."""

    number: int
    image: Image


class LiveCamera:
    """The last images of a camera. Message threads show them, anybody may look; a color learned counts from then on."""

    def __init__(self, of: CameraSpec) -> None:
        self._of = of
        self._camera: BlobDetector = of.camera()
        self._seen: deque[CameraImage] = deque(maxlen=KEPT)
        self.colors: Mapping[str, Color] = dict(of.colors)

    @property
    def last_image(self) -> CameraImage | None:
        """The last image; None where none has come yet."""
        return self._seen[-1] if self._seen else None

    def read_message(self, message: Any) -> Mapping[ReadingKey, float]:
        """The readings of a message of the camera; ImageError where it holds no image."""
        if self._of.type.endswith("CompressedImage"):
            image = decode_compressed_image(message.data)
        else:
            size = {each: getattr(message, each) for each in ("encoding", "width", "height", "step")}
            image = decode_image(message.data, **size)
        self._seen.append(CameraImage(self._seen[-1].number + 1 if self._seen else 1, image))
        return self._camera.readings(image)

    def learn_color(self, name: str, number: int, points: Sequence[PixelPoint]) -> Color:
        """The color of a thing from clicks (column, row) into the image of this number; looked for from now on."""
        check_color_name(name)
        image = next((seen.image for seen in self._seen if seen.number == number), None)
        if image is None:
            problem = f"is {number}, but that image is no longer kept"
            remedy = "click into one that came a moment ago"
            raise SettingError(where="the camera", setting="image", problem=problem, remedy=remedy)
        color = calibrate_from_clicks(image, points, where=f"color {name!r}")
        self.colors = {**self.colors, name: color}
        self._camera = BlobDetector(self.colors, view_deg=self._of.view_deg, least_px=self._of.least_px)
        return color

    def encode_annotated_image(self) -> tuple[int, bytes] | None:
        """The last image as JPEG, with outlines around what has one of the colors; None where none has come yet."""
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
