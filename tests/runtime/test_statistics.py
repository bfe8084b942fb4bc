"""Statistics over members: by hand for five members in two squads, and against plain Python for any."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, hypot, inf, isnan, log, nan, pi, sin, sqrt, tau
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from understudy.model.squad import TELLING, Measuring, Role, Squad, Statistic
from understudy.model.value_kinds import BOOLEAN, Continuous, Kind, Toroidal
from understudy.runtime.body import Reading
from understudy.runtime.team.members import Member, Membership
from understudy.runtime.team.squad_body import list_squad_readings
from understudy.runtime.team.statistics import StatisticMemory, compute_statistic

FIVE = Membership.from_squads(
    [[Member(0, 0, 0), Member(0, 1, 1), Member(0, 2, 0)], [Member(0, 3, 0), Member(0, 4, 1)]]
)
"""Rows 0, 1, 2 are the first squad, rows 3, 4 the second."""
ALL = (True,) * 5
LINE, ANGLE, DEGREE = Continuous(), Toroidal(), tau / 360
MEASURING = get_args(Measuring)
Values = Sequence[float]


def survey(
    statistic: Statistic,
    values: Values,
    kind: Kind | None,
    counted: Sequence[bool] = ALL,
    roster: Membership = FIVE,
) -> list[float]:
    found = compute_statistic(statistic, np.array(values, float), np.array(counted, bool), roster, kind)
    return [float(value) for value in found]


def of(how: Any, **more: Any) -> Statistic:
    return Statistic("s", how, None if "flag" in more else "r", **more)


LOST = (nan, nan, nan, 2.0, nan)
FLAGS = (1.0, 0.0, 1.0, 1.0, 1.0)
DOWN = (0.0,) * 5
METERS = (1.0, 3.0, 2.0, 5.0, nan)
ONLY_FIRST = (True, False, True, False, False)

TOLD: list[tuple[Statistic, Kind | None, Values, Sequence[bool], list[float]]] = [
    # flags of each, kind None
    (of("any", flag="f"), None, FLAGS, ALL, [1, 1]),
    (of("all", flag="f"), None, FLAGS, ALL, [0, 1]),
    (of("none", flag="f"), None, FLAGS, ALL, [0, 0]),
    (of("none", flag="f"), None, DOWN, ALL, [1, 1]),
    (of("count", flag="f"), None, FLAGS, ALL, [2, 2]),
    (of("fraction", flag="f"), None, FLAGS, ALL, [2 / 3, 1]),
    # a yes or no; who does not answer says neither
    (of("any"), BOOLEAN, (0, 1, nan, nan, nan), ALL, [1, 0]),
    (of("all"), BOOLEAN, (1, 1, nan, 1, 1), ALL, [0, 1]),
    (of("none"), BOOLEAN, (0, nan, 0, nan, nan), ALL, [1, 1]),
    (of("count"), BOOLEAN, (0, 1, 1, nan, 1), ALL, [2, 1]),
    (of("count", below=0.5), BOOLEAN, (0, 1, 1, nan, 1), ALL, [1, 0]),  # how many say no
    # a number: whether it is there
    (of("any"), LINE, LOST, ALL, [0, 1]),
    (of("all"), LINE, METERS, ALL, [1, 0]),
    (of("count"), LINE, METERS, ALL, [3, 1]),
    (of("none"), LINE, LOST, ALL, [1, 0]),
    # whether it is at least so much, and below so much
    (of("count", least=2.0), LINE, METERS, ALL, [2, 1]),
    (of("count", below=2.0), LINE, METERS, ALL, [1, 0]),
    (of("count", least=2.0, below=3.0), LINE, METERS, ALL, [1, 0]),
    (of("all", below=6.0), LINE, METERS, ALL, [1, 0]),
    # of members in a role, or that are left; of nobody
    (of("all", flag="f"), None, FLAGS, ONLY_FIRST, [1, 0]),
    (of("any", flag="f"), None, FLAGS, ONLY_FIRST, [1, 0]),
    (of("none", flag="f"), None, FLAGS, ONLY_FIRST, [0, 1]),
    (of("count", flag="f"), None, FLAGS, ONLY_FIRST, [2, 0]),
    (of("fraction", flag="f"), None, FLAGS, ONLY_FIRST, [1, nan]),
    (Statistic("left", "count"), None, (1.0,) * 5, ONLY_FIRST, [2, 0]),
]
MEASURED: list[tuple[Any, Kind, Values, Sequence[bool], list[float]]] = [
    ("mean", LINE, METERS, ALL, [2, 5]),
    ("minimum", LINE, METERS, ALL, [1, 5]),
    ("maximum", LINE, METERS, ALL, [3, 5]),
    ("spread", LINE, METERS, ALL, [sqrt(2 / 3), 0]),
    ("mean", LINE, LOST, ALL, [nan, 2]),
    ("minimum", LINE, LOST, ALL, [nan, 2]),
    ("maximum", LINE, LOST, ALL, [nan, 2]),
    ("spread", LINE, LOST, ALL, [nan, 0]),
    ("mean", LINE, METERS, ONLY_FIRST, [1.5, nan]),
    ("maximum", LINE, METERS, ONLY_FIRST, [2, nan]),
    ("mean", BOOLEAN, (0, 1, 1, nan, 1), ALL, [2 / 3, 1]),
    # on a circle: 5° is between 350° and 20°, and absent ones do not count
    ("mean", ANGLE, (350 * DEGREE, nan, 20 * DEGREE, 3.0, 3.0), ALL, [5 * DEGREE, 3]),
    ("mean", Toroidal(24.0), (23.0, 3.0, 1.0, 12.0, nan), ALL, [1, 12]),
    ("spread", ANGLE, (1.0, 1.0, 1.0, nan, nan), ALL, [0, nan]),
    ("spread", ANGLE, (-0.1, 0.0, 0.1, 6.0, 6.0), ALL, [0.0817, 0]),  # nearly that on a line, 0.0816
]  # fmt: skip


@pytest.mark.parametrize(("statistic", "kind", "values", "counted", "expected"), TOLD, ids=str)
def test_what_is_told_of_how_many(
    statistic: Statistic, kind: Kind | None, values: Values, counted: Sequence[bool], expected: list[float]
) -> None:
    assert survey(statistic, values, kind, counted) == pytest.approx(expected, nan_ok=True)


@pytest.mark.parametrize(("how", "kind", "values", "counted", "expected"), MEASURED, ids=str)
def test_what_is_measured(
    how: Any, kind: Kind, values: Values, counted: Sequence[bool], expected: list[float]
) -> None:
    assert survey(of(how), values, kind, counted) == pytest.approx(expected, nan_ok=True, abs=1e-4)


TIMES: list[
    tuple[Statistic, Values, list[float]]
] = [  # what it is now, each tenth of a second -> what it reads
    (of("any", within_s=0.2), (0, 1, 0, 0, 0, 1), [0, 1, 1, 1, 0, 1]),
    (of("none", within_s=0.1), (1, 0, 0, 0), [1, 1, 0, 0]),
    (of("any", since=True), (0, 1, 1, 0, 0, 1, 0), [nan, 0, 0, 0.1, 0.2, 0, 0.1]),
    (of("all", for_s=0.2), (1, 1, 1, 1, 0, 1, 1, 1), [0, 0, 1, 1, 0, 0, 0, 1]),
    (of("mean", within_s=0.2), (3, 6, nan, 9, 12, nan, nan, nan), [3, 4.5, 4.5, 7.5, 10.5, 10.5, 12, nan]),
    (of("minimum", within_s=0.2), (3, 6, 9, 12, nan, nan, nan), [3, 3, 3, 6, 9, 12, nan]),
    (of("maximum", within_s=0.2), (9, 6, 3, nan, 4), [9, 9, 9, 6, 4]),
    (of("count", within_s=0.1), (4, 2, 2, 0), [4, 3, 2, 1]),
]


@pytest.mark.parametrize(("statistic", "values", "expected"), TIMES, ids=str)
@pytest.mark.parametrize("begin", [0, 7, 12345])
def test_what_is_remembered(statistic: Statistic, values: Values, expected: list[float], begin: int) -> None:
    memory = StatisticMemory(statistic, BOOLEAN, 1, 0.1)
    for tick, (value, reads) in enumerate(zip(values, expected, strict=True), start=begin):
        for _ in range(2):  # asked again in a tick, it answers the same
            seen = memory.update(np.array([float(value)]), tick * 0.1).tolist()
            assert seen == pytest.approx([reads], nan_ok=True)
    memory.clear()
    assert memory.update(np.array([nan]), (begin + len(values)) * 0.1).tolist() == pytest.approx(
        [nan if isnan(expected[0]) or statistic.how not in ("any", "all", "none") else 0], nan_ok=True
    )


def test_squads_remember_by_themselves() -> None:
    memory = StatisticMemory(of("any", since=True), Continuous(), 2, 0.5)
    assert memory.update(np.array([1.0, 0.0]), 0.0).tolist() == pytest.approx([0, nan], nan_ok=True)
    assert memory.update(np.array([0.0, 1.0]), 0.5).tolist() == [0.5, 0]
    assert memory.update(np.array([0.0, 0.0]), 1.0).tolist() == [1.0, 0.5]


READS = st.floats(-50, 50) | st.sampled_from((0.0, 1.0, nan, nan))
MEMBERS = st.lists(st.lists(st.tuples(READS, st.booleans()), max_size=5), min_size=1, max_size=4)
"""Of each squad, what each member reads, and whether it counts."""


def roster(squads: Sequence[Sequence[Any]]) -> Membership:
    rows = iter(range(99))
    return Membership.from_squads([[Member(0, next(rows), 0) for _ in squad] for squad in squads])


def plainly_told(how: str, yes: list[bool]) -> float:
    if how == "fraction":
        return sum(yes) / len(yes) if yes else nan
    return float(
        {"any": any(yes), "all": all(yes) and bool(yes), "none": not any(yes), "count": sum(yes)}[how]
    )


def plainly_measured(how: str, values: list[float], period: float | None) -> float:
    there = [value for value in values if not isnan(value)]
    if not there:
        return nan
    if how in ("minimum", "maximum"):
        return min(there) if how == "minimum" else max(there)
    if period is not None:
        turn = tau / period
        east, north = (sum(f(value * turn) for value in there) / len(there) for f in (cos, sin))
        if how == "mean":
            return atan2(north, east) / turn % period
        return sqrt(-2 * log(min(1.0, hypot(east, north)))) / turn
    mean = sum(there) / len(there)
    return mean if how == "mean" else sqrt(sum((value - mean) ** 2 for value in there) / len(there))


@given(
    MEMBERS,
    st.sampled_from(TELLING),
    st.none() | st.floats(-9, 9),
    st.none() | st.floats(-9, 9),
    st.booleans(),
)
def test_told_as_plainly(
    squads: list[list[tuple[float, bool]]], how: Any, least: float | None, below: float | None, boolean: bool
) -> None:
    def yes(value: float) -> bool:
        if boolean and least is None and below is None:
            return value == 1.0
        return (-inf if least is None else least) <= value < (inf if below is None else below)

    members = [member for squad in squads for member in squad]
    found = survey(
        of(how, least=least, below=below),
        [value for value, _ in members],
        BOOLEAN if boolean else LINE,
        [counts for _, counts in members],
        roster(squads),
    )
    plain = [plainly_told(how, [yes(value) for value, counts in squad if counts]) for squad in squads]
    assert found == pytest.approx(plain, nan_ok=True)


@given(MEMBERS, st.sampled_from(MEASURING), st.sampled_from((None, 1.0, tau, 24.0)))
def test_measured_as_plainly(squads: list[list[tuple[float, bool]]], how: Any, period: float | None) -> None:
    kind = LINE if period is None else Toroidal(period)
    members = [member for squad in squads for member in squad]
    found = survey(
        of(how), [value for value, _ in members], kind, [counts for _, counts in members], roster(squads)
    )
    for mine, squad in zip(found, squads, strict=True):
        counted = [value for value, counts in squad if counts]
        plain = plainly_measured(how, counted, period)
        if period is None or how not in ("mean", "spread"):
            assert mine == pytest.approx(plain, nan_ok=True, abs=1e-12)
        elif isnan(plain):
            assert isnan(mine)
        elif clear(counted, period):
            apart = abs(mine - plain)
            assert (min(apart, period - apart) if how == "mean" else apart) < 1e-6 * period


def clear(values: list[float], period: float) -> bool:
    """Whether angles have a direction in common at all; otherwise rounding decides."""
    turn = tau / period
    there = [value * turn for value in values if not isnan(value)]
    length = hypot(sum(map(cos, there)), sum(map(sin, there))) / len(there)
    return 1e-3 < length < 1 - 1e-9


@given(MEMBERS, st.sampled_from((*TELLING, *MEASURING)), st.integers(2, 4), st.sampled_from((LINE, ANGLE)))
def test_alone_and_among_others_it_is_the_same(
    squads: list[list[tuple[float, bool]]], how: Any, worlds: int, kind: Kind
) -> None:
    """Bit for bit."""
    values = [value for squad in squads for value, _ in squad]
    counted = [counts for squad in squads for _, counts in squad]
    rows = iter(range(99))
    lists = [[Member(0, next(rows), 0) for _ in squad] for squad in squads]
    many = Membership.from_squads(lists, worlds, [len(values)])
    assert many.row.tolist() == list(range(worlds * len(values)))
    together = survey(of(how), values * worlds, kind, counted * worlds, many)
    np.testing.assert_array_equal(
        together, survey(of(how), values, kind, counted, Membership.from_squads(lists)) * worlds
    )


TICKS = st.lists(st.sampled_from((0.0, 1.0)), min_size=1, max_size=20)


@given(
    TICKS, st.integers(1, 6), st.sampled_from(("within_s", "since", "for_s")), st.sampled_from((0.1, 0.25))
)
def test_remembered_as_plainly(values: list[float], span: int, what: str, tick_s: float) -> None:
    given: dict[str, Any] = {"since": True} if what == "since" else {what: round(span * tick_s, 9)}
    memory = StatisticMemory(of("any", **given), BOOLEAN, 1, tick_s)
    for now, value in enumerate(values):
        (mine,) = memory.update(np.array([value]), now * tick_s).tolist()
        ago = next((back for back in range(now + 1) if values[now - back]), None)
        run = next((back for back in range(now + 1) if not values[now - back]), now + 1)
        plain = {
            "within_s": float(ago is not None and ago <= span),
            "since": nan if ago is None else ago * tick_s,
            "for_s": float(run > span),
        }
        assert mine == pytest.approx(plain[what], nan_ok=True)


@given(st.lists(READS, min_size=1, max_size=20), st.integers(1, 5), st.sampled_from(MEASURING))
def test_numbers_are_remembered_as_plainly(values: list[float], span: int, how: Any) -> None:
    memory = StatisticMemory(of(how, within_s=round(span * 0.1, 9)), Continuous(), 1, 0.1)
    for now, value in enumerate(values):
        (mine,) = memory.update(np.array([value]), now * 0.1).tolist()
        lately = values[max(0, now - span) : now + 1]
        over = how if how in ("minimum", "maximum") else "mean"
        assert mine == pytest.approx(plainly_measured(over, lately, None), nan_ok=True, abs=1e-12)


def test_the_mean_direction_is_on_the_circle() -> None:
    """Also where rounding would take it a whole turn on."""
    (mean, _) = survey(of("mean"), (-1e-18, nan, nan, pi, nan), ANGLE)
    assert 0 <= mean < tau


UNITS: list[tuple[Statistic, str]] = [
    (of("count"), ""),
    (of("fraction"), ""),
    (of("count", below=2.0), ""),
    (of("count", within_s=2.0), ""),
    (of("any"), ""),
    (of("any", since=True), "s"),
    (of("mean"), "m"),
    (of("maximum"), "m"),
    (of("spread"), "m"),
    (of("mean", within_s=2.0), "m"),
    (of("count", flag="f"), ""),
]


@pytest.mark.parametrize(("statistic", "unit"), UNITS, ids=str)
def test_what_is_measured_has_the_unit_of_its_reading_and_how_many_has_none(
    statistic: Statistic, unit: str
) -> None:
    squad = Squad("pair", (Role("left", "robot", 2),), statistics=(statistic,))
    (reading,) = list_squad_readings(squad, [Reading("r", LINE, "m")])
    assert reading.unit == unit
