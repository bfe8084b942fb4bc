"""The coach at the page: what to show next, set up on a click, and a robot that asks where it is unsure."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import radians
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect
from tests.browser.studio import Studio, open_studio
from tests.browser.teacher import KEYS, Teacher
from tests.browser.test_doubt import show

from understudy.learning.fit import learn_automaton
from understudy.model.learner_options import LearnerOptions, TreeOptions
from understudy.model.lesson import Example, ExampleKind
from understudy.model.library import Library, TrainedAutomaton
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.storage.library_folder import save_automaton
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy_lab.novices.novice import Novice, draw_traits

Snap = Callable[[Page, str], None]
SHOWN, AHEAD, UNSURE = (4, 5), "9", "13"
"""The worlds in which the way was shown, always to the left; one in which A is not behind, and one in which the robot
is unsure three times."""
BEHIND = "Show me what to do in state forward when A is behind you"


@pytest.fixture
def studio(tmp_path: Path) -> Iterator[Studio]:
    """A studio with goto as it was shown in two worlds; learned by the highest gain, a check finds something in it."""
    lesson = new_lesson(
        Library(FORAGE_KIT),
        "goto",
        parameters=["A"],
        states=["forward", "rotate_left", "rotate_right"],
        flags=["done"],
        features=["distance_to(A)", "angle_to(A)"],
        options=LearnerOptions(learner=TreeOptions(order="gain first")),
        live=False,
    )
    session = Session(Forage([SHOWN[0]]), Library(FORAGE_KIT), lesson, targets={"A": "station"})
    for world in SHOWN:
        session.reset(world)
        show(session)
    save_automaton(tmp_path / "library", session.make_trained_automaton())
    made = Studio(tmp_path / "library")
    made.start()
    yield made
    made.stop()


@pytest.fixture
def teacher(visit: Callable[[], Page]) -> Teacher:
    """Somebody who has opened goto, lets time stand still, and looks at what the coach says."""
    page = visit()
    teacher = Teacher(page)
    teacher.click("Open one of the library")
    teacher.click("Open goto")
    expect(page.get_by_role("tab", name="Automaton", selected=True)).to_be_visible()
    teacher.click("Pause")
    expect(page.get_by_role("button", name="Resume", exact=True)).to_be_visible()
    page.get_by_role("tab", name="Coach").click()
    return teacher


def test_what_to_show_next_is_set_up_shown_and_said_no_more(teacher: Teacher, snap: Snap) -> None:
    page = teacher.page
    goes_to(teacher, AHEAD)
    advice = page.get_by_role("list", name="Advice").get_by_role("listitem")
    behind = advice.filter(has_text=BEHIND)
    behind.get_by_role("button", name="Set up").click()
    expect(behind).to_contain_text("The situation is set up in state forward")
    expect(teacher.state_button("forward")).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_role("button", name="Resume", exact=True)).to_be_visible()
    expect(page.get_by_role("complementary")).to_contain_text(re.compile(r"angle to A\s*−?1[3-8]\d°"))
    snap(page, "coach")
    before = teacher.examples
    teacher.press(KEYS["rotate_right"])
    teacher.press(".")
    expect(behind).to_have_count(0)
    assert teacher.examples == before + 2  # with its default
    teacher.press("Control+z")
    expect(behind).to_have_count(1)
    show_it = advice.get_by_role("button", name=re.compile(r"^show example \d+$")).first
    number = show_it.inner_text().split()[-1]
    show_it.click()
    expect(page.get_by_role("row", name=f"Example {number} ", selected=True)).to_be_visible()
    expect(page.get_by_role("button", name="Delete")).to_be_visible()


def test_what_a_check_finds_is_listed_and_set_up(teacher: Teacher, snap: Snap) -> None:
    page = teacher.page
    found = page.get_by_role("list", name="Findings").get_by_role("listitem")
    expect(found).to_have_count(1)
    expect(found).to_contain_text(
        "Warning: forward and turn left undo each other where distance to A is at least"
    )
    expect(found).to_contain_text("Assumes: readings of this cell occur")
    found.get_by_role("button", name="Set up").click()
    expect(found).to_contain_text("The situation is set up in state forward")
    expect(teacher.state_button("forward")).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_role("complementary")).to_contain_text(re.compile(r"angle to A\s*−\d+°"))
    found.scroll_into_view_if_needed()
    snap(page, "checked")
    before = teacher.examples
    teacher.press("Enter")
    teacher.press(".")
    expect(found).to_have_count(0)
    assert teacher.examples > before


def test_a_robot_that_is_unsure_asks_and_the_press_is_the_answer(teacher: Teacher, snap: Snap) -> None:
    page = teacher.page
    teacher.click("pause")
    goes_to(teacher, UNSURE)
    teacher.press("t")
    teacher.press("Space")
    question = page.get_by_role("status", name="Question of the robot")
    expect(question).to_contain_text("I am not sure: I would go to turn left")
    snap(page, "asked")
    before, clock = teacher.examples, teacher.clock_s
    expect(page.get_by_role("button", name="Carry on")).to_be_enabled()
    assert teacher.clock_s == clock
    teacher.press(KEYS["rotate_left"])
    expect(page.get_by_role("tab", name=f"Lesson {before + 2}")).to_be_visible()
    expect(page.get_by_role("group", name="Mode").get_by_role("button", name="Try")).to_have_attribute(
        "aria-pressed", "true"
    )
    expect(question).to_contain_text("I would stay in turn left")  # it went on
    assert teacher.clock_s > clock
    now = teacher.clock_s
    question.get_by_role("button", name="Carry on").click()
    expect(question).to_have_count(0)
    teacher.wait_until(lambda: teacher.clock_s > now)
    assert teacher.examples == before + 2


def test_where_it_was_unsure_is_marked_and_gone_back_to(teacher: Teacher, snap: Snap) -> None:
    page = teacher.page
    teacher.click("mark")
    goes_to(teacher, UNSURE)
    page.get_by_label("Speed").select_option("8×")
    teacher.press("t")
    teacher.press("Space")
    marks = page.get_by_role("list", name="Moments at which it was unsure").get_by_role("listitem")
    expect(marks).to_have_count(3)
    expect(teacher.state_button("done")).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_title(re.compile("unsure at"))).to_have_count(3)
    snap(page, "marked")
    marks.last.get_by_role("button").click()
    question = page.get_by_role("status", name="Question of the robot")
    expect(question).to_contain_text("I would go to turn left")
    expect(page.get_by_title("Time in the world")).to_have_text("0:00.0")
    snap(page, "gone-back")
    question.get_by_role("button", name="Yes, go to turn left").click()
    expect(question).to_have_count(0)
    expect(marks.filter(has_text="in start")).to_have_count(0)


def goes_to(teacher: Teacher, seed: str) -> None:
    """Go to the world of a seed."""
    field = teacher.page.get_by_label("seed")
    field.fill(seed)
    field.press("Enter")
    field.blur()
    expect(teacher.page.get_by_title("Time in the world")).to_have_text("0:00.0")


def test_late_presses_are_noticed_and_taken_earlier_on_a_click(
    chromium: Browser, tmp_path: Path, snap: Snap
) -> None:
    """A novice whose presses come half a second late."""
    save_automaton(tmp_path / "late", Novice(draw_traits(1), 1).teach())
    with open_studio(chromium, tmp_path / "late", "soccer") as page:
        teacher = Teacher(page)
        teacher.click("Open one of the library")
        page.get_by_role("button", name=re.compile("^Open ")).last.click()
        expect(page.get_by_role("tab", name="Automaton", selected=True)).to_be_visible()
        page.get_by_role("tab", name="Coach").click()
        late = page.get_by_role("region", name="Reaction time")
        expect(late).to_contain_text(
            re.compile(r"You seem to react within 0\.\d+ s\. Taken 0\.\d+ s earlier, the")
        )
        snap(page, "late")
        late.get_by_role("button", name=re.compile("Use 0")).click()
        expect(late).to_have_count(0)
        expect(page.get_by_text(re.compile(r"Reaction time is 0\.\d+ s from now on"))).to_be_visible()
        teacher.click("undo")
        expect(late).to_be_visible()


def test_a_press_that_looks_like_a_slip_was_meant_or_is_mended(
    chromium: Browser, tmp_path: Path, snap: Snap
) -> None:
    """Eight presses that say where to go on and where to turn, and once the wrong button."""
    shown = [("rotate_left", 3 + k / 4, 90 + 10 * k) for k in range(4)]
    shown += [("done", 0.2 + k / 20, 80 + 20 * k) for k in range(4)]
    lesson = new_lesson(
        Library(FORAGE_KIT),
        "goto",
        parameters=["A"],
        states=["forward", "rotate_left"],
        flags=["done"],
        features=["distance_to(A)", "angle_to(A)"],
        live=False,
    )
    examples = tuple(
        Example(number, "forward", (far, radians(angle)), says, ExampleKind.DIRECTIVE)
        for number, (says, far, angle) in enumerate([*shown, ("done", 3.4, 105)], 1)
    )
    lesson = replace(lesson, examples=examples)
    save_automaton(tmp_path / "slip", TrainedAutomaton(learn_automaton(lesson), lesson))
    with open_studio(chromium, tmp_path / "slip") as page:
        teacher = Teacher(page)
        teacher.click("Open one of the library")
        teacher.click("Open goto")
        expect(page.get_by_text("Opened goto")).to_be_visible()
        page.get_by_role("tab", name="Coach").click()
        asked = page.get_by_role("listitem").filter(has_text="Did you mean this in state forward")
        expect(asked).to_contain_text("Example 9 says done, but examples")
        snap(page, "slip")
        asked.get_by_label("What example 9 was meant to say").select_option("rotate_left")
        expect(asked).to_have_count(0)
        page.get_by_role("tab", name="Lesson").click()
        ninth = page.get_by_role("row").filter(has_text="105")
        expect(ninth).to_contain_text("turn left")
        teacher.click("undo")
        expect(ninth).to_contain_text("done")
        page.get_by_role("tab", name="Coach").click()
        asked.get_by_role("button", name="Yes, I meant done").click()
        expect(asked).to_have_count(0)
