"""The tour of the first run: who follows it has a robot that goes to a place by itself."""

from __future__ import annotations

import logging
from collections.abc import Callable
from random import Random

import pytest
from playwright.sync_api import Page, expect
from tests.browser.static_studio import both_places
from tests.browser.studio import Studio
from tests.browser.teacher import DISTANCE, Teacher

MOST_PRESSES = 16
"""The most presses that a way to the station may take."""
LEAST_S, MOST_S = 0.25, 0.35
"""How late a person presses."""
WORLDS = 6
"""The most worlds before it is let run in a hundred."""
WORKS = 90
"""In how many of a hundred worlds it works then, at least."""
_log = logging.getLogger(__name__)

pytestmark = both_places


@pytest.fixture
def moves_clock() -> bool:
    """Time passes while the person looks: as fast as the page shows it."""
    return True


def test_the_tour_ends_with_a_robot_that_does_it(
    visit: Callable[..., Page], studio: Studio, snap: Callable[[Page, str], None], place: str
) -> None:
    teacher = Teacher(visit(prompt=True), studio.clock)
    page = teacher.page
    tour = page.get_by_role("region", name="Tour")
    late = Random(1)
    teacher.click("Show me how")
    expect(tour).to_contain_text("1 of 6")
    teacher.click("Begin")
    expect(tour).to_contain_text("2 of 6")
    expect(page.get_by_role("complementary")).to_contain_text(DISTANCE)
    ways = []
    for _ in range(WORLDS):
        ways.append(follow(teacher, late))
        if asks_for_hundred(page):
            break
        teacher.new_world()
    _log.info("presses a way: %s", ways)
    assert max(ways) <= MOST_PRESSES
    if place == "served":
        see_hundred_worlds(teacher, snap)
    expect(tour).to_contain_text("Done")
    expect(tour).to_contain_text("by itself")
    page.reload()
    tour.get_by_role("button", name="Close", exact=True).click()  # a message may have one, too
    page.reload()
    expect(teacher.state_button("done")).to_be_visible()
    expect(tour).to_have_count(0)


def see_hundred_worlds(teacher: Teacher, snap: Callable[[Page, str], None]) -> None:
    """Let it run in a hundred worlds, which a studio of static files does not offer."""
    page = teacher.page
    teacher.click("Show 100 worlds")
    worlds = page.get_by_role("region", name="A hundred worlds")
    expect(worlds).to_contain_text("of 100 worlds in which it was not taught", timeout=30_000)
    works = int(worlds.inner_text().partition("works in ")[2].partition(" ")[0])
    _log.info("works in %d of 100 worlds", works)
    assert works >= WORKS
    expect(page.get_by_role("region", name="Tour")).to_contain_text("Done")
    snap(page, "the end of the tour")
    worlds.get_by_role("button", name="Close the worlds").click()


def follow(teacher: Teacher, late: Random, *, limit_s: float = 60.0) -> int:
    """Press what the tour says until it asks for another world, or a hundred; return the number of presses."""
    page, presses, until = teacher.page, 0, teacher.clock_s + limit_s
    another = page.get_by_role("button", name="New world", exact=True).and_(page.locator("[data-pointed]"))
    while teacher.clock_s < until:
        if asks_for_hundred(page) or another.count():
            return presses
        said = list_pointed(page)
        if said:
            teacher.let_pass(late.uniform(LEAST_S, MOST_S))
            if click_if_pointed_at(page, said[0]):
                presses += 1
                teacher.let_pass(0.25)
        teacher.let_pass(0.1)
    advice = page.get_by_role("region", name="Tour").inner_text()
    seen = f"{teacher.state} at {teacher.read_aim()}; the tour says {advice!r}"
    raise AssertionError(f"not there within {limit_s} s, after {presses} presses: {seen}")


def asks_for_hundred(page: Page) -> bool:
    """Return whether the tour asks to let it run in a hundred worlds, or is over, where there are none."""
    advice = page.get_by_role("region", name="Tour").inner_text()
    return "a hundred worlds" in advice or "Done" in advice


def list_pointed(page: Page) -> list[str]:
    """Return the states whose buttons the tour points at now."""
    # At once: by the time that a locator has been counted, the mark may be gone.
    states: list[str] = page.locator(".state[data-pointed]").evaluate_all(
        "all => all.map(one => one.dataset.state)"
    )
    return states


def click_if_pointed_at(page: Page, state: str) -> bool:
    """Click the button of a state if the tour still points at it; return whether it did."""
    # In one step in the page: between a look and a press, the robot may decide so by itself.
    clicked: bool = page.locator(".state[data-pointed]").evaluate_all(
        """(all, state) => {
            const [one] = all.filter((each) => each.dataset.state === state);
            one?.click();
            return one !== undefined;
        }""",
        state,
    )
    return clicked


def test_the_tour_can_be_left_and_taken_up_again(visit: Callable[[], Page]) -> None:
    teacher = Teacher(visit())
    tour = teacher.page.get_by_role("region", name="Tour")
    teacher.click("Show me how")
    teacher.click("Begin")
    expect(tour).to_contain_text("2 of 6")
    teacher.click("Leave the tour")
    expect(tour).to_have_count(0)
    teacher.press("ArrowLeft")
    teacher.page.reload()
    teacher.click("Resume the tour")
    expect(tour).to_contain_text("2 of 6")
