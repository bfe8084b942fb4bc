"""Decoding of images that robots send: `sensor_msgs/Image` in several encodings, and `CompressedImage`.

Images come over a network and may be cut off, damaged or hostile. Sizes are checked before memory is allocated. Every
invalid image raises ImageError and nothing else, and no image is decoded in part.
"""

from __future__ import annotations

from collections.abc import Mapping
from struct import Struct
from types import MappingProxyType
from typing import Any, TypeAlias
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from understudy.addons.robots.camera.blobs import Image
from understudy.errors import UnderstudyError, join_names
from understudy.extras import import_opencv

Size: TypeAlias = tuple[int, int]
"""Width and height, in pixels."""

PNG, JPEG, JPEG_END = b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"\xff\xd9"
_PNG_CHUNK, _PNG_SUM, _PNG_SIZE = Struct(">I4s"), Struct(">I"), Struct(">II")
_PNG_PIXELS = (b"IHDR", b"PLTE", b"IDAT", b"IEND")
_PNG_HEAD_BYTES = 13
_JPEG_SEGMENT, _JPEG_SIZE = Struct(">BBH"), Struct(">xHH")
_JPEG_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}


class ImageError(UnderstudyError, json_type="ImageError"):
    """An image that cannot be decoded."""

    def __init__(self, *, problem: str, remedy: str) -> None:
        self.problem, self.remedy = problem, remedy
        super().__init__(f"image: {problem}; {remedy}")


def strip_image_metadata(content: bytes) -> tuple[bytes, Size]:
    """Return a PNG or JPEG without metadata, and the size that it claims; raise ImageError if it is not complete."""
    if content.startswith(PNG):
        return _png(content)
    if content.startswith(JPEG):
        if not content.rstrip(b"\0").endswith(JPEG_END):  # some cameras fill up with zeros
            raise ImageError(
                problem="is a JPEG that was cut off", remedy="check the connection to the camera"
            )
        return content, _jpeg_size(content)
    raise ImageError(problem=f"begins with {content[:8]!r}", remedy="let the camera send JPEG or PNG")


def _png(content: bytes) -> tuple[bytes, Size]:
    """Return a PNG without texts, profiles and animation, and its size (PNG specification, section 5.3)."""
    chunks, at, kind = [PNG], len(PNG), b""
    view = memoryview(content)
    while kind != b"IEND":
        if at + 12 > len(content):
            raise ImageError(problem="is a PNG that was cut off", remedy="check the connection to the camera")
        length, kind = _PNG_CHUNK.unpack_from(content, at)
        end = at + 12 + length
        first = len(chunks) == 1
        if end > len(content) or first != (kind == b"IHDR") or (first and length != _PNG_HEAD_BYTES):
            raise _damaged()
        if kind in _PNG_PIXELS:
            if crc32(view[at + 4 : end - 4]) != _PNG_SUM.unpack_from(content, end - 4)[0]:
                raise _damaged()
            chunks.append(content[at:end])
        at = end
    width, height = _PNG_SIZE.unpack_from(chunks[1], 8)
    return b"".join(chunks), (width, height)


def _damaged() -> ImageError:
    return ImageError(problem="is a PNG that is damaged", remedy="check the connection to the camera")


def _jpeg_size(content: bytes) -> Size:
    """Return the size in the first frame header of a JPEG (ITU T.81, section B.2.2)."""
    at = 2
    while at + 9 <= len(content):
        mark, kind, length = _JPEG_SEGMENT.unpack_from(content, at)
        if mark != 0xFF:
            break
        if kind == 0xFF:  # a marker may have any number of these before it
            at += 1
        elif kind in _JPEG_FRAMES:
            height, width = _JPEG_SIZE.unpack_from(content, at + 4)
            return width, height
        else:
            at += 2 + length
    raise ImageError(problem="is a JPEG without a size", remedy="check what the camera sends")


