"""The tour of the first run: who follows it has a robot that goes to a place by itself."""

from __future__ import annotations

import logging
from collections.abc import Callable
from time import monotonic

from playwright.sync_api import Page, expect
from tests.browser.teacher import DISTANCE, KEYS, Teacher

MOST_ACTIONS = 25
ACTION_S, MOST_S = 1.5, 120.0
"""What a person takes for an action, and for the whole tour, with the time that the robot is on its way."""
_log = logging.getLogger(__name__)


def test_the_tour_ends_with_a_robot_that_does_it(visit: Callable[[], Page]) -> None:
    teacher = Teacher(visit(), turns_deg=5.0, drives_deg=15.0)
    page = teacher.page
    tour = page.get_by_role("region", name="Tour")
    teacher.click("Show me how")
    expect(tour).to_contain_text("1 of 5")
    teacher.click("Begin")
    expect(tour).to_contain_text("2 of 5")
    expect(page.get_by_role("complementary")).to_contain_text(DISTANCE)
    teacher.show_the_way()
    robot_s = teacher.clock_s
    expect(tour).to_contain_text("4 of 5")
    teacher.new_world()
    teacher.show_the_way()
    robot_s += teacher.clock_s
    expect(tour).to_contain_text("5 of 5")
    teacher.new_world()
    lets_it_try(teacher)
    robot_s += teacher.clock_s
    expect(tour).to_contain_text("by itself")
    _log.info("%d actions, the robot on its way for %.1f s", teacher.actions, robot_s)
    assert teacher.actions <= MOST_ACTIONS
    assert ACTION_S * teacher.actions + robot_s <= MOST_S
    page.reload()
    page.get_by_role("button", name="Close", exact=True).click()
    page.reload()
    expect(teacher.directing("done")).to_be_visible()
    expect(tour).to_have_count(0)


def test_the_tour_can_be_left_and_taken_up_again(visit: Callable[[], Page]) -> None:
    teacher = Teacher(visit())
    tour = teacher.page.get_by_role("region", name="Tour")
    teacher.click("Show me how")
    teacher.click("Begin")
    expect(tour).to_contain_text("2 of 5")
    teacher.click("Leave the tour")
    expect(tour).to_have_count(0)
    teacher.press("ArrowLeft")
    teacher.page.reload()
    teacher.click("Resume the tour")
    expect(tour).to_contain_text("2 of 5")


def lets_it_try(teacher: Teacher, *, seconds: float = 90.0) -> None:
    """Test it until it is there by itself; correct it where it does what it should not, and let it go on."""
    testing = teacher.page.get_by_role("button", name="Testing")
    tour = teacher.page.get_by_role("region", name="Tour")
    teacher.press("t")
    until = monotonic() + seconds
    stays, there_since = teacher.reading(), monotonic()
    while monotonic() < until:
        if teacher.state == "done" and "by itself" in tour.inner_text():  # and not since it was pressed
            return
        reading = teacher.reading()
        if reading != stays:
            stays, there_since = reading, monotonic()
        right = teacher.wish(reading, "")
        wrong = teacher.state == "forward" and abs(reading[1]) > 40.0
        if wrong or monotonic() - there_since > 2.0:
            teacher.press(KEYS[right])
            teacher.page.wait_for_timeout(600)
            teacher.press("t")
            expect(testing).to_have_attribute("aria-pressed", "true")
            stays, there_since = reading, monotonic()
        teacher.page.wait_for_timeout(100)
    raise AssertionError(f"not there within {seconds} s")
