"""What each press records, as tables (ARCHITECTURE section 3, "What a directive records")."""

from __future__ import annotations

from math import nan
from typing import Any

import pytest
from tests.bodies import RANGE, Scripted
from tests.make.sessions import WITH_GO, decide_once, list_rows, make_session, play

from understudy.errors import UnknownName
from understudy.training.session import Session
from understudy.training.trainee import Mode

# The ball is 100 m away at first, and one meter nearer each tick of 0.1 s.
PRESSES: list[tuple[list[Any], list[tuple[Any, ...]]]] = [
    (
        [2, "forward", 1],
        [
            ("start", 98, "forward", "directive"),
            ("forward", 98, "forward", "default"),
        ],
    ),
    (
        ["forward", 1, 3, "left", 5],
        [
            ("start", 100, "forward", "directive"),
            ("forward", 100, "forward", "default"),
            ("forward", 96, "left", "directive"),
            ("left", 96, "left", "default"),
        ],
    ),
    (["forward"], []),  # a press acts at the next tick
    (["confirm", 1], [("start", 100, "start", "confirmation")]),
    (["start", 1], [("start", 100, "start", "confirmation")]),
    (  # directing the current state is confirming it
        ["forward", 2, "forward", 1],
        [
            ("start", 100, "forward", "directive"),
            ("forward", 100, "forward", "default"),
            ("forward", 98, "forward", "confirmation"),
        ],
    ),
    (  # of several presses before one tick the last counts
        ["forward", "left", "right", 1],
        [
            ("start", 100, "right", "directive"),
            ("right", 100, "right", "default"),
        ],
    ),
    (["forward", "confirm", 1], [("start", 100, "start", "confirmation")]),
    (  # into a flag: no default
        ["forward", 1, "done", 1],
        [
            ("start", 100, "forward", "directive"),
            ("forward", 100, "forward", "default"),
            ("forward", 99, "done", "directive"),
        ],
    ),
    (["done", 1, "forward", 3], [("start", 100, "done", "directive")]),  # out of a flag: nothing
    (["done", 1, "confirm", 3], [("start", 100, "done", "directive")]),
    (["done", 1, "done", 3], [("start", 100, "done", "directive")]),
    (["forward", "restart", 3], []),  # a restart takes a press that waits with it
    ([3, "restart", 3, "note_moved", 2, "train", 1], []),
]


@pytest.mark.parametrize(("steps", "expected"), PRESSES)
def test_presses(steps: list[Any], expected: list[tuple[Any, ...]]) -> None:
    assert list_rows(play(make_session(flags=["done"]), *steps)) == expected


def test_what_the_switch_resets() -> None:
    """Time in state and child flags stand at their reset values in the default, and only there."""
    taught = make_session(["go", "left"], ["range_of(ball)", "done", "time_in_state"], library=WITH_GO)
    play(taught, 1, "go", 3, "left", 2, "confirm", 1)  # go is started at tick 1, and done at tick 2
    assert list_rows(taught) == [
        ("start", 99, 0, 0.1, "go", "directive"),
        ("go", 99, 0, 0.0, "go", "default"),
        ("go", 96, 1, 0.3, "left", "directive"),
        ("left", 96, 0, 0.0, "left", "default"),
        ("left", 94, 0, 0.2, "left", "confirmation"),
    ]


def test_a_confirmation_resets_and_restarts_nothing() -> None:
    taught = make_session(["go"], ["done", "time_in_state"], library=WITH_GO)
    play(taught, "go", 5, "confirm", 1)
    assert list_rows(taught)[-1] == ("go", 1, 0.5, "go", "confirmation")
    assert taught.run_state[1].state == "done"
    play(taught, "go", 1)
    assert taught.run_state[1].state == "done"


def test_directing_again_from_elsewhere_restarts_the_child() -> None:
    taught = make_session(["go", "left"], ["done"], library=WITH_GO)
    play(taught, "go", 5, "left", 1, "go", 1)
    assert list_rows(taught)[-2:] == [("left", 0, "go", "directive"), ("go", 0, "go", "default")]


