"""Learning curves: how often what was taught so far succeeds, as a teaching goes on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from understudy.model.library import Library
from understudy.training.demonstrators.teacher import Account, Teacher

Success: TypeAlias = Callable[[Library], float]
"""The share of unseen worlds in which a library succeeds."""

APART = 6
"""So many new examples are waited for between two looks; but a try that went well is always looked at."""
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

    def look(self, name: str, what: str, account: Account) -> None:
        """Judge what was learned so far, if the automaton that does the whole task is among it."""
        if self.teacher is None or self.whole not in self.teacher.library.taught:
            return
        accounts = self.teacher.accounts.values()
        examples = sum(account.examples for account in accounts)
        grown = examples - self.points[-1].examples if self.points else APART
        if grown >= APART or what in ("enough", "learned"):
            seconds = round(sum(account.seconds for account in accounts), 1)
            self.points.append(Point(examples, seconds, self.success(self.teacher.library)))


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


def at(points: Sequence[Point], examples: float) -> float:
    """Success after so many examples: that of the last look before; nothing where there was none."""
    before = [point.success for point in points if point.examples <= examples]
    return before[-1] if before else 0.0
