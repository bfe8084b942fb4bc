"""Queries: decisions that are uncertain are asked about or marked, in testing and in live teaching.

The queries stand beside a session. Its driver asks for a question before each tick.

    asking = UncertaintyQueries(session)
    question = asking.find_question()
    if question is not None:
        session.paused = True  # and show question.sentence
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from enum import StrEnum

from understudy.coaching.reasons_to_ask import DoubtReason, Uncertainty, UncertaintyModel
from understudy.coaching.repetition import RepetitionWatch
from understudy.learning.fit import learn
from understudy.runtime.body import is_rewindable
from understudy.training.other_agents import SessionSnapshot
from understudy.training.session import Session
from understudy.training.trainee import Mode, SessionView

UNSURE, UNSURE_LIVE = 0.5, 0.7
"""The doubt from which on the robot asks: in testing, and in live teaching, where much is still new."""
UNSURE_FLAG = 0.5
"""The doubt from which on the robot asks before it raises a flag, which ends its behavior, in live teaching, too."""
MOST_MARKS = 50
REST_S = 2.0
"""The time after a question in which the robot asks no other, s: a person who is always asked stops listening."""


FIDGETS, FIDGETING_S = 8, 2.0
"""The number of switches within a time, s, from which on the robot asks what it should do."""


class QueryPolicy(StrEnum):
    """What happens at an uncertain decision."""

    NEVER = "never"
    PAUSE = "pause"  # wait for an answer
    MARK = "mark"  # go on, and remember the moment


@dataclass(frozen=True, slots=True)
class Question:
    """An uncertain decision: its time, state and feature vector, and the decision that would be taken.

    `answers` are the states that the decision may lead to, the most likely first.
    `instant` is there if the moment was marked and its body can be rewound: `session.rewind` goes back to it.
    """

    time_s: float
    state: str
    values: tuple[float, ...]
    next: str
    doubt: Uncertainty
    answers: tuple[str, ...] = ()
    instant: SessionSnapshot | None = None

    @property
    def sentence(self) -> str:
        """The question, for a person."""
        if self.doubt.because is DoubtReason.REPEATING:
            return f"{self.doubt.reason}. Where in this round should I do something else?"
        if self.doubt.because is DoubtReason.ELSEWHERE:
            return f"I would go to {self.next}, but {self.doubt.reason}. What is right?"
        does = f"stay in {self.state}" if self.next == self.state else f"go to {self.next}"
        return f"I am not sure: I would {does}, but {self.doubt.reason}. What is right?"


_FIDGETING = Uncertainty(1.0, DoubtReason.FIDGETING, "I switch back and forth here")


class UncertaintyQueries:
    """Uncertain decisions of a session in testing or live teaching.

    `marked` are the moments at which it continued. `unsure` is the doubt from which on it asks; None: the default of
    the session's mode.
    """

    def __init__(
        self, session: Session, when: QueryPolicy = QueryPolicy.PAUSE, *, unsure: float | None = None
    ) -> None:
        self.session, self.when, self._unsure = session, when, unsure
        self.marked: list[Question] = []
        self._asked: set[tuple[str, str]] = set()
        self._for: tuple[object, ...] = ()
        self._last_s = -REST_S
        self._state, self._switches = "", deque[float](maxlen=FIDGETS)

    @property
    def unsure(self) -> float:
        """The doubt from which on it asks, from 0 to 1."""
        if self._unsure is not None:
            return self._unsure
        return UNSURE_LIVE if self.session.mode is Mode.LIVE else UNSURE

    def find_question(self) -> Question | None:
        """Find the question before the next tick that has to be answered; None otherwise.

        A question is not repeated before the lesson changes, since continuing was an answer. Only a robot that repeats
        itself is asked about again, until a whole round was asked about: what is right at one moment of it need not be
        right at another. After a question there are none for REST_S.
        """
        session = self.session
        if self.when is QueryPolicy.NEVER or session.mode is Mode.TRAINING:
            return None
        view = session.view()
        values = tuple(view.features.values())
        fidgets = self._note_state(view)
        self._learn()
        self._repetition.observe(view.time_s, view.state, values)
        rests = 0.0 <= view.time_s - self._last_s < REST_S  # a restarted world has an earlier time
        if view.flag is not None or view.waiting is not None or rests:
            return None
        repeats = self._repetition.find_doubt()
        doubt = _FIDGETING if fidgets else repeats or self._doubts.estimate(view.state, values)
        following = self._doubts.decide(view.state, values)
        is_flag = session.automaton.state(following).flag is not None
        unsure = min(self.unsure, UNSURE_FLAG) if is_flag and self._unsure is None else self.unsure
        if doubt.amount < unsure or self.was_asked(view.state, doubt):
            return None
        self._last_s = view.time_s
        answers = self._doubts.rank_answers(view.state, values)
        question = Question(view.time_s, view.state, values, following, doubt, answers)
        self.note_asked(question)
        if self.when is QueryPolicy.PAUSE:
            return question
        self._mark(question)
        return None

    def was_asked(self, state: str, doubt: Uncertainty) -> bool:
        """Return whether a question was asked in a state for the same reason, and the lesson has not changed since."""
        self._learn()
        if doubt.because is DoubtReason.REPEATING:
            return self._repetition.was_asked_about(state)
        return (state, doubt.reason) in self._asked

    def count_asked_about_repetition(self, state: str) -> int:
        """Return how often it was asked why the robot repeats itself in a state, since the lesson changed."""
        self._learn()
        return self._repetition.count_asked(state)

    def note_asked(self, question: Question) -> None:
        """Note a question that something else has asked, so that it is not repeated either."""
        self._learn()
        if question.doubt.because is DoubtReason.REPEATING:
            self._repetition.note_asked(question.state)
        else:
            self._asked.add((question.state, question.doubt.reason))

    def _note_state(self, view: SessionView) -> bool:
        """Note the present state, and return whether the robot switches back and forth."""
        switches = self._switches
        if switches and view.time_s < switches[-1]:  # another world
            switches.clear()
        if view.state != self._state:
            self._state = view.state
            switches.append(view.time_s)
        return len(switches) == FIDGETS and view.time_s - switches[0] < FIDGETING_S

    def is_still_uncertain(self, question: Question) -> bool:
        """Return whether the decision would still be uncertain, since the lesson may have changed."""
        self._learn()
        if question.doubt.because is DoubtReason.REPEATING:  # not a doubt of one moment
            return self._repetition.count_asked(question.state) > 0
        if question.doubt.because is DoubtReason.FIDGETING:
            return self.was_asked(question.state, question.doubt)
        automaton = self.session.automaton
        if question.state not in automaton.state_names or len(question.values) != len(automaton.features):
            return False
        return self._doubts.estimate(question.state, question.values).amount >= self.unsure

    def _mark(self, question: Question) -> None:
        session = self.session
        instant = session.capture() if is_rewindable(session.body) else None
        self.marked.append(replace(question, instant=instant))
        del self.marked[:-MOST_MARKS]

    def _learn(self) -> None:
        """Learn again if the lesson changed."""
        key = (self.session.examples, self.session.automaton)
        if not self._for or any(new is not old for new, old in zip(key, self._for, strict=True)):
            lesson = self.session.lesson
            self._for, self._doubts = key, UncertaintyModel(lesson, learn(lesson))
            self._asked.clear()
            self._repetition = RepetitionWatch(lesson)
