"""The library at the page: other names, copies and former versions."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect
from tests.browser.teacher import Teacher


@pytest.fixture
def teacher(visit: Callable[[], Page]) -> Teacher:
    """Somebody who has saved goto, and looks at the library."""
    made = Teacher(visit())
    made.begin_goto()
    made.press("Space")
    show(made, "forward")
    made.page.get_by_role("tab", name="Library").click()
    return made


def show(teacher: Teacher, state: str) -> None:
    """One more example, and save."""
    save = teacher.page.get_by_role("button", name="Save", exact=True)
    teacher.directing(state).click()
    teacher.page.get_by_role("button", name="Step").click()
    save.click()
    expect(save).to_be_disabled()


def test_other_names(teacher: Teacher) -> None:
    page = teacher.page
    page.get_by_role("button", name="Duplicate goto").click()
    page.get_by_role("textbox", name="Name of the copy of goto").fill("twin")
    page.keyboard.press("Enter")
    expect(page.get_by_role("button", name="Open twin")).to_be_visible()
    page.get_by_role("button", name="Rename goto").click()
    field = page.get_by_role("textbox", name="New name of goto")
    field.fill("twin")
    page.keyboard.press("Enter")
    expect(page.get_by_text("the library has twin already")).to_be_visible()
    field.fill("reach")
    page.keyboard.press("Enter")
    expect(page.get_by_role("button", name="Rename reach")).to_be_visible()
    expect(page.get_by_role("banner")).to_contain_text("reach")
    expect(field).to_have_count(0)


def test_back_to_a_former_version(teacher: Teacher) -> None:
    page = teacher.page
    show(teacher, "rotate_left")
    page.get_by_role("button", name="Versions of goto").click()
    page.get_by_role("button", name="version 1", exact=True).click()
    changes = page.get_by_role("region", name="What changed since version 1")
    expect(changes).to_contain_text("go to rotate_left (directive)")
    assert teacher.examples == 4
    page.get_by_role("button", name="Go back to version 1 of goto").click()
    expect(page.get_by_role("button", name="version 2", exact=True)).to_be_visible()
    assert teacher.examples == 2
