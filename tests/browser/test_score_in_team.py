"""Among other robots, the page scores one of them, or their coordinator, as it runs here."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher
from tests.sim.patrollers import ROBOTS

from understudy.model.library import TrainedAutomaton
from understudy.storage.library_folder import save_automaton


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    """A studio with four robots in a squad, which runs what is trained in new worlds after each press."""
    for name in ROBOTS.taught:
        save_automaton(tmp_path / "library", TrainedAutomaton(ROBOTS.automaton(name)))
    made = Studio(tmp_path / "library", "patrol", scores=True)
    made.start()
    yield made
    made.stop()


def begin(page: Page, group: str, reading: str, *, flags: str | None = None) -> Teacher:
    """Begin a lesson for a robot or a coordinator, and press *wander*."""
    teacher = Teacher(page)
    page.get_by_role("button", name=f"{group} ·").click()
    teacher.click("Teach something new")
    form = page.locator("form.choice")
    form.get_by_role("textbox", name="Name", exact=True).fill("lead")
    for label in ("wander", reading):
        box = form.get_by_role("checkbox", name=label, exact=True)
        expect(box).to_have_count(1)  # the form may still be that of the group before
        box.check()
    if flags is not None:
        form.get_by_label("Flags").fill(flags)
    teacher.click("Begin")
    teacher.state_button("wander").click()
    return teacher


@pytest.mark.parametrize(
    ("group", "reading", "others"),
    [("patrol", "present", ""), ("robot 3", "stuck", " (the other robots idle)")],
    ids=["coordinator", "robot"],
)
def test_what_is_trained_among_others_is_scored(
    visit: Callable[[], Page], snap: Callable[[Page, str], None], group: str, reading: str, others: str
) -> None:
    page = begin(visit(), group, reading).page
    line = page.get_by_label("In new worlds")
    expect(line).to_contain_text(f"lead works in 0 of 100 new worlds{others}")
    line.get_by_role("button", name="Keep going").click()
    expect(page.get_by_text("Press what it should do, and resume")).to_be_visible()
    snap(page, f"keep going {group}")


def test_a_goal_of_a_coordinator_is_chosen_and_measured(
    visit: Callable[[], Page], snap: Callable[[Page, str], None]
) -> None:
    """Without a flag, the page offers goals about the robots that follow it."""
    page = begin(visit(), "patrol", "present", flags="").page
    line = page.get_by_label("In new worlds")
    expect(line).to_contain_text("not measured: choose what success means")
    snap(page, "goal of a coordinator offered")
    pane = line.bounding_box()
    for each in line.get_by_role("listitem").get_by_role("button").all():
        box = each.bounding_box()
        assert box is not None
        assert pane is not None
        assert box["x"] + box["width"] <= pane["x"] + pane["width"], "a long goal is wrapped"
    line.get_by_role("button", name="never lets its robots touch anything").click()
    expect(line).to_contain_text("of 50 new worlds")
    expect(line).to_contain_text("Success: never lets its robots touch anything")
    expect(line.get_by_role("button", name="Keep going")).to_be_visible()
    snap(page, "goal of a coordinator chosen")
