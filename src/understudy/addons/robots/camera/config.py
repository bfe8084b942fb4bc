"""The camera's table in a robot file: the source of its images, and the colors, which calibration writes there."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any, Literal

from msgspec import field

from understudy.addons.robots.camera.blobs import LEAST_PX, BlobDetector
from understudy.addons.robots.camera.color import Color
from understudy.errors import DefinitionError, FileError, SettingError
from understudy.sim.scenario.squad_schema import StrictStruct
from understudy.sim.scenario.toml_decode import parse_toml
from understudy.storage.atomic_write import write_atomically

CAMERA, COLORS = "camera", "colors"
HEADING = f"[{CAMERA}.{COLORS}]"
NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
_HEADING = re.compile(r"\s*\[\s*camera\s*\.\s*colors\s*\]\s*(#.*)?")
_ANY_HEADING = re.compile(r"\s*\[")


class CameraSpec(StrictStruct, frozen=True, kw_only=True):
    """The source of a camera's images, and the colors of targets, which give the readings `blob_x` and `blob_size`.

    `view_deg` is the horizontal angle of view; by default that of the simulated camera, 60. Blobs of fewer than
    `least_px` pixels of the simulated frame are absent, and so are all if the image is older than `stale_s`.
    """

    topic: str = "image_raw/compressed"
    type: Literal["sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"] = (
        "sensor_msgs/msg/CompressedImage"
    )
    view_deg: float | None = None
    least_px: float = LEAST_PX
    rate_hz: float | None = None
    stale_s: float = 0.5
    required: bool = False
    colors: Mapping[str, Color] = field(default_factory=dict)

    def camera(self) -> BlobDetector:
        """Make the detector for this camera.

        SettingError is raised if a setting is invalid, and ExtraMissing if OpenCV is not installed.
        """
        for key, value in (("least_px", self.least_px), ("stale_s", self.stale_s)):
            if not (isfinite(value) and value > 0.0):
                raise SettingError(
                    where=CAMERA, setting=key, problem=f"is {value}", remedy="give a number above 0"
                )
        return BlobDetector(self.colors, view_deg=self.view_deg, least_px=self.least_px)


def check_color_name(name: str) -> None:
    """Refuse a name of a color that cannot be the name of a target."""
    if not NAME.fullmatch(name):
        remedy = "use letters, digits and _, beginning with a letter: the name of the target, such as ball"
        raise DefinitionError(what=f"color {name!r:.40}", problem="is no name", remedy=remedy)


def format_color_line(name: str, color: Color) -> str:
    """Format a color as a line of TOML for the table [camera.colors]."""
    hue, saturation, value = (
        f"[{least:g}, {most:g}]" for least, most in (color.hue_deg, color.saturation, color.value)
    )
    return f"{name} = {{ hue_deg = {hue}, saturation = {saturation}, value = {value} }}"


def insert_color(content: str, name: str, color: Color, path: Path | str = "robot.toml") -> str:
    """Insert a color into the text of a robot file, or replace the one of its name; leave all other text unchanged.

    FileError is raised if the file writes its colors in a form that cannot be changed line by line.
    """
    check_color_name(name)
    before = parse_toml(content, path)
    line = format_color_line(name, color)
    lines = content.splitlines(keepends=True)
    heading = next((at for at, each in enumerate(lines) if _HEADING.fullmatch(each.rstrip("\r\n"))), None)
    if heading is None:
        gap = "" if not content else "\n" if content.endswith("\n") else "\n\n"
        changed = f"{content}{gap}{HEADING}\n{line}\n"
    else:
        end = next((at for at in range(heading + 1, len(lines)) if _ANY_HEADING.match(lines[at])), len(lines))
        old = re.compile(rf"""\s*(["']?){name}\1\s*=""")
        at = next((at for at in range(heading + 1, end) if old.match(lines[at])), None)
        last = max((at for at in range(heading, end) if lines[at].strip()), default=heading)
        if at is None and not lines[last].endswith("\n"):
            lines[last] += "\n"
        lines[last + 1 if at is None else at : last + 1 if at is None else at + 1] = [line + "\n"]
        changed = "".join(lines)
    if not _only_added(before, changed, name, color):
        place = f"{CAMERA}.{COLORS}"
        problem, remedy = "is written in a way that this cannot change", f"put there yourself: {line}"
        raise FileError(path=path, place=place, problem=problem, remedy=remedy)
    return changed


def write_color(path: Path | str, name: str, color: Color) -> None:
    """Write a color into a robot file atomically; raise FileError if that is impossible."""
    path = Path(path)
    try:
        content = path.read_bytes().decode("utf-8-sig")
    except (OSError, ValueError) as error:
        missing = isinstance(error, FileNotFoundError)
        problem = "there is no such file" if missing else f"cannot be read ({error})"
        raise FileError(path=path, place="", problem=problem, remedy="give a robot's file") from None
    write_atomically(path, insert_color(content, name, color, path).encode())


def _only_added(before: dict[str, Any], changed: str, name: str, color: Color) -> bool:
    """Return whether a changed text differs from the original document by nothing but the color."""
    camera = before.get(CAMERA, {})
    colors = camera.get(COLORS, {}) if isinstance(camera, dict) else None
    if not isinstance(colors, dict):
        return False
    wanted = {**before, CAMERA: {**camera, COLORS: {**colors, name: _plain(color)}}}
    try:
        return tomllib.loads(changed) == wanted
    except ValueError:
        return False


def _plain(color: Color) -> dict[str, list[float]]:
    return {each: list(getattr(color, each)) for each in color.__struct_fields__}
