"""Unlearning in a session: the diagnosis of a correction, and the step that puts suspects in quarantine with it."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import replace
from functools import cached_property
from math import isnan
from typing import Self

import numpy as np

from understudy.learning.fit import learn_state
from understudy.learning.mislabels import CorrectionDiagnosis, diagnose_correction
from understudy.learning.training_set import group_examples_by_state
from understudy.model.automaton import name_next_state
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Feature, Percept, ReadingKey
from understudy.model.lesson import Example, ExampleKind, Lesson, ReadingLog
from understudy.runtime.feature_columns import read_feature_column
from understudy.runtime.interpreter import measure_elapsed
from understudy.training.edits import describe_edit, set_quarantine
from understudy.training.feature_values import compute_example_values
from understudy.training.sample_buffer import Sample
from understudy.training.trainee import OwnSwitch, TickResult

SOON_S = 2.0
"""A press within this time after a switch that sends the robot back says that it should not have switched, s."""
UNSEEN_S = 0.2
"""A person does not see a state that lasts at most this long, s."""


class LastSwitch:
    """The last switch that the learned automaton made, and the example that a correction of it would give: to stay.

    States that last at most UNSEEN_S are skipped: switches through them are one, from the state before them.
    """

    def __init__(self, keys: tuple[ReadingKey, ...], steady: frozenset[str]) -> None:
        self._keys, self._steady = keys, steady
        self.clear()

    def clear(self) -> None:
        """Forget the switch: nothing that follows relates to it."""
        self._last: tuple[OwnSwitch, Binding] | None = None
        self._switched_s: float | None = None

    def note_tick(self, result: TickResult, moment: Sample, binding: Binding, *, first: str) -> None:
        """Note a tick without a press; `first` is the state in which the automaton begins."""
        if result.next == result.state:
            return
        switch = OwnSwitch(result.state, result.next, result.own, moment.seconds, moment.values)
        last = self.switch
        if last is not None and last.state not in (first, result.next) and self._is_unseen(moment.seconds):
            switch = replace(last, next=result.next)
        self._last, self._switched_s = (switch, binding), moment.seconds

    def _is_unseen(self, now: float) -> bool:
        """Return whether the state since the last switch was too short to be seen."""
        return self._switched_s is not None and measure_elapsed(now, self._switched_s) <= UNSEEN_S

    @property
    def switch(self) -> OwnSwitch | None:
        """The switch; None if there is none, or it was forgotten."""
        return None if self._last is None else self._last[0]

    def restore(self, switch: OwnSwitch | None, binding: Binding) -> None:
        """Note a switch of before a kill."""
        self._last = None if switch is None else (switch, binding)

    def find_answered(
        self,
        now: float,
        state: str | None,
        *,
        directed: Set[tuple[str, str]],
        late_s: float,
        paused: bool,
        raised: bool,
        appeared: bool = False,
    ) -> OwnSwitch | None:
        """Return the last switch if a press at this time judges it: by taking it back, or since it comes so soon.

        `directed` has the switches, from and to, that were demonstrated. A switch that was demonstrated from the
        present state is meant from there, unless the press comes so soon that it must judge the last switch. So is one
        back from where the behavior has `raised` a flag, if the last switch was demonstrated; and one back after
        something has `appeared` or disappeared since.
        """
        switch = self.switch
        if switch is None or state is None or state == switch.next:  # it confirms where the robot is now
            return None
        passed_s = measure_elapsed(now, switch.seconds)
        is_from_here = (switch.next, state) in directed
        if state == switch.state:
            is_from_here |= appeared or (raised and (switch.state, switch.next) in directed)
            return switch if passed_s <= (late_s if is_from_here else SOON_S) else None
        is_from_here = is_from_here and (switch.state, state) not in directed
        return switch if passed_s <= late_s and not paused and not is_from_here else None

    def has_anything_appeared(self, readings: Sequence[float], features: Sequence[BoundFeature]) -> bool:
        """Return whether a feature of the body was absent at the switch and is present now, or vice versa."""
        if self._last is None:
            return False
        switch, binding = self._last
        ground = [
            BoundFeature(each.feature, each.binding.substitute(binding))
            for each in features
            if isinstance(each.feature, Feature)
        ]
        then, now = (
            [isnan(read_feature_column(each, percept, agents=1)[0]) for each in ground]
            for percept in (self._make_percept(switch.values), self._make_percept(readings))
        )
        return then != now

    def _make_percept(self, readings: Sequence[float]) -> Percept:
        return {key: np.array([value]) for key, value in zip(self._keys, readings, strict=True)}

    def find_undone_stay(self, correction: Example, lesson: Lesson, now: float) -> Example | None:
        """Return the example of staying, if the correction takes the last switch back; otherwise None."""
        if self._last is None:
            return None
        switch, binding = self._last
        back = (correction.state, correction.next) == (switch.next, switch.state)
        if not back or measure_elapsed(now, switch.seconds) > SOON_S:
            return None
        stay = Example(
            correction.number, switch.state, (), switch.state, ExampleKind.CONFIRMATION, correction=True,
            moment=0, own=switch.own, binding=binding,
        )  # fmt: skip
        record = ReadingLog(self._keys, np.array([switch.values]), np.array([switch.seconds]))
        return replace(
            stay, values=compute_example_values(stay, lesson, record, steady=self._steady), moment=None
        )


class CorrectionStep:
    """A correction, with the lesson `before` it and the lesson `after` it. It is diagnosed only on request.

    If it takes back a switch, `stay` is what should have been decided then. This is diagnosed first, since the present
    mistake follows from that one.
    """

    def __init__(
        self, before: Lesson, after: Lesson, correction: Example, stay: Example | None = None
    ) -> None:
        self._before, self._after, self._correction, self._stay = before, after, correction, stay

    @classmethod
    def from_lessons(cls, before: Lesson, after: Lesson, stay: Example | None) -> Self | None:
        """Make the step from the lessons before and after a press; None if the press was not a correction."""
        old = {example.number: example for example in before.examples}
        new_examples = [example for example in after.examples if example.number not in old]
        if not new_examples or not new_examples[0].correction:
            return None
        bare = tuple(old.get(example.number, example) for example in after.examples)
        return cls(before, replace(after, examples=bare), new_examples[0], stay)

    @cached_property
    def diagnosis(self) -> CorrectionDiagnosis | None:
        """The cause of the mistake; None if the lesson before it decides as the correction shows."""
        stay = self._stay
        if stay is not None and decide_for_example(self._before, stay) != stay.next:
            judgement = diagnose_correction(
                replace(self._after, examples=(*self._after.examples, stay)), stay
            )
            if judgement.suspects:
                return judgement
        if decide_for_example(self._before, self._correction) == self._correction.next:
            return None
        return diagnose_correction(self._after, self._correction)

    def step(self, what: str) -> tuple[Lesson, str]:
        """Return the lesson after the correction, with suspects in quarantine if it says so, and its name for undo."""
        if not self._after.options.unlearning or self.diagnosis is None or not self.diagnosis.suspects:
            return self._after, what
        reasons = self.diagnosis.reasons
        return set_quarantine(self._after, reasons), f"{what}, {describe_edit('quarantine', len(reasons))}"

    def is_still_in_lesson(self, lesson: Lesson) -> bool:
        """Return whether the correction is still in the lesson, unchanged."""
        return any(example is self._correction for example in lesson.examples)


def decide_for_example(lesson: Lesson, example: Example) -> str:
    """Return the next state that the automaton learned from a lesson decides for an example's state and values."""
    examples = group_examples_by_state(lesson).get(example.state)
    if not examples:
        return example.state
    outcome = learn_state(lesson, example.state, examples).decide(example.values)
    return name_next_state(lesson.automaton, example.state, outcome)
