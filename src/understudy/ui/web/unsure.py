"""Moments at which the robot was unsure and went on: numbered for pages, each with the run it was in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from understudy.coaching.queries import Asking, Question
from understudy.errors import SessionError
from understudy.model.example import Example
from understudy.ui.controller.coach import Coach
from understudy.ui.web.views.scene import Plain


@dataclass(frozen=True, slots=True)
class Mark:
    """A question that was not waited at; `run` is the number of its run, None where that was left for another."""

    number: int
    question: Question
    run: int | None

    @property
    def plain(self) -> Plain:
        """For a page."""
        question = self.question
        return {
            "number": self.number,
            "time_s": question.time_s,
            "run": self.run,
            "sentence": question.sentence,
        }


class Unsure:
    """The marks of one desk, oldest first."""

    def __init__(self) -> None:
        self._marks: tuple[Mark, ...] = ()
        self._open: tuple[Mark, ...] = ()
        self._for: tuple[Sequence[Example], tuple[Mark, ...]] = (), ()
        self._number, self._run, self._now = 0, 0, 0.0

    def see(self, marked: Sequence[Question], run: int, now: float) -> None:
        """A tick passed. Where time went back before, what came after is in no run any more."""
        if run == self._run and now < self._now:
            self._marks = tuple(
                replace(mark, run=None) if mark.run == run and mark.question.time_s >= now else mark
                for mark in self._marks
            )
        self._run, self._now = run, now
        if marked and (not self._marks or marked[-1] is not self._marks[-1].question):
            self._number += 1
            self._marks = (*self._marks, Mark(self._number, marked[-1], run))[-len(marked) :]

    def plain(self, coach: Coach) -> Plain:
        """What it does where it is unsure, the question that waits, and the marks at which it would still be unsure."""
        question = coach.question
        asked = None if question is None else {"sentence": question.sentence, "next": question.next}
        return {
            "when": coach.asking.when.value,
            "question": asked,
            "marks": [mark.plain for mark in self._still(coach.asking)],
        }

    def _still(self, asking: Asking) -> tuple[Mark, ...]:
        """Those at which it would be unsure now, too."""
        examples, marks = asking.session.examples, self._marks
        if examples is not self._for[0] or marks is not self._for[1]:
            self._for = examples, marks
            self._open = tuple(mark for mark in marks if asking.still(mark.question))
        return self._open

    def of(self, number: int) -> Mark:
        """The mark of a number; SessionError where there is none."""
        for mark in self._marks:
            if mark.number == number:
                return mark
        raise SessionError(f"no moment {number} is marked any more")
