"""Examples that were made from recordings, at the page: where each is from, and who drove."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher

from understudy import (
    ExampleSource,
    Forage,
    Library,
    Session,
    TrainedAutomaton,
    learn_automaton,
    new_lesson,
    save_automaton,
)
from understudy.sim.forage import FORAGE_KIT

SOURCE = ExampleSource("anna.csv", 12.34, "anna", 0.97)


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    """A studio whose library has an automaton with one example from a recording and one from a session."""
    library = Library(FORAGE_KIT)
    empty = new_lesson(library, "driven", states=["forward"], features=["distance_to(station)"])
    session = Session(Forage([9]), library, empty)
    session.direct("forward")
    session.run_for(1.0)
    directive, default = session.lesson.examples[:2]
    lesson = replace(session.lesson, examples=(replace(directive, source=SOURCE), default))
    save_automaton(tmp_path / "library", TrainedAutomaton(learn_automaton(lesson), lesson))
    made = Studio(tmp_path / "library")
    made.start()
    yield made
    made.stop()


def test_an_example_says_where_it_is_from(visit: Callable[[], Page]) -> None:
    teacher = Teacher(visit())
    teacher.page.get_by_role("tab", name="Library").click()
    teacher.click("Open driven")
    expect(teacher.page.get_by_role("button", name="why?")).to_be_visible()  # it is open, at the first tab
    teacher.page.get_by_role("tab", name=re.compile("Lesson")).click()
    teacher.click("Example 1")
    expect(teacher.page.get_by_text("from anna.csv at 12.3 s, driven by anna")).to_be_visible()
    teacher.click("Example 2")
    expect(teacher.page.get_by_text("from anna.csv")).to_have_count(0)
    expect(teacher.page.get_by_text(re.compile("^shown at "))).to_be_visible()
