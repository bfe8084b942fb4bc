"""How sure a decision is of itself."""

from __future__ import annotations

from math import nan, radians

import pytest
from hypothesis import given
from tests.make.goto_sessions import GOTO, Row, make_goto_session
from tests.make.lessons import draw_tables
from tests.make.lessons import make_lesson as lesson_of

from understudy.coaching.reasons_to_ask import DoubtReason, UncertaintyModel
from understudy.learning.fit import learn
from understudy.learning.training_set import group_by_feature_vector
from understudy.model.lesson import Lesson
from understudy.model.value_kinds import Kind


def doubts(lesson: Lesson) -> UncertaintyModel:
    return UncertaintyModel(lesson, learn(lesson))


ASKED = [
    # state, distance, degrees, doubt at least and at most, why, what of it is said
    ("forward", 6.0, 10, 0.0, 0.0, DoubtReason.SHOWN, ""),
    ("forward", 5.4, 15, 0.0, 0.3, DoubtReason.SHOWN, ""),
    ("forward", 0.29, 350, 0.0, 0.1, DoubtReason.SHOWN, ""),
    ("forward", 3.0, 180, 0.7, 1.0, DoubtReason.FAR, "there are no examples in forward when A is"),
    ("left", 5.0, 270, 0.7, 1.0, DoubtReason.FAR, "to the right"),
    ("left", 5.0, 340, 0.3, 0.5, DoubtReason.HANGING, "only example 5 says so"),
    ("done", 0.3, 0, 0.0, 0.0, DoubtReason.SHOWN, "never left"),
]


@pytest.mark.parametrize(("state", "distance", "degrees", "least", "most", "because", "said"), ASKED)
def test_doubt_and_its_reason(
    state: str, distance: float, degrees: float, least: float, most: float, because: DoubtReason, said: str
) -> None:
    found = doubts(make_goto_session()).estimate(state, (distance, radians(degrees)))
    assert least <= found.amount <= most, found
    assert found.because is because, found
    assert said in found.reason


def test_where_nothing_was_shown_or_hardly_anything() -> None:
    without = make_goto_session(tuple(row for row in GOTO if row[0] != "left"))
    found = doubts(without).estimate("left", (1.0, 1.0))
    assert (found.amount, found.because) == (1.0, DoubtReason.UNTAUGHT)
    tiny = doubts(make_goto_session(GOTO[:2])).estimate("forward", (6.0, radians(10)))
    assert (tiny.amount, tiny.because) == (0.6, DoubtReason.SCANT)


def test_absence_that_was_never_shown_is_far_from_all() -> None:
    found = doubts(make_goto_session()).estimate("forward", (nan, nan))
    assert found.amount >= 0.9
    assert "there are no examples like this" in found.reason


def test_a_leaf_whose_examples_want_different_things() -> None:
    again: Row = ("forward", "left", "directive", 0.3, 350)
    found = doubts(make_goto_session((*GOTO, again))).estimate("forward", (0.3, radians(350)))
    assert (found.amount, found.because, found.examples) == (1.0, DoubtReason.DISAGREEING, (2, 7))


def test_what_was_shown_nearest_may_say_otherwise() -> None:
    """In the gap between done at 0.3 m and forward at 5 m, which belongs to the default, doubt grows toward done."""
    knows = doubts(make_goto_session())
    near, far = (knows.estimate("forward", (distance, radians(352))) for distance in (0.5, 4.0))
    assert (near.because, near.examples) == (DoubtReason.OTHERWISE, (2,))
    assert near.reason == "example 2, which is nearest, says go to done"
    assert near.amount > 0.5 > far.amount


@given(draw_tables())
def test_doubt_is_a_share_and_what_was_shown_without_contradiction_is_in_none(
    table: tuple[list[tuple[tuple[float, ...], int, int]], list[Kind]],
) -> None:
    drawn, kinds = table
    rows = [("a", row[0], ("a", "b", "c")[row[1]], "directive") for row in drawn]
    lesson = lesson_of(rows, kinds)
    knows = doubts(lesson)
    groups = group_by_feature_vector(lesson.examples).values()
    agreed = all(len({example.next for example in group}) == 1 for group in groups)
    for example in lesson.examples:
        found = knows.estimate("a", example.values)
        assert 0.0 <= found.amount <= 1.0
        if len(lesson.examples) >= 3 and agreed:
            assert found.amount == 0.0, (found, example)
