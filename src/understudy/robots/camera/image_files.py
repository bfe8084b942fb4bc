"""PNG and JPEG files as they may come over a network: whether they are whole, and how large they claim to be.

A decoder believes what a file says. Damage to one length in a PNG made OpenCV 5 take 3 GB and 15 s, and a JPEG that
was cut off is decoded all the same, gray from there on. So files are walked through first, which takes microseconds.
"""

from __future__ import annotations

from struct import Struct
from typing import TypeAlias
from zlib import crc32

from understudy.errors import UnderstudyError

Size: TypeAlias = tuple[int, int]
"""Width and height, pixels."""

PNG, JPEG, JPEG_END = b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"\xff\xd9"
_PNG_CHUNK, _PNG_SUM, _PNG_SIZE = Struct(">I4s"), Struct(">I"), Struct(">II")
_PNG_PIXELS = (b"IHDR", b"PLTE", b"IDAT", b"IEND")
_PNG_HEAD_BYTES = 13
_JPEG_SEGMENT, _JPEG_SIZE = Struct(">BBH"), Struct(">xHH")
_JPEG_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}


class ImageError(UnderstudyError):
    """An image that cannot be read."""

    def __init__(self, *, problem: str, remedy: str) -> None:
        self.problem, self.remedy = problem, remedy
        super().__init__(f"image: {problem}; {remedy}")


def pixels_only(content: bytes) -> tuple[bytes, Size]:
    """A file with nothing in it but its pixels, and the size it claims; ImageError where it is not whole."""
    if content.startswith(PNG):
        return _png(content)
    if content.startswith(JPEG):
        if not content.rstrip(b"\0").endswith(JPEG_END):  # some cameras fill up with zeros
            raise ImageError(problem="is a JPEG that was cut off", remedy="look at the link to the camera")
        return content, _jpeg_size(content)
    raise ImageError(problem=f"begins with {content[:8]!r}", remedy="let the camera send JPEG or PNG")


def _png(content: bytes) -> tuple[bytes, Size]:
    """A PNG without texts, profiles and animation (PNG specification, 5.3)."""
    kept, at, kind = [PNG], len(PNG), b""
    view = memoryview(content)
    while kind != b"IEND":
        if at + 12 > len(content):
            raise ImageError(problem="is a PNG that was cut off", remedy="look at the link to the camera")
        length, kind = _PNG_CHUNK.unpack_from(content, at)
        end = at + 12 + length
        first = len(kept) == 1
        if end > len(content) or first != (kind == b"IHDR") or (first and length != _PNG_HEAD_BYTES):
            raise _damaged()
        if kind in _PNG_PIXELS:
            if crc32(view[at + 4 : end - 4]) != _PNG_SUM.unpack_from(content, end - 4)[0]:
                raise _damaged()
            kept.append(content[at:end])
        at = end
    width, height = _PNG_SIZE.unpack_from(kept[1], 8)
    return b"".join(kept), (width, height)


def _damaged() -> ImageError:
    return ImageError(problem="is a PNG that is damaged", remedy="look at the link to the camera")


def _jpeg_size(content: bytes) -> Size:
    """The size in the first frame header of a JPEG (ITU T.81, B.2.2)."""
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
    raise ImageError(problem="is a JPEG without a size", remedy="look at what the camera sends")
