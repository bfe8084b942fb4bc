"""Images as robots send them: known pixels in every encoding, and whatever may come instead."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from understudy.addons.robots.camera.blobs import Image
from understudy.addons.robots.camera.image_decoding import (
    CHANNELS,
    ImageError,
    decode_compressed_image,
    decode_image,
)

cv2 = pytest.importorskip("cv2", reason="needs the extra camera")

# Two pixels: their bytes as they come, and what they are. YUV is that of ITU-R BT.601 with room above and below.
PIXELS = [
    ("rgb8", (1, 2, 3, 4, 5, 6), (1, 2, 3), (4, 5, 6)),
    ("bgr8", (1, 2, 3, 4, 5, 6), (3, 2, 1), (6, 5, 4)),
    ("rgba8", (1, 2, 3, 9, 4, 5, 6, 9), (1, 2, 3), (4, 5, 6)),
    ("bgra8", (1, 2, 3, 9, 4, 5, 6, 9), (3, 2, 1), (6, 5, 4)),
    ("mono8", (7, 8), (7, 7, 7), (8, 8, 8)),
    ("yuv422", (128, 235, 128, 16), (255, 255, 255), (0, 0, 0)),
    ("uyvy", (90, 82, 240, 82), (255, 0, 0), (255, 0, 0)),
    ("yuv422_yuy2", (235, 128, 16, 128), (255, 255, 255), (0, 0, 0)),
    ("yuyv", (82, 90, 82, 240), (255, 0, 0), (255, 0, 0)),
]


@pytest.mark.parametrize(("encoding", "sent", "first", "second"), PIXELS, ids=[row[0] for row in PIXELS])
@pytest.mark.parametrize("padding", [0, 3])
def test_encoding(
    encoding: str, sent: tuple[int, ...], first: tuple[int, ...], second: tuple[int, ...], padding: int
) -> None:
    row = bytes(sent) + bytes(padding)
    image = decode_image(row * 2, encoding=encoding, width=2, height=2, step=len(row))
    assert image.shape == (2, 2, 3)
    assert image.dtype == np.uint8
    np.testing.assert_allclose(image[0].astype(int), [first, second], atol=1)
    np.testing.assert_array_equal(image[0], image[1])


def picture() -> Image:
    """Soft red above, blue below, so that JPEG keeps it."""
    image = np.zeros((24, 40, 3), np.uint8)
    image[:12], image[12:] = (200, 40, 30), (20, 60, 180)
    return image


def compress(ending: str, image: Image | None = None) -> bytes:
    content: bytes = cv2.imencode(ending, (picture() if image is None else image)[:, :, ::-1])[1].tobytes()
    return content


@pytest.mark.parametrize(("ending", "off"), [(".png", 0), (".jpg", 12)])
def test_compressed(ending: str, off: int) -> None:
    image = decode_compressed_image(compress(ending))
    np.testing.assert_allclose(image.astype(int)[[4, 20]], picture().astype(int)[[4, 20]], atol=off)


def test_compressed_gray() -> None:
    gray = cv2.imencode(".png", np.full((3, 4), 77, np.uint8))[1].tobytes()
    np.testing.assert_array_equal(decode_compressed_image(gray), np.full((3, 4, 3), 77))


def test_zeros_after_jpeg() -> None:
    assert decode_compressed_image(compress(".jpg") + bytes(5)).shape == (24, 40, 3)


def huge_png() -> bytes:
    content = bytearray(compress(".png"))
    struct.pack_into(">II", content, 16, 60_000, 60_000)
    struct.pack_into(">I", content, 29, zlib.crc32(content[12:29]))
    return bytes(content)


def huge_jpeg() -> bytes:
    content = bytearray(compress(".jpg"))
    struct.pack_into(">HH", content, content.index(b"\xff\xc0") + 5, 60_000, 60_000)
    return bytes(content)


def long_chunk() -> bytes:
    """Its pixels claim to be 2 GB."""
    content = bytearray(compress(".png"))
    struct.pack_into(">I", content, content.index(b"IDAT") - 4, 2**31)
    return bytes(content)


def change_pixels() -> bytes:
    content = bytearray(compress(".png"))
    content[content.index(b"IDAT") + 10] ^= 1
    return bytes(content)


def chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def no_pixels() -> bytes:
    """A PNG that is whole, and empty."""
    return compress(".png")[:33] + chunk(b"IEND", b"")


def test_png_with_words() -> None:
    content = compress(".png")
    wordy = content[:33] + chunk(b"tEXt", b"Title\0red above, blue below") + content[33:]
    np.testing.assert_array_equal(decode_compressed_image(wordy), picture())


def test_orientation_is_not_looked_at() -> None:
    content = compress(".jpg")
    tags = b"Exif\0\0MM\0*" + struct.pack(">IHHHIHHI", 8, 1, 0x0112, 3, 1, 6, 0, 0)  # turned by 90 degrees
    turned = content[:2] + b"\xff\xe1" + struct.pack(">H", len(tags) + 2) + tags + content[2:]
    assert decode_compressed_image(turned).shape == (24, 40, 3)


RAW_WRONG = [
    ({"encoding": "16UC1"}, "its encoding is '16UC1'; let the camera send one of rgb8"),
    ({"height": 0}, "is 2 x 0 pixels"),
    ({"width": 2**31, "height": 2**31}, "at most 8388608"),
    ({"step": 5}, "its rows are 5 bytes long; 2 pixels of rgb8 take 6"),
    ({"step": 7}, "holds 12 bytes; 2 rows of 7 bytes are 14"),
    ({"encoding": "yuyv", "width": 3}, "is 3 pixels wide in yuyv"),
]


@pytest.mark.parametrize(("change", "said"), RAW_WRONG, ids=lambda value: str(value)[:30])
def test_wrong_image(change: dict[str, object], said: str) -> None:
    fields = {"encoding": "rgb8", "width": 2, "height": 2, "step": 6} | change
    with pytest.raises(ImageError, match=said):
        decode_image(bytes(12), **fields)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "begins with b''; let the camera send JPEG or PNG"),
        (b"GIF89a" + bytes(50), "begins with b'GIF89a"),
        (huge_png, "is 60000 x 60000 pixels"),
        (huge_jpeg, "is 60000 x 60000 pixels"),
        (lambda: compress(".jpg")[:-40], "is a JPEG that was cut off"),
        (lambda: compress(".png")[:40], "is a PNG that was cut off"),
        (lambda: compress(".png")[:-12], "is a PNG that was cut off"),
        (long_chunk, "is a PNG that is damaged"),
        (change_pixels, "is a PNG that is damaged"),
        (no_pixels, "is damaged; check what the camera sends"),
        (b"\xff\xd8\xff\xd9", "without a size"),
    ],
    ids=lambda value: getattr(
        value, "__name__", str(value)[:20]
    ),  # a function's address differs in each process
)
def test_wrong_compressed(content: object, said: str) -> None:
    with pytest.raises(ImageError, match=said):
        decode_compressed_image(content() if callable(content) else content)  # type: ignore[arg-type]


@given(
    st.sampled_from((".jpg", ".png")),
    st.lists(st.tuples(st.integers(0, 2000), st.integers(0, 255)), max_size=12),
)
@settings(max_examples=150)
@example(".jpg", [])
def test_damaged_is_an_image_or_an_error(ending: str, changes: list[tuple[int, int]]) -> None:
    content = bytearray(compress(ending))
    for at, value in changes:
        content[at % len(content)] = value
    try:
        image = decode_compressed_image(bytes(content))
    except ImageError:
        return
    assert image.ndim == 3
    assert image.shape[2] == 3


@given(
    st.sampled_from(sorted(CHANNELS)),
    st.integers(-3, 6),
    st.integers(-3, 6),
    st.integers(-3, 30),
    st.binary(max_size=120),
)
@settings(max_examples=200)
def test_any_fields_are_an_image_or_an_error(
    encoding: str, width: int, height: int, step: int, data: bytes
) -> None:
    try:
        image = decode_image(data, encoding=encoding, width=width, height=height, step=step)
    except ImageError:
        return
    assert image.shape == (height, width, 3)
