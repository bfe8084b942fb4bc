"""Command `understudy robots color`: calibrate a camera color from images and write it to a robot's file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from understudy.ui.cli.options import Json

if TYPE_CHECKING:
    from understudy.robots.camera.image_folder import DetectionResult


def calibrate_color(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Folder with images of the object, PNG or JPEG.")
    ],
    name: Annotated[
        str, typer.Option("--name", "-n", help="Name of the target that has this color, such as ball.")
    ],
    robot: Annotated[
        Path | None, typer.Option("--robot", metavar="FILE", help="Write the color into this robot's file.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Find the color by which a robot's camera detects an object, from images of it.

    The object has to fill the middle of each image. Alternatively, ball1.png can have a mask beside it,
    ball1.mask.png, which is white where the object is. With masks, the color range is made narrow enough to exclude
    the rest of the images. Take the images with the robot's own camera, in every lighting that will occur.

    [dim]understudy robots color images/ball --name ball --robot rover.toml[/]
    """
    from rich.markup import escape

    from understudy.robots.camera.calibration import calibrate_from_images
    from understudy.robots.camera.config import HEADING, check_color_name, format_color_line, write_color
    from understudy.robots.camera.image_folder import detect_in_images, read_image_folder
    from understudy.ui.cli.output import make_console, make_table, print_json

    check_color_name(name)
    pictures = read_image_folder(folder)
    found_color = calibrate_from_images([picture.shown for picture in pictures], where=str(folder))
    found = detect_in_images(pictures, found_color)
    if robot is not None:
        write_color(robot, name, found_color)
    if as_json:
        told = {"name": name, "color": found_color, "images": [_told(each) for each in found]}
        print_json(told if robot is None else {**told, "saved": str(robot)})
        return
    out, made = (
        make_console(),
        make_table("image", "#x (px)", "#size (px)", "#of it found", "#of the rest taken"),
    )
    for each in found:
        x, size = ("not seen", "") if each.blob is None else (f"{each.blob.x:.1f}", f"{each.blob.size:.0f}")
        made.add_row(escape(each.name), x, size, _percent(each.thing), _percent(each.rest))
    out.print(made)
    out.print(escape(HEADING), soft_wrap=True)
    out.print(escape(format_color_line(name, found_color)), soft_wrap=True)
    if robot is not None:
        out.print(f"Saved to [bold]{escape(str(robot))}[/]", soft_wrap=True)


def _told(found: DetectionResult) -> dict[str, object]:
    x, size = (None, None) if found.blob is None else found.blob
    return {"name": found.name, "x": x, "size": size, "thing_found": found.thing, "rest_taken": found.rest}


def _percent(share: float | None) -> str:
    return "" if share is None else f"{100.0 * share:.1f} %"
