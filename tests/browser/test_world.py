"""The world at the page: how soon a press is answered, how fast time goes, and markers."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Page, Position, expect
from tests.browser.teacher import DISTANCE, Teacher

PRESSES = 6
TARGET = "nearest_marker"


@pytest.fixture
def teacher(visit: Callable[[], Page]) -> Teacher:
    """Somebody who has begun goto."""
    made = Teacher(visit())
    made.begin_goto()
    return made


def test_a_press_is_in_the_journal_and_how_long_that_took_is_shown(teacher: Teacher) -> None:
    for number in range(PRESSES):
        teacher.press_until_shown(("ArrowUp", "ArrowLeft", "ArrowRight")[number % 3])
        told = re.search(r"([\d.]+) ms", teacher.page.locator(".latency").inner_text())
        assert told
        assert float(told[1]) > 0
    assert teacher.examples >= PRESSES


def test_as_fast_as_it_goes(teacher: Teacher) -> None:
    """The speed is chosen with the keyboard at first, and no robot turns: letters and digits choose in a list."""
    page = teacher.page
    speed = page.get_by_role("combobox", name="Speed")
    speed.focus()
    teacher.press("2")
    expect(speed).to_have_value("2")
    assert teacher.state == "start"
    speed.blur()
    teacher.press("ArrowLeft")
    speed.select_option("fastest")
    expect(speed).to_have_value("fastest")
    teacher.let_pass(2 * 16)
    teacher.press("Space")
    expect(page.get_by_role("button", name="Resume")).to_be_visible()
    page.get_by_role("slider", name="Rewind").press("ArrowLeft")
    expect(page.get_by_text("going on begins here", exact=True)).to_be_visible()
    speed.select_option("1")
    expect(speed).to_have_value("1")


def test_a_marker_is_placed_aimed_at_and_removed_and_so_is_an_obstacle(teacher: Teacher) -> None:
    page = teacher.page
    teacher.press("Space")
    stands = page.get_by_role("combobox", name="What A stands for")
    stands.select_option(TARGET)
    readings = page.get_by_role("complementary")
    expect(readings).not_to_contain_text(DISTANCE)
    add = page.get_by_role("combobox", name="Add to the world")
    expect(add.get_by_role("option", name="mouse")).to_have_count(0)
    add.select_option("marker")
    world = page.locator("canvas")
    box = world.bounding_box()
    assert box
    x, y = box["width"] / 2, box["height"] / 2
    world.click(position={"x": x, "y": y})
    expect(readings).to_contain_text(DISTANCE)
    near = teacher.read_aim()
    world.hover(position={"x": x, "y": y})
    page.mouse.down()
    page.mouse.move(box["x"] + x + 60, box["y"] + y + 40, steps=6)
    page.mouse.up()
    teacher.wait_for_change(near)
    world.click(position={"x": x + 60, "y": y + 40})
    chosen = page.get_by_role("group", name="What was clicked")
    expect(chosen).to_contain_text("marker")
    chosen.get_by_role("button", name="Remove").click()
    expect(readings).not_to_contain_text(DISTANCE)

    world = page.get_by_role("img", name=re.compile("The world"))
    place: Position = {"x": 345, "y": 120}
    page.get_by_role("combobox", name="Add to the world").select_option("obstacle")
    world.click(position=place)
    expect(page.get_by_role("status").filter(has_text="An obstacle was added")).to_be_visible()
    world.drag_to(world, source_position=place, target_position={"x": 345, "y": 170})
    expect(page.get_by_role("status").filter(has_text="An obstacle was moved")).to_be_visible()
    world.click(position={"x": 345, "y": 170})
    page.get_by_role("group", name="What was clicked").get_by_role("button", name="Remove").click()
    expect(page.get_by_role("status").filter(has_text="An obstacle was removed")).to_be_visible()


def test_time_before_a_lesson(visit: Callable[[], Page]) -> None:
    """It stands still at first; a lesson begins in the world as it is then."""
    page = visit()
    teacher = Teacher(page)
    assert teacher.clock_s == 0
    teacher.click("Resume")
    teacher.wait_until(lambda: teacher.clock_s > 0.2)
    teacher.click("Pause")
    passed = teacher.clock_s
    teacher.click("Step")
    teacher.begin_goto()
    teacher.wait_until(lambda: teacher.clock_s > passed + 0.1)
