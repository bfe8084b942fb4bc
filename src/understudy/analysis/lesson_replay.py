"""A lesson's recorded moments: what an automaton decides at them, beside what was shown and what a former one decided.

At each press the demonstrator said what is right. In the second before it they let the robot go on, which says less:
what is decided there may change, and that is told, but nothing is called lost.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import UnderstudyError
from understudy.learning.training_set import group_by_feature_vector, select_teaching_examples
from understudy.model.automaton import Automaton
from understudy.model.features import BoundFeature, FlagFeature, TimeInState, TimerFeature
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import TrainedAutomaton
from understudy.model.tree import STAY
from understudy.runtime.feature_columns import read_feature_column
from understudy.training.feature_values import find_own_value

Vector: TypeAlias = tuple[float, ...]
ExampleRows: TypeAlias = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class ReplayedPress:
    """A moment of a press: what the example of this number showed, what is decided now, and what was formerly (None:
    there is no former version, or it cannot be asked).
    """

    number: int
    kind: str
    state: str
    shown: str
    now: str
    formerly: str | None

    @property
    def is_regression(self) -> bool:
        """Whether it was decided as shown, and no longer is."""
        return self.formerly == self.shown != self.now


@dataclass(frozen=True, slots=True)
class DecisionChange:
    """So many moments of the second before presses at which another next state is decided than formerly."""

    state: str
    formerly: str
    now: str
    moments: int


@dataclass(frozen=True, slots=True)
class LessonReplay:
    """An automaton on the moments of its lesson: how many examples say what is right, and how many moments before
    presses there are; the examples decided otherwise than shown or than formerly, and what changed before presses.
    """

    examples: int
    before: int
    different: tuple[ReplayedPress, ...]
    changes: tuple[DecisionChange, ...]

    @property
    def mismatches(self) -> tuple[ReplayedPress, ...]:
        """What is decided otherwise than shown."""
        return tuple(each for each in self.different if each.now != each.shown)

    @property
    def regressions(self) -> tuple[ReplayedPress, ...]:
        """What was decided as shown, and no longer is."""
        return tuple(each for each in self.different if each.is_regression)


def replay_lesson(taught: TrainedAutomaton, former: TrainedAutomaton | None = None) -> LessonReplay:
    """What an automaton decides at the moments of its lesson; nothing of one that was written by hand."""
    lesson = taught.lesson
    if lesson is None:
        return LessonReplay(0, 0, (), ())
    tested = list(_tested(lesson))
    different = [
        each for each in (_decided(example, taught, former) for example in tested) if each is not None
    ]
    before, changes = _before(lesson, taught.automaton, None if former is None else former.automaton)
    return LessonReplay(len(tested), before, tuple(different), changes)


def _tested(lesson: Lesson) -> Iterator[Example]:
    """The examples that say what is right: made by presses, and no automatic default where something was said with
    the very same vector.
    """
    said = {
        (example.state, key)
        for example in select_teaching_examples(lesson)
        if example.is_shown
        for key in group_by_feature_vector([example])
    }
    for example in select_teaching_examples(lesson):
        (key,) = group_by_feature_vector([example])
        default = example.kind is ExampleKind.DEFAULT
        if example.is_from_press and not (
            default and (lesson.automaton.stateless or (example.state, key) in said)
        ):
            yield example


def _decided(
    example: Example, taught: TrainedAutomaton, former: TrainedAutomaton | None
) -> ReplayedPress | None:
    """How a press is decided; None where that is as shown, and as formerly."""
    now = query_next_state(taught.automaton, example.state, example.values)
    formerly = None if former is None else _formerly(example, taught, former.automaton)
    if now == example.next and formerly in (None, now):
        return None
    shown = example.next
    return ReplayedPress(example.number, example.kind.value, example.state, shown, now, formerly)


def _formerly(example: Example, taught: TrainedAutomaton, former: Automaton) -> str | None:
    """What a former automaton decides at the moment of an example; None where it has no such state, or looks at
    something that was not recorded.
    """
    if example.state not in former.state_names or taught.lesson is None:
        return None
    if former.features == taught.automaton.features:
        return query_next_state(former, example.state, example.values)
    if example.moment is None:
        return None
    rows = np.array([example.moment])
    vector = _vectors(former.features, example, taught.lesson, rows)
    return None if vector is None else query_next_state(former, example.state, vector[0])


def query_next_state(automaton: Automaton, state: str, values: Sequence[float]) -> str:
    """The state after a query of a state."""
    function = automaton.transitions.get(state)
    outcome = STAY if function is None else function.decide(values)
    return state if outcome == STAY else automaton.state_names[outcome]


def _before(
    lesson: Lesson, now: Automaton, former: Automaton | None
) -> tuple[int, tuple[DecisionChange, ...]]:
    """How many moments before presses there are that can be replayed, and what changed at them."""
    count, changes = 0, Counter[tuple[str, str, str]]()
    seen: set[int] = set()
    for example in lesson.examples:
        if not example.is_shown or example.moment is None or example.moment in seen:
            continue
        seen.add(example.moment)
        rows = _same_state(example, lesson)
        vectors_now = _vectors(now.features, example, lesson, rows)
        if vectors_now is None:
            continue
        count += len(rows)
        if former is None or example.state not in former.state_names:
            continue
        then = vectors_now
        if former.features != now.features:
            found = _vectors(former.features, example, lesson, rows)
            if found is None:
                continue
            then = found
        for old, new in zip(then, vectors_now, strict=True):
            pair = query_next_state(former, example.state, old), query_next_state(now, example.state, new)
            changes[example.state, *pair] += pair[0] != pair[1]
    found_changes = [DecisionChange(*key, moments) for key, moments in changes.items() if moments]
    return count, tuple(found_changes)


def _same_state(example: Example, lesson: Lesson) -> ExampleRows:
    """The rows of the record before an example's moment at which its state had been entered already."""
    moment = example.moment or 0
    rows: ExampleRows = np.arange(moment - example.window, moment)
    ago = lesson.record.seconds[moment] - lesson.record.seconds[rows]
    there: ExampleRows = rows[ago <= example.own.get("time_in_state", 0.0) + 1e-9]
    return there


def _vectors(
    features: Sequence[BoundFeature], example: Example, lesson: Lesson, rows: ExampleRows
) -> list[Vector] | None:
    """Feature vectors [M] at rows of the record; None where the record or the kit has not what a feature needs.

    What is the automaton's own is as at the press: counters of before it are not recorded, times are. Nor is since when
    a flag had been up, so that before a press with a flag nothing can be replayed.
    """
    record = lesson.record
    percept = {key: record.values[rows, column] for column, key in enumerate(record.keys)}
    ago = record.seconds[example.moment or 0] - record.seconds[rows]
    columns = []
    for bound in features:
        own = find_own_value(bound.feature, example.own)
        if own is not None:
            if isinstance(bound.feature, FlagFeature) and own and ago.any():
                return None
            timed = isinstance(bound.feature, TimerFeature | TimeInState)
            columns.append(own - ago if timed else np.full(len(rows), own))
            continue
        ground = replace(bound, binding=bound.binding.substitute(example.binding))
        try:
            columns.append(read_feature_column(ground, percept, agents=len(rows)))
        except (UnderstudyError, KeyError):
            return None
    return list(zip(*(column.tolist() for column in columns), strict=True)) or [()] * len(rows)
