"""A robot is moved and turned with a finger."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from math import atan2, cos, degrees, hypot, radians, sin

import pytest
from playwright.sync_api import Browser, Page, expect
from tests.browser.hand import drag_finger, find_robot, wait_for_still_picture
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher
from tests.browser.window import open_page

SIZES = {"phone upright": (390, 844), "phone lying": (844, 390), "tablet": (800, 1100)}
OFF_PX = 18.0
"""How far beside the middle of what it presses a finger is: what is 44 px wide is still hit."""


@pytest.fixture
def teacher(chromium: Browser, studio: Studio, request: pytest.FixtureRequest) -> Iterator[Teacher]:
    """Somebody who has begun goto on a screen that is touched, in a world that is paused."""
    width, height = SIZES[request.param]
    screen = {"width": width, "height": height}
    with open_page(
        chromium, studio.address, fine=True, viewport=screen, has_touch=True, is_mobile=True
    ) as page:
        page.get_by_role("button", name="Teach something new", exact=True).tap()
        page.get_by_role("button", name="Begin", exact=True).tap()
        expect(page.locator("[data-state=forward]")).to_be_visible()
        page.get_by_role("button", name="Pause", exact=True).tap()
        expect(page.get_by_role("button", name="Resume")).to_be_visible()
        wait_for_still_picture(page)
        yield Teacher(page)


def read_heading_deg(page: Page) -> float:
    """The direction from the robot to its handle, as it is seen: 0 is right, 90 is up."""
    x, y = page.evaluate(HANDLE)
    robot_x, robot_y = find_robot(page)
    return degrees(atan2(robot_y - y, x - robot_x))


def read_turn_deg(teacher: Teacher, before: tuple[float, float]) -> float:
    """How far the robot was turned to the left since a reading."""
    return (before[1] - teacher.read_aim()[1] + 180) % 360 - 180


def is_turned(teacher: Teacher, before: tuple[float, float], wanted: object) -> bool:
    return read_turn_deg(teacher, before) == wanted


COVERED = "([x, y]) => document.elementFromPoint(x, y).tagName"
HANDLE = """() => {
  const canvas = document.querySelector("canvas");
  const named = getComputedStyle(canvas).getPropertyValue("--accent").trim();
  const color = [1, 3, 5].map((at) => parseInt(named.slice(at, at + 2), 16));
  const { width, height } = canvas;
  const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
  const box = canvas.getBoundingClientRect();
  const has = (x, y) => color.every((each, at) => Math.abs(data[4 * (y * width + x) + at] - each) <= 3);
  const fine = width / box.width, radius = 13 * fine;
  let best = [0, 0, 0];
  for (let y = Math.ceil(radius); y < height - radius; y += 1)
    for (let x = Math.ceil(radius); x < width - radius; x += 1) {
      let count = 0;
      for (let at = 0; at < 24; at += 1) {
        const turn = (at * Math.PI) / 12;
        if (has(Math.round(x + radius * Math.cos(turn)), Math.round(y + radius * Math.sin(turn)))) count += 1;
      }
      if (count > best[0]) best = [count, x, y];
    }
  return [box.x + best[1] / fine, box.y + best[2] / fine];
}"""
"""Where the ring of the handle is in the window, px."""


@pytest.mark.parametrize("teacher", SIZES, indirect=True)
def test_a_finger_turns_a_robot(teacher: Teacher, snap: Callable[[Page, str], None]) -> None:
    page = teacher.page
    x, y = find_robot(page)
    page.touchscreen.tap(x + OFF_PX, y)
    chosen = page.get_by_role("group", name="What was clicked")
    expect(chosen).to_contain_text("handle to turn it")
    wait_for_still_picture(page)
    assert page.evaluate(COVERED, find_robot(page)) == "CANVAS"
    snap(page, f"handle-{page.evaluate('innerWidth')}")
    behind = teacher.read_aim()
    grip = page.evaluate(HANDLE)
    away = hypot(grip[0] - x, grip[1] - y)
    now = radians(read_heading_deg(page))
    for turn_deg in (60, -130):
        start = (x + away * cos(now), y - away * sin(now) + OFF_PX)
        now += radians(turn_deg)
        drag_finger(page, start, (x + away * cos(now), y - away * sin(now)))
        wanted = pytest.approx((turn_deg + 180) % 360 - 180, abs=8)
        before = behind
        teacher.wait_until(partial(is_turned, teacher, before, wanted))
        wait_for_still_picture(page)
        behind = teacher.read_aim()
        assert behind[0] == before[0]
        assert (before[1] - behind[1] + 180) % 360 - 180 == wanted
    expect(chosen).to_be_visible()


@pytest.mark.parametrize("teacher", ["phone upright"], indirect=True)
def test_a_finger_beside_a_robot_moves_it(teacher: Teacher) -> None:
    page = teacher.page
    x, y = find_robot(page)
    before = teacher.read_aim()
    drag_finger(page, (x, y - OFF_PX), (x, y - OFF_PX - 80))
    teacher.wait_for_change(before)
    expect(page.get_by_role("group", name="What was clicked")).to_have_count(0)
