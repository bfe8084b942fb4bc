"""For a behavior without a flag, the page offers what success can mean; what is chosen is then measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from msgspec import structs
from playwright.sync_api import Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher

from understudy.sim.catalog import find_scenario
from understudy.sim.scenario.files import format_scenario


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    """A studio with an arena that has no goal, which runs what is trained in new worlds after each press."""
    world = tmp_path / "arena.toml"
    world.write_text(format_scenario(structs.replace(find_scenario("arena"), goal=None)))
    made = Studio(tmp_path / "library", str(world), clock=True, scores=True)
    made.start()
    yield made
    made.stop()


def test_what_success_means_is_chosen_and_measured(
    visit: Callable[..., Page], studio: Studio, snap: Callable[[Page, str], None]
) -> None:
    page = visit(prompt=True)
    person = Teacher(page, studio.clock)
    person.click("Teach something new")
    form = page.locator("form.choice")
    form.get_by_role("textbox", name="Name", exact=True).fill("wander")
    form.get_by_label("Flags").fill("")
    snap(page, "goal form")
    person.begin_as_in_the_paper()
    person.state_button("rotate_left").click()
    person.let_pass(0.5)
    line = page.get_by_label("In new worlds")
    expect(line).to_contain_text("not measured: choose what success means")
    expect(line.get_by_role("button", name="Keep going")).to_have_count(0)
    snap(page, "goal offered")
    line.get_by_role("button", name="never touches anything").click()
    expect(line).to_contain_text("wander works in 50 of 50 new worlds")
    expect(line).to_contain_text("Success: never touches anything")
    expect(line.get_by_role("button", name="Keep going")).to_be_visible()
    snap(page, "goal chosen")
    line.get_by_role("button", name="change").click()
    line.get_by_role("button", name="covers at least").click()
    expect(line).to_contain_text("wander works in 0 of 50 new worlds")
    snap(page, "goal changed")
    line.get_by_role("button", name="change").click()
    line.get_by_role("button", name="none of them").click()
    expect(line).to_contain_text("choose what success means")


def test_what_made_it_worse_is_undone(
    visit: Callable[..., Page], studio: Studio, snap: Callable[[Page, str], None]
) -> None:
    """Turning on the spot touches nothing; then it is shown to drive on, into a wall."""
    page = visit(prompt=True)
    person = Teacher(page, studio.clock)
    person.click("Teach something new")
    form = page.locator("form.choice")
    form.get_by_role("textbox", name="Name", exact=True).fill("wander")
    form.get_by_label("Flags").fill("")
    person.begin_as_in_the_paper()
    person.state_button("rotate_left").click()
    person.let_pass(0.5)
    line = page.get_by_label("In new worlds")
    line.get_by_role("button", name="never touches anything").click()
    line.get_by_role("button", name="Keep going").click()
    expect(page.get_by_text("wander holds, as it is")).to_be_visible()
    person.state_button("forward").click()
    person.let_pass(0.5)
    expect(line).to_contain_text("wander works in 0 of 50 new worlds")
    line.get_by_role("button", name="Keep going").click()
    said = page.get_by_text("121 of 121 after press 1, before the last press. Undo it, or go on here")
    expect(said).to_be_visible()
    snap(page, "worse")
    line.get_by_role("button", name="Undo the last press").click()
    expect(
        page.get_by_text("wander is as after press 1 again; redo brings back the last press. It works")
    ).to_be_visible()
    expect(line.get_by_role("button", name="Undo the last press")).to_have_count(0)
    snap(page, "better again")
