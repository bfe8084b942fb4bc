"""What changed, in one line at the page: with its conditions, and with a way back; and once more before it is saved."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from math import radians

from playwright.sync_api import Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher

from understudy.learning.fit import learn_automaton
from understudy.model.lesson import Example, ExampleKind
from understudy.model.library import Library, TrainedAutomaton
from understudy.sim.forage import FORAGE_KIT
from understudy.storage.library_folder import save_automaton
from understudy.training.lesson_design import new_lesson

SHOWN = [  # state, distance (m), angle (°), next state
    ("start", 3.0, 0, "forward"),
    ("forward", 3.0, 0, "forward"),
    ("forward", 2.0, 50, "rotate_left"),
    ("rotate_left", 2.0, 40, "rotate_left"),
    ("forward", 0.3, 0, "done"),
]


def goto() -> TrainedAutomaton:
    lesson = new_lesson(
        Library(FORAGE_KIT),
        "goto",
        parameters=["A"],
        states=["forward", "rotate_left"],
        flags=["done"],
        features=["distance_to(A)", "angle_to(A)"],
        live=True,
    )
    examples = [
        Example(
            number,
            state,
            (far, radians(aim)),
            following,
            ExampleKind.DEFAULT if state == following else ExampleKind.DIRECTIVE,
        )
        for number, (state, far, aim, following) in enumerate(SHOWN, 1)
    ]
    lesson = replace(lesson, examples=tuple(examples))
    return TrainedAutomaton(learn_automaton(lesson), lesson)


def test_what_changed_is_said_shown_and_undone(
    visit: Callable[[], Page], studio: Studio, snap: Callable[[Page, str], None]
) -> None:
    studio.stop()
    save_automaton(studio.library, goto())
    studio.start()
    page = visit()
    person = Teacher(page)
    person.click("Open one of the library")
    person.click("Open goto")
    expect(person.state_button("forward")).to_be_visible()
    person.press("Space")
    said = "forward no longer raises done"
    line = page.get_by_text("Changed: " + said)
    delete(page)
    expect(line).to_be_visible()
    snap(page, "changed")
    page.get_by_role("button", name="show me").click()
    shown = page.get_by_role("region", name="What changed")
    expect(shown).to_contain_text("− distance to A is below")
    snap(page, "changed-shown")
    page.get_by_role("button", name="undo", exact=True).click()
    expect(line).to_have_count(0)
    expect(shown).to_have_count(0)
    delete(page)
    page.get_by_role("button", name="Save", exact=True).click()
    before = page.get_by_role("alert", name="Before it is saved")
    expect(before).to_contain_text("Since it was last saved, beyond what you pressed:")
    expect(before).to_contain_text(said)
    snap(page, "changed-before-saving")
    before.get_by_role("button", name="Save anyway").click()
    expect(before).to_have_count(0)
    expect(page.get_by_text("in the library", exact=True)).to_be_visible()


def delete(page: Page) -> None:
    """Delete the example by which it is done."""
    page.get_by_role("tab", name=re.compile("Lesson")).click()
    row = page.get_by_role("row").filter(has=page.get_by_role("cell", name="done", exact=True))
    row.get_by_role("button").click()
    page.get_by_role("button", name="Delete", exact=True).click()
    expect(row).to_have_count(0)
