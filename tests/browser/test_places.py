"""A world and a library are chosen on the page, without a restart; an edited world is saved and found again."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect
from tests.browser.static_studio import both_places
from tests.browser.teacher import Teacher

pytestmark = both_places


@pytest.fixture
def teacher(visit: Callable[[], Page]) -> Teacher:
    """Somebody who has taught goto a little, and looks into the library."""
    made = Teacher(visit())
    made.begin_goto()
    made.press("ArrowUp")
    expect(made.page.get_by_role("button", name="Save", exact=True)).to_be_enabled()
    made.page.get_by_role("tab", name="Library").click()
    return made


def test_a_world_of_ones_own(teacher: Teacher, snap: Callable[[Page, str], None]) -> None:
    """Saved as it stands, chosen, and the lesson goes along."""
    page = teacher.page
    page.get_by_role("combobox", name="Add to the world").select_option("obstacle")
    page.locator("canvas").click(position={"x": 330, "y": 300})
    expect(page.get_by_text("An obstacle was added")).to_be_visible()
    page.get_by_label("Save it as").fill("yard")
    teacher.click("Save world")
    expect(page.get_by_text("The world is saved as yard")).to_be_visible()
    snap(page, "places")
    page.get_by_label("World", exact=True).select_option("yard")
    page.get_by_role("button", name="Save, then go to yard").click()
    expect(page.get_by_role("banner").get_by_label("Scenario")).to_have_value("yard")
    expect(page.get_by_text("goto is opened here")).to_be_visible()
    expect(page.get_by_role("banner")).to_contain_text("goto (A)")
    before = teacher.examples
    teacher.press("ArrowLeft")
    expect(teacher.state_button("rotate_left")).to_have_attribute("aria-pressed", "true")
    assert teacher.examples > before


def test_a_library_of_ones_own(teacher: Teacher) -> None:
    page = teacher.page
    teacher.click("Save")
    expect(page.get_by_text("goto is saved")).to_be_visible()
    page.get_by_role("combobox", name="Library").select_option(label="new library …")
    page.get_by_label("New library").fill("lesson two")
    teacher.click("Begin it")
    expect(page.get_by_text("Library lesson two: teach something new")).to_be_visible()
    expect(page.get_by_role("button", name="Open goto", exact=True)).to_have_count(0)
    page.get_by_role("combobox", name="Library").select_option("library")
    expect(page.get_by_text("Library library: teach something new")).to_be_visible()
    expect(page.get_by_role("button", name="Open goto", exact=True)).to_be_visible()


def test_the_header_goes_to_another_world(teacher: Teacher) -> None:
    """What is not saved is not left behind."""
    page = teacher.page
    where = page.get_by_role("banner").get_by_label("Scenario")
    where.select_option("arena")
    expect(page.get_by_text("goto has unsaved changes")).to_be_visible()
    expect(where).to_have_value("forage")
    teacher.click("Save")
    expect(page.get_by_text("goto is saved")).to_be_visible()
    where.select_option("arena")
    expect(where).to_have_value("arena")
    expect(page.get_by_role("img", name="The world arena")).to_be_visible()
