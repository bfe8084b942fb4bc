"""Silence is consent: rules (1) to (3) of ARCHITECTURE section 3, "Watched examples"."""

from __future__ import annotations

from typing import Any

import pytest
from tests.make.sessions import Row, list_rows, make_session, play

from understudy.model.learner_options import LearnerOptions
from understudy.training.session import Session

WATCHED = LearnerOptions(watched=True)


def list_watched(of: Session) -> list[Row]:
    """Watched examples of the lesson as it would be kept now, without their kind."""
    return [row[:-1] for row in list_rows(of.lesson) if row[-1] == "watched"]


SILENCE: list[tuple[list[Any], list[Row]]] = [
    (["forward", 1], []),
    (["forward", 2], [("forward", 99, "forward")]),
    (["forward", 4], [("forward", 99, "forward")]),  # stays are at least 0.3 s apart
    (["forward", 5], [("forward", 99, "forward"), ("forward", 96, "forward")]),
    (["forward", 10], [("forward", 99, "forward"), ("forward", 96, "forward"), ("forward", 93, "forward")]),
    # a press at 90 m, second 1.0, discards the last 0.4 s
    (["forward", 10, "confirm", 1], [("forward", 99, "forward"), ("forward", 96, "forward")]),
    (["forward", 4, "left", 1], []),
    (["forward", 6, "left", 1], [("forward", 99, "forward")]),
    # each state by itself
    (["forward", 6, "left", 6], [("forward", 99, "forward"), ("left", 93, "left"), ("left", 90, "left")]),
    ([10], []),  # resting in start
    (["done", 10], []),  # a flag state
    (["forward", 2, "restart", 5], [("forward", 99, "forward")]),
]


@pytest.mark.parametrize(("steps", "expected"), SILENCE)
def test_silence_in_training(steps: list[Any], expected: list[Row]) -> None:
    assert list_watched(play(make_session(flags=["done"], options=WATCHED), *steps)) == expected


@pytest.mark.parametrize(("reaction_s", "kept"), [(0.0, 6), (0.2, 6), (0.3, 5), (0.8, 0)])
def test_a_longer_reaction_discards_more(reaction_s: float, kept: int) -> None:
    """The last max(0.4, reaction_s + 0.2) s before a press at second 1.0 are doubtful."""
    options = LearnerOptions(watched=True, reaction_s=reaction_s)
    taught = play(make_session(options=options), "forward", 10, "left", 1)
    seconds = [
        round(taught.lesson.record.seconds[e.moment or 0], 6)
        for e in taught.lesson.examples
        if not e.is_from_press
    ]
    assert seconds == [second for second in (0.1, 0.4, 0.7) if second <= kept / 10]


def in_a_test() -> Session:
    """In a test: forward at 100 m, left at 95 m, done at 90 m."""
    taught = make_session(flags=["done"], options=WATCHED)
    taught.is_watching = False
    play(taught, "forward", 5, "left", 5, "done", 1)
    taught.reset(0)
    taught.is_watching = True
    taught.test()
    return taught


def test_in_testing_what_the_automaton_did() -> None:
    """The cuts of lessons with watched examples are midpoints: it turns at 97 m, and is done at 92 m."""
    taught = play(in_a_test(), 9)
    assert list_watched(taught) == [
        ("forward", 99, "forward"),
        ("forward", 97, "left"),
        ("left", 96, "left"),
        ("left", 93, "left"),
        ("left", 92, "done"),
    ]


def test_a_flag_is_not_watched_and_its_correction_removes_what_it_contradicts() -> None:
    taught = play(in_a_test(), 20)
    (raised,) = [row for row in list_watched(taught) if row[2] == "done"]
    play(taught, "right", 1)
    assert list_rows(taught)[-1][:-1] == ("left", raised[1], "right")
    assert [row for row in list_watched(taught) if row[2] == "done"] == []


def test_not_watching() -> None:
    taught = make_session(options=WATCHED)
    taught.is_watching = False
    play(taught, "forward", 10)
    assert list_watched(taught) == []
    taught.is_watching = True
    play(taught, 1)
    assert list_watched(taught) == [("forward", 90, "forward")]


def test_looking_away_and_pressing_still_discards_the_last_moments() -> None:
    taught = play(make_session(options=WATCHED), "forward", 3)
    taught.is_watching = False
    play(taught, "left", 1)
    assert list_watched(taught) == []


def test_a_lesson_that_does_not_ask_for_them_has_none() -> None:
    assert list_watched(play(make_session(), "forward", 10)) == []


def test_driving_is_not_watched() -> None:
    taught = play(make_session(options=WATCHED), "forward", 1)
    taught.drive("left")
    play(taught, 5)
    assert list_watched(taught) == []


def test_vectors_that_a_press_made_and_duplicates_are_dropped() -> None:
    """Load grows every half second: 0 is the default's, each other value is kept once."""
    taught = play(make_session(features=["load"], options=WATCHED), "forward", 20)
    assert list_watched(taught) == [("forward", load, "forward") for load in (1, 2, 3)]


def test_a_press_later_on_the_same_vector_replaces_what_was_watched() -> None:
    """Load is 2 from second 1.0 on: watched there, then pressed at second 1.4."""
    taught = play(make_session(features=["load"], options=WATCHED), "forward", 11)
    taught.restart()
    play(taught, "forward", 1, "left", 1)
    assert ("forward", 2, "left", "directive") in list_rows(taught.lesson)
    assert ("forward", 2, "forward") not in list_watched(taught)


def test_looking_at_the_lesson_changes_nothing() -> None:
    """What a library would keep now includes what was just seen; a press may still take it back."""
    taught = play(make_session(options=WATCHED), "forward", 5)
    first = taught.make_trained_automaton().lesson
    assert first is not None
    assert list_rows(first) == list_rows(taught.lesson)
    assert len(first.examples) == 4
    assert len(taught.examples) == 2
    play(taught, "left", 1)
    assert list_watched(taught) == [("forward", 99, "forward")]


def test_testing_learns_from_what_was_watched() -> None:
    taught = play(make_session(options=WATCHED), "forward", 5)
    taught.test()
    assert [row[-1] for row in list_rows(taught)] == ["directive", "default", "watched", "watched"]


def test_no_reaction_shift() -> None:
    taught = play(make_session(options=LearnerOptions(watched=True, reaction_s=0.2)), "forward", 2)
    assert list_watched(taught) == [("forward", 99, "forward")]
