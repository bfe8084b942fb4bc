"""A robot that comes back to its first situation twice in one state repeats itself, as a table."""

from __future__ import annotations

from math import nan, radians, tau

import numpy as np
import pytest
from tests.make.goto_sessions import GOTO, make_goto_session

from understudy.coaching.lesson_analysis import FeatureDistances
from understudy.coaching.repetition import RepetitionWatch, choose_moment, find_repetition
from understudy.coaching.situation_text import make_feature_phrases
from understudy.model.features import BoundFeature, Feature
from understudy.model.value_kinds import Toroidal

HEADING = BoundFeature(Feature("heading", Toroidal(), "heading", unit="rad"))

TURNING = [0.5 * step % tau for step in range(30)]  # 12.6 steps a turn


CASES: list[tuple[list[float], range | None]] = [
    (TURNING, range(12, 25)),  # the second round
    (TURNING[:20], None),  # only one round
    ([2.0] * 30, None),  # it waits
    ([nan] * 30, None),  # it sees nothing
    ([3.0 + 0.2 * (step % 2) for step in range(30)], None),  # it trembles
    ([0.01 * step for step in range(30)], None),  # it gets on
    ([], None),
    ([1.0], None),
]


@pytest.mark.parametrize(("angles", "expected"), CASES)
def test_repetition(angles: list[float], expected: range | None) -> None:
    values = np.array(angles, np.float64).reshape(-1, 1)
    distances = FeatureDistances(make_feature_phrases([HEADING], values), None)
    assert find_repetition(values, distances) == expected


def turn_left(watch: RepetitionWatch, ticks: range, *, answers: bool = True) -> list[tuple[float, int]]:
    """Turn by 32 degrees every half second, from 90 degrees on; return time and bearing of each question."""
    asked = []
    for tick in ticks:
        bearing = 90 - 32 * tick
        watch.observe(0.5 * tick, "left", (5.0, radians(bearing) % tau))
        if watch.find_doubt() is not None:
            asked.append((0.5 * tick, (bearing + 180) % 360 - 180))
            if answers:
                watch.note_asked("left")
    return asked


def test_a_robot_that_turns_for_ever_is_asked_about_over_a_whole_round() -> None:
    """First in the third round, near 20 degrees, where it was told to leave the turn once; then a quarter farther each
    time. A round takes 5.5 s.
    """
    watch = RepetitionWatch(make_goto_session(GOTO))
    assert turn_left(watch, range(200)) == [(12.0, 42), (19.0, -46), (26.0, -134), (33.0, 138)]
    assert watch.was_asked_about("left")
    assert not watch.was_asked_about("forward")


def test_a_question_that_could_not_be_asked_waits_for_the_next_round() -> None:
    watch = RepetitionWatch(make_goto_session(GOTO))
    asked = turn_left(watch, range(60), answers=False)
    assert asked[0] == (12.0, 42)
    assert {round(time_s - 12.0, 1) % 5.5 for time_s, _ in asked} <= {0.0, 0.5}


STAYS: list[tuple[str, list[tuple[float, str]]]] = [
    ("another state between", [(6.0, "forward")]),
    ("another world", [(-1.0, "left")]),
    ("not observed for a while", [(16.0, "left")]),
]


@pytest.mark.parametrize(("what", "between"), STAYS)
def test_a_stay_that_was_interrupted_begins_again(what: str, between: list[tuple[float, str]]) -> None:
    watch = RepetitionWatch(make_goto_session(GOTO))
    assert turn_left(watch, range(23)) == []
    for time_s, state in between:
        watch.observe(time_s, state, (5.0, 0.0))
    later = round(2 * max(time_s for time_s, _ in between)) + 1
    assert turn_left(watch, range(later, later + 20)) == []


MOMENTS = [
    (0, 2),  # at 10 degrees, next to the example that leaves the turn at 20 degrees
    (1, 5),  # a quarter of the round later
    (2, 8),
    (3, 11),
    (4, 2),
]


@pytest.mark.parametrize(("asked", "moment"), MOMENTS)
def test_each_question_is_a_quarter_of_the_round_later(asked: int, moment: int) -> None:
    rows = np.array([(5.0, radians(70 - 30 * step) % tau) for step in range(12)])
    assert choose_moment(make_goto_session(GOTO), "left", rows, asked) == moment


def test_without_an_example_that_leaves_the_state_it_is_asked_where_the_round_begins() -> None:
    rows = np.array([(5.0, radians(70 - 30 * step) % tau) for step in range(12)])
    assert choose_moment(make_goto_session(GOTO[:1]), "left", rows, 0) == 0
