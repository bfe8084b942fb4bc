"""Blobs in images whose truth is known."""

from __future__ import annotations

from math import isnan, radians, tan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.robots.scenes import (
    BLUE,
    BROWN,
    GREEN,
    GREENS,
    ORANGE,
    ORANGES,
    RED,
    REDS,
    WHITE,
    Image,
    render,
)

from understudy.addons.robots.camera.blobs import Blob, BlobDetector, FrameGeometry
from understudy.addons.robots.camera.color import Color
from understudy.errors import SettingError

pytest.importorskip("cv2", reason="needs the extra camera")

COLORS = {"ball": ORANGES, "boss": REDS, "intruder": GREENS}


def paint_box(left: int, top: int, width: int, height: int, *, shape: tuple[int, int] = (120, 160)) -> Image:
    """A box of orange on black."""
    image = np.zeros((*shape, 3), np.uint8)
    image[top : top + height, left : left + width] = ORANGE
    return image


def ball(image: Image, **options: float | FrameGeometry | None) -> Blob | None:
    return BlobDetector({"ball": ORANGES}, **options).detect(image)["ball"]  # type: ignore[arg-type]


# x is the middle between the edges, in pixels from the left edge of the frame; size is that of the box.
BOXES = [
    ("in the middle", (70, 50, 20, 10), Blob(80.0, 200.0)),
    ("an odd width", (0, 50, 15, 10), Blob(7.5, 150.0)),
    ("at the right edge", (150, 0, 10, 120), Blob(155.0, 1200.0)),
    ("all of it", (0, 0, 160, 120), Blob(80.0, 19200.0)),
    ("a speck", (80, 60, 1, 1), None),
    ("nothing", (0, 0, 0, 0), None),
]


@pytest.mark.parametrize(
    ("what", "box", "expected"), BOXES, ids=lambda value: value if isinstance(value, str) else ""
)
def test_box(what: str, box: tuple[int, int, int, int], expected: Blob | None) -> None:
    assert ball(paint_box(*box)) == expected


# The simulated frame over other images: [H, W] of the image, its angle of view, a box in it, and its blob in the frame.
HALVED = 2.0 * np.rad2deg(np.arctan(0.5 * tan(radians(30.0))))  # sees half as far to the sides as 60 degrees
DOUBLED = 2.0 * np.rad2deg(np.arctan(2.0 * tan(radians(30.0))))
FRAMES = [
    ("twice as fine", (240, 320), None, (140, 100, 40, 20), Blob(80.0, 200.0)),
    ("half as fine", (60, 80), None, (35, 25, 10, 5), Blob(80.0, 200.0)),
    ("wide: its full width", (90, 160), None, (0, 40, 20, 10), Blob(10.0, 200.0)),
    (
        "tall: above and below it there is nothing",
        (160, 160),
        None,
        (70, 0, 20, 160),
        Blob(80.0, 20.0 * 120.0),
    ),
    ("a narrow view is a part of the frame", (120, 160), HALVED, (0, 50, 40, 20), Blob(50.0, 200.0)),
    ("of a wide view a part counts", (240, 320), DOUBLED, (80, 100, 20, 10), Blob(10.0, 200.0)),
    ("of a wide view the rest does not", (240, 320), DOUBLED, (0, 100, 80, 20), None),
]


