"""States at the page: what they are called, and several that run the same."""

from __future__ import annotations

import re
from collections.abc import Callable

from playwright.sync_api import Page, expect
from tests.browser.teacher import Teacher

FORWARD = re.compile("which runs forward$")


def test_two_states_that_run_forward(visit: Callable[[], Page], snap: Callable[[Page, str], None]) -> None:
    """Servoing: forward_left has seen the ball on its left, forward_right on its right."""
    page = visit()
    teacher = Teacher(page)
    teacher.click("Teach something new")
    page.get_by_label("Name", exact=True).fill("servo")
    expect(page.get_by_role("textbox", name=FORWARD)).to_have_count(0)
    teacher.click("Names of the states")
    teacher.click("forward once more")
    teacher.click("Leave out forward 2")
    teacher.click("forward once more")
    page.get_by_role("textbox", name=FORWARD).nth(0).fill("forward_left")
    page.get_by_role("textbox", name=FORWARD).nth(1).fill("forward_left")
    expect(page.get_by_role("button", name="Begin", exact=True)).to_be_disabled()
    expect(page.get_by_text("Two states are called forward left.")).to_be_visible()
    page.get_by_role("textbox", name=FORWARD).nth(1).fill("forward_right")
    snap(page, "two-states-forward")
    teacher.begin_as_in_the_paper()
    expect(teacher.state_button("forward_left")).to_be_visible()
    teacher.press("ArrowUp")
    expect(teacher.state_button("forward_left")).to_have_attribute("aria-pressed", "true")
    teacher.press("2")
    expect(teacher.state_button("forward_right")).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_role("button", name=re.compile("^forward left to forward right"))).to_have_count(1)
    snap(page, "two-states-forward-taught")


def test_a_state_gets_another_name_and_keeps_its_examples(visit: Callable[[], Page]) -> None:
    page = visit()
    teacher = Teacher(page)
    teacher.begin_goto()
    teacher.press("Space")
    teacher.press("ArrowUp")
    teacher.click("Step")
    expect(teacher.state_button("forward")).to_have_attribute("aria-pressed", "true")
    page.get_by_role("tab", name=re.compile("Lesson")).click()
    page.get_by_role("button", name="choose features").click()
    teacher.click("Names of the states")
    page.get_by_role("textbox", name=FORWARD).fill("ahead")
    teacher.click("Choose")
    expect(teacher.state_button("ahead")).to_be_visible()
    assert teacher.examples == 2
    page.get_by_role("tab", name=re.compile("Lesson")).click()
    expect(page.get_by_role("cell", name="ahead", exact=True)).not_to_have_count(0)
