"""A bad example, from the wrong key to the right robot and back, at the page."""

from __future__ import annotations

import re
from collections.abc import Callable
from math import degrees, pi, tau

from playwright.sync_api import Page, expect
from tests.browser.studio import Studio
from tests.browser.teacher import KEYS, Teacher

from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.storage.library_folder import save_automaton
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session

SLIP, TICK = 3, 12
"""The world in which the wrong key was pressed, and so many ticks after it began to drive."""
STEPS = 200


def right(session: Session) -> str:
    """What is right at a distance and an angle to A, while it does something."""
    view = session.view()
    off = degrees((view.features["angle_to(A)"] + pi) % tau - pi)
    if view.features["distance_to(A)"] < 0.35:
        return "done"
    if abs(off) > (9.0 if view.state == "forward" else 3.0):
        return "rotate_left" if off > 0 else "rotate_right"
    return "forward"


def show(session: Session, *, slip: bool = False) -> None:
    """Direct the robot to A; in one world with a slip: once to the right, where it should drive on."""
    driven = 0
    while session.view().state != "done":
        driven += session.view().state == "forward"
        wish = right(session)
        if slip and driven == TICK:
            wish, slip = "rotate_right", False
        elif driven % 6 == 5 and wish == session.view().state == "forward":
            session.confirm()
        if wish != session.view().state:
            session.direct(wish)
        session.tick()


def make_goto_with_slip() -> Session:
    """Somebody who has shown goto in some worlds, and slipped in one."""
    lesson = new_lesson(
        Library(FORAGE_KIT),
        "goto",
        parameters=["A"],
        states=["forward", "rotate_left", "rotate_right"],
        flags=["done"],
        features=["distance_to(A)", "angle_to(A)"],
        live=False,
    )
    session = Session(Forage([SLIP]), Library(FORAGE_KIT), lesson, targets={"A": "station"})
    for world in (4, 5, SLIP, 6):
        session.reset(world)
        show(session, slip=world == SLIP)
    return session


def errs(session: Session) -> int | None:
    """After how many ticks in the world of the slip it turns right from driving; None where it never does."""
    session.reset(SLIP)
    session.test()
    for tick in range(STEPS):
        before = session.view().state
        session.tick()
        if (before, session.view().state) == ("forward", "rotate_right"):
            return tick
    return None


class Watcher(Teacher):
    """Somebody who lets time go on tick by tick."""

    def until_it_turns(self, most: int) -> int | None:
        """After how many ticks of driving and turning it turns right from driving, in the world of the slip."""
        seed = self.page.get_by_label("seed")
        seed.fill(str(SLIP))
        seed.press("Enter")
        seed.blur()
        time = self.page.get_by_title("Time in the world")
        expect(time).to_have_text("0:00.0")  # until then, it is that of the world before
        expect(self.state_button("start")).to_have_attribute("aria-pressed", "true")
        before = "start"
        for tick in range(most):
            clock = time.inner_text()
            self.press(".")
            expect(time).not_to_have_text(clock)
            if (before, self.state) == ("forward", "rotate_right"):
                return tick
            before = self.state
        return None


def test_a_slip_is_pointed_out_held_and_let_go(
    visit: Callable[[], Page], studio: Studio, snap: Callable[[Page, str], None]
) -> None:
    session = make_goto_with_slip()
    turned = errs(session)
    assert turned is not None
    session.train()
    studio.stop()
    save_automaton(studio.library, session.make_trained_automaton())
    studio.start()
    page = visit()
    watcher = Watcher(page)
    watcher.click("Open one of the library")
    watcher.click("Open goto")
    expect(watcher.state_button("forward")).to_be_visible()
    watcher.press("Space")
    watcher.press("t")
    assert watcher.until_it_turns(turned + 5) == turned
    watcher.press(KEYS["forward"])
    watcher.press(".")
    doubt = page.get_by_role("status", name="Doubtful examples")
    expect(doubt).to_contain_text("was wrong because of example")
    snap(page, "doubt")
    doubt.get_by_role("button", name=re.compile("quarantine")).click()
    expect(doubt).to_have_count(0)
    page.get_by_role("tab", name=re.compile("Lesson")).click()
    held = page.get_by_role("row", name=re.compile("in quarantine"))
    expect(held).to_have_count(1)
    snap(page, "held")
    watcher.press("t")
    assert watcher.until_it_turns(turned + 5) is None
    watcher.press("t")
    watcher.press("Control+z")
    expect(held).to_have_count(0)
    expect(doubt).to_have_count(1)
    watcher.press("t")
    assert watcher.until_it_turns(turned + 5) is not None