def test_counters_and_timers_as_they_are_when_pressed() -> None:
    """The switch to lap counts one: the default, which is lap's first vector, has it counted."""
    taught = make_session(["lap", "click", "left"], ["laps", "watch"])
    play(taught, "lap", 2, "click", 2, "left", 1)
    ((*_, watch, _, _), *_) = found = list_rows(taught)
    assert watch != watch  # absent: never set
    assert [row[1] for row in found] == [0, 1, 1, 1, 1, 1]
    assert [row[2] for row in found[3:]] == [0.0, 0.2, 0.2]


def test_absent_readings_are_recorded_as_absent() -> None:
    taught = make_session(body=Scripted(script={**RANGE, ("range", "ball"): lambda tick: nan}))
    play(taught, "forward", 1)
    assert all(example.values[0] != example.values[0] for example in taught.examples)


# Paused


def test_a_paused_press_records_the_snapshot_on_display() -> None:
    taught = make_session()
    play(taught, 3)
    taught.paused = True
    shown = taught.view().features["range_of(ball)"]
    taught.direct("forward")
    taught.paused = False
    play(taught, 1)
    assert shown == 97
    assert list_rows(taught)[0] == ("start", 97, "forward", "directive")


# Testing


def learn_and_test() -> Any:
    """Forward at once, left at 95 m, done at 90 m; then testing. Ticks go on from 12."""
    taught = make_session(flags=["done"])
    play(taught, "forward", 5, "left", 5, "done", 2)
    taught.reset(0)
    taught.test()
    return taught


def test_testing_learns_and_restarts() -> None:
    taught = learn_and_test()
    assert taught.mode is Mode.TESTING
    assert taught.view().path == ("start",)
    seen = [play(taught, 1).view().path[0] for _ in range(12)]
    assert seen == ["forward"] * 5 + ["left"] * 5 + ["done"] * 2
    assert len(taught.examples) == 5  # testing records nothing by itself


def test_directing_while_testing_is_a_correction_and_drops_to_training() -> None:
    taught = learn_and_test()
    play(taught, 3, "right")
    assert taught.mode is Mode.TRAINING
    play(taught, 5)
    assert list_rows(taught)[5:] == [("forward", 97, "right", "directive"), ("right", 97, "right", "default")]
    assert [example.correction for example in taught.examples] == [False] * 5 + [True] * 2
    assert taught.view().state == "right"  # the demonstrator decides now
    play(taught, "left", 1)
    assert not taught.examples[-1].correction


def test_a_second_press_before_the_tick_is_still_a_correction() -> None:
    taught = play(learn_and_test(), 3, "right", "left", 1)
    assert list_rows(taught)[5:] == [("forward", 97, "left", "directive"), ("left", 97, "left", "default")]
    assert all(example.correction for example in taught.examples[5:])


def test_confirming_while_testing() -> None:
    taught = play(learn_and_test(), 3, "confirm", 1)
    assert list_rows(taught)[5:] == [("forward", 97, "forward", "confirmation")]
    assert taught.examples[5].correction


FLAG_CORRECTIONS = [  # pressed while done is up, what is recorded: where it was raised, at 90 m, from left
    ("right", ("left", 90, "right", "directive"), "right"),
    ("left", ("left", 90, "left", "confirmation"), "left"),
    ("start", ("left", 90, "start", "directive"), "start"),
    ("done", ("left", 90, "done", "directive"), "done"),
    ("confirm", ("left", 90, "done", "directive"), "done"),
]


@pytest.mark.parametrize(("press", "recorded", "after"), FLAG_CORRECTIONS)
def test_out_of_a_flag_in_testing_corrects_its_entry(
    press: str, recorded: tuple[Any, ...], after: str
) -> None:
    taught = play(learn_and_test(), 20, press, 1)
    assert list_rows(taught)[5:] == [recorded]
    assert taught.examples[5].correction
    assert taught.view().state == after
    play(taught, "right", 1)  # in training now: from where it is
    assert len(taught.examples) == (6 if after in ("right", "done") else 8) + (after == "right")


