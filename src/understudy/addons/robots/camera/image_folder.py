"""Folders of images for calibration: images of an object, and masks of them if there are any."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from understudy.addons.robots.camera.blobs import Blob, BlobDetector, Image, Mask
from understudy.addons.robots.camera.calibration import LabeledImage
from understudy.addons.robots.camera.color import Color
from understudy.addons.robots.camera.image_decoding import ImageError, decode_compressed_image
from understudy.errors import FileError

ENDINGS = (".png", ".jpg", ".jpeg")
MASK = ".mask"
"""The ending of masks: `ball1.mask.png` belongs to `ball1.png` or `ball1.jpg`.

A mask is white where the object is and black elsewhere.
"""


class CalibrationImage(NamedTuple):
    """An image of a folder, with its mask if there is one."""

    name: str
    shown: LabeledImage


class DetectionResult(NamedTuple):
    """The result of detecting a color in an image.

    `thing` and `rest` are the shares of the object and of the other pixels that have the color; None without a mask.
    """

    name: str
    blob: Blob | None
    thing: float | None
    rest: float | None


def read_image_folder(folder: Path | str) -> tuple[CalibrationImage, ...]:
    """Read the images of a folder, by name; raise FileError if there are none or one cannot be read."""
    try:
        files = sorted(
            file for file in Path(folder).iterdir() if file.suffix.lower() in ENDINGS and file.is_file()
        )
    except OSError as error:
        problem = error.strerror or str(error)
        raise FileError(path=folder, place="", problem=problem, remedy="give a folder of images") from None
    masks = {file.stem.removesuffix(MASK): file for file in files if file.stem.endswith(MASK)}
    images = [file for file in files if not file.stem.endswith(MASK)]
    if not images:
        remedy = "put images of the thing there, PNG or JPEG"
        raise FileError(path=folder, place="", problem="holds no images", remedy=remedy)
    if orphans := [masks[stem] for stem in masks if stem not in {file.stem for file in images}]:
        remedy = f"put {orphans[0].stem.removesuffix(MASK)}.png beside it, or remove it"
        raise FileError(path=orphans[0], place="", problem="is a mask of no image", remedy=remedy)
    return tuple(CalibrationImage(file.name, _shown(file, masks.get(file.stem))) for file in images)


def detect_in_images(pictures: tuple[CalibrationImage, ...], color: Color) -> tuple[DetectionResult, ...]:
    """Detect a color in each image, to judge how well it works."""
    camera = BlobDetector({"it": color})
    return tuple(_found(camera, picture) for picture in pictures)


def _found(camera: BlobDetector, picture: CalibrationImage) -> DetectionResult:
    image, mask = picture.shown
    blob = camera.detect(image)["it"]
    if mask is None:
        return DetectionResult(picture.name, blob, None, None)
    taken, there = camera.masks(image)["it"] > 0, mask > 0
    return DetectionResult(picture.name, blob, _share(taken[there]), _share(taken[~there]))


def _share(flags: Any) -> float | None:
    return float(flags.mean()) if flags.size else None


def _shown(file: Path, mask_file: Path | None) -> LabeledImage:
    image = _read(file)
    if mask_file is None:
        return LabeledImage(image)
    mask: Mask = _read(mask_file)[:, :, 0]
    if mask.shape != image.shape[:2]:
        (tall, wide), (height, width) = mask.shape, image.shape[:2]
        problem, remedy = f"is {wide} x {tall} pixels", f"make it as large as {file.name}, {width} x {height}"
        raise FileError(path=mask_file, place="", problem=problem, remedy=remedy)
    # A mask saved as JPEG is only nearly black and white.
    return LabeledImage(image, (mask > 127).astype(mask.dtype) * 255)


def _read(file: Path) -> Image:
    try:
        return decode_compressed_image(file.read_bytes())
    except ImageError as error:
        raise FileError(path=file, place="", problem=error.problem, remedy=error.remedy) from None
    except OSError as error:
        problem = error.strerror or str(error)
        raise FileError(
            path=file, place="", problem=problem, remedy="give an image that can be read"
        ) from None
