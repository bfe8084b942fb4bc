"""What is not installed is said in one sentence, wherever it is asked for."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from shutil import copy

import pytest
from tests.robots.rovers import ROVER, Wire
from tests.ui.cli.commands import ROOT

from understudy.addons.robots.inputs import SensorInputs
from understudy.addons.robots.robot_file import parse_robot
from understudy.extras import ExtraMissing, import_opencv

EXTRAS = ("cyclonedds", "rosbags", "mcap", "cv2", "mujoco", "zenoh")
WITHOUT = f"import sys; sys.modules.update(dict.fromkeys({EXTRAS}))\n"
RECORDING, ROS = "a recording needs an extra that is not installed", "pip install 'understudy-robots[ros2]'"
CASES = [
    (["robots", "check", "{robot}"], ROS),
    (["robots", "stop", "{robot}"], ROS),
    (["run", "--robot", "{robot}"], RECORDING),
    (["run", "--robot", "{robot}", "--no-record"], ROS),
    (["studio", "--robot", "{robot}", "--no-browser"], RECORDING),
    (["run", "--replay", "{recording}"], RECORDING),
    (["learn", "--recording", "{recording}"], RECORDING),
    (["robots", "color", "{folder}", "--name", "ball"], "pip install 'understudy-robots[camera]'"),
]


ASK = """
import contextlib, io, json
from understudy.ui.cli.main import make_command_line

for arguments in json.loads(sys.stdin.read()):
    code, errors = 0, io.StringIO()
    with contextlib.redirect_stderr(errors):
        try:
            make_command_line()(arguments)
        except SystemExit as ended:
            code = ended.code
    print(json.dumps([code, errors.getvalue()]))
"""
"""A program that gives commands one after another, and tells how each ended and what it wrote on standard error."""


def test_what_to_install_is_said(tmp_path: Path) -> None:
    """All in one process, which takes a while to start."""
    robot = tmp_path / "rover.toml"
    robot.write_text(ROVER, encoding="utf-8")
    recording = copy(robot, tmp_path / "run.mcap")  # what is in it is not looked at
    copy(ROOT / "docs" / "pictures" / "physics.png", tmp_path)
    commands = [
        [each.format(robot=robot, folder=tmp_path, recording=recording) for each in arguments]
        for arguments, _ in CASES
    ]
    path = os.pathsep.join((str(ROOT / "src"), str(ROOT)))
    result = subprocess.run(
        [sys.executable, "-c", WITHOUT + ASK],
        input=json.dumps(commands),
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": path},
    )
    ended = [json.loads(line) for line in result.stdout.splitlines()]
    assert len(ended) == len(CASES)
    for (arguments, said), (code, errors) in zip(CASES, ended, strict=True):
        assert (code, errors.count("\n")) == (2, 1), (arguments, errors)
        assert said in errors, arguments
    assert not (tmp_path / "recordings").exists() or not [*(tmp_path / "recordings").iterdir()]


def test_the_rest_asks_for_none_of_them() -> None:
    modules = (
        "ui.cli.main",
        "ui.cli.commands.run",
        "ui.controller.trainer",
        "ui.web.server",
        "ui.terminal.app",
        "addons.robots.twin",
        "addons.bridges.mujoco.body",
    )
    program = WITHOUT + "".join(f"import understudy.{module}\n" for module in modules)
    path = os.pathsep.join((str(ROOT / "src"), str(ROOT)))
    subprocess.run([sys.executable, "-c", program], check=True, env={**os.environ, "PYTHONPATH": path})


def test_a_camera_without_opencv_is_not_a_mistake_in_the_file(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("rosbags", reason="needs the extra ros2")
    monkeypatch.setitem(sys.modules, "cv2", None)
    import_opencv.cache_clear()
    seen = '[camera]\ntopic = "image"\ntype = "sensor_msgs/msg/Image"\nview_deg = 60\n'
    color = "[camera.colors]\nball = { hue_deg = [10, 30], saturation = [0.4, 1], value = [0.1, 1] }\n"
    with pytest.raises(ExtraMissing, match=r"^a camera needs an extra .* 'understudy-robots\[camera\]'$"):
        SensorInputs(parse_robot(ROVER + seen + color), Wire())
    import_opencv.cache_clear()
