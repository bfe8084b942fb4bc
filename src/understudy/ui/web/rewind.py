"""The last minutes of a run, to which it can be rewound, and the moments with uncertain decisions."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from understudy.coaching.questions import QueryPolicy, Question, UncertaintyQueries
from understudy.errors import SessionError
from understudy.model.lesson import Example
from understudy.training.other_agents import SessionSnapshot
from understudy.training.session import Session
from understudy.ui.controller.coach import CoachController
from understudy.ui.web.messages.base import Data

EVERY_S = 0.5
KEPT_S = 300.0
"""How long a moment is stored, s of the world's time."""
MOST_BYTES = 64 * 1024 * 1024
"""The greatest size of all stored moments together; fewer moments of a large world fit."""


class RunData(Data, frozen=True, kw_only=True):
    """A run of the world, with the earliest time (s) that can be rewound to."""

    number: int
    from_s: float


class RewindPoint(NamedTuple):
    """A moment of a run: its time (s of the world), its snapshot, and the size of the snapshot (bytes)."""

    time_s: float
    instant: SessionSnapshot
    size: int


class RewindBuffer:
    """The stored moments of one run of a session, oldest first."""

    def __init__(self) -> None:
        self._frames: deque[RewindPoint] = deque()
        self._size = 0
        self._examples: Sequence[Example] | None = None
        self._shown: dict[tuple[int, int | None], float | None] = {}  # when; None: not in this run

    def append(self, session: Session) -> None:
        """Store the present moment if it is due; drop moments at or after its time, which a rewind left behind."""
        now = session.body.time_s
        while self._frames and self._frames[-1].time_s >= now:
            self._size -= self._frames.pop().size
        self._note(session.examples, now)
        if self._frames and now < self._frames[-1].time_s + EVERY_S - session.body.tick_s / 2:
            return
        instant = session.capture()
        frame = RewindPoint(now, instant, len(instant.body))
        self._frames.append(frame)
        self._size += frame.size
        while len(self._frames) > 1 and (self._frames[0].time_s < now - KEPT_S or self._size > MOST_BYTES):
            self._size -= self._frames.popleft().size

    def _note(self, examples: Sequence[Example], now: float | None) -> None:
        if examples is self._examples:
            return
        self._examples = examples
        times = self._shown
        self._shown = {each: times.get(each, now) for each in map(_which, examples)}

    def find_before_time(self, time_s: float) -> RewindPoint:
        """Return the last stored moment before a time (s), or the first one; SessionError if none is stored."""
        if not self._frames:
            raise SessionError("there is nothing to go back to yet: let the run continue for a moment")
        times = [frame.time_s for frame in self._frames]
        return self._frames[max(0, bisect_right(times, time_s + 1e-9) - 1)]

    def find_before_example(self, number: int) -> RewindPoint | None:
        """Return the stored moment before an example was given; None if it is not stored or belongs to another run."""
        time_s = next((time for (each, _), time in self._shown.items() if each == number), None)
        if time_s is None:
            return None
        frame = self.find_before_time(time_s - EVERY_S)
        return frame if frame.time_s <= time_s else None

    def clear(self, examples: Sequence[Example]) -> None:
        """Begin a new run; `examples` are those given before it."""
        self._frames.clear()
        self._size = 0
        self._shown, self._examples = {}, None
        self._note(examples, None)


def _which(example: Example) -> tuple[int, int | None]:
    """Return a key that distinguishes an example from an undone one with the same number."""
    return example.number, example.moment


class QuestionData(Data, frozen=True, kw_only=True):
    """The question that waits for an answer, the proposed next state, and the states to choose from, likely first."""

    sentence: str
    next: str
    answers: list[str]


class UnsureMarkData(Data, frozen=True, kw_only=True):
    """A moment at which the automaton was uncertain and continued."""

    number: int
    time_s: float
    run: int | None
    """The number of the run; null if that run was left."""
    sentence: str


class QueryStatusData(Data, frozen=True, kw_only=True):
    """The query policy, the question that waits, and the marked moments at which the automaton is still uncertain."""

    policy: QueryPolicy
    question: QuestionData | None
    marks: list[UnsureMarkData]


@dataclass(frozen=True, slots=True)
class UncertainMoment:
    """A marked question that did not pause the run; `run` is the number of its run, None if that run was left."""

    number: int
    question: Question
    run: int | None

    @property
    def data(self) -> UnsureMarkData:
        """The marked moment as the page shows it."""
        return UnsureMarkData.of(self.question, number=self.number, run=self.run)


class UncertainMoments:
    """The moments of a session that were marked because the automaton was uncertain, oldest first."""

    def __init__(self) -> None:
        self._marks: tuple[UncertainMoment, ...] = ()
        self._open: tuple[UncertainMoment, ...] = ()
        self._for: tuple[Sequence[Example], tuple[UncertainMoment, ...]] = (), ()
        self._number, self._run, self._now = 0, 0, 0.0

    def update(self, marked: Sequence[Question], run: int, now: float) -> None:
        """Add a newly marked question; detach the marks that a rewind left behind from their run."""
        if run == self._run and now < self._now:
            self._marks = tuple(
                replace(mark, run=None) if mark.run == run and mark.question.time_s >= now else mark
                for mark in self._marks
            )
        self._run, self._now = run, now
        if marked and (not self._marks or marked[-1] is not self._marks[-1].question):
            self._number += 1
            self._marks = (*self._marks, UncertainMoment(self._number, marked[-1], run))[-len(marked) :]

    def data(self, coach: CoachController) -> QueryStatusData:
        """Return the query policy, the waiting question and the open marks as the page shows them."""
        question = coach.question
        marks = [mark.data for mark in self._still(coach.asking)]
        pending = None if question is None else QuestionData.of(question)
        return QueryStatusData(policy=coach.asking.when, question=pending, marks=marks)

    def _still(self, asking: UncertaintyQueries) -> tuple[UncertainMoment, ...]:
        """Return the marked moments at which the present automaton would still be uncertain."""
        examples, marks = asking.session.examples, self._marks
        if examples is not self._for[0] or marks is not self._for[1]:
            self._for = examples, marks
            self._open = tuple(mark for mark in marks if asking.is_still_uncertain(mark.question))
        return self._open

    def find(self, number: int) -> UncertainMoment:
        """Return the mark with a number; SessionError if there is none."""
        for mark in self._marks:
            if mark.number == number:
                return mark
        raise SessionError(f"moment {number} is no longer marked")
