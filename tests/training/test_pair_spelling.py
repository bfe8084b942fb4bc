"""Pairs of readings as people write them: "gap / speed", "heading - course"."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from understudy.errors import UnderstudyError
from understudy.model.behaviors import Behavior
from understudy.model.binding import Target
from understudy.model.features import BoundFeature, Feature, TimeInState, pair_features
from understudy.model.library import Kit, Library
from understudy.model.reading_pairs import PairOperation
from understudy.model.value_kinds import Continuous, Toroidal
from understudy.training.lesson_design import new_lesson, parse_feature

NUMBERS = [
    Feature(name, Continuous(), name, unit=unit)
    for name, unit in (("gap", "m"), ("speed", "m/s"), ("x-y", "m"), ("front left", "m"), ("m/s", "m/s"))
]
LIBRARY = Library(
    Kit.from_parts(
        *NUMBERS,
        Feature("distance_to", Continuous(), "range", of="target", unit="m"),
        Feature("heading", Toroidal(), "heading", unit="rad"),
        TimeInState(),
        Behavior("go"),
        Target("ball"),
        Target("post"),
    )
)

WRITTEN = [  # as written, as shown
    ("gap / speed", "gap / speed"),
    ("gap/speed", "gap / speed"),
    ("  gap   /   speed ", "gap / speed"),
    ("(gap / speed)", "gap / speed"),
    ("distance_to(ball) / speed", "distance_to(ball) / speed"),
    ("distance_to( ball )/speed", "distance_to(ball) / speed"),
    ("distance_to(ball) - distance_to(A)", "distance_to(ball) - distance_to(A)"),
    ("(gap - distance_to(ball)) / speed", "(gap - distance_to(ball)) / speed"),
    ("gap / (gap / speed)", "gap / (gap / speed)"),
    ("gap / speed / speed", "(gap / speed) / speed"),
    ("gap - gap / gap * 1", None),
    ("gap - gap - gap", "(gap - gap) - gap"),
    # names that hold a sign or a space
    ("x-y", "x-y"),
    ("m/s", "m/s"),
    ("gap - x-y", "gap - x-y"),
    ("gap-x-y", "gap - x-y"),
    ("x-y - gap", "x-y - gap"),
    ("gap / m/s", "gap / m/s"),
    ("front left - gap", "front left - gap"),
    ("front left-gap", "front left - gap"),
    ("heading - heading", "heading - heading"),
]


@pytest.mark.parametrize(("written", "shown"), WRITTEN)
def test_as_people_write_them(written: str, shown: str | None) -> None:
    if shown is None:
        with pytest.raises(UnderstudyError):
            parse_feature(LIBRARY, written)
    else:
        assert str(parse_feature(LIBRARY, written)) == shown


def test_what_is_shown_can_be_written() -> None:
    for _, shown in WRITTEN:
        if shown is not None:
            assert str(parse_feature(LIBRARY, shown)) == shown


REFUSED = [
    ("gap / spee", "no feature 'spee'; did you mean 'speed'"),
    ("ga - gap", "no feature 'ga'; did you mean 'gap'"),
    ("gap /", "no feature 'gap /'"),
    ("/ gap", "no feature '/ gap'"),
    ("gap / (speed", "'(speed' is not a name"),
    ("gap / distance_to", "distance_to.*0 of its 1 parameters"),
    ("gap / time_in_state", "time_in_state is no reading"),
    ("gap - speed", "gap is in m, and speed in m/s"),
    ("gap / heading", "heading is toroidal"),
    ("gap / gap / gap / gap / gap", "more than 3 pairs are within each other"),
    ("", "'' is not a name"),
    ("()", "'' is not a name"),
]


@pytest.mark.parametrize(("written", "problem"), REFUSED)
def test_refused(written: str, problem: str) -> None:
    with pytest.raises(UnderstudyError, match=problem.replace("(", r"\(").replace(".*", "(.|\n)*")):
        parse_feature(LIBRARY, written)


def test_a_lesson_takes_them() -> None:
    lesson = new_lesson(
        LIBRARY, "a", states=["go"], features=["gap / speed", "distance_to(A) / speed"], parameters=["A"]
    )
    assert [str(each) for each in lesson.automaton.features] == ["gap / speed", "distance_to(A) / speed"]
    with pytest.raises(UnderstudyError, match="bal"):
        new_lesson(LIBRARY, "a", states=["go"], features=["distance_to(bal) / speed"])


SIDES = st.recursive(
    st.sampled_from([BoundFeature(each) for each in NUMBERS]),
    lambda sides: st.builds(pair_features, st.just(PairOperation.QUOTIENT), sides, sides),
    max_leaves=4,
)


@given(SIDES)
def test_any_quotient_is_read_as_it_is_written(feature: BoundFeature) -> None:
    assert parse_feature(LIBRARY, str(feature)) == feature
