"""One teaching of the forage experiment, whole, beside what was published; and what its goals would say."""

from __future__ import annotations

from typing import Any

import pytest

from understudy.sim.forage import make_corner_cases
from understudy.storage.document import encode_document
from understudy_lab.forage import study
from understudy_lab.forage.teach import teach, teach_and_judge, worlds_of
from understudy_lab.results import load_published
from understudy_lab.study import Row
from understudy_lab.teachers.teacher import FIRST_SEED

PUBLISHED = load_published("forage")
assert PUBLISHED is not None
FINDINGS, ROWS = PUBLISHED.findings, PUBLISHED.rows
EXPECTED = FINDINGS.numbers


@pytest.fixture(scope="module", params=["live", "watched"])
def method(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


@pytest.fixture(scope="module")
def row(method: str) -> Row:
    return teach_and_judge(study.TEACHINGS[0], method=method)


@pytest.mark.retrains
def test_the_first_teaching_is_as_published(row: Row, method: str) -> None:
    before = next(each for each in ROWS if each["task"] == {"method": method, "seed": row["seed"]})
    for exact in ("seed", "examples", "presses", "lessons", "worlds", "success", "corner_cases"):
        assert row[exact] == before[exact]
    for close in ("teaching_seconds", "relative_to_expert"):
        assert row[close] == pytest.approx(before[close], abs=1e-4)


@pytest.mark.retrains
def test_it_was_taught_well(row: Row) -> None:
    assert row["success"] >= 0.95
    assert row["relative_to_expert"] >= 0.88
    assert row["examples"]["total"] <= 90
    assert row["teaching_seconds"] <= 600


@pytest.mark.retrains
@pytest.mark.parametrize("case", make_corner_cases())
def test_corner_case(row: Row, case: str) -> None:
    assert row["corner_cases"][case] >= 0.95  # all of its twenty worlds but one, at least


@pytest.mark.retrains
def test_the_same_seed_gives_the_same_library(method: str) -> None:
    first, again = (teach(study.TEACHINGS[0], method=method).library for _ in range(2))
    for name, taught in first.taught.items():
        assert encode_document(again.taught[name]) == encode_document(taught)


@pytest.mark.retrains
def test_it_presses_like_a_person(row: Row) -> None:
    """Far fewer presses than ticks: a policy copied by pressing every tick would be ten a second."""
    assert row["presses"] < 0.2 * row["teaching_seconds"]


def test_no_robot_is_judged_where_it_was_taught() -> None:
    assert worlds_of(2**30).stop < FIRST_SEED
    assert not set(worlds_of(3)) & set(worlds_of(4))


def test_the_published_result_holds_what_was_asked() -> None:
    short = {
        "food per second / hand-written, median",
        "presses of a median teaching",
    }
    assert {goal.what for goal in FINDINGS.goals if not goal.held} == {
        f"taught live: {what}" for what in short
    }
    assert EXPECTED["methods"]["watched"]["of"] == len(study.TEACHINGS) == 20


MISSES = [
    ("teachings_reaching_95", 18, "18 of 20"),
    ("success", {"min": 0.8}, "80%"),
    ("relative_to_expert", {"median": 0.9}, "0.900"),
    ("examples", {"median": 81.0}, "81"),
    ("teaching_seconds", {"median": 601.0}, "601"),
]


@pytest.mark.parametrize(("what", "value", "said"), MISSES)
def test_a_miss_is_said(what: str, value: Any, said: str) -> None:
    short = {**EXPECTED["methods"]["watched"], what: value}
    assert [goal.measured for goal in (judge(short) for judge in study.GOALS) if not goal.held] == [said]
