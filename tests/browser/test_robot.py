"""A real robot at the page, simulated in physics in a process of its own: armed, taught, shown a color, and stopped."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher

from understudy.model.plain_names import format_names as plain

for module in ("cyclonedds", "rosbags", "mujoco", "cv2"):
    pytest.importorskip(module, reason="needs the extras ros2 and mujoco")

DOMAIN = "61"
pytestmark = pytest.mark.xdist_group("domain 61")


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Path]:
    """The file of a robot that plays soccer."""
    command = [sys.executable, "-m", "understudy.ui.cli", "robots", "simulate", "soccer", "--domain", DOMAIN]
    process = subprocess.Popen(
        [*command, "--write-files", str(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    try:
        assert process.stdout is not None
        said = ""
        while "Ctrl-C" not in said:
            line = process.stdout.readline()
            assert line, f"the robot did not start: {said}"
            said += line
        yield tmp_path / "humanoid.toml"
    finally:
        process.terminate()
        process.communicate(timeout=20)


@pytest.fixture
def studio(tmp_path: Path, robot: Path) -> Iterator[Studio]:
    made = Studio(tmp_path / "library", "--robot", str(robot))
    made.start()
    yield made
    made.stop()


def causes(robot: Path) -> list[str]:
    """Why it stopped, each time; on a busy machine the watchdogs may stop it, too."""
    lines = robot.with_suffix(".stops.jsonl").read_text().splitlines()
    found = [json.loads(line)["cause"] for line in lines]
    return [cause for cause in found if not cause.startswith(("no sign for", "this program stood still"))]


def test_a_robot_is_armed_taught_and_stopped(
    visit: Callable[[], Page], robot: Path, snap: Callable[[Page, str], None]
) -> None:
    page = visit()
    teacher = Teacher(page)
    bar = page.get_by_role("group", name="Real robots")
    expect(bar).to_contain_text("humanoid not armed")
    expect(page.get_by_role("button", name="New world")).to_have_count(0)
    camera = page.get_by_role("img", name="What the camera sees")
    expect(camera).to_be_visible()
    expect(camera).to_have_js_property("naturalWidth", 160)
    expect(camera).to_have_js_property("naturalHeight", 120)

    teacher.click("Teach something new")
    form = page.locator("form.choice")
    form.get_by_role("textbox", name="Name", exact=True).fill("servo")
    for label in ("turn_left", "turn_right", "walk_forward", "blob_x(ball)", "blob_size(ball)"):
        form.get_by_role("checkbox", name=plain(label), exact=True).check()
    teacher.begin_as_in_the_paper()
    bar.get_by_role("button", name="Arm").click()
    expect(bar).to_contain_text("humanoid armed")
    before = camera.get_attribute("src") or ""
    teacher.directing("turn_left").click()
    readings = page.get_by_role("complementary")
    expect(readings).to_contain_text("px")  # the ball comes into sight
    teacher.directing("walk_forward").click()
    expect(page.get_by_role("tab", name="Lesson")).to_contain_text("4")  # each directive has its default
    expect(camera).not_to_have_attribute("src", before)
    snap(page, "robot")

    page.keyboard.press("Escape")
    expect(bar).to_contain_text("not armed: emergency: stopped in the studio")
    expect(bar.get_by_role("button", name="Arm", exact=True)).to_be_enabled()
    snap(page, "robot-stopped")
    assert causes(robot) == ["emergency: stopped in the studio"]


def test_a_color_is_shown_by_clicking_and_who_leaves_stops_it(visit: Callable[[], Page], robot: Path) -> None:
    page = visit()
    bar = page.get_by_role("group", name="Real robots")
    camera = page.get_by_role("img", name="What the camera sees")
    former = robot.read_text()
    camera.click()
    expect(page.get_by_text("Cameras detect ball by this color now; saved in humanoid.toml")).to_be_visible()
    assert robot.read_text() != former
    bar.get_by_role("button", name="Arm").click()
    expect(bar).to_contain_text("humanoid armed")
    page.close()
    watcher = visit()
    expect(watcher.get_by_role("group", name="Real robots")).to_contain_text(
        "no page is in control in the studio"
    )
    assert causes(robot) == ["no page is in control in the studio"]