def test_a_corrected_flag_is_no_longer_raised_there() -> None:
    taught = play(learn_and_test(), 20, "left", 1)
    assert decide_once(taught.make_trained_automaton().automaton, "left", 90.0) == "left"
    assert decide_once(taught.make_trained_automaton().automaton, "left", 80.0) == "left"


def at_a_flag() -> Session:
    """What was learned has raised done, at 90 m."""
    taught = play(make_session(["forward", "left"], flags=["done"]), "forward", 10, "done", 1)
    taught.reset(0)
    return play(taught, "test", 13)


def test_a_flag_can_be_corrected_after_an_edit_is_undone() -> None:
    taught = at_a_flag()
    taught.delete(2)
    taught.undo()
    assert taught.view().flag == "done"
    play(taught, "forward", 1)
    assert list_rows(taught)[3:] == [("forward", 90, "forward", "confirmation")]
    assert taught.examples[-1].correction


def test_a_flag_can_be_corrected_after_rewinding_to_it() -> None:
    taught = at_a_flag()
    instant = taught.capture()
    play(taught, "restart", 5)
    taught.rewind(instant)
    play(taught, "forward", 1)
    assert list_rows(taught)[3:] == [("forward", 90, "forward", "confirmation")]


def test_switching_to_training_at_a_flag_records_nothing() -> None:
    taught = play(learn_and_test(), 20, "train", "right", 1)
    assert len(taught.examples) == 5
    assert taught.view().state == "right"


def test_a_flag_directed_into_is_not_corrected_in_a_later_test() -> None:
    """The entry of a flag belongs to the test in which it was raised."""
    taught = play(learn_and_test(), 20)
    taught.restart()
    play(taught, "done", 1, "right", 1)
    assert list_rows(taught)[5:] == [("start", 80, "done", "directive")]


# What records nothing


def test_driving_records_nothing_and_the_robot_obeys() -> None:
    taught = make_session()
    play(taught, "forward", 2)
    body = taught.body
    assert isinstance(body, Scripted)
    taught.drive("left")
    play(taught, 3)
    assert [commands["turn"] for commands in body.commanded[-3:]] == [[1.0]] * 3
    taught.drive(None)
    play(taught, 1)
    assert body.commanded[-1]["drive"] == [1.0]  # it goes on with what it was doing
    assert len(taught.examples) == 2


def test_a_press_ends_driving() -> None:
    taught = make_session()
    taught.drive("left")
    play(taught, 2, "forward", 1)
    assert list_rows(taught)[0] == ("start", 98, "forward", "directive")


def test_driving_takes_basic_behaviors_of_the_kit() -> None:
    with pytest.raises(UnknownName, match="basic behavior 'fly'"):
        make_session().drive("fly")


def test_reset_begins_anew() -> None:
    taught = play(make_session(), "forward", 5)
    taught.reset(7)
    assert taught.body.time_s == 0
    assert taught.view().path == ("start",)
    assert len(taught.examples) == 2


def test_a_press_is_numbered() -> None:
    taught = make_session()
    assert [taught.direct("forward"), taught.confirm(), taught.direct("left")] == [1, 2, 3]
    assert taught.view().waiting == "left"


def test_the_demonstrator_decides_in_training() -> None:
    """What was learned before does not act in training mode; nested automata do."""
    taught = play(learn_and_test(), 1, "train", 8)
    assert taught.view().path == ("forward",)


def test_stateless_lessons() -> None:
    taught = make_session(["forward", "left"], stateless=True, flags=["done"])
    play(taught, "forward", 5, "left", 5, "done", 1)
    taught.reset(0)
    taught.test()
    seen = [play(taught, 1).view().path[0] for _ in range(10)]
    policy = taught.make_trained_automaton().automaton
    assert seen[0] == "forward"
    assert seen[-1] in ("left", "done")
    assert decide_once(policy, "start", 100.0) == decide_once(policy, "left", 100.0) == "forward"
    assert decide_once(policy, "forward", 95.0) == decide_once(policy, "left", 95.0) == "left"
