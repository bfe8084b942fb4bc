"""The model of a novice's live teaching: the robot acts by itself, and the novice presses what it should do instead.

The novice has the same traits as in the paper's training, and the same five minutes. Situations that occur to the
novice alternate with those that the program finds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from understudy.coaching.next_situation import find_next_situation, go_to_situation
from understudy.coaching.questions import Question, UncertaintyQueries
from understudy.coaching.reasons_to_ask import DoubtReason
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.novices.novice import Novice
from understudy_lab.tasks.soccer import ANYWHERE, Soccer
from understudy_lab.teachers.teacher import FIRST_SEED

ANSWER_S = 1.0
"""The time in s that an answer to a question takes; the world is paused."""
OVERDUE_S = 1.0
"""The time in s for which a novice tolerates that the robot is late with a switch that it was shown."""
FRESH_WORLDS = 12
"""The number of fresh worlds in which the program looks for the next situation."""


class Placement(NamedTuple):
    """How a robot comes into its next situation."""

    put_down: Callable[[Novice, Session, str], None]
    """A function that puts the robot into a situation that occurs to the novice."""
    allow_anywhere: Callable[[Session], None] = lambda session: None
    """A function that lets the robot of a fresh world begin anywhere."""


def teach_live(
    novice: Novice, session: Session, placement: Placement, note: Callable[[], None] = lambda: None
) -> None:
    """Let a novice teach live for the time given; `note` is called after each situation."""
    session.teach()
    _LiveTeaching(novice, session, placement).go_through_situations(note)


class _LiveTeaching:
    """The live teaching of one novice."""

    def __init__(self, novice: Novice, session: Session, placement: Placement) -> None:
        self._novice, self._session, self._placement = novice, session, placement
        self._queries = UncertaintyQueries(session)
        self._unlike_since: float | None = None  # when the robot began not to do what the novice wishes
        self._repeats = ""  # the state in which the robot has said that it repeats itself

    def go_through_situations(self, note: Callable[[], None]) -> None:
        """Put the robot into one situation after another, watch it and correct it."""
        novice = self._novice
        traits, given_s = novice.traits, novice.habits.given_s
        turn, proposes = int(novice.draws.integers(len(traits.situations))), False
        while novice.seconds < given_s:
            self._repeats = ""
            if proposes:
                self._go_to_next()
            else:
                situation = traits.situations[turn % len(traits.situations)]
                self._placement.put_down(novice, self._session, situation)
                novice.shown[situation] += 1
                turn += 1
            proposes = not proposes
            novice.seconds = min(given_s, novice.seconds + traits.carry_s)
            novice.look_afresh()
            self._unlike_since = None
            self._watch_robot(min(traits.patience_s, given_s - novice.seconds))
            note()

    def _go_to_next(self) -> None:
        """Go to the situation that the program finds in fresh worlds."""
        self._placement.allow_anywhere(self._session)
        first = draw_seed(self._novice)
        seeds = range(first, first + FRESH_WORLDS)
        situation = find_next_situation(self._session, seeds=seeds, queries=self._queries)
        if situation is None:
            self._session.reset(first)
        else:
            go_to_situation(self._session, situation)
            if situation.question.doubt.because is DoubtReason.REPEATING:
                self._queries.note_asked(situation.question)
                self._answer(situation.question)

    def _watch_robot(self, limit_s: float) -> None:
        """Watch the robot until it has succeeded or the time is up, answer its questions, and correct it."""
        novice, session = self._novice, self._session
        until = novice.seconds + limit_s
        while novice.seconds < until and not novice.there(screen := session.view()):
            question = self._queries.find_question()
            if question is None:
                novice.consider(session, self._find_correction(screen))
                session.tick()
                novice.seconds += session.body.tick_s
            else:
                self._answer(question)

    def _find_correction(self, screen: SessionView) -> str | None:
        """Return the state to correct to; None where the robot is right, or not yet late with what it was shown."""
        novice = self._novice
        if screen.state != self._repeats:
            self._repeats = ""
        wished = novice.wish(screen)
        if wished in (None, screen.state):
            self._unlike_since = None
            return None
        if self._repeats:  # it will not do that by itself: they were asked for it
            return wished
        if self._unlike_since is None:
            self._unlike_since = novice.seconds
        late_s = novice.seconds - self._unlike_since
        return None if (screen.state, wished) in novice.switched and late_s < OVERDUE_S else wished

    def _answer(self, question: Question) -> None:
        """Answer a question while the robot waits; press nothing if what it proposes is right."""
        novice, session, screen = self._novice, self._session, self._session.view()
        novice.seconds += ANSWER_S
        if question.doubt.because is DoubtReason.REPEATING:
            self._repeats = question.state
        contradictory = question.doubt.because in (DoubtReason.FIDGETING, DoubtReason.DISAGREEING)
        if not contradictory and novice.wish(replace(screen, state=question.next)) in (None, question.next):
            return
        right = novice.wish(screen) or screen.state
        if right == question.next:
            return
        session.paused = True
        novice.press(session, None if right == question.state else right)
        session.paused = False
        novice.cancel_press()


def draw_seed(novice: Novice) -> int:
    """Draw the seed of another world in which this novice teaches."""
    return FIRST_SEED + int(novice.draws.integers(2**40))


def _put_down_by_the_ball(novice: Novice, session: Session, situation: str) -> None:
    if isinstance(session.body, Soccer):
        session.body.starts = [novice.choose_start(situation)]
    session.reset(draw_seed(novice))


def _begin_anywhere(session: Session) -> None:
    if isinstance(session.body, Soccer):
        session.body.starts = [ANYWHERE]


BY_THE_BALL = Placement(_put_down_by_the_ball, _begin_anywhere)
"""Where the robot is put down that has to approach a ball."""
