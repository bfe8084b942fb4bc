"""`understudy robots color`: from a folder of images to a line in a robot's file."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from tests.robots.scenes import BLUE, GREEN, ORANGE, render
from tests.ui.cli.commands import run, run_json

cv2 = pytest.importorskip("cv2", reason="needs the extra camera")


@pytest.fixture
def images(tmp_path: Path) -> Path:
    folder = tmp_path / "ball"
    folder.mkdir()
    for number, ground in enumerate((BLUE, GREEN)):
        image = render((80, 60, 25, ORANGE), ground=ground, noise=3.0, shade=0.2)
        cv2.imwrite(str(folder / f"ball{number}.png"), image[:, :, ::-1])
    return folder


def test_written_to_the_robot(images: Path, tmp_path: Path) -> None:
    file = tmp_path / "rover.toml"
    file.write_text('name = "rover"\n')
    told = run_json("robots", "color", images, "--name", "ball", "--robot", file)
    assert [each["x"] for each in told["images"]] == pytest.approx([80.0, 80.0], abs=1.0)
    written = tomllib.loads(file.read_text())
    assert written == {"name": "rover", "camera": {"colors": {"ball": told["color"]}}}


def test_line_to_copy(images: Path) -> None:
    result = run("robots", "color", images, "--name", "ball")
    assert result.exit_code == 0, result.output
    assert "[camera.colors]\nball = { hue_deg = [" in result.stdout
    assert "ball1.png" in result.stdout


def test_robot_file_that_is_missing(images: Path, tmp_path: Path) -> None:
    result = run("robots", "color", images, "--name", "ball", "--robot", tmp_path / "none.toml")
    assert result.exit_code == 2
    assert "there is no such file" in result.stderr


def test_nothing_in_the_folder(tmp_path: Path) -> None:
    result = run("robots", "color", tmp_path, "--name", "ball")
    assert result.exit_code == 2
    assert "holds no images; put images of the thing there, PNG or JPEG" in result.stderr
