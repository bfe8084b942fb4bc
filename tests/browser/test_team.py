"""A coordinator trained at the page: it is chosen in the team, and directing it moves the whole squad."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher
from tests.sim.patrollers import ROBOTS

from understudy.model.library import TrainedAutomaton
from understudy.model.plain_names import format_names as plain
from understudy.storage.library_folder import save_automaton


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    """A studio with the patrol, whose robots can wander and servo."""
    for name in ROBOTS.taught:
        save_automaton(tmp_path / "library", TrainedAutomaton(ROBOTS.automaton(name)))
    made = Studio(tmp_path / "library", "patrol")
    made.start()
    yield made
    made.stop()


def test_a_coordinator_is_taught(visit: Callable[[], Page], snap: Callable[[Page, str], None]) -> None:
    teacher = Teacher(visit())
    page = teacher.page
    patrol = page.get_by_role("button", name="patrol · ")
    patrol.click()
    expect(patrol).to_have_attribute("aria-pressed", "true")
    teacher.click("Teach something new")
    form = page.locator("form.choice")
    form.get_by_role("textbox", name="Name", exact=True).fill("lead")
    form.get_by_label("Flags").fill("")
    for label in (
        "wander",
        "servo(intruder)",
        "servo(home)",
        "someone_sees(intruder)",
        "all_done",
        "present",
    ):
        form.get_by_role("checkbox", name=plain(label), exact=True).check()
    teacher.begin_as_in_the_paper()
    expect(patrol).to_contain_text("4 idles")
    teacher.state_button("wander").click()
    expect(patrol).not_to_contain_text("idle")
    teacher.let_pass(2.0)
    snap(page, "team")
    expect(page.get_by_role("complementary")).to_contain_text("4")
    expect(page.get_by_role("button", name="robot 1 ·")).not_to_contain_text("idle")
    teacher.click("Save")
    expect(page.get_by_role("tab", name="Library")).to_contain_text("1")
    robot = page.get_by_role("button", name="robot 1 ·")
    robot.click()
    expect(robot).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_role("tab", name="Library")).to_contain_text("3")
