"""Looking back at the page: why, what lessons promise and what saving would break, versions, and simplifying."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Locator, Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import Teacher
from tests.browser.test_doubt import make_goto_with_slip, show
from tests.browser.window import wait_until

from understudy.judging.properties.stored_moments import add_moment_property
from understudy.model.library import Library, TrainedAutomaton
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.storage.library_folder import save_automaton
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session

WORLD = 4
Snap = Callable[[Page, str], None]


def goes() -> Session:
    """Somebody who has shown goto once, up to the flag."""
    lesson = new_lesson(
        Library(FORAGE_KIT),
        "goto",
        parameters=["A"],
        states=["forward", "rotate_left", "rotate_right"],
        flags=["done"],
        features=["distance_to(A)", "angle_to(A)"],
        live=False,
    )
    session = Session(Forage([WORLD]), Library(FORAGE_KIT), lesson, targets={"A": "station"})
    show(session)
    return session


def fetches(library: Library) -> Session:
    """Somebody who has shown fetch, which runs goto, and promises to be done in a minute."""
    lesson = new_lesson(
        library, "fetch", states=["goto(station)"], flags=["done"], features=["done"], live=False
    )
    session = Session(Forage([WORLD]), library, lesson)
    session.direct("goto")
    session.run_for(60.0)
    session.direct("done")
    session.tick()
    session.reset(WORLD)
    add_moment_property(session, flag="done", within_s=60.0)
    return session


def open_goto(studio: Studio, visit: Callable[[], Page], *known: TrainedAutomaton) -> Teacher:
    """Goto, of a library that has these, open in the world where it was shown; time stands still."""
    studio.stop()
    for each in known:
        save_automaton(studio.library, each)
    studio.start()
    page = visit()
    teacher = Teacher(page)
    teacher.click("Open one of the library")
    teacher.click("Open goto")
    expect(teacher.state_button("forward")).to_be_visible()
    teacher.press("Space")
    seed = page.get_by_label("seed")
    seed.fill(str(WORLD))
    seed.press("Enter")
    seed.blur()
    return teacher


@pytest.fixture
def teacher(studio: Studio, visit: Callable[[], Page]) -> Teacher:
    """A library with goto and with fetch, which runs it, and goto open."""
    goto = goes().make_trained_automaton()
    return open_goto(
        studio, visit, goto, fetches(Library(FORAGE_KIT).with_automaton(goto)).make_trained_automaton()
    )


def tab(page: Page, name: str) -> None:
    page.get_by_role("tab", name=re.compile(name)).click()


def last_example(page: Page) -> Locator:
    """The one that showed when to raise the flag."""
    return page.get_by_role("row").filter(has=page.get_by_role("cell", name="done", exact=True))


def forget_the_flag(page: Page) -> None:
    tab(page, "Lesson")
    last_example(page).get_by_role("button").click()
    page.get_by_role("button", name="Delete", exact=True).click()
    expect(last_example(page)).to_have_count(0)


def test_a_promise_is_kept_and_a_broken_one_is_told_before_it_is_saved(teacher: Teacher, snap: Snap) -> None:
    page = teacher.page
    saving = page.get_by_role("button", name="Save", exact=True)
    tab(page, "Lesson")
    outcomes = page.get_by_role("region", name="Properties")
    outcomes.get_by_role("button", name="+ property").click()
    outcomes.get_by_label("seconds").fill("30")
    outcomes.get_by_role("button", name="Add property", exact=True).click()
    expect(outcomes).to_contain_text("done is raised within 30 s in forage, A = station")
    outcomes.get_by_role("button", name="Test lessons").click()
    expect(outcomes).to_contain_text("All as shown, all properties hold")
    expect(outcomes).to_contain_text(re.compile(r"✓ \d+\.\d s"))
    saving.click()
    expect(saving).to_be_disabled()

    forget_the_flag(page)
    expect(outcomes).to_contain_text("before the lesson changed")
    outcomes.get_by_role("button", name="Test lessons").click()
    tested = page.get_by_role("region", name="Tested")
    expect(tested).to_contain_text("Failed: 2 of 2")
    expect(tested).to_contain_text("changed since it was saved; fetch runs it")
    expect(tested).to_contain_text(
        "done is raised within 60 s in forage; it holds with the former version of goto"
    )
    snap(page, "tested")
    saving.click()
    warning = page.get_by_role("alert", name="Before it is saved")
    expect(warning).to_contain_text("goto no longer has the property: done is raised within 30 s")
    expect(warning).to_contain_text("fetch no longer has the property: done is raised within 60 s")
    expect(saving).to_be_enabled()
    snap(page, "saving")
    teacher.press("Control+z")
    expect(warning).to_have_count(0)
    expect(saving).to_be_disabled()

    outcomes.get_by_role("button", name="Close what was tested").click()
    outcomes.get_by_role("button", name=re.compile("Remove property")).click()
    expect(outcomes).not_to_contain_text("done is raised within 30 s")
    teacher.press("Control+z")
    expect(outcomes).to_contain_text("done is raised within 30 s")


def test_what_moved_between_two_versions(teacher: Teacher, snap: Snap) -> None:
    page = teacher.page
    tab(page, "Lesson")
    number = last_example(page).get_by_role("button").inner_text()
    forget_the_flag(page)
    page.get_by_role("button", name="Save", exact=True).click()
    page.get_by_role("button", name="Save anyway").click()
    expect(page.get_by_role("button", name="Save", exact=True)).to_be_disabled()
    tab(page, "Library")
    page.get_by_role("button", name="Versions of goto").click()
    page.get_by_role("button", name="version 1", exact=True).click()
    changes = page.get_by_role("region", name="What changed since version 1")
    expect(changes).to_contain_text("forward → done vanished")
    expect(changes).to_contain_text("− distance to A is below")
    expect(changes).to_contain_text(f"because of example {number} (gone, showed it)")
    snap(page, "moved")


def test_simpler_is_shown_before_it_is_kept(studio: Studio, visit: Callable[[], Page], snap: Snap) -> None:
    teacher = open_goto(studio, visit, make_goto_with_slip().make_trained_automaton())
    page = teacher.page
    rules = page.get_by_role("tabpanel").get_by_role("listitem")
    expect(rules).not_to_have_count(0)
    before = rules.all_inner_texts()
    page.get_by_role("button", name="simplify …").click()
    card = page.get_by_role("region", name="Simplify")
    expect(card).to_contain_text(re.compile(r"\d+ answers become \d+"))
    expect(card).to_contain_text("would be decided otherwise")
    snap(page, "simpler")
    card.get_by_role("button", name="Leave").click()
    expect(rules).to_have_text(before, use_inner_text=True)
    page.get_by_role("button", name="simplify …").click()
    card.get_by_role("button", name="Keep").click()
    expect(page.get_by_role("button", name="simplified …")).to_be_visible()
    expect(rules).not_to_have_text(before, use_inner_text=True)
    teacher.press("Control+z")
    expect(page.get_by_role("button", name="simplify …")).to_be_visible()
    expect(rules).to_have_text(before, use_inner_text=True)


def test_why_goes_along_with_time_and_opens_who_showed_it(teacher: Teacher, snap: Snap) -> None:
    page = teacher.page
    teacher.press("t")
    page.get_by_role("button", name="why?").click()
    why = page.get_by_role("region", name="Why")
    expect(why).to_contain_text("It goes from start to")
    for _ in range(8):
        teacher.press(".")
    expect(why).to_contain_text("the last switch, at 0:00")
    expect(why).not_to_contain_text("goes from start")
    snap(page, "why")

    def is_back() -> bool:
        page.get_by_role("slider", name="Rewind").press("ArrowLeft")
        return re.search(r"[Ii]t goes from start to", why.inner_text()) is not None

    wait_until(page, is_back)
    expect(why).not_to_contain_text("the last switch, ")
    example = why.get_by_role("button", name=re.compile(r"^\d+ press")).first
    number = example.inner_text().split()[0]
    example.click()
    expect(page.get_by_role("button", name=f"Example {number}", exact=True)).to_have_attribute(
        "aria-expanded", "true"
    )
    expect(page.get_by_text("shown at 0:00")).to_be_visible()
    tab(page, "Automaton")
    expect(why).to_be_visible()


def test_undo_and_redo_stay_on_one_line(teacher: Teacher) -> None:
    page = teacher.page
    page.set_viewport_size({"width": 1024, "height": 700})
    tab(page, "Lesson")
    tops = [
        page.get_by_role("button", name=name, exact=True).evaluate("each => each.offsetTop")
        for name in ("Undo", "Redo")
    ]
    assert tops[0] == tops[1]
