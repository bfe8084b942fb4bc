"""Unlearning in a session: what a correction came to, and the step that puts suspects in quarantine with it."""

from __future__ import annotations

from functools import cached_property

from understudy.learning.arrays import teaching
from understudy.learning.transitions import learn_state
from understudy.learning.unlearning import Judgement, judge
from understudy.model.example import Example
from understudy.model.lesson import Lesson
from understudy.model.tree import STAY
from understudy.training.edits import counted, quarantined


class Unlearning:
    """One correction: the lesson `before` it and `after`, which holds it. Judged only when somebody asks."""

    def __init__(self, before: Lesson, after: Lesson, correction: Example) -> None:
        self._before, self._after, self._correction = before, after, correction

    @cached_property
    def judgement(self) -> Judgement | None:
        """Where the mistake came from; None where what was learned before decides as the correction shows."""
        if decided(self._before, self._correction) == self._correction.next:
            return None
        return judge(self._after, self._correction)

    def step(self, what: str) -> tuple[Lesson, str]:
        """The lesson after the correction, with suspects in quarantine where it wants that, and what undo calls it."""
        if not self._after.options.unlearning or self.judgement is None or not self.judgement.suspects:
            return self._after, what
        reasons = self.judgement.reasons
        return quarantined(self._after, reasons), f"{what}, {counted('quarantine', len(reasons))}"

    def stands(self, lesson: Lesson) -> bool:
        """Whether the correction is still in the lesson, as it was made."""
        return any(example is self._correction for example in lesson.examples)


def decided(lesson: Lesson, example: Example) -> str:
    """The next state that what is learned from a lesson decides for an example's state and values."""
    examples = teaching(lesson).get(example.state)
    if not examples:
        return example.state
    outcome = learn_state(lesson, example.state, examples).decide(example.values)
    return example.state if outcome == STAY else lesson.automaton.state_names[outcome]
