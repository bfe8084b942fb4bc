"""Conditions that can never hold, and those that always do."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from understudy.errors import SettingError
from understudy.judging.properties.condition import Clause, ClauseTest, Condition, parse_condition
from understudy.judging.properties.contradictions import check_condition
from understudy.model.property import PropertyKind

NEVER, ALWAYS, LONGER = PropertyKind.NEVER, PropertyKind.ALWAYS, PropertyKind.NEVER_LONGER

EMPTY = [
    "x is above 3 m and below 2 m",
    "x is at least 1 m and below 100 cm",
    "angle is between 170° and -170°",  # from 170 up and below -170, which wraps nowhere
    "x is above inf m",
    "x is at least ∞ m",  # what is infinite is absent
    "x is below -inf m",
    "y is below 1 m or x is above 2 m and below 1 m",
    "signal is red and signal is green",
    "done is raised and not raised",
    "robot is in pit and not in pit",
    "x is absent and below 2 m",
    "distance(robot, station) is below 0 m",
    "delivered is at most -1 units",
]
POSSIBLE = [
    "x is above 2 m and below 3 m",
    "x is at least 1 m and at most 100 cm",
    "angle is at least 170° or below -170°",
    "x is between 0.3 m and inf m",
    "x is at least −∞",
    "signal is red or green",
    "signal is not red and not green",
    "x is absent or below 2 m",
    "x is below 1 m and y is above 2 m",
    "robot is in pit and not in field",
    "distance(robot, station) is at most 0 m",
    "x is above 3 units and below 2 m",  # which the units decide
]
EVERYTHING = [
    "x is below 2 m or at least 2 m",
    "x is above -inf m",
    "x is at most inf m",
    "x is below 2 m or y is below 1 m or x is above 150 cm",
    "done is raised or not raised",
    "x is absent or not absent",
    "distance(robot, station) is at least 0 m or below 3 m",
]


@pytest.mark.parametrize("kind", [NEVER, ALWAYS, LONGER])
@pytest.mark.parametrize("words", EMPTY)
def test_what_can_never_hold_is_refused(words: str, kind: PropertyKind) -> None:
    with pytest.raises(SettingError, match="can never hold"):
        check_condition(kind, parse_condition(words))


@pytest.mark.parametrize("words", POSSIBLE)
def test_what_can_hold_is_not(words: str) -> None:
    check_condition(ALWAYS, parse_condition(words))


@pytest.mark.parametrize("words", EVERYTHING)
def test_what_always_holds_cannot_be_forbidden(words: str) -> None:
    check_condition(ALWAYS, parse_condition(words))
    for kind in (NEVER, LONGER):
        with pytest.raises(SettingError, match="always holds, so that the property cannot hold"):
            check_condition(kind, parse_condition(words))


COMPARISONS = [each for each in ClauseTest if each.is_of_number]
CLAUSES = st.builds(
    Clause,
    st.just("x"),
    st.sampled_from(COMPARISONS),
    number=st.integers(-2, 2).map(float),
    unit=st.just("m"),
)
VALUES = [each / 2 for each in range(-6, 7)]
"""Some below, above, between and at all limits."""


def holds(clause: Clause, value: float) -> bool:
    return {
        ClauseTest.BELOW: value < clause.number,
        ClauseTest.AT_MOST: value <= clause.number,
        ClauseTest.AT_LEAST: value >= clause.number,
        ClauseTest.ABOVE: value > clause.number,
    }[clause.comparison]


@given(st.lists(CLAUSES, min_size=1, max_size=4))
def test_refused_is_exactly_what_no_value_or_every_value_satisfies(clauses: list[Clause]) -> None:
    """Compare with trying values, for clauses joined by `and` and by `or`."""

    def refuses(condition: Condition, kind: PropertyKind) -> bool:
        try:
            check_condition(kind, condition)
        except SettingError:
            return True
        return False

    joined = Condition((tuple(clauses),))
    apart = Condition(tuple((each,) for each in clauses))
    assert refuses(joined, ALWAYS) == (not any(all(holds(c, v) for c in clauses) for v in VALUES))
    assert refuses(apart, NEVER) == all(any(holds(c, v) for c in clauses) for v in VALUES)
