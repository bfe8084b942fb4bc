"""Conditions in words: what they mean, and what cannot be understood."""

from __future__ import annotations

from math import pi

import pytest

from understudy.errors import SettingError
from understudy.judging.properties.condition import convert_threshold, parse_condition

WORDS = [  # as written, as understood
    ("front is below 0.2 m", "front is below 0.2 m"),
    ("front  is\nat most 20cm", "front is at most 20 cm"),
    ("angle_to(A) is at least −30°", "angle_to(A) is at least -30°"),
    ("food is above 1e2", "food is above 100"),
    ("at_station is yes and food_left is not no", "at_station is yes and food_left is not no"),
    ("x is below 1 m or absent", "x is below 1 m or x is absent"),
    ("x is at least 1 m and below 2 m", "x is at least 1 m and x is below 2 m"),
    ("x is between 1 m and 2 m and y is no", "x is at least 1 m and x is below 2 m and y is no"),
    ("x is not absent", "x is not absent"),
    ("robot is in pit or ball is not in field", "robot is in pit or ball is not in field"),
    ("done is raised", "done is raised"),
    ("goal is reached", "goal is reached"),
    ("distance(robot, food) is below 0.5 m", "distance(robot, food) is below 0.5 m"),
]


@pytest.mark.parametrize(("text", "meant"), WORDS)
def test_words(text: str, meant: str) -> None:
    condition = parse_condition(text)
    assert str(condition) == meant
    assert parse_condition(meant) == condition


def test_and_binds_closer_than_or() -> None:
    condition = parse_condition("a is yes and b is yes or c is yes")
    assert [len(clauses) for clauses in condition.alternatives] == [2, 1]
    assert condition.single is None
    assert parse_condition("a is yes").single is not None


@pytest.mark.parametrize(
    "text",
    ["", "front", "below 0.2 m", "front < 0.2 m", "front is below", "front is below near", "a is yes and"],
)
def test_what_cannot_be_understood(text: str) -> None:
    with pytest.raises(SettingError, match=r"cannot be understood; write it as 'front is below 0\.2 m'"):
        parse_condition(text)


UNITS = [  # number, unit as written, unit of the reading, number in that
    (0.5, "m", "m", 0.5),
    (30.0, "cm", "m", 0.3),
    (180.0, "°", "rad", pi),
    (2.0, "min", "s", 120.0),
    (3.0, "units", "units", 3.0),
    (0.5, "", "", 0.5),
]


@pytest.mark.parametrize(("number", "unit", "to", "found"), UNITS)
def test_units(number: float, unit: str, to: str, found: float) -> None:
    assert convert_threshold(number, unit, of="x", to=to) == pytest.approx(found)


MISFITS = [  # unit as written, unit of the reading, what is said
    ("", "m", "'3' has no unit, but x is in m; write it in m, cm or mm"),
    ("", "units", "'3' has no unit, but x is in units; write 3 units"),
    ("s", "m", "'3 s' does not fit: x is in m; write it in m, cm or mm"),
    ("m", "", "'3 m' has a unit, but x has none; write 3"),
]


@pytest.mark.parametrize(("unit", "to", "said"), MISFITS)
def test_units_that_do_not_fit(unit: str, to: str, said: str) -> None:
    with pytest.raises(SettingError) as refused:
        convert_threshold(3.0, unit, of="x", to=to)
    assert str(refused.value) == f"condition: threshold {said}"
