"""A person presses late: readings of a press are those of `reaction_s` before it (ARCHITECTURE section 3)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from tests.bodies import Scripted
from tests.make.sessions import WITH_GO, list_rows, make_session, play

from understudy.model.learner_options import LearnerOptions
from understudy.training.session import Session

NEAREST = [  # reaction, s; the value at the press, at tick 6: 100 m and one less per tick of 0.1 s
    (0.0, 94),
    (0.04, 94),
    (0.06, 95),
    (0.2, 96),
    (0.24, 96),
    (0.26, 97),
    (0.6, 100),
    (1.0, 100),  # there is nothing before the episode began
]


@pytest.mark.parametrize(("reaction_s", "value"), NEAREST)
def test_nearest_tick(reaction_s: float, value: float) -> None:
    taught = play(make_session(options=LearnerOptions(reaction_s=reaction_s)), 6, "forward", 1)
    assert list_rows(taught) == [
        ("start", value, "forward", "directive"),
        ("forward", value, "forward", "default"),
    ]


@pytest.mark.parametrize(("reaction_s", "value"), NEAREST)
def test_it_can_be_chosen_afterwards(reaction_s: float, value: float) -> None:
    taught = play(make_session(options=LearnerOptions(reaction_s=0.3)), 6, "forward", 1)
    taught.change_design(options=LearnerOptions(reaction_s=reaction_s))
    assert [example.values[0] for example in taught.examples] == [value, value]


def test_only_continuous_and_toroidal_readings_of_the_body_are_earlier() -> None:
    """Categorical readings and the automaton's own features are those of the press itself."""
    features = ["range_of(ball)", "bearing_of(ball)", "load", "seen", "done", "time_in_state"]
    taught = make_session(["go", "left"], features, library=WITH_GO, options=LearnerOptions(reaction_s=0.3))
    play(taught, "go", 5, "left", 1)  # pressed at tick 5; readings of tick 2
    assert list_rows(taught)[2] == ("go", 98, 6.2, 0, 1, 1, 0.5, "left", "directive")


def test_the_demonstrators_own_clock_counts() -> None:
    """A demonstrator whose clock runs at twice the body's pace reacts in half as many ticks."""
    body = Scripted()
    taught = make_session(
        body=body, clock=lambda: 50 + 2 * body.time_s, options=LearnerOptions(reaction_s=0.4)
    )
    play(taught, 6, "forward", 1)
    assert list_rows(taught)[0][1] == 96


def drive(taught: Session) -> None:
    taught.drive("left")
    play(taught, 3)
    taught.drive(None)


CUTS: dict[str, Callable[[Session], Any]] = {
    "restart": Session.restart,
    "note_moved": Session.note_moved,
    "driving": drive,
    "testing": Session.test,
}


@pytest.mark.parametrize("cut", CUTS.values(), ids=CUTS)
def test_never_from_before(cut: Callable[[Session], Any]) -> None:
    taught = play(make_session(options=LearnerOptions(reaction_s=0.5)), 5)
    cut(taught)
    here = taught.view().features["range_of(ball)"]
    play(taught, 2, "forward", 1)
    assert list_rows(taught)[0][1] == here


def test_never_from_before_a_reset() -> None:
    taught = play(make_session(options=LearnerOptions(reaction_s=0.5)), 5)
    taught.reset(3)
    play(taught, 2, "forward", 1)
    assert list_rows(taught)[0][1] == 100


def test_unshifted_while_paused() -> None:
    taught = play(make_session(options=LearnerOptions(reaction_s=0.3)), 5)
    taught.paused = True
    play(taught, "forward")
    taught.paused = False
    play(taught, 1)
    assert list_rows(taught)[0][1] == 95
    taught.change_design(options=LearnerOptions(reaction_s=0.5))
    assert list_rows(taught)[0][1] == 95


def test_a_corrected_flag_is_corrected_where_it_was_raised() -> None:
    """What was learned has no reaction time: the vector is the very one that it decided on."""
    taught = make_session(flags=["done"])
    play(taught, "forward", 5, "done", 1)
    taught.change_design(options=LearnerOptions(reaction_s=0.3))
    taught.reset(0)
    taught.test()
    play(taught, 8)
    assert list_rows(taught)[2] == ("forward", 98, "done", "directive")  # pressed at 95 m
    assert taught.view().state == "done"
    play(taught, "forward", 1)
    assert list_rows(taught)[-1] == ("forward", 98, "forward", "confirmation")
