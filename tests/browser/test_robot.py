"""A real robot at the page, simulated in physics in a process of its own: armed, taught, shown a color, and stopped."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from itertools import cycle
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher
from tests.browser.window import wait_until
from tests.processes import end_with_tests
from tests.robots.domains import own_domain
from tests.robots.rovers import TOO_BUSY

from understudy.model.plain_names import format_names as plain

for module in ("cyclonedds", "rosbags", "mujoco", "cv2"):
    pytest.importorskip(module, reason="needs the extras ros2 and mujoco")

DOMAINS = cycle((own_domain(), own_domain(50)))
"""One after the other, since publishers of a robot that was killed are seen for ten seconds."""


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Path]:
    """The file of a robot that plays soccer."""
    command = [sys.executable, "-m", "understudy.ui.cli", "robots", "simulate", "soccer"]
    process = subprocess.Popen(
        end_with_tests([*command, "--domain", str(next(DOMAINS)), "--write-files", tmp_path]),
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
        process.communicate()


@pytest.fixture
def studio(tmp_path: Path, robot: Path) -> Iterator[Studio]:
    made = Studio(tmp_path / "library", "--robot", str(robot))
    made.start()
    yield made
    made.stop()


def causes(robot: Path) -> list[str]:
    """Why it stopped, each time, but where a busy machine stopped it."""
    lines = robot.with_suffix(".stops.jsonl").read_text().splitlines()
    found = [json.loads(line)["cause"] for line in lines]
    return [cause for cause in found if not any(words in cause for words in TOO_BUSY)]


def is_armed(page: Page) -> bool:
    """Whether the robot is armed; if not, press Arm, since on a busy machine it may be refused, or stopped again."""
    bar = page.get_by_role("group", name="Real robots")
    arm = bar.get_by_role("button", name="Arm", exact=True)
    arm.evaluate_all(
        "all => all.forEach((each) => each.click())"
    )  # at once: armed, there is nothing to click
    return "humanoid armed" in bar.inner_text()


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
    wait_until(page, partial(is_armed, page))
    before = camera.get_attribute("src") or ""
    teacher.state_button("turn_left").click()
    readings = page.get_by_role("complementary")
    wait_until(page, lambda: is_armed(page) and "px" in readings.inner_text())  # the ball comes into sight
    teacher.state_button("walk_forward").click()
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
    camera = page.get_by_role("img", name="What the camera sees")
    former = robot.read_text()
    camera.click()
    expect(page.get_by_text("Cameras detect ball by this color now; saved in humanoid.toml")).to_be_visible()
    assert robot.read_text() != former
    bar = page.get_by_role("group", name="Real robots")
    for _ in range(20):
        wait_until(page, partial(is_armed, page))
        page.close()
        page = visit()
        bar = page.get_by_role("group", name="Real robots")
        expect(bar).to_contain_text("not armed: ")
        if not any(words in bar.inner_text() for words in TOO_BUSY):
            break
    expect(bar).to_contain_text("no page is in control in the studio")
    assert set(causes(robot)) == {"no page is in control in the studio"}
