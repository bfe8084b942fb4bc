"""Quotients and differences of two readings, which are features that are data."""

from __future__ import annotations

import pickle  # noqa: TID251 - between processes, never from files
from copy import deepcopy
from math import inf, nan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from understudy.errors import DefinitionError
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Feature, ReadingKey, TimeInState, feature, pair_features
from understudy.model.reading_pairs import PairOperation, ReadingPair, divide_units, pair_units
from understudy.model.value_kinds import BOOLEAN, Column, Continuous, Toroidal
from understudy.runtime.feature_columns import read_feature_column

QUOTIENT, DIFFERENCE = PairOperation
GAP = BoundFeature(Feature("gap", Continuous(), "gap", unit="m"))
SPEED = BoundFeature(Feature("speed", Continuous(), "speed", unit="m/s"))
HEADING, COURSE = (
    BoundFeature(Feature(name, Toroidal(), name, unit="rad")) for name in ("heading", "course")
)
RANGE = Feature("distance_to", Continuous(), "range", of="target", unit="m")
BALL, POST = (BoundFeature(RANGE, Binding(target=name)) for name in ("ball", "post"))


@feature(Continuous())
def wander(robot: object) -> Column:
    """A Python function."""
    return np.zeros(1)


def compute(bound: BoundFeature, **readings: float) -> float:
    """Compute a pair of readings of the robot itself."""
    percept: dict[ReadingKey, Column] = {(name, None): np.array([value]) for name, value in readings.items()}
    return float(read_feature_column(bound, percept, agents=1)[0])


VALUES = [  # gap, speed, quotient, difference
    (6.0, 2.0, 3.0, 4.0),
    (-1.0, 4.0, -0.25, -5.0),
    (0.0, 4.0, 0.0, -4.0),
    (1.0, 0.0, nan, 1.0),  # nothing is divided by 0
    (0.0, 0.0, nan, 0.0),
    (nan, 1.0, nan, nan),  # absent where a side is
    (1.0, nan, nan, nan),
    (1e300, 1e-300, nan, 1e300),  # too large for a number
]


@pytest.mark.parametrize(("gap", "speed", "quotient", "difference"), VALUES)
def test_values(gap: float, speed: float, quotient: float, difference: float) -> None:
    other = BoundFeature(Feature("speed", Continuous(), "speed", unit="m"))
    np.testing.assert_equal(compute(pair_features(QUOTIENT, GAP, SPEED), gap=gap, speed=speed), quotient)
    np.testing.assert_equal(compute(pair_features(DIFFERENCE, GAP, other), gap=gap, speed=speed), difference)


@pytest.mark.parametrize(
    ("heading", "course", "difference"), [(0.5, 0.25, 0.25), (0.25, 0.5, 2 * np.pi - 0.25)]
)
def test_differences_of_angles_are_angles(heading: float, course: float, difference: float) -> None:
    turned = pair_features(DIFFERENCE, HEADING, COURSE)
    assert turned.kind == Toroidal()
    assert compute(turned, heading=heading, course=course) == pytest.approx(difference)


def test_a_pair_of_a_pair() -> None:
    closing = pair_features(QUOTIENT, pair_features(DIFFERENCE, GAP, GAP), SPEED)
    assert (str(closing), closing.feature.unit) == ("(gap - gap) / speed", "s")
    assert compute(closing, gap=3.0, speed=2.0) == 0.0


NAMES = [  # operation, sides, shown, name, binding, unit
    (QUOTIENT, GAP, SPEED, "gap / speed", "gap / speed", {}, "s"),
    (QUOTIENT, BALL, SPEED, "distance_to(ball) / speed", "distance_to(A) / speed", {"A": "ball"}, "s"),
    (DIFFERENCE, BALL, POST, "distance_to(ball) - distance_to(post)", "distance_to(A) - distance_to(B)",
     {"A": "ball", "B": "post"}, "m"),
    (QUOTIENT, BALL, BALL, "distance_to(ball) / distance_to(ball)", "distance_to(A) / distance_to(A)",
     {"A": "ball"}, ""),
    (QUOTIENT, SPEED, pair_features(DIFFERENCE, GAP, POST), "speed / (gap - distance_to(post))",
     "speed / (gap - distance_to(A))", {"A": "post"}, "1/s"),
]  # fmt: skip


@pytest.mark.parametrize(("operation", "left", "right", "shown", "name", "binding", "unit"), NAMES)
def test_names(
    operation: PairOperation,
    left: BoundFeature,
    right: BoundFeature,
    shown: str,
    name: str,
    binding: dict[str, str],
    unit: str,
) -> None:
    made = pair_features(operation, left, right)
    assert (str(made), made.feature.name, dict(made.binding), made.feature.unit) == (
        shown,
        name,
        binding,
        unit,
    )
    assert made.feature.parameters == tuple(binding)