@pytest.mark.parametrize(
    ("what", "shape", "view_deg", "box", "expected"),
    FRAMES,
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_frame(
    what: str,
    shape: tuple[int, int],
    view_deg: float | None,
    box: tuple[int, int, int, int],
    expected: Blob | None,
) -> None:
    assert ball(paint_box(*box, shape=shape), view_deg=view_deg) == (expected and pytest.approx(expected))


def test_absent_together() -> None:
    readings = BlobDetector({"ball": ORANGES, "boss": REDS}).readings(paint_box(70, 50, 20, 10))
    assert readings["blob_x", "ball"] == 80.0
    assert readings["blob_size", "ball"] == 200.0
    assert isnan(readings["blob_x", "boss"])
    assert isnan(readings["blob_size", "boss"])


def test_largest_region_counts() -> None:
    image = paint_box(10, 10, 10, 10) + paint_box(100, 50, 20, 20)
    assert ball(image) == Blob(110.0, 400.0)


def test_of_equals_the_leftmost() -> None:
    image = paint_box(100, 10, 10, 10) + paint_box(30, 50, 10, 10)
    assert ball(image) == Blob(35.0, 100.0)


def test_red_crosses_the_seam() -> None:
    image = np.zeros((120, 160, 3), np.uint8)
    image[50:60, 70:80], image[50:60, 80:90] = (220, 0, 20), (220, 20, 0)  # hues 355 and 5
    assert BlobDetector({"boss": REDS}).detect(image)["boss"] == Blob(80.0, 200.0)


def test_shade_noise_and_distractors() -> None:
    image = render(
        (40, 60, 14, ORANGE), (90, 40, 9, RED), (125, 80, 11, GREEN), (20, 20, 15, BLUE), (140, 20, 15, BROWN),
        (70, 100, 12, WHITE), shade=0.55, noise=6.0,
    )  # fmt: skip
    found = BlobDetector(COLORS).detect(image)
    for name, (x, radius) in {"ball": (40, 14), "boss": (90, 9), "intruder": (125, 11)}.items():
        blob = found[name]
        assert blob is not None
        assert blob.x == pytest.approx(x, abs=1.0)
        assert blob.size == pytest.approx((2 * radius) ** 2, rel=0.15)


def test_no_blob_in_noise() -> None:
    found = BlobDetector(COLORS).detect(render(ground=BROWN, noise=25.0))
    assert found == dict.fromkeys(COLORS)


@given(
    across=st.integers(-30, 30),
    down=st.integers(-20, 20),
    radius=st.integers(4, 25),
    shade=st.floats(0.0, 0.5),
)
@settings(max_examples=12)
def test_shifted(across: int, down: int, radius: int, shade: float) -> None:
    before, after = (
        ball(render((80 + dx, 60 + dy, radius, ORANGE), shade=shade)) for dx, dy in ((0, 0), (across, down))
    )
    assert before is not None
    assert after == Blob(before.x + across, before.size)


@given(
    x=st.floats(30.0, 130.0),
    y=st.floats(30.0, 90.0),
    radius=st.floats(6.0, 25.0),
    times=st.sampled_from((0.5, 2.0)),
)
@settings(max_examples=12)
def test_finer_image_same_blob(x: float, y: float, radius: float, times: float) -> None:
    blob = ball(render((x, y, radius, ORANGE), times=times))
    assert blob is not None
    coarse = max(1.0, 1.0 / times)
    assert blob.x == pytest.approx(x, abs=1.0 * coarse)
    assert blob.size**0.5 == pytest.approx(2.0 * radius, abs=2.0 * coarse)


@given(seed=st.integers(0, 1000), noise=st.floats(0.0, 10.0))
@settings(max_examples=12)
def test_mirrored(seed: int, noise: float) -> None:
    image = render((50, 60, 12, ORANGE), shade=0.4, noise=noise, seed=seed)
    seen, mirrored = ball(image), ball(np.ascontiguousarray(image[:, ::-1]))
    assert seen is not None
    assert mirrored == pytest.approx(Blob(160.0 - seen.x, seen.size))


WRONG = [
    (Color(hue_deg=(-5.0, 10.0)), "hue_deg"),
    (Color(hue_deg=(float("nan"), 10.0)), "hue_deg"),
    (Color(saturation=(0.8, 0.2)), "saturation"),
    (Color(value=(0.0, 255.0)), "value"),
]


@pytest.mark.parametrize(("color", "key"), WRONG)
def test_color_that_cannot_be(color: Color, key: str) -> None:
    with pytest.raises(SettingError, match=f"color 'ball': {key} is"):
        BlobDetector({"ball": color})


def test_view_that_cannot_be() -> None:
    with pytest.raises(SettingError, match="view_deg is 180"):
        BlobDetector({}, view_deg=180.0)
