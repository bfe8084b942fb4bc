"""Replay of a lesson's recorded moments, to compare decisions with the demonstrator's and with a former version's.

At each press the demonstrator said which decision is right. In the second before the press they only let the robot
continue, so a different decision there is reported as a change and not as a regression.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import UnderstudyError
from understudy.learning.report import find_overruled
from understudy.learning.training_set import group_by_feature_vector, select_teaching_examples
from understudy.model.automaton import Automaton, query_next_state
from understudy.model.features import BoundFeature, FlagFeature, TimeInState, TimerFeature
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.library import TrainedAutomaton
from understudy.runtime.feature_columns import read_feature_column
from understudy.training.feature_values import find_own_value

Vector: TypeAlias = tuple[float, ...]
ExampleRows: TypeAlias = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class ReplayedPress:
    """The decisions at the moment of a press.

    `shown` is the next state in the example of this `number`, `now` that of the automaton, and `formerly` that of the
    former version; `formerly` is None if there is no former version or it cannot decide there.
    """

    number: int
    kind: str
    state: str
    shown: str
    now: str
    formerly: str | None

    @property
    def is_regression(self) -> bool:
        """True if the former version decided as shown and the current one does not."""
        return self.formerly == self.shown != self.now


@dataclass(frozen=True, slots=True)
class DecisionChange:
    """A number of moments in the second before presses at which the next state differs from the former version's."""

    state: str
    formerly: str
    now: str
    moments: int


@dataclass(frozen=True, slots=True)
class LessonReplay:
    """The decisions of an automaton at the recorded moments of its lesson.

    `examples` is the number of examples that were compared, and `before` the number of moments in the second before
    presses that could be replayed. `different` has the examples decided otherwise than shown or than formerly,
    `changes` the other moments that a former version decides otherwise. Of the `watched` examples, `overruled` are
    those in which the robot now decides otherwise than it did while the demonstrator watched.
    """

    examples: int
    before: int
    different: tuple[ReplayedPress, ...]
    changes: tuple[DecisionChange, ...]
    watched: int = 0
    overruled: int = 0

    @property
    def mismatches(self) -> tuple[ReplayedPress, ...]:
        """The examples whose decision differs from what the demonstrator showed."""
        return tuple(each for each in self.different if each.now != each.shown)

    @property
    def regressions(self) -> tuple[ReplayedPress, ...]:
        """The examples that the former version decided as shown and the current one does not."""
        return tuple(each for each in self.different if each.is_regression)


def replay_lesson(taught: TrainedAutomaton, former: TrainedAutomaton | None = None) -> LessonReplay:
    """Compute an automaton's decisions at the recorded moments of its lesson.

    The result is empty if the automaton was written by hand. With a `former` version, its decisions are compared.
    """
    lesson = taught.lesson
    if lesson is None:
        return LessonReplay(0, 0, (), ())
    tested = list(_tested(lesson))
    different = [
        each for each in (_decided(example, taught, former) for example in tested) if each is not None
    ]
    before, changes = _before(lesson, taught.automaton, None if former is None else former.automaton)
    watched = sum(example.kind is ExampleKind.WATCHED for example in select_teaching_examples(lesson))
    overruled = sum(
        len(find_overruled(lesson, state, function))
        for state, function in taught.automaton.transitions.items()
    )
    return LessonReplay(len(tested), before, tuple(different), changes, watched, overruled)


def _tested(lesson: Lesson) -> Iterator[Example]:
    """Yield the press-made examples with which decisions are compared.

    An automatic default is skipped in a stateless lesson, and if a directive or confirmation has the same state and
    feature vector.
    """
    decided = {
        (example.state, key)
        for example in select_teaching_examples(lesson)
        if example.is_shown
        for key in group_by_feature_vector([example])
    }
    for example in select_teaching_examples(lesson):
        (key,) = group_by_feature_vector([example])
        default = example.kind is ExampleKind.DEFAULT
        if example.is_from_press and not (
            default and (lesson.automaton.stateless or (example.state, key) in decided)
        ):
            yield example


def _decided(
    example: Example, taught: TrainedAutomaton, former: TrainedAutomaton | None
) -> ReplayedPress | None:
    """Return the decisions at the moment of a press, or None if they equal what was shown and the former decision."""
    now = query_next_state(taught.automaton, example.state, example.values)
    formerly = None if former is None else _formerly(example, taught, former.automaton)
    if now == example.next and formerly in (None, now):
        return None
    return ReplayedPress(example.number, example.kind.value, example.state, example.next, now, formerly)


def _formerly(example: Example, taught: TrainedAutomaton, former: Automaton) -> str | None:
    """Return the decision of a former version at the moment of an example.

    It is None if that version has no such state, or needs a feature that was not recorded.
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


def _before(
    lesson: Lesson, now: Automaton, former: Automaton | None
) -> tuple[int, tuple[DecisionChange, ...]]:
    """Count the moments before presses that can be replayed, and list the decisions that changed at them."""
    count, changes = 0, Counter[tuple[str, str, str]]()
    replayed: set[int] = set()
    for example in lesson.examples:
        if not example.is_shown or example.moment is None or example.moment in replayed:
            continue
        replayed.add(example.moment)
        rows = _same_state(example, lesson)
        vectors_now = _vectors(now.features, example, lesson, rows)
        if vectors_now is None:
            continue
        count += len(rows)
        if former is None or example.state not in former.state_names:
            continue
        then = vectors_now
        if former.features != now.features:
            former_vectors = _vectors(former.features, example, lesson, rows)
            if former_vectors is None:
                continue
            then = former_vectors
        for old, new in zip(then, vectors_now, strict=True):
            pair = query_next_state(former, example.state, old), query_next_state(now, example.state, new)
            changes[example.state, *pair] += pair[0] != pair[1]
    found_changes = [DecisionChange(*key, moments) for key, moments in changes.items() if moments]
    return count, tuple(found_changes)


def _same_state(example: Example, lesson: Lesson) -> ExampleRows:
    """Return the rows of the record in an example's window at which the automaton was already in the same state."""
    moment = example.moment or 0
    rows: ExampleRows = np.arange(moment - example.window, moment)
    ago = lesson.record.seconds[moment] - lesson.record.seconds[rows]
    there: ExampleRows = rows[ago <= example.own.get("time_in_state", 0.0) + 1e-9]
    return there


def _vectors(
    features: Sequence[BoundFeature], example: Example, lesson: Lesson, rows: ExampleRows
) -> list[Vector] | None:
    """Compute feature vectors [M] at rows of the record; return None if a feature's readings were not recorded.

    Counters have their values at the press, because earlier ones are not recorded; times are computed. Since when a
    flag had been raised is not recorded either, so the moments before a press with a raised flag cannot be replayed.
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
