"""Learning curves: the success of what was learned so far, measured repeatedly during a teaching."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from understudy.model.library import Library
from understudy.training.session import Session
from understudy_lab.teachers.person import ReactionTime, SimulatedPerson
from understudy_lab.teachers.teacher import ScriptedTeacher, TeachingCost

Success: TypeAlias = Callable[[Library, int], float]
"""The share of unseen worlds in which a library succeeds; the number of earlier measurements selects the worlds."""

APART = 6
"""The number of new examples between two measurements; the lesson after a successful try is measured, too."""
HELD, WELL = 4, 0.9


@dataclass(frozen=True, slots=True)
class CurvePoint:
    """A measurement during a teaching: examples in all lessons, time in s, and success so far."""

    examples: int
    seconds: float
    success: float


@dataclass
class LearningCurve:
    """The measurements of one teaching, made whenever its teacher reports something new."""

    whole: str
    success: Success
    points: list[CurvePoint] = field(default_factory=list)
    teacher: ScriptedTeacher | None = None

    def person(self, draws: np.random.Generator, reaction: ReactionTime) -> SimulatedPerson:
        """Return a person whose presses cause measurements."""
        return ObservedPerson(draws, reaction, self)

    def pressed(self, session: Session, seconds: float) -> None:
        """Measure after a press in the lesson of the whole task, `seconds` after the accounts were last updated."""
        if self.teacher is None or session.automaton.name != self.whole:
            return
        accounts = self.teacher.accounts
        examples = sum(account.examples for name, account in accounts.items() if name != self.whole)
        examples += sum(example.is_from_press for example in session.examples)
        if not self.points or examples - self.points[-1].examples >= APART:
            seconds += sum(account.seconds for account in accounts.values())
            self._look(
                self.teacher.library.with_automaton(session.make_trained_automaton()), examples, seconds
            )

    def went(self, name: str, what: str, account: TeachingCost) -> None:
        """Measure after a successful try, if there are new examples and the automaton of the whole task exists."""
        if what != "enough" or self.teacher is None or self.whole not in self.teacher.library.taught:
            return
        if not self.points or self._said(self.teacher) > self.points[-1].examples:
            self._look_at(self.teacher)

    def held(self, name: str) -> bool:
        """Measure a finished automaton until a test fails or four in a row succeed, and return whether four did.

        For an automaton that is only a part of the task, return True without a measurement.
        """
        if self.teacher is None or name != self.whole:
            return True
        while self._look_at(self.teacher) >= WELL and find_first_success(self.successes) is None:
            pass
        return find_first_success(self.successes) is not None

    @property
    def successes(self) -> list[float]:
        """The success at each measurement."""
        return [point.success for point in self.points]

    def _look_at(self, teacher: ScriptedTeacher) -> float:
        seconds = sum(account.seconds for account in teacher.accounts.values())
        return self._look(teacher.library, self._said(teacher), seconds)

    def _look(self, library: Library, examples: int, seconds: float) -> float:
        success = self.success(library, len(self.points))
        self.points.append(CurvePoint(examples, round(seconds, 1), success))
        return success

    @staticmethod
    def _said(teacher: ScriptedTeacher) -> int:
        return sum(account.examples for account in teacher.accounts.values())


class ObservedPerson(SimulatedPerson):
    """A person whose presses cause measurements of the learning curve."""

    def __init__(self, draws: np.random.Generator, reaction: ReactionTime, curve: LearningCurve) -> None:
        super().__init__(draws, reaction)
        self._curve = curve
        self._looked = 0

    def _consider(self, session: Session, wished: str | None, now: float) -> None:
        if self.presses != self._looked:  # the last press has acted, or was settled and counting began again
            self._looked = self.presses
            self._curve.pressed(session, self.seconds)
        super()._consider(session, wished, now)


def find_first_success(successes: Sequence[float]) -> int | None:
    """Return the index of the first of four measurements in a row with at least 90 % success, or None."""
    well = [success >= WELL for success in successes]
    starts = (first for first in range(len(well) - HELD + 1) if all(well[first : first + HELD]))
    return next(starts, None)


def success_at(points: Sequence[Sequence[float]], upto: float, what: int) -> float:
    """Return the last success measured by `upto` examples (`what` 0) or seconds (1); 0 before the first."""
    before = [point[2] for point in points if point[what] <= upto]
    return before[-1] if before else 0.0