def test_a_parameter_of_the_automaton_takes_the_place_of_a_target() -> None:
    made = pair_features(QUOTIENT, BALL, SPEED)
    assert (
        str(BoundFeature(made.feature, made.binding.substitute({"ball": "goal"})))
        == "distance_to(goal) / speed"
    )


REFUSED = [
    (QUOTIENT, HEADING, COURSE, "heading / course.*heading is toroidal"),
    (QUOTIENT, GAP, HEADING, "heading is toroidal"),
    (DIFFERENCE, GAP, HEADING, "gap is continuous"),
    (DIFFERENCE, HEADING, BoundFeature(Feature("dial", Toroidal(1.0), "dial")), "dial is toroidal"),
    (DIFFERENCE, GAP, SPEED, "gap is in m, and speed in m/s"),
    (DIFFERENCE, GAP, BoundFeature(Feature("x", Continuous(), "x")), "gap is in m, and x in no unit"),
    (QUOTIENT, GAP, BoundFeature(Feature("ready", BOOLEAN, "ready")), "ready is categorical"),
    (
        QUOTIENT,
        BoundFeature(Feature("load", Continuous(), "load", fresh=0.0)),
        SPEED,
        "load is reset by switches",
    ),
    (QUOTIENT, GAP, BoundFeature(TimeInState()), "time_in_state is no reading"),
    (QUOTIENT, GAP, BoundFeature(wander), "wander is no reading"),
]


@pytest.mark.parametrize(("operation", "left", "right", "problem"), REFUSED)
def test_refused(operation: PairOperation, left: BoundFeature, right: BoundFeature, problem: str) -> None:
    with pytest.raises(DefinitionError, match=problem):
        pair_features(operation, left, right)


UNITS = [  # dividend, divisor, quotient
    ("m", "m/s", "s"),
    ("m", "m", ""),
    ("", "", ""),
    ("", "m", "1/m"),
    ("m/s", "m", "1/s"),
    ("m/s^2", "m/s", "1/s"),
    ("m/s²", "m/s", "1/s"),
    ("rad/s", "m^2", "rad/(s*m^2)"),
    ("1/s", "1/s", ""),
    ("%", "%", ""),
    ("px", "s", "px/s"),
    ("m/s/s", "m", "(m/s/s)/m"),  # not understood, and so kept whole
]


@pytest.mark.parametrize(("left", "right", "quotient"), UNITS)
def test_units(left: str, right: str, quotient: str) -> None:
    assert divide_units(left, right) == quotient
    assert pair_units(DIFFERENCE, left, right) == (left if left == right else None)


@given(
    powers=st.lists(st.tuples(st.sampled_from(["m", "s", "rad"]), st.integers(1, 3)), max_size=3),
    below=st.lists(st.tuples(st.sampled_from(["m", "s", "rad"]), st.integers(1, 3)), max_size=3),
)
def test_a_unit_divided_by_itself_is_none(
    powers: list[tuple[str, int]], below: list[tuple[str, int]]
) -> None:
    above, divisor = ("*".join(f"{name}^{power}" for name, power in side) for side in (powers, below))
    unit = divide_units(above, divisor)
    assert divide_units(unit, unit) == ""
    assert divide_units(unit, "") == unit


@given(
    left=st.floats(allow_infinity=False),
    right=st.floats(allow_infinity=False),
    operation=st.sampled_from(PairOperation),
)
def test_values_are_finite_or_absent(left: float, right: float, operation: PairOperation) -> None:
    other = BoundFeature(Feature("speed", Continuous(), "speed", unit="m"))
    if operation is QUOTIENT or abs(left - right) < inf:
        assert abs(compute(pair_features(operation, GAP, other), gap=left, speed=right)) != inf


def test_pairs_are_values() -> None:
    made = pair_features(QUOTIENT, BALL, SPEED)
    for copy in (pickle.loads(pickle.dumps(made)), deepcopy(made)):
        assert copy == made
        assert isinstance(copy.feature, Feature)
        assert copy.feature.pair == made.feature.pair  # type: ignore[union-attr]
    assert isinstance(made.feature, Feature)
    assert isinstance(made.feature.pair, ReadingPair)
    assert [each.reading for each in made.feature.pair.readings] == ["range", "speed"]
    assert made.feature.doc == "distance_to(A) divided by speed."
