"""Commands `understudy robots check` and `understudy robots color`: check real robots, and calibrate their cameras."""

from __future__ import annotations

from collections.abc import Mapping
from math import isnan
from time import sleep

import typer
from rich.markup import escape

from understudy.addons.robots.camera.calibration import calibrate_from_images
from understudy.addons.robots.camera.config import HEADING, check_color_name, format_color_line, write_color
from understudy.addons.robots.camera.image_folder import DetectionResult, detect_in_images, read_image_folder
from understudy.addons.robots.diagnostics import ConnectionReport, diagnose_connection
from understudy.addons.robots.fleet import connect_robot, connect_team
from understudy.addons.robots.robot_file import is_team_file
from understudy.errors import join_names
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.output import make_console, make_table
from understudy.ui.cli.robots_options import RobotColorOptions, RobotsCheckOptions

NOTHING = 1e-6
"""Magnitude below which values are shown as 0, to hide rounding errors."""


def check_robots(options: RobotsCheckOptions) -> None:
    """Connect to robots and show which readings arrive, their rate and age, and what is missing."""
    team = is_team_file(options.file)
    with connect_team(options.file) if team else connect_robot(options.file) as fleet:
        sleep(options.seconds)
        found = [diagnose_connection(robot, seconds=options.seconds) for robot in fleet]
    if options.as_json:
        print_json({"robots": found} if team else found[0])
    else:
        for each in found:
            _show(each)
    if any(each.problems for each in found):
        raise typer.Exit(1)


def _show(found: ConnectionReport) -> None:
    made = make_table("reading", "#rate", "#age", "~value", "~topic", title=found.name)
    for each in found.arrivals:
        made.add_row(
            each.name + "*" * each.required,
            _measured(each.rate_hz, "Hz"),
            _measured(each.age_s, "s"),
            _values(each.values, each.unit),
            each.topic,
        )
    out = make_console()
    out.print(made)
    if any(each.required for each in found.arrivals):
        out.print("* required: the robot stops without it.", markup=False)
    for problem in found.problems:
        out.print(problem, markup=False)
    if found.lacks:
        out.print(f"Lessons that ask for {join_names(found.lacks)} find that absent.", markup=False)
    if not found.problems:
        out.print(f"{found.name}: all is there.", markup=False)


def _values(values: Mapping[str, float], unit: str) -> str:
    """Format one value with its unit, or the present values grouped by target: ball x 80, size 120 px."""
    if len(values) == 1:
        return _measured(next(iter(values.values())), unit)
    seen: dict[str, list[str]] = {}
    for name, value in values.items():
        if not isnan(value):
            what, _, target = name.removesuffix(")").partition("(")
            seen.setdefault(target, []).append(f"{what.removeprefix('blob_')} {value:.3g}")
    return (
        ", ".join(f"{name} {', '.join(each)} {unit}" for name, each in seen.items())
        or "detects no known color"
    )


def _measured(value: float, unit: str) -> str:
    if isnan(value):
        return "absent"
    return f"{0.0 if abs(value) < NOTHING else value:.3g} {unit}".rstrip()


def calibrate_color(options: RobotColorOptions) -> None:
    """Find the color by which a robot's camera detects an object, from images of it."""
    check_color_name(options.name)
    pictures = read_image_folder(options.folder)
    found_color = calibrate_from_images([picture.shown for picture in pictures], where=str(options.folder))
    found = detect_in_images(pictures, found_color)
    if options.robot is not None:
        write_color(options.robot, options.name, found_color)
    if options.as_json:
        told = {"name": options.name, "color": found_color, "images": [_told(each) for each in found]}
        print_json(told if options.robot is None else {**told, "saved": str(options.robot)})
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
    out.print(escape(format_color_line(options.name, found_color)), soft_wrap=True)
    if options.robot is not None:
        out.print(f"Saved to [bold]{escape(str(options.robot))}[/]", soft_wrap=True)


def _told(found: DetectionResult) -> dict[str, object]:
    x, size = (None, None) if found.blob is None else found.blob
    return {"name": found.name, "x": x, "size": size, "thing_found": found.thing, "rest_taken": found.rest}


def _percent(share: float | None) -> str:
    return "" if share is None else f"{100.0 * share:.1f} %"
