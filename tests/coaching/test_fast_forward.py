"""Fast forward: the run goes on without the person up to where they are needed, and nothing of it is learned."""

from __future__ import annotations

import pytest
from tests.bodies import Scripted
from tests.make.sessions import make_session, play, ticks

from understudy.coaching.fast_forward import PauseReason, fast_forward
from understudy.coaching.questions import UncertaintyQueries
from understudy.errors import SessionError
from understudy.model.learner_options import LearnerOptions
from understudy.training.session import Session

NEVER = 2.0
"""More doubt than there can be."""


def live(*steps: str | int, watched: bool = False) -> Session:
    """A lesson taught live; the ball comes one meter nearer each tick of 0.1 s, from 100 m on."""
    options = LearnerOptions(live=True, watched=watched)
    return play(make_session(flags=["done"], options=options, body=Scripted()), *steps)


def calm(taught: Session) -> UncertaintyQueries:
    """What is asked about: nothing."""
    return UncertaintyQueries(taught, unsure=NEVER)


def test_it_stops_before_the_tick_at_which_it_is_unsure() -> None:
    taught = live("forward", 3)
    stopped = fast_forward(taught)
    assert stopped.reason is PauseReason.UNSURE
    assert stopped.question is not None
    assert stopped.question.time_s == pytest.approx(taught.body.time_s)
    assert stopped.sentence == stopped.question.sentence


def test_it_stops_where_the_automaton_raises_a_flag() -> None:
    taught = live("forward", 5, "done", 2)
    taught.reset(1)
    stopped = fast_forward(taught, queries=calm(taught))
    assert (stopped.reason, taught.view().flag) == (PauseReason.FLAG, "done")
    assert stopped.seconds == pytest.approx(0.6)


def test_it_stops_at_a_property() -> None:
    taught = live("forward", 3)
    stopped = fast_forward(
        taught, queries=calm(taught), until=lambda now: now.view().features["range_of(ball)"] < 90
    )
    assert stopped.reason is PauseReason.PROPERTY
    assert taught.view().features["range_of(ball)"] == 89


def test_it_stops_where_nothing_changes_any_more() -> None:
    taught = live("forward", 3)
    stopped = fast_forward(taught, queries=calm(taught))
    assert stopped.reason is PauseReason.STUCK
    assert stopped.seconds == pytest.approx(30.1)


def test_it_stops_at_its_limit() -> None:
    taught = live("forward", 3)
    stopped = fast_forward(taught, queries=calm(taught), limit_s=2.0)
    assert stopped.reason is PauseReason.LIMIT
    assert stopped.seconds == pytest.approx(2.0)


def test_nothing_is_learned_from_silence_on_the_way() -> None:
    for skipped in (True, False):
        taught = live("forward", 1, watched=True)
        if skipped:
            fast_forward(taught, queries=calm(taught), limit_s=2.0)
        else:
            ticks(taught, 20)
        assert taught.is_watching
        assert any(not example.is_from_press for example in taught.lesson.examples) is not skipped


def test_in_training_there_is_nothing_to_skip() -> None:
    taught = make_session(flags=["done"])
    with pytest.raises(SessionError, match="nothing happens without you"):
        fast_forward(taught)
    assert taught.body.time_s == 0.0
