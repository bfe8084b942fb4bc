"""What the tests of the notebook's widget share: a session, and a driver whose clock moves when told."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session
from understudy.ui.notebook.session_driver import SessionDriver

VIEW = {"action": "show", "view": "one"}
STATES = ("start", "forward", "rotate_left", "rotate_right", "done")


def make_goto_session(
    *, body: Forage | None = None, live: bool = False, journal: Path | None = None
) -> Session:
    """A session of a robot that is to go to its station."""
    lesson = new_lesson(
        Library(FORAGE_KIT),
        "goto",
        parameters=["A"],
        states=["forward", "rotate_left", "rotate_right"],
        flags=["done"],
        features=["distance_to(A)", "angle_to(A)"],
        live=live,
    )
    world = Forage([42]) if body is None else body
    return Session(world, Library(FORAGE_KIT), lesson, targets={"A": "station"}, journal=journal)


class Hand:
    """A person at a view: time passes when told."""

    def __init__(self, session: Session, *, speed: float = 1.0, folder: Path | None = None) -> None:
        self.now = 0.0
        self.session = session
        self.driver = SessionDriver(session, speed=speed, folder=folder, wall=lambda: self.now)
        self.ask(**VIEW)

    def ask(self, **request: Any) -> str:
        """What the status says to a request."""
        self.driver.receive(request)
        return self.driver.trainer.status.text

    def press(self, state: str) -> str:
        """What the status says to a press."""
        return self.ask(action="press", state=state)

    def wait(self, ticks: int = 1) -> None:
        """Let the time of so many ticks pass, with the view on the screen."""
        for _ in range(ticks):
            self.now += self.session.body.tick_s
            self.ask_quietly(**VIEW)
            self.driver.beat()

    def ask_quietly(self, **request: Any) -> None:
        """Make a request whose answer does not matter."""
        self.driver.receive(request)

    @property
    def status(self) -> tuple[str, str]:
        """The status: its text and its tone."""
        status = self.driver.trainer.status
        return status.text, status.tone
