"""Fast forward: a session runs at the engine's speed to the next moment at which its demonstrator is needed.

stopped = fast_forward(session)
print(stopped.sentence)
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum

from understudy.coaching.questions import Question, UncertaintyQueries
from understudy.errors import SessionError
from understudy.training.session import Session
from understudy.training.trainee import Mode

LIMIT_S = 300.0
"""The longest stretch that is skipped at once, s."""
SAME_S = 30.0
"""The time in the same states after which a robot may be stuck, s."""
FIDGETS, FIDGETING_S = 30, 6.0
"""The number of switches within a time, s, from which on a robot fidgets: it switches without getting anything done."""


class PauseReason(StrEnum):
    """Why a fast forward paused."""

    UNSURE = "unsure"
    FLAG = "flag"
    PROPERTY = "property"
    STUCK = "stuck"
    LIMIT = "limit"


SENTENCES = {
    PauseReason.FLAG: "The automaton raised a flag.",
    PauseReason.PROPERTY: "The property that was watched for holds.",
    PauseReason.STUCK: "All states are as they were for a while, or they switch back and forth.",
    PauseReason.LIMIT: "Nothing needed you.",
}


@dataclass(frozen=True, slots=True)
class FastForward:
    """The result of a fast forward: why it stopped, the skipped time in s, and the question if it is unsure."""

    reason: PauseReason
    seconds: float
    question: Question | None = None

    @property
    def sentence(self) -> str:
        """The reason, for a person."""
        return SENTENCES[self.reason] if self.question is None else self.question.sentence


@contextmanager
def stop_watching(session: Session) -> Iterator[None]:
    """Let nothing be learned from silence inside, because no person watches."""
    watching, session.is_watching = session.is_watching, False
    try:
        yield
    finally:
        session.is_watching = watching


def fast_forward(
    session: Session,
    *,
    queries: UncertaintyQueries | None = None,
    until: Callable[[Session], bool] = lambda session: False,
    limit_s: float = LIMIT_S,
) -> FastForward:
    """Run a session to the next moment at which its demonstrator is needed, and stop before that tick.

    Nothing is recorded from silence on the way, because no person watches.

    Parameters
    ----------
    session
        A session in live teaching or testing.
    queries
        What is uncertain, and was asked about before. None: all that is uncertain from now on.
    until
        A property of the session at which to stop, such as a collision or a finished world.
    limit_s
        The longest time to skip, s of the body.

    Returns
    -------
    FastForward
        Why it stopped: an uncertain decision, a flag that the automaton raised, the property, a robot that is stuck or
        switches back and forth, or the limit.

    Raises
    ------
    SessionError
        If the session is in training, where the robot does only what it is told.
    """
    if session.mode is Mode.TRAINING:
        raise SessionError(
            "in training nothing happens without you: switch to live teaching or testing first"
        )
    asking = queries or UncertaintyQueries(session)
    began = session.body.time_s
    with stop_watching(session):
        reason, question = _run(session, asking, until, began + limit_s)
    return FastForward(reason, session.body.time_s - began, question)


def _run(
    session: Session, asking: UncertaintyQueries, until: Callable[[Session], bool], until_s: float
) -> tuple[PauseReason, Question | None]:
    body = session.body
    changes, path = deque([body.time_s], maxlen=FIDGETS), session.trainee.path
    while body.time_s < until_s - body.tick_s / 2:
        if (question := asking.find_question()) is not None:
            return PauseReason.UNSURE, question
        session.tick()
        if session.trainee.result.raised:
            return PauseReason.FLAG, None
        if until(session):
            return PauseReason.PROPERTY, None
        if session.trainee.path != path:
            path = session.trainee.path
            changes.append(body.time_s)
        fidgets = len(changes) == FIDGETS and body.time_s - changes[0] < FIDGETING_S
        if fidgets or body.time_s - changes[-1] > SAME_S:
            return PauseReason.STUCK, None
    return PauseReason.LIMIT, None
