"""A failing world at the page: it is opened where it goes wrong, one press corrects it, and the list ticks it off."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from playwright.sync_api import Browser, Locator, Page, expect
from tests.browser.studio import open_studio
from tests.browser.teacher import Teacher
from tests.browser.test_review import tab
from tests.falsification.team_kept import keep_team
from tests.falsification.test_falsify_team import PROPERTY
from tests.falsification.test_team_failure import teach_lead
from tests.ui.cli.commands import run
from tests.ui.web.test_failing_worlds import make_failures

from understudy.judging.properties.property_file import HEAD

Snap = Callable[[Page, str], None]


def part(page: Page) -> Locator:
    """Where the failing worlds are listed."""
    return page.get_by_role("region", name="Failing worlds")


def row(page: Page, name: str) -> Locator:
    return part(page).get_by_role("listitem").filter(has_text=name)


def test_a_failure_is_opened_corrected_and_ticked_off(tmp_path: Path, chromium: Browser, snap: Snap) -> None:
    library = make_failures(tmp_path)
    with open_studio(chromium, library, "forage", "--failures", str(tmp_path / "failures")) as page:
        tab(page, "Coach")
        snap(page, "failures-before")
        expect(row(page, "forage-2")).to_contain_text("no more progress")
        part(page).get_by_role("button", name="Run again").click()
        expect(part(page)).to_contain_text("0 of 4 worlds pass now")

        part(page).get_by_role("button", name="Open failing world forage-2").click()
        teacher = Teacher(page)
        expect(teacher.state_button("start")).to_have_attribute("aria-pressed", "true")
        expect(page.get_by_text("Paused in forage-2")).to_be_visible()
        snap(page, "failures-opened")
        page.keyboard.press("Space")  # it goes wrong again: it stands
        expect(page.get_by_role("button", name="Pause", exact=True)).to_be_visible()
        teacher.let_pass(0.5)
        before = teacher.examples
        teacher.state_button("left").click()
        teacher.wait_until(lambda: teacher.examples > before)
        part(page).get_by_role("button", name="Run again").click()  # by itself only where that is quick
        expect(row(page, "forage-1").get_by_role("img", name="Passes now")).to_be_visible()
        expect(row(page, "forage-2").get_by_role("img", name="Passes now")).to_be_visible()
        expect(row(page, "forage-4").get_by_role("img", name="Still fails")).to_be_visible()
        snap(page, "failures-corrected")

        part(page).get_by_role("button", name="back to forage").click()
        expect(part(page).get_by_role("button", name="back to forage")).to_have_count(0)
        page.get_by_role("button", name="Save", exact=True).click()
        page.get_by_role("button", name="Save anyway").click()  # it changed more than was pressed
        expect(page.get_by_text("goto is saved")).to_be_visible()
        snap(page, "failures-saved")


def test_a_failure_of_a_team_opens_its_coordinator(tmp_path: Path, chromium: Browser, snap: Snap) -> None:
    """A patrol that is sent home fails where it must not come near it: its coordinator is opened before that."""
    library = keep_team(tmp_path, teach_lead())
    (library / "properties.toml").write_text(HEAD + PROPERTY)
    options = ("--property", "keeps_away", "--worlds", 6, "--limit", 60, "-o", tmp_path / "failures")
    assert run("falsify", library, "lead", *options).exit_code == 1
    with open_studio(chromium, library, "patrol", "--failures", str(tmp_path / "failures")) as page:
        tab(page, "Coach")
        part(page).get_by_role("button", name="Open failing world lead-1").click()
        expect(page.get_by_text("Paused in ")).to_be_visible()
        expect(page.get_by_role("heading", name="lead").or_(page.get_by_text("lead").first)).to_be_visible()
        snap(page, "failures-of-a-team")
        page.keyboard.press("Space")  # the team goes on, led by what was learned
        expect(page.get_by_text("Paused in ")).to_have_count(0)
        part(page).get_by_role("button", name="back to patrol").click()
        expect(part(page).get_by_role("button", name="back to patrol")).to_have_count(0)
