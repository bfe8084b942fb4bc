"""A failing world at the page: it is opened where it goes wrong, one press corrects it, and the list ticks it off."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from playwright.sync_api import Browser, Locator, Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher
from tests.browser.test_review import tab
from tests.ui.web.test_failing_worlds import make_failures

Snap = Callable[[Page, str], None]


def part(page: Page) -> Locator:
    """Where the failing worlds are listed."""
    return page.get_by_role("region", name="Failing worlds")


def row(page: Page, name: str) -> Locator:
    return part(page).get_by_role("listitem").filter(has_text=name)


def test_a_failure_is_opened_corrected_and_ticked_off(tmp_path: Path, chromium: Browser, snap: Snap) -> None:
    library = make_failures(tmp_path)
    studio = Studio(library, "forage", "--failures", str(tmp_path / "failures"))
    studio.start()
    try:
        page = chromium.new_page(viewport={"width": 1280, "height": 800})
        page.goto(studio.address)
        tab(page, "Coach")
        snap(page, "failures-before")
        expect(row(page, "forage-2")).to_contain_text("no more progress")
        part(page).get_by_role("button", name="Run again").click()
        expect(part(page)).to_contain_text("0 of 4 worlds pass now")

        part(page).get_by_role("button", name="Open failing world forage-2").click()
        teacher = Teacher(page)
        expect(teacher.directing("start")).to_have_attribute("aria-pressed", "true")
        expect(page.get_by_text("Paused in forage-2")).to_be_visible()
        snap(page, "failures-opened")
        page.keyboard.press("Space")  # it goes wrong again: it stands
        page.wait_for_timeout(500)
        teacher.directing("left").click()
        expect(row(page, "forage-1").get_by_role("img", name="Passes now")).to_be_visible(timeout=20_000)
        expect(row(page, "forage-2").get_by_role("img", name="Passes now")).to_be_visible()
        expect(row(page, "forage-4").get_by_role("img", name="Still fails")).to_be_visible()
        snap(page, "failures-corrected")

        part(page).get_by_role("button", name="back to forage").click()
        expect(part(page).get_by_role("button", name="back to forage")).to_have_count(0)
        page.get_by_role("button", name="Save", exact=True).click()
        expect(page.get_by_text("goto is saved")).to_be_visible()
        snap(page, "failures-saved")
    finally:
        studio.stop()
