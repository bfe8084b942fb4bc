"""The camera's part of a robot file: colors written between what a person wrote."""

from __future__ import annotations

import tomllib
from pathlib import Path

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from understudy.addons.robots.camera.color import Color, Share
from understudy.addons.robots.camera.config import CameraSpec, format_color_line, insert_color, write_color
from understudy.errors import DefinitionError, FileError, SettingError

BALL = Color(hue_deg=(15.5, 40.0), saturation=(0.6, 1.0), value=(0.25, 1.0))
LINE = "ball = { hue_deg = [15.5, 40], saturation = [0.6, 1], value = [0.25, 1] }\n"
HEADING = "[camera.colors]\n"

WRITTEN = [
    ("an empty file", "", HEADING + LINE),
    ("no camera", 'name = "rover"\n', 'name = "rover"\n\n' + HEADING + LINE),
    ("no end of line", 'name = "rover"', 'name = "rover"\n\n' + HEADING + LINE),
    ("a camera", '[camera]\ntopic = "image"\n', '[camera]\ntopic = "image"\n\n' + HEADING + LINE),
    ("no colors yet", HEADING + "\n[limits]\nspeed = 1\n", HEADING + LINE + "\n[limits]\nspeed = 1\n"),
    (
        "after others",
        HEADING + "# By day.\nhome = {}\n\n[limits]\n",
        HEADING + "# By day.\nhome = {}\n" + LINE + "\n[limits]\n",
    ),
    ("in its place", HEADING + "ball = {}\nhome = {} # blue\n", HEADING + LINE + "home = {} # blue\n"),
    ("in quotes", HEADING + '"ball" = {}\n', HEADING + LINE),
    ("at the end", HEADING + "home = {}", HEADING + "home = {}\n" + LINE),
    (
        "like another's name",
        HEADING + "football = {}\nballs = {}\n",
        HEADING + "football = {}\nballs = {}\n" + LINE,
    ),
    ("a heading with spaces", "[ camera . colors ] # them\n", "[ camera . colors ] # them\n" + LINE),
]


@pytest.mark.parametrize(("what", "before", "after"), WRITTEN, ids=[row[0] for row in WRITTEN])
def test_written(what: str, before: str, after: str) -> None:
    assert insert_color(before, "ball", BALL) == after
    assert insert_color(after, "ball", BALL) == after


@pytest.mark.parametrize(
    "content",
    [
        "camera = { colors = {} }\n",
        "[camera]\ncolors = { home = {} }\n",
        "[camera.colors.ball]\nhue_deg = [0, 10]\n",
        "[camera.colors]\nball = { hue_deg = [\n0, 10] }\n",
        "camera = 3\n",
        "[camera.colors]\nabout = '''\n[limits]'''\n",
    ],
)
def test_not_by_lines(content: str) -> None:
    with pytest.raises(
        FileError, match=r"camera\.colors: is written in a way .* put there yourself: ball = {"
    ):
        insert_color(content, "ball", BALL)


def test_no_toml() -> None:
    with pytest.raises(FileError, match=r"robot\.toml at line 1, column 8: is not TOML"):
        insert_color("[camera", "ball", BALL)


def test_no_name() -> None:
    with pytest.raises(DefinitionError, match="color 'a b': is no name"):
        insert_color("", "a b", BALL)


SHARES = st.tuples(st.integers(0, 100), st.integers(0, 100)).map(
    lambda pair: tuple(each / 100 for each in sorted(pair))
)
HUES = st.tuples(*[st.integers(0, 3600).map(lambda tenths: tenths / 10)] * 2)


@given(HUES, SHARES, SHARES)
def test_line_reads_back(hue_deg: Share, saturation: Share, value: Share) -> None:
    color = Color(hue_deg=hue_deg, saturation=saturation, value=value)
    assert msgspec.convert(tomllib.loads(format_color_line("ball", color)), dict[str, Color]) == {
        "ball": color
    }


def test_file(tmp_path: Path) -> None:
    file = tmp_path / "rover.toml"
    file.write_text('name = "rover" # ours\n\n[camera]\nview_deg = 62\n')
    write_color(file, "ball", BALL)
    document = tomllib.loads(file.read_text())
    assert file.read_text().startswith('name = "rover" # ours\n')
    assert msgspec.convert(document["camera"], CameraSpec) == CameraSpec(view_deg=62.0, colors={"ball": BALL})


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="there is no such file; give a robot's file"):
        write_color(tmp_path / "none.toml", "ball", BALL)


@pytest.mark.parametrize(
    "part", [CameraSpec(least_px=float("nan")), CameraSpec(stale_s=0.0), CameraSpec(view_deg=200.0)]
)
def test_camera_that_cannot_be(part: CameraSpec) -> None:
    pytest.importorskip("cv2", reason="needs the extra camera")
    with pytest.raises(SettingError, match=r"camera: .* is "):
        part.camera()
