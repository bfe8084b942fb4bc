"""The studio as static files: what is kept in the browser, what a second tab may do, and what is left out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher
from tests.browser.window import open_page

PRESSES = {"forward": "ArrowUp", "rotate_left": "ArrowLeft", "rotate_right": "ArrowRight"}


@pytest.fixture
def place() -> str:
    """All of these tests are about static files."""
    return "static"


@pytest.fixture
def teacher(visit: Callable[[], Page]) -> Teacher:
    """Somebody who has pressed a few times, each of which is acknowledged, and so kept: it is shown a moment before."""
    made = Teacher(visit())
    made.begin_goto()
    for state, key in PRESSES.items():
        made.press(key)
        expect(made.state_button(state)).to_have_attribute("aria-pressed", "true")
        expect(made.page.locator(".state.waiting")).to_have_count(0)
    return made


def open_again(context: BrowserContext, studio: Studio) -> Page:
    page = context.new_page()
    page.goto(studio.address)
    studio.wait_until_open(page)
    return page


def test_presses_outlive_the_page(teacher: Teacher, studio: Studio) -> None:
    """The page is closed without a warning, as by a crash, right after the last press is acknowledged."""
    context, shown = teacher.page.context, teacher.examples
    teacher.page.close(run_before_unload=False)
    again = Teacher(open_again(context, studio))
    expect(again.page.get_by_role("banner")).to_contain_text("goto (A)")
    expect(again.page.get_by_text("not saved yet").first).to_be_visible()
    assert again.examples >= shown
    again.press("ArrowUp")
    expect(again.state_button("forward")).to_have_attribute("aria-pressed", "true")


def test_a_second_tab_only_reads_until_the_first_is_closed(teacher: Teacher, studio: Studio) -> None:
    second = open_again(teacher.page.context, studio)
    expect(second.get_by_role("alert")).to_contain_text("this tab only reads")
    expect(second.get_by_role("button", name="Teach something new", exact=True)).to_be_disabled()
    expect(second.get_by_role("button", name="Take control")).to_have_count(0)
    teacher.press("ArrowUp")
    expect(teacher.state_button("forward")).to_have_attribute("aria-pressed", "true")
    teacher.page.close()
    expect(second.get_by_role("banner")).to_contain_text("goto (A)")  # it loads itself again
    expect(second.get_by_role("alert")).to_have_count(0)


def test_what_needs_other_worlds_is_left_out(teacher: Teacher) -> None:
    page = teacher.page
    expect(page.get_by_role("region", name="In new worlds")).to_have_count(0)
    page.get_by_role("tab", name="Lesson").click()
    expect(page.get_by_role("region", name="Properties", exact=True)).to_be_visible()
    expect(page.get_by_role("region", name="Unseen worlds")).to_have_count(0)
    page.get_by_role("tab", name="Library").click()
    expect(page.get_by_text("kept in this browser only")).to_be_visible()
    expect(page.get_by_role("region", name="Properties of the library")).to_have_count(0)


def test_what_cannot_be_loaded_is_said(chromium: Browser, studio: Studio) -> None:
    with open_page(chromium, studio.address) as page:
        page.route("**/understudy.zip", lambda route: route.fulfill(status=404))
        page.reload()
        expect(page.get_by_role("alert")).to_contain_text("The studio cannot run in this browser")
        expect(page.get_by_role("alert")).to_contain_text("understudy.zip cannot be loaded (404)")


def test_the_library_goes_out_and_in_as_a_zip(
    teacher: Teacher, studio: Studio, visit: Callable[[], Page], tmp_path: Path
) -> None:
    teacher.click("Save")
    expect(teacher.page.get_by_text("goto is saved")).to_be_visible()
    assert studio.list_automata(teacher.page) == {"goto"}
    with teacher.page.expect_download() as download:
        teacher.page.get_by_role("button", name="Export library").click()
    download.value.save_as(tmp_path / "library.zip")
    other = visit()
    other.get_by_role("tab", name="Library").click()
    other.get_by_label("A library as a zip").set_input_files(tmp_path / "library.zip")
    expect(other.get_by_text("Imported goto")).to_be_visible()
    (tmp_path / "broken.zip").write_bytes(b"PK")
    other.get_by_label("A library as a zip").set_input_files(tmp_path / "broken.zip")
    expect(other.get_by_text("cannot be read as a zip")).to_be_visible()
    other.reload()
    other.get_by_role("tab", name="Library").click()
    expect(other.get_by_role("button", name="Open goto", exact=True)).to_be_visible()
