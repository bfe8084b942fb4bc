"""Colors from clicks and from images: what they find in images that they were not made from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.robots.scenes import (
    BLUE,
    BROWN,
    GRAY,
    GREEN,
    ORANGE,
    RED,
    WHITE,
    YELLOW,
    Disc,
    Image,
    render,
)  # fmt: skip

from understudy.addons.robots.camera.blobs import BlobDetector, Mask
from understudy.addons.robots.camera.calibration import (
    LabeledImage,
    calibrate_from_clicks,
    calibrate_from_images,
    calibrate_from_pixels,
)
from understudy.addons.robots.camera.color import Color, make_hsv_bounds
from understudy.addons.robots.camera.image_folder import detect_in_images, read_image_folder
from understudy.errors import FileError, SettingError

cv2 = pytest.importorskip("cv2", reason="needs the extra camera")

CLICKED = {"orange": ORANGE, "red": RED, "green": GREEN, "blue": BLUE, "yellow": YELLOW, "white": WHITE}


def all_colors(**options: Any) -> tuple[Image, dict[str, tuple[int, int]]]:
    """A disc of each color, and where they are."""
    places = {name: (25 + 55 * (at % 3), 30 + 60 * (at // 3)) for at, name in enumerate(CLICKED)}
    discs: list[Disc] = [(*places[name], 15.0, color) for name, color in CLICKED.items()]
    return render(*discs, **options), places


def test_clicks_find_each_color_in_another_light() -> None:
    image, places = all_colors(noise=3.0)
    colors = {name: calibrate_from_clicks(image, [place]) for name, place in places.items()}
    darker, _ = all_colors(noise=5.0, shade=0.35, seed=1)
    found = BlobDetector(colors).detect(darker)
    for name, (x, _) in places.items():
        blob = found[name]
        assert blob is not None, name
        assert blob.x == pytest.approx(x, abs=2.0), name
        assert blob.size == pytest.approx(900.0, rel=0.25), name


@given(st.tuples(*[st.integers(0, 255)] * 3), st.integers(0, 20), st.integers(0, 99))
@settings(max_examples=100)
def test_what_was_clicked_is_in_its_color(pixel: tuple[int, int, int], noise: int, seed: int) -> None:
    spread = np.random.default_rng(seed).integers(-noise, noise + 1, (7, 7, 3))
    image = np.clip(np.array(pixel) + spread, 0, 255).astype(np.uint8)
    try:
        color = calibrate_from_clicks(image, [(3, 3)])
    except SettingError:
        return  # dark or dull: noise makes any hue of it
    assert np.mean(BlobDetector({"it": color}).masks(image)["it"][1:-1, 1:-1] > 0) > 0.7


def test_hue_of_red_crosses_the_seam() -> None:
    pixels = np.array([(200, 0, 20), (200, 20, 0), (200, 5, 5)], np.uint8)  # hues 354, 6 and 0
    first, last = calibrate_from_pixels(pixels).hue_deg
    assert 340.0 < first < 350.0
    assert 10.0 < last < 20.0


def test_margins() -> None:
    """By 8 degrees of hue, down to 0.7 of the saturation and 0.4 of the value."""
    color = calibrate_from_pixels(
        np.array([(200, 50, 50)] * 9, np.uint8)
    )  # hue 0, saturation 191 and value 200 of 255
    assert color == Color(hue_deg=(352.0, 8.0), saturation=(0.52, 1.0), value=(0.31, 1.0))


def test_several_colors_are_refused() -> None:
    image, places = all_colors()
    with pytest.raises(
        SettingError, match=r"clicks: pixels are of hues \d+ degrees apart; show one color at a time"
    ):
        calibrate_from_clicks(image, [places["orange"], places["blue"]])


def test_click_outside() -> None:
    with pytest.raises(
        SettingError, match=r"a click is \(160, 5\); give a pixel of the image, which is 160 x 120"
    ):
        calibrate_from_clicks(render(), [(160, 5)])


def test_no_click() -> None:
    with pytest.raises(SettingError, match="pixels are none"):
        calibrate_from_clicks(render(), [])


def render_labeled(*discs: Disc, **options: Any) -> LabeledImage:
    """The scene, in which the last disc is the thing."""
    x, y, radius, _ = discs[-1]
    down, across = np.mgrid[0:120, 0:160] + 0.5
    mask: Mask = (np.hypot(across - x, down - y) <= radius).astype(np.uint8) * 255
    return LabeledImage(render(*discs, **options), mask)


def test_mask_keeps_a_like_color_out() -> None:
    amber = (235, 150, 22)  # of hue 36; ORANGE is 27
    scenes = [
        render_labeled((40, 60, 15, amber), (110, 60, 15, ORANGE), noise=3.0, shade=0.3),
        render_labeled((120, 40, 20, amber), (50, 70, 10, ORANGE), noise=3.0, seed=1),
    ]
    camera = BlobDetector({"it": calibrate_from_images(scenes)})
    found = camera.detect(
        render_labeled((100, 60, 25, amber), (40, 50, 12, ORANGE), noise=3.0, seed=2).image
    )["it"]
    assert found is not None
    assert found.x == pytest.approx(40.0, abs=1.5)
    careless = BlobDetector({"it": calibrate_from_images([middle(ORANGE)])})
    assert careless.detect(render((100, 60, 25, amber)))["it"] is not None, "easily told apart"


def middle(color: tuple[int, int, int]) -> LabeledImage:
    return LabeledImage(render((80, 60, 20, color), noise=3.0))


def save_image(folder: Path, name: str, image: Image | Mask) -> None:
    pixels = image[:, :, ::-1] if image.ndim == 3 else image
    cv2.imwrite(str(folder / name), pixels)


def test_folder(tmp_path: Path) -> None:
    shown = render_labeled((40, 60, 15, RED), (110, 60, 15, GREEN), noise=3.0, shade=0.3)
    save_image(tmp_path, "a.jpg", shown.image)
    save_image(tmp_path, "a.mask.png", np.asarray(shown.mask))
    save_image(tmp_path, "b.png", middle(GREEN).image)
    (tmp_path / "notes.txt").write_text("no image")
    pictures = read_image_folder(tmp_path)
    color = calibrate_from_images([picture.shown for picture in pictures], where=str(tmp_path))
    first, second = detect_in_images(pictures, color)
    assert first.name == "a.jpg"
    assert first.blob is not None
    assert first.blob.x == pytest.approx(110.0, abs=1.0)
    assert first.thing is not None
    assert first.thing > 0.95
    assert first.rest is not None
    assert first.rest < 0.02
    assert second.blob is not None
    assert second.thing is None


def test_mask_as_jpeg(tmp_path: Path) -> None:
    shown = render_labeled((40, 60, 15, RED), (110, 60, 15, GREEN))
    save_image(tmp_path, "a.png", shown.image)
    save_image(tmp_path, "a.mask.jpg", np.asarray(shown.mask) // 2 + 60)
    (picture,) = read_image_folder(tmp_path)
    np.testing.assert_array_equal(picture.shown.mask, shown.mask)


def broken(folder: Path) -> None:
    (folder / "a.png").write_bytes(b"no image")


def orphan(folder: Path) -> None:
    save_image(folder, "a.png", render())
    save_image(folder, "b.mask.png", np.zeros((120, 160), np.uint8))


def other_size(folder: Path) -> None:
    save_image(folder, "a.png", render())
    save_image(folder, "a.mask.png", np.zeros((60, 80), np.uint8))


def leave_empty(folder: Path) -> None:
    """It stays empty."""


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (broken, "a.png: begins with b'no image'"),
        (orphan, "b.mask.png: is a mask of no image; put b.png beside it"),
        (other_size, "a.mask.png: is 80 x 60 pixels; make it as large as a.png, 160 x 120"),
        (leave_empty, "holds no images"),
    ],
)
def test_folder_that_cannot_be(made: Any, said: str, tmp_path: Path) -> None:
    made(tmp_path)
    with pytest.raises(FileError, match=said):
        read_image_folder(tmp_path)


def test_no_folder(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="give a folder of images"):
        read_image_folder(tmp_path / "none")


# Hue in 256 steps: 360 degrees are 256, so that 90 degrees are 64.
BOUNDS = [
    ((90.0, 180.0), [(64, 128)]),
    ((0.0, 360.0), [(0, 255)]),
    ((270.0, 90.0), [(192, 255), (0, 64)]),
    ((180.0, 360.0), [(128, 255), (0, 0)]),
    ((359.9, 90.0), [(0, 64)]),
    ((90.0, 90.0), [(64, 64)]),
]


@pytest.mark.parametrize(("hue_deg", "steps"), BOUNDS)
def test_bounds(hue_deg: tuple[float, float], steps: list[tuple[int, int]]) -> None:
    expected = [((low, 51, 102), (high, 255, 255)) for low, high in steps]
    assert make_hsv_bounds(Color(hue_deg=hue_deg, saturation=(0.2, 1.0), value=(0.4, 1.0))) == expected


@pytest.mark.parametrize("ground", [GRAY, BROWN, BLUE])
def test_middle_of_images(ground: tuple[int, int, int]) -> None:
    color = calibrate_from_images([middle(ORANGE), middle(ORANGE)])
    found = BlobDetector({"it": color}).detect(render((30, 30, 10, ORANGE), ground=ground, shade=0.4))["it"]
    assert found is not None
    assert found.x == pytest.approx(30.0, abs=1.0)
