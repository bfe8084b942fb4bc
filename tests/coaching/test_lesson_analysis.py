"""What is known of each state of a lesson: tables that a reader can check by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.make.lessons import make_lesson as lesson_of

from understudy.coaching.lesson_analysis import (
    MOST_TRIALS,
    LessonAnalysis,
    StateAnalysis,
    predict_left_out,
)
from understudy.learning.fit import learn

STOPS: list[tuple[Any, ...]] = [("go", [value], "stop", "directive") for value in (0, 1, 2)]
TURN = ("go", [10], "turn", "directive")


def analyze(rows: list[tuple[Any, ...]]) -> LessonAnalysis:
    lesson = lesson_of(rows)
    return LessonAnalysis(lesson, learn(lesson))


def analyze_go(rows: list[tuple[Any, ...]]) -> StateAnalysis:
    return analyze(rows).states["go"]


CONTRASTS = [  # where; the outcome of which all examples are farther than others; by how much; the nearest other
    (9.0, "stop", 6 / 7, 3),  # 0.7 of the range from the last stop, 0.1 from the turn; twice far is 0.7
    (9.0, "turn", 0.0, 2),
    (6.0, "stop", 0.0, 3),  # in the middle
    (6.5, "stop", 1 / 7, 3),
    (9.0, "start", 0.0, 3),  # no example has this outcome
]


@pytest.mark.parametrize(("value", "outcome", "contrast", "nearest"), CONTRASTS)
def test_how_much_nearer_other_examples_are(
    value: float, outcome: str, contrast: float, nearest: int
) -> None:
    analysis = analyze([*STOPS, TURN])
    state = analysis.states["go"]
    distances = state.plain_distances.compute(state.shown.values, np.array([value]))
    found, row = state.measure_contrast(distances, analysis.lesson.automaton.index(outcome))
    assert float(found) == pytest.approx(contrast)
    assert row == nearest


def test_where_all_examples_have_one_outcome_none_is_nearer() -> None:
    state = analyze_go(STOPS)
    found, _ = state.measure_contrast(np.array([[0.9, 0.1, 0.5]]), int(state.shown.outcomes[0]))
    assert found.tolist() == [0.0]


def test_what_would_be_decided_without_an_example() -> None:
    state = analyze_go([*STOPS, TURN])
    assert [bool(state.predict_without((row,)).all()) for row in range(4)] == [True, True, True, False]
    assert state.predict_without((0, 3)).tolist() == [True, False]
    assert state.fit_without((3,)) is state.fit_without((3,))  # learned once


def test_without_all_its_presses_a_state_is_not_left() -> None:
    state = analyze_go([*STOPS, ("go", [5], "go", "watched")])
    assert state.press_rows == [0, 1, 2]
    assert not state.predict_without((0, 1, 2)).any()


def test_each_press_is_left_out_once_and_in_large_lessons_with_others() -> None:
    few = analyze([*STOPS, TURN, ("go", [4], "go", "watched"), ("stop", [1], "go", "directive")])
    assert [(state.name, rows) for state, rows in few.trials] == [
        *(("go", (row,)) for row in range(4)),
        ("stop", (0,)),
    ]
    assert predict_left_out(few.trials).tolist() == [True, True, True, False]  # one alone says nothing
    many = analyze([("go", [value], "stop", "directive") for value in range(2 * MOST_TRIALS)])
    assert [rows for _, rows in many.trials][:2] == [(0, MOST_TRIALS), (1, MOST_TRIALS + 1)]
    assert sorted(row for _, rows in many.trials for row in rows) == list(range(2 * MOST_TRIALS))


def test_halves_leave_out_each_press_once_in_each_draw() -> None:
    trials = analyze([*STOPS, TURN, ("stop", [1], "go", "directive")]).draw_halves()
    assert {state.name for state, _ in trials} == {"go"}
    for (_, first), (_, second) in zip(trials[::2], trials[1::2], strict=True):
        assert sorted(first + second) == [0, 1, 2, 3]
    assert len({rows for _, rows in trials}) > 2


def test_leaves_whose_examples_disagree() -> None:
    again = [
        ("go", [10], "stop", "directive"),
        ("go", [10], "go", "default"),
        ("go", [10], "turn", "directive"),
    ]
    state = analyze_go([*STOPS, TURN, *again])
    ((share, numbers),) = state.split_leaves.values()
    assert share == pytest.approx(1 / 3)
    assert numbers == (3, 4, 6)  # the default beside them does not count
    assert analyze_go([*STOPS, TURN]).split_leaves == {}
