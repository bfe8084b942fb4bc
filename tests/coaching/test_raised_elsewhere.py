"""The coach goes to where a flag is raised elsewhere than it was shown, before it asks about any doubt."""

from __future__ import annotations

from dataclasses import replace

from understudy.coaching.next_situation import go_to_situation
from understudy.coaching.questions import UncertaintyQueries
from understudy.coaching.raised_elsewhere import find_raised_elsewhere
from understudy.coaching.reasons_to_ask import DoubtReason
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT, Forage
from understudy.training.lesson_design import new_lesson
from understudy.training.session import Session

SEEDS = range(100, 106)


def make_lesson(*presses: tuple[str, str, float]) -> Lesson:
    """Return a lesson of going to the station; each press with its state, the next one and the distance, m."""
    library = Library(FORAGE_KIT)
    lesson: Lesson = new_lesson(
        library, "goto", states=["forward"], flags=["done"], features=["distance_to(station)", "food_stored"],
        options=LearnerOptions(live=True),
    )  # fmt: skip
    examples = tuple(
        Example(number, state, (meters, 0.0), following, ExampleKind.DIRECTIVE)
        for number, (state, following, meters) in enumerate(presses, 1)
    )
    return replace(lesson, examples=examples)


BEGINS = [("start", "forward", 3.0), ("start", "forward", 1.0)]
NEAR = [
    ("forward", "done", 0.2),
    ("forward", "done", 0.3),
    ("forward", "forward", 0.6),
    ("forward", "forward", 4.0),
]


def begin(lesson: Lesson) -> Session:
    session = Session(Forage([0]), Library(FORAGE_KIT), lesson)
    session.test()
    return session


def test_where_nothing_is_raised_elsewhere_there_is_no_such_situation() -> None:
    """Between what was shown and 0.6 m everything agrees; a flag that was pressed once says nothing."""
    assert find_raised_elsewhere(begin(make_lesson(*BEGINS, *NEAR)), seeds=SEEDS) is None
    assert find_raised_elsewhere(begin(make_lesson(*BEGINS, NEAR[0], NEAR[3])), seeds=SEEDS) is None


def test_it_is_where_the_flag_is_about_to_be_raised_and_asked_once() -> None:
    """In start it was shown to be done only; that this is far away from what was shown, only the other state tells."""
    session = begin(make_lesson(("start", "done", 0.2), ("start", "done", 0.3), *NEAR[2:]))
    queries = UncertaintyQueries(session)
    found = find_raised_elsewhere(session, seeds=SEEDS, queries=queries)
    assert found is not None
    assert (found.seed, found.question.state, found.question.next) == (100, "start", "done")
    assert found.question.doubt.because is DoubtReason.ELSEWHERE
    shown = "done was shown only where distance_to(station) is 0.20 to 0.30 m"
    assert found.question.sentence == f"I would go to done, but {shown}. What is right?"
    go_to_situation(session, found)
    view = session.view()
    assert (view.state, tuple(view.features.values())) == (found.question.state, found.question.values)
    queries.note_asked(found.question)
    assert find_raised_elsewhere(session, seeds=SEEDS, queries=queries) is None
