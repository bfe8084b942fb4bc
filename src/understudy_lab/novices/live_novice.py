"""The model of a novice who teaches live: the robot acts by itself, and the novice presses what it should do instead.

The novice has the same traits as in the paper's training, and the same five minutes. Situations that occur to the
novice alternate with those that the program finds.
"""

from __future__ import annotations

from dataclasses import replace

from understudy.coaching.next_situation import find_next_situation, go_to_situation
from understudy.coaching.queries import Question, UncertaintyQueries
from understudy.coaching.uncertainty import DoubtReason
from understudy.model.library import Library, TrainedAutomaton
from understudy.training.session import Session
from understudy.training.trainee import SessionView
from understudy_lab.novices.novice import Novice
from understudy_lab.novices.traits import ALIKE, SharedTraits, Traits
from understudy_lab.tasks.servo_teacher import four_states
from understudy_lab.tasks.soccer import ANYWHERE, Soccer, kit
from understudy_lab.teachers.teacher import FIRST_SEED

ANSWER_S = 1.0
"""The time in s that an answer to a question takes; the world is paused."""
OVERDUE_S = 1.0
"""The time in s for which a novice tolerates that the robot is late with a switch that it was shown."""
FRESH_WORLDS = 12
"""The number of fresh worlds in which the program looks for the next situation."""


class LiveNovice(Novice):
    """A simulated novice who teaches live."""

    def __init__(self, traits: Traits, seed: int, habits: SharedTraits = ALIKE) -> None:
        super().__init__(traits, seed, habits)
        self._body = Soccer([self._draw_seed()], self._start(traits.situations[0]))
        self._session = Session(self._body, Library(kit), four_states(Library(kit)))
        self._session.teach()
        self._queries = UncertaintyQueries(self._session)
        self._pressed: set[tuple[str, str]] = set()
        """The switches that this novice has pressed, from and to."""

    def teach(self) -> TrainedAutomaton:
        """Put the robot into one situation after another, watch it and correct it, and return its automaton."""
        traits, given_s = self.traits, self.habits.given_s
        turn, proposes = int(self._draws.integers(len(traits.situations))), False
        while self.seconds < given_s:
            if proposes:
                self._go_to_next()
            else:
                self._put_down(traits.situations[turn % len(traits.situations)])
                turn += 1
            proposes = not proposes
            self.seconds = min(given_s, self.seconds + traits.carry_s)
            self._side, self._unlike_since = None, None
            self._watch_robot(min(traits.patience_s, given_s - self.seconds))
        return self._session.make_trained_automaton()

    def _draw_seed(self) -> int:
        return FIRST_SEED + int(self._draws.integers(2**40))

    def _put_down(self, situation: str) -> None:
        """Put the robot into a situation that occurs to this novice."""
        self._body.starts = [self._start(situation)]
        self._session.reset(self._draw_seed())
        self.shown[situation] += 1

    def _go_to_next(self) -> None:
        """Go to the situation that the program finds in fresh worlds."""
        self._body.starts = [ANYWHERE]
        first = self._draw_seed()
        seeds = range(first, first + FRESH_WORLDS)
        found = find_next_situation(self._session, seeds=seeds, queries=self._queries)
        if found is None:
            self._session.reset(first)
        else:
            go_to_situation(self._session, found)

    def _watch_robot(self, limit_s: float) -> None:
        """Watch the robot until it reaches the ball or the time is up, answer its questions, and correct it."""
        session, until = self._session, self.seconds + limit_s
        while self.seconds < until and not self.there(screen := session.view()):
            question = self._queries.find_question()
            if question is None:
                self._consider(session, self._find_correction(screen), self.seconds)
                session.tick()
                self.seconds += session.body.tick_s
            else:
                self._answer(question)

    def _find_correction(self, screen: SessionView) -> str | None:
        """Return the state to correct to; None where the robot is right, or not yet late with what it was shown."""
        wished = self.wish(screen)
        if wished in (None, screen.state):
            self._unlike_since = None
            return None
        if self._unlike_since is None:
            self._unlike_since = self.seconds
        late_s = self.seconds - self._unlike_since
        return None if (screen.state, wished) in self._pressed and late_s < OVERDUE_S else wished

    def _answer(self, question: Question) -> None:
        """Answer a question while the robot waits; press nothing if what it proposes is right."""
        session, screen = self._session, self._session.view()
        self.seconds += ANSWER_S
        contradictory = question.doubt.because in (DoubtReason.FIDGETING, DoubtReason.DISAGREEING)
        if not contradictory and self.wish(replace(screen, state=question.next)) in (None, question.next):
            return
        right = self.wish(screen) or screen.state
        if right == question.next:
            return
        session.paused = True
        if right == question.state:
            session.confirm()
            self.presses += 1
        else:
            self._press(session, right)
        session.paused = False
        self._due = None

    def _press(self, session: Session, wished: str) -> None:
        self._pressed.add((session.view().state, wished))
        super()._press(session, wished)
