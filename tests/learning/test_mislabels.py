"""Presses that look like slips: tables that a reader can check by hand, and what holds of every lesson."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.make.lessons import draw_tables, make_lesson

from understudy.learning.mislabels import find_mislabels, list_press_examples
from understudy.model.lesson import Lesson

FAR = [("go", [value], "turn", "directive") for value in (60, 64, 68, 72)]
NEAR = [("go", [value], "rest", "directive") for value in (2, 4, 6, 8)]
SLIP = ("go", [65], "rest", "directive")
ELSEWHERE = [("turn", [value], "rest", "directive") for value in (1, 3, 5, 7)]


CASES: list[tuple[list[Any], list[int]]] = [  # examples; the numbers of those that look like slips
    ([*FAR, *NEAR, SLIP], [8]),
    ([*FAR, *NEAR, ("go", [5], "turn", "confirmation")], [8]),
    # too few to tell
    ([*FAR[:3], *NEAR[:2], SLIP], []),
    # nobody says otherwise: it begins a region of its own
    ([*FAR, *NEAR, ("go", [500], "rest", "directive")], []),
    ([*FAR, *FAR], []),
    # in its state it is the only one; what was said in another state speaks against it
    ([*FAR, *ELSEWHERE, ("rest", [4], "turn", "directive")], [8]),
    # defaults say nothing, so they are no slips
    ([*FAR, *NEAR, ("go", [65], "go", "default")], []),
]


@pytest.mark.parametrize(("shown", "found"), CASES)
def test_what_looks_like_a_slip(shown: list[Any], found: list[int]) -> None:
    assert [suspect.example.number for suspect in find_mislabels(make_lesson(shown))] == found


def test_reasons_name_those_who_speak_against_it() -> None:
    (suspect,) = find_mislabels(make_lesson([*FAR, *NEAR, SLIP]))
    assert suspect.reason.startswith("Example 8 says rest, but examples ")
    assert suspect.reason.endswith(", which are most like it, say turn.")


def test_what_a_demonstrator_stands_by_is_not_asked_again() -> None:
    shown = [*FAR, *NEAR, SLIP, ("go", [67], "rest", "directive")]
    assert [suspect.example.number for suspect in find_mislabels(make_lesson(shown))] == [9, 8]
    doubts = {suspect.example.number: suspect.doubt for suspect in find_mislabels(make_lesson(shown))}
    assert not find_mislabels(make_lesson(shown), meant=doubts)
    assert find_mislabels(make_lesson(shown), meant={9: doubts[9] - 0.3})[0].example.number == 9


def test_a_slip_in_quarantine_teaches_nothing_and_is_no_slip_any_more() -> None:
    slipped = make_lesson([*FAR, *NEAR, SLIP])
    held = tuple(replace(each, quarantined="slip" if each.number == 8 else "") for each in slipped.examples)
    assert not find_mislabels(replace(slipped, examples=held))


def test_corrections_may_be_slips_too() -> None:
    slipped = make_lesson([*FAR, *NEAR, SLIP])
    made = tuple(replace(each, correction=each.number == 8) for each in slipped.examples)
    assert [suspect.example.number for suspect in find_mislabels(replace(slipped, examples=made))] == [8]


def test_a_press_is_known_with_its_default() -> None:
    made = make_lesson([*NEAR, ("go", [65], "rest", "directive"), ("rest", [65], "rest", "default")])
    pressed = tuple(replace(each, moment=3 if each.number > 3 else None) for each in made.examples)
    assert list_press_examples(replace(made, examples=pressed), 4) == (4, 5)
    assert list_press_examples(made, 0) == (0,)


def test_stateless_lessons_are_looked_at_as_one() -> None:
    shown = [*FAR[:2], *(("turn", [value], "turn", "confirmation") for value in (62, 66)), *NEAR, SLIP]
    assert [suspect.example.number for suspect in find_mislabels(make_lesson(shown, stateless=True))] == [8]


@settings(max_examples=60)
@given(draw_tables(), st.booleans(), st.randoms(use_true_random=False))
def test_suspects_are_presses_each_once_in_any_order(table: Any, stateless: bool, random: Any) -> None:
    rows, kinds = table
    names = ("go", "turn", "rest")
    shown = [
        ("go", list(row.values), names[row.outcome], "directive" if row.group else "default") for row in rows
    ]
    made = make_lesson(shown * 2, kinds, stateless=stateless)
    found = find_mislabels(made, least=0.1)
    numbers = [suspect.example.number for suspect in found]
    assert len(set(numbers)) == len(numbers)
    assert all(suspect.example.is_shown and suspect.doubt >= 0.1 for suspect in found)
    shuffled = list(made.examples)
    random.shuffle(shuffled)
    assert find_mislabels(replace(made, examples=tuple(shuffled)), least=0.1) == found


def test_a_lesson_without_examples_has_no_slips() -> None:
    empty: Lesson = replace(make_lesson([*NEAR]), examples=())
    assert find_mislabels(empty) == ()
