"""The page says in how many new worlds what is trained works, after each press, until that is turned off."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect
from tests.browser.foraging import GOTO, Forager
from tests.browser.studio import Studio


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    """A studio that runs what is trained in new worlds after each press."""
    made = Studio(tmp_path / "library", clock=True, scores=True)
    made.start()
    yield made
    made.stop()


def test_a_lesson_is_scored_until_that_is_turned_off(
    visit: Callable[..., Page], studio: Studio, snap: Callable[[Page, str], None]
) -> None:
    page = visit(prompt=True)
    person = Forager(page, studio.clock)
    person.begin(GOTO)
    person.direct("forward")
    line = page.get_by_label("In new worlds")
    while not line.count():
        person.go(1)
    expect(line).to_contain_text("goto works in 0 of 100 new worlds")
    snap(page, "score")
    line.get_by_role("button", name="turn off").click()
    expect(line).to_contain_text("not measured: turned off")
    expect(line).to_contain_text("Success: done is raised, wherever that is")
    expect(line.get_by_role("button", name="Keep going")).to_be_visible()
    snap(page, "score turned off")
    line.get_by_role("button", name="turn on").click()
    expect(line).to_contain_text("goto works in 0 of 100 new worlds")
    line.get_by_role("button", name="Keep going").click()
    expect(page.get_by_text("goto works in 0 of")).to_have_count(2)
    expect(page.get_by_text("Press what it should do, and resume")).to_be_visible()
    snap(page, "keep going")


def test_the_coach_advises_first_on_what_went_wrong_there(
    visit: Callable[..., Page], studio: Studio, snap: Callable[[Page, str], None]
) -> None:
    page = visit(prompt=True)
    person = Forager(page, studio.clock)
    person.begin(GOTO)
    for state in ("rotate_left", "forward", "rotate_left", "forward"):
        person.direct(state)
        person.go(1)
    page.get_by_role("tab", name="Coach").click()
    first = page.get_by_label("Advice", exact=True).get_by_role("listitem").first
    expect(first).to_contain_text("I went wrong there in")
    snap(page, "coach")
