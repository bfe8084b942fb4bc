"""What went wrong in new worlds is advised on first: tables of decisions there, of a lesson written by hand."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import pytest
from tests.make.goto_sessions import GOTO, Row, make_goto_session

from understudy.coaching.advice import Advice, AdviceKind, WrongDecisions
from understudy.coaching.give_advice import give_advice
from understudy.coaching.lesson_analysis import MetDecision
from understudy.learning.fit import learn
from understudy.model.learner_options import LearnerOptions, TreeOptions
from understudy.model.lesson import Lesson

FAR_OFF = "done where distance_to(A) is 4 m"


def advise(lesson: Lesson, *met: tuple[str, float, float], worlds: int = 10) -> tuple[Advice, ...]:
    """Advise on a lesson whose robot went wrong at these states, distances, and bearings, each in a world."""
    decisions = [
        MetDecision(seed, 0.0, state, (off, radians(deg))) for seed, (state, off, deg) in enumerate(met)
    ]
    wrong = WrongDecisions(worlds, dict.fromkeys(range(len(met)), FAR_OFF), decisions)
    return give_advice(lesson, learn(lesson), wrong=wrong)


def learn_by_gain() -> Lesson:
    """Learned by the highest gain, done is told from forward by the bearing, wherever the target is."""
    rows: tuple[Row, ...] = (
        ("forward", "forward", "confirmation", 6.0, 10),
        ("forward", "forward", "confirmation", 5.0, 60),
        ("forward", "done", "directive", 0.3, 100),
        ("forward", "done", "directive", 0.2, 110),
        ("forward", "forward", "confirmation", 0.5, 200),
    )
    return replace(make_goto_session(rows), options=LearnerOptions(learner=TreeOptions(order="gain first")))


FIRST = [  # the lesson, the decision that went wrong, the advice that is first, its examples
    (make_goto_session(), ("forward", 3.0, 180), AdviceKind.GAP, ()),  # behind: never shown there
    (make_goto_session(), ("forward", 0.2, 350), AdviceKind.SINGLE, (2,)),  # done, as only example 2 says
    (
        make_goto_session((*GOTO, ("forward", "left", "directive", 0.3, 350))),
        ("forward", 0.3, 350),
        AdviceKind.CONTRADICTION,
        (2, 7),
    ),
    (
        learn_by_gain(),
        ("forward", 4.0, 105),
        AdviceKind.STRETCHED,
        (1,),
    ),  # done far away, where example 1 is nearest
]


@pytest.mark.parametrize(("lesson", "met", "kind", "examples"), FIRST)
def test_what_went_wrong_in_worlds_comes_first(
    lesson: Lesson, met: tuple[str, float, float], kind: AdviceKind, examples: tuple[int, ...]
) -> None:
    first = advise(lesson, met, met, worlds=8)[0]
    assert (first.kind, first.examples) == (kind, examples)
    assert first.evidence == f"I went wrong there in 2 of 8 new worlds ({FAR_OFF})."
    assert first.weight == pytest.approx(0.95 + 0.05 * 2 / 8)


def test_more_worlds_come_before_fewer() -> None:
    behind, near = ("forward", 3.0, 180.0), ("forward", 0.2, 350.0)
    assert [each.kind for each in advise(make_goto_session(), behind, near, near)][:2] == [
        AdviceKind.SINGLE,
        AdviceKind.GAP,
    ]
    assert [each.kind for each in advise(make_goto_session(), behind, behind, near)][:2] == [
        AdviceKind.GAP,
        AdviceKind.SINGLE,
    ]


def test_a_world_counts_once() -> None:
    met = [MetDecision(7, 0.0, "forward", (3.0, radians(deg))) for deg in (170, 180, 190)]
    first = give_advice(
        make_goto_session(), learn(make_goto_session()), wrong=WrongDecisions(4, {7: ""}, met)
    )[0]
    assert first.evidence.startswith("I went wrong there in 1 of 4 new worlds")


AS_BEFORE = [  # a lesson, and decisions in worlds that no advice is about
    (make_goto_session(), []),
    (make_goto_session(), [("forward", 6.0, 10.0)]),  # as shown
    (make_goto_session(GOTO[:2]), [("forward", 3.0, 180.0)]),  # hardly anything was shown
]


@pytest.mark.parametrize(("lesson", "met"), AS_BEFORE)
def test_else_the_order_is_that_of_the_lesson(lesson: Lesson, met: list[tuple[str, float, float]]) -> None:
    assert advise(lesson, *met) == give_advice(lesson, learn(lesson))


def test_a_state_that_is_never_left_is_where_it_stayed() -> None:
    shown = (*GOTO[:3], ("forward", "left", "directive", 3.0, 60), ("left", "left", "default", 3.0, 60))
    first = advise(make_goto_session(shown), ("left", 3.0, 60))[0]
    assert (first.kind, first.state) == (AdviceKind.NEVER_LEFT, "left")
