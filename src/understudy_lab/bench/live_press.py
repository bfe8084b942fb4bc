"""The time from a press in live teaching to the end of the tick that decides by it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import cycle

from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session

GOAL_MS = 10.0
FEATURES = ("distance_to(nearest_food)", "angle_to(nearest_food)", "food_stored", "food_below_me")
NAMES = {"go": "forward", "left": "rotate_left", "right": "rotate_right"}
"""The states of the world by those of the lesson that is measured."""


def make_live_session(lesson: Lesson) -> Session:
    """Return a session that is taught live in the foraging world, with the examples of `lesson`."""
    library = Library(FORAGE_KIT)
    here = new_lesson(
        library,
        "goto",
        states=list(NAMES.values()),
        flags=["done"],
        features=FEATURES,
        options=LearnerOptions(live=True),
    )
    examples = tuple(
        replace(
            each,
            state=NAMES.get(each.state, each.state),
            next=NAMES.get(each.next, each.next),
            moment=None,
            window=0,
        )
        for each in lesson.examples
    )
    return Session(Forage([0]), library, replace(here, examples=examples))


def press_repeatedly(session: Session) -> Callable[[], None]:
    """Return a function that presses another state each time, and runs the tick that learns and decides."""
    states = cycle(NAMES.values())

    def press() -> None:
        session.direct(next(states))
        session.tick()

    return press
