"""Automata in automata at the page, and the way from the library to a behavior."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Locator, Page, expect
from tests.browser.teacher import Teacher
from tests.browser.test_axe import nests
from tests.browser.test_shelf import show


@pytest.fixture
def teacher(visit: Callable[[], Page]) -> Teacher:
    """Somebody who has saved goto."""
    made = Teacher(visit())
    made.begin_goto()
    made.click("Pause")
    expect(made.page.get_by_role("button", name="Resume", exact=True)).to_be_visible()
    show(made, "forward")
    return made


def middle(edge: Locator) -> tuple[float, float]:
    """A point on the line itself: the middle of the box around it may lie beside it."""
    x, y = edge.locator(".line").evaluate(
        """line => {
            const { x, y } = line.getPointAtLength(line.getTotalLength() / 2).matrixTransform(line.getScreenCTM());
            return [x, y];
        }"""
    )
    return float(x), float(y)


def test_an_edge_inside_says_when_it_is_taken(teacher: Teacher) -> None:
    page = teacher.page
    nests(teacher)
    page.mouse.click(*middle(page.get_by_role("button", name="start to forward, in goto")))
    expect(page.get_by_role("heading", name="This transition, in goto")).to_be_visible()
    expect(page.locator(".rule")).to_have_count(1)
    expect(page.locator(".rule")).to_contain_text("start → forward")
    expect(page.locator(".rule .condition")).to_contain_text("always")
    page.get_by_role("button", name="show all").click()
    expect(page.get_by_role("heading", name="What it learned")).to_be_visible()


def test_from_the_shelf_to_a_behavior(teacher: Teacher) -> None:
    page = teacher.page
    page.get_by_role("tab", name="Library").click()
    for number in range(6):
        page.get_by_role("button", name="Duplicate goto", exact=True).click()
        page.get_by_role("textbox", name="Name of the copy of goto").fill(f"twin {number}")
        page.keyboard.press("Enter")
        expect(page.get_by_role("button", name=f"Open twin {number}")).to_be_visible()
    page.get_by_role("tab", name="Automaton").click()
    for name in ("twin 5", "twin 0", "twin 5"):
        page.get_by_role("complementary").get_by_role("button", name=name).click()
        there = page.locator(".behavior[aria-current=true]")
        expect(there).to_have_count(1)
        expect(there).to_contain_text(name)
        expect(there).to_be_in_viewport()
        expect(there).to_be_focused()
