"""A world with more than one robot at the page, and a lesson in which silence is consent."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    """A studio with a team."""
    made = Studio(tmp_path / "library", "forage-team")
    made.start()
    yield made
    made.stop()


def test_the_others_and_nobody_watching(visit: Callable[[], Page]) -> None:
    teacher = Teacher(visit())
    teacher.begin_goto()
    page = teacher.page
    others = page.get_by_role("combobox", name="What the others do meanwhile")
    expect(others).to_have_value("")
    others.select_option("forward")
    expect(page.get_by_role("button", name="robot 2")).to_contain_text("forward")
    expect(others).to_have_value("forward")
    switch = page.get_by_role("switch", name="Stop learning from silence")
    expect(switch).to_have_count(0)
    page.get_by_role("button", name="choose features").click()
    page.get_by_role("checkbox", name="Learn from silence").check()
    page.get_by_role("button", name="Choose", exact=True).click()
    switch.click()
    expect(switch).to_have_attribute("aria-checked", "true")
    expect(page.get_by_text("Learning from silence: off")).to_be_visible()
    others.select_option("")
    expect(page.get_by_role("button", name="robot 2")).to_contain_text("idle")
