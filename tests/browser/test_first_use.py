"""What a person meets on the first day: mistakes are told, old ones go away, and names can be read."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import product

from playwright.sync_api import Page, expect
from tests.browser.teacher import Teacher

Visit = Callable[[], Page]
IDENTIFIER = re.compile(r"[a-z]_[a-z]|[a-z]\([A-Za-z]")


def error(page: Page):  # type: ignore[no-untyped-def]  # a Locator
    """The error that is shown."""
    return page.locator(".toast.error")


def test_a_seed_that_is_none_is_told_and_the_error_goes_with_the_next_success(teacher: Teacher) -> None:
    """Also where the success says the same as the last."""
    page, field = teacher.page, teacher.page.get_by_label("seed")
    for seed in ("abc", "-1", "4.5"):
        before = field.input_value()
        field.fill(seed)
        field.press("Enter")
        expect(error(page)).to_contain_text(f"The seed {seed} is no whole number")
        expect(field).to_have_value(before)
    field.fill("3")
    field.press("Enter")
    expect(page.locator(".toast")).to_contain_text("World 3, from the start")
    field.fill("abc")
    field.press("Enter")
    expect(error(page)).to_be_visible()
    field.fill("3")
    field.press("Enter")
    expect(error(page)).to_have_count(0)
    expect(page.locator(".toast")).to_contain_text("World 3, from the start")


def test_a_reaction_time_that_is_none_is_told(visit: Visit) -> None:
    page = visit()
    page.get_by_role("button", name="Teach something new", exact=True).click()
    begin = page.get_by_role("button", name="Begin", exact=True)
    for seconds in ("abc", "-0.3", ""):
        page.get_by_label("Reaction time").fill(seconds)
        expect(page.get_by_text("The reaction time is no number of seconds")).to_be_visible()
        expect(begin).to_be_disabled()
        page.get_by_label("Reaction time").fill("0,25")
        expect(begin).to_be_enabled()


def test_the_robot_goes_on_after_a_reload(teacher: Teacher) -> None:
    before = teacher.clock_s
    teacher.page.reload()
    expect(teacher.state_button("forward")).to_be_visible()
    expect(teacher.page.get_by_role("button", name="Pause", exact=True)).to_be_visible()
    teacher.wait_until(lambda: teacher.clock_s > before)


def test_control_that_would_be_refused_is_not_offered(teacher: Teacher, visit: Visit) -> None:
    other = visit()
    expect(other.get_by_text("Someone else is in control")).to_be_visible()
    expect(other.get_by_role("button", name="Take control")).to_have_count(0)
    teacher.click("Hand over")
    expect(other.get_by_role("button", name="Take control")).to_be_visible()


def test_escape_closes_the_field_for_a_name(teacher: Teacher) -> None:
    """Also before the browser has drawn the field once: a busy computer draws late."""
    page = teacher.page
    teacher.press("ArrowUp")
    expect(page.get_by_role("button", name="Save", exact=True)).to_be_enabled()
    teacher.click("Save")
    page.get_by_role("tab", name="Library").click()
    field = page.locator(".name-form input")
    for way, elsewhere in product(("Rename", "Duplicate"), (False, True)):
        teacher.click(f"{way} goto")
        expect(field).to_be_focused()
        if elsewhere:
            page.get_by_text("As a file").click()
        page.keyboard.press("Escape")
        expect(field).to_have_count(0)
    page.evaluate(
        """() => new MutationObserver((_, watch) => {
            if (!document.querySelector(".name-form input")) return;
            watch.disconnect();
            dispatchEvent(new KeyboardEvent("keydown", {key: "Escape"}));
            window.pressedEscape = true;
        }).observe(document.body, {childList: true, subtree: true})"""
    )
    teacher.click("Duplicate goto")
    page.wait_for_function("window.pressedEscape")
    expect(field).to_have_count(0)


def test_names_are_written_as_people_read_them(teacher: Teacher) -> None:
    """On every tab and in the form, in the rules and in what is said of a press.

    The first state does not look like a button that starts something: it records an example, as every press.
    """
    page = teacher.page
    row = page.get_by_role("toolbar", name="Direct the robot")
    expect(row).not_to_contain_text(re.compile("start", re.IGNORECASE))
    expect(teacher.state_button("start")).to_contain_text("stand still")
    teacher.press("ArrowLeft")
    expect(teacher.state_button("rotate_left")).to_have_attribute("aria-pressed", "true")
    teacher.press("ArrowUp")
    expect(page.get_by_text("turn left → forward").first).to_be_visible()
    for tab in ("Automaton", "Lesson", "Coach", "Library"):
        page.get_by_role("tab", name=tab).click()
        expect(page.get_by_role("tab", name=tab, selected=True)).to_be_visible()
        seen = page.evaluate(
            "document.body.innerText.replace(document.querySelector('.folder')?.innerText, '')"
        )
        assert IDENTIFIER.findall(seen) == [], tab
    page.get_by_role("button", name="choose features").click()
    assert IDENTIFIER.findall(page.locator("form.choice").inner_text()) == []
    page.get_by_role("checkbox", name="distance to nearest food").check(force=True)