Data: TypeAlias = bytes | bytearray | memoryview | NDArray[np.uint8]

CHANNELS: Mapping[str, int] = MappingProxyType(
    {
        "rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "mono8": 1,
        "yuv422": 2, "uyvy": 2, "yuv422_yuy2": 2, "yuyv": 2,
    }
)  # fmt: skip
"""The encodings that can be decoded, with bytes per pixel; ROS 2 has two names for each byte order of YUV 4:2:2."""
CONVERSIONS: Mapping[str, str] = MappingProxyType(
    {
        "bgr8": "COLOR_BGR2RGB", "rgba8": "COLOR_RGBA2RGB", "bgra8": "COLOR_BGRA2RGB", "mono8": "COLOR_GRAY2RGB",
        "yuv422": "COLOR_YUV2RGB_UYVY", "uyvy": "COLOR_YUV2RGB_UYVY",
        "yuv422_yuy2": "COLOR_YUV2RGB_YUY2", "yuyv": "COLOR_YUV2RGB_YUY2",
    }
)  # fmt: skip
MOST_PIXELS = 2**23
"""The largest number of pixels; a small file may claim any size and would otherwise fill the memory."""


def decode_image(data: Data, *, encoding: str, width: int, height: int, step: int) -> Image:
    """Decode a `sensor_msgs/Image` to red, green and blue [H, W, 3]; raise ImageError if it is invalid.

    Rows are `step` bytes long. For rgb8 without padding the result is a view of `data`: copy it to keep it.
    """
    channels = CHANNELS.get(encoding)
    if channels is None:
        supported = f"let the camera send one of {join_names(CHANNELS)}"
        raise ImageError(problem=f"its encoding is {encoding!r:.40}", remedy=supported)
    _check_size(width, height)
    if channels == 2 and width % 2:
        raise ImageError(problem=f"is {width} pixels wide in {encoding}", remedy="an even number is right")
    if step < width * channels:
        remedy = f"{width} pixels of {encoding} take {width * channels}"
        raise ImageError(problem=f"its rows are {step} bytes long", remedy=remedy)
    flat = np.frombuffer(data, np.uint8)
    if len(flat) != step * height:
        remedy = f"{height} rows of {step} bytes are {step * height}"
        raise ImageError(problem=f"holds {len(flat)} bytes", remedy=remedy)
    rows = flat.reshape(height, step)[:, : width * channels]
    image: Image = rows.reshape(height, width, channels)
    if encoding == "rgb8":
        return image
    cv = import_opencv()
    converted: Image = cv.cvtColor(np.ascontiguousarray(image), getattr(cv, CONVERSIONS[encoding]))
    return converted


def decode_compressed_image(data: Data) -> Image:
    """Decode a `sensor_msgs/CompressedImage`, JPEG or PNG, to red, green and blue [H, W, 3].

    The format is recognized by the first bytes. ImageError is raised if the image is damaged. The orientation tag of
    a JPEG is ignored, so that x counts along the rows of the sensor.
    """
    content, size = strip_image_metadata(bytes(data))
    _check_size(*size)
    cv = import_opencv()
    image = _decoded(cv, np.frombuffer(content, np.uint8))
    if image is None:
        raise ImageError(problem="is damaged", remedy="check what the camera sends, and the connection")
    rgb: Image = cv.cvtColor(image, cv.COLOR_BGR2RGB)
    return rgb


def _decoded(cv: Any, content: NDArray[np.uint8]) -> Any:
    try:
        return cv.imdecode(content, cv.IMREAD_COLOR | cv.IMREAD_IGNORE_ORIENTATION)
    except cv.error:
        return None


def _check_size(width: int, height: int) -> None:
    if not (width > 0 and height > 0 and width * height <= MOST_PIXELS):
        remedy = f"at least one pixel, and at most {MOST_PIXELS}, are right"
        raise ImageError(problem=f"is {width} x {height} pixels", remedy=remedy)
