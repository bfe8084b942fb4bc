"""The model of a novice who teaches live: the robot acts by itself, and the novice presses what it should do instead.

The novice is the same as in the paper's training. Situations alternate between those that occur to the novice and those
that the program proposes. The novice is content after several in a row in which the robot needed no press.
"""

from __future__ import annotations

from dataclasses import replace

from understudy.coaching.next_situation import find_next_situation, go_to_situation
from understudy.coaching.queries import Question, UncertaintyQueries
from understudy.coaching.uncertainty import DoubtReason
from understudy.model.library import Library, TrainedAutomaton
from understudy.training.session import Session
from understudy_lab.novices.novice import Novice
from understudy_lab.tasks.servo_teacher import four_states
from understudy_lab.tasks.soccer import ANYWHERE, Soccer, kit
from understudy_lab.teachers.teacher import FIRST_SEED

ANSWER_S = 1.0
"""The time in s that an answer to a question takes; the world is paused."""
STEPS_IN_S = 1.0
"""The time in s for which a novice tolerates that the robot is late with a switch that it was shown."""
CONTENT = 400
"""The number of situations in a row without a press after which a novice is content."""
FRESH = 12
"""The number of fresh worlds in which the program looks for the next situation."""


class LiveNovice(Novice):
    """A simulated novice who teaches live."""

    _session: Session
    _queries: UncertaintyQueries

    def teach(self) -> TrainedAutomaton:
        """Put the robot into one situation after another until content, for five minutes at most."""
        traits, draws, given_s = self.traits, self._draws, self.habits.given_s
        body = Soccer([FIRST_SEED + int(draws.integers(2**40))], self._start(traits.situations[0]))
        session = Session(body, Library(kit), four_states(Library(kit)))
        session.teach()
        self._session, self._queries = session, UncertaintyQueries(session)
        self._shown: set[tuple[str, str]] = set()
        turn, well = int(draws.integers(len(traits.situations))), 0
        proposes = False
        while self.seconds < given_s and well < CONTENT:
            if proposes:
                self._go_to_next(body)
            else:
                situation = traits.situations[turn % len(traits.situations)]
                body.starts = [self._start(situation)]
                session.reset(FIRST_SEED + int(draws.integers(2**40)))
                self.shown[situation] += 1
                turn += 1
            proposes = not proposes
            self.seconds = min(given_s, self.seconds + traits.carry_s)
            self._side, self._unlike_since = None, None
            presses = self.presses
            reached = self._watch_robot(min(traits.patience_s, given_s - self.seconds))
            well = well + 1 if reached and self.presses == presses else 0
        return session.make_trained_automaton()

    def _go_to_next(self, body: Soccer) -> None:
        body.starts = [ANYWHERE]
        first = FIRST_SEED + int(self._draws.integers(2**40))
        seeds = range(first, first + FRESH)
        found = find_next_situation(self._session, seeds=seeds, queries=self._queries)
        if found is None:
            self._session.reset(first)
        else:
            go_to_situation(self._session, found)

    def _watch_robot(self, limit_s: float) -> bool:
        """Watch the robot, answer its questions, and correct it; return whether it reached the ball in time."""
        session, until = self._session, self.seconds + limit_s
        while self.seconds < until:
            screen = session.view()
            if self.there(screen):
                return True
            question = self._queries.find_question()
            if question is not None:
                self._answer(question)
                continue
            wished = self.wish(screen)
            if wished in (None, screen.state):
                self._unlike_since, wished = None, None
            elif self._unlike_since is None:
                self._unlike_since = self.seconds
            if wished is not None and (screen.state, wished) in self._shown:
                since = self._unlike_since
                if since is not None and self.seconds - since < STEPS_IN_S:
                    wished = None
            self._consider(session, wished, self.seconds)
            session.tick()
            self.seconds += session.body.tick_s
        return False

    def _answer(self, question: Question) -> None:
        """Answer a question while the robot waits; press nothing if it would do what is right."""
        session = self._session
        self.seconds += ANSWER_S
        screen = session.view()
        odd = question.doubt.because in (DoubtReason.FIDGETING, DoubtReason.DISAGREEING)
        if not odd and self.wish(replace(screen, state=question.next)) in (None, question.next):
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
        self._shown.add((session.view().state, wished))
        super()._press(session, wished)
