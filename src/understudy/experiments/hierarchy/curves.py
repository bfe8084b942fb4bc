"""Learning curves: how often what was taught so far succeeds, as a teaching goes on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from understudy.model.library import Library
from understudy.training.demonstrators.person import Person, Reaction
from understudy.training.demonstrators.teacher import Account, Teacher
from understudy.training.session import Session

Success: TypeAlias = Callable[[Library], float]
"""The share of unseen worlds in which a library succeeds."""

APART = 6
"""So many new examples are waited for between two looks; but what a try or a lesson ends with is looked at, too."""
HELD, WELL = 4, 0.9


@dataclass(frozen=True, slots=True)
class Point:
    """A look at what was learned: after how many examples in all lessons and after how long, s; and its success."""

    examples: int
    seconds: float
    success: float


@dataclass
class Curve:
    """Looks at a teaching whenever something was taught: what its teacher reports to."""

    whole: str
    success: Success
    points: list[Point] = field(default_factory=list)
    teacher: Teacher | None = None

    def person(self, draws: np.random.Generator, reaction: Reaction) -> Person:
        """A person whose every press is looked at."""
        return Watched(draws, reaction, self)

    def pressed(self, session: Session, seconds: float) -> None:
        """Look after a press in the lesson of the whole task, `seconds` since the teacher last settled."""
        if self.teacher is None or session.automaton.name != self.whole:
            return
        accounts = self.teacher.accounts
        examples = sum(account.examples for name, account in accounts.items() if name != self.whole)
        examples += sum(example.pressed for example in session.examples)
        if not self.points or examples - self.points[-1].examples >= APART:
            passed = round(seconds + sum(account.seconds for account in accounts.values()), 1)
            library = self.teacher.library.with_taught(session.taught())
            self.points.append(Point(examples, passed, self.success(library)))

    def look(self, name: str, what: str, account: Account) -> None:
        """Judge what was learned so far, if the automaton that does the whole task is among it."""
        if self.teacher is None or self.whole not in self.teacher.library.taught:
            return
        accounts = self.teacher.accounts.values()
        examples = sum(account.examples for account in accounts)
        new = not self.points or examples > self.points[-1].examples
        if (new and what == "enough") or what == "learned":
            seconds = round(sum(account.seconds for account in accounts), 1)
            self.points.append(Point(examples, seconds, self.success(self.teacher.library)))


class Watched(Person):
    """A person whose presses are looked at as they act."""

    def __init__(self, draws: np.random.Generator, reaction: Reaction, curve: Curve) -> None:
        super().__init__(draws, reaction)
        self._curve = curve
        self._looked = 0

    def _consider(self, session: Session, wished: str | None, now: float) -> None:
        if self.presses != self._looked:  # the last press has acted, or was settled and counting began anew
            self._looked = self.presses
            self._curve.pressed(session, self.seconds)
        super()._consider(session, wished, now)


def needed(successes: Sequence[float]) -> int | None:
    """The first of the looks from which success is 90 % or more four times in a row; None where there is none.

    After its last look a teaching is over: what was learned then stays, and counts on.
    """
    well = [success >= WELL for success in successes]
    if not well:
        return None
    well += [well[-1]] * (HELD - 1)
    starts = (first for first in range(len(successes)) if all(well[first : first + HELD]))
    return next(starts, None)


def success_at(points: Sequence[Sequence[float]], upto: float, what: int) -> float:
    """Success after so many examples (`what` 0) or seconds (1): that of the last look by then, 0 before the first."""
    before = [point[2] for point in points if point[what] <= upto]
    return before[-1] if before else 0.0
