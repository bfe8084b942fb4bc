"""A lesson's examples as arrays, checked against the features' kinds, and grouped by state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError
from understudy.learning._split_kernels import DEFAULT, SHOWN, WATCHED
from understudy.model.learner_options import SklearnOptions
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.tree import STAY
from understudy.model.value_kinds import Categorical, Kind, Toroidal

GROUPS = {
    ExampleKind.DEFAULT: DEFAULT,
    ExampleKind.DIRECTIVE: SHOWN,
    ExampleKind.CONFIRMATION: SHOWN,
    ExampleKind.WATCHED: WATCHED,
}


@dataclass(frozen=True)
class TrainingSet:
    """The examples of one transition function: feature vectors [n, F], indices of next states [n] and groups [n].

    Groups are DEFAULT, SHOWN (directives and confirmations) and WATCHED. `current` is the index of the state,
    or STAY in a stateless lesson, where the examples belong to all states.
    """

    examples: tuple[Example, ...]
    values: NDArray[np.float64]
    outcomes: NDArray[np.int64]
    groups: NDArray[np.int64]
    current: int


def select_teaching_examples(lesson: Lesson) -> tuple[Example, ...]:
    """Return the examples to learn from: all but those in quarantine and, if the options say so, defaults."""
    learner = lesson.options.learner
    defaults = isinstance(learner, SklearnOptions) or learner.defaults
    return tuple(
        example
        for example in lesson.examples
        if not example.quarantined and (defaults or example.kind is not ExampleKind.DEFAULT)
    )


def identify_teaching(lesson: Lesson, *, with_watched: bool = False) -> tuple[object, ...]:
    """Return a value that is equal for two lessons with the same design, options and presses, whatever their records.

    With `with_watched`, all other examples count, too.
    """
    return (
        lesson.automaton,
        lesson.options,
        [
            (
                each.number,
                each.state,
                each.next,
                each.kind,
                each.correction,
                [None if value != value else value for value in each.values],
                each.quarantined,
            )
            for each in lesson.examples
            if with_watched or each.is_from_press
        ],
    )


def group_examples_by_state(lesson: Lesson) -> dict[str, tuple[Example, ...]]:
    """Return the examples of each state that gets a transition function, by name in declared order.

    Flag states and states without press-made examples get none. In a stateless lesson all states share the
    directives and confirmations of all states (paper section 3.2).
    """
    lasting = [state.name for state in lesson.automaton.states if state.flag is None]
    if lesson.automaton.stateless:
        pool = tuple(
            example
            for example in select_teaching_examples(lesson)
            if example.is_shown and example.state in lasting
        )
        return dict.fromkeys(lasting, pool) if pool else {}
    by_state: dict[str, list[Example]] = {name: [] for name in lesson.automaton.state_names}
    for example in select_teaching_examples(lesson):
        if example.state not in by_state:
            lesson.automaton.index(example.state)  # raises UnknownName
        by_state[example.state].append(example)
    return {
        name: tuple(by_state[name])
        for name in lasting
        if any(example.is_from_press for example in by_state[name])
    }


def make_training_set(lesson: Lesson, examples: tuple[Example, ...], state: str) -> TrainingSet:
    """Convert examples to arrays; refuse values outside a feature's kind, and unknown next states."""
    automaton = lesson.automaton
    indices = {name: index for index, name in enumerate(automaton.state_names)}
    for example in examples:
        if example.next not in indices:
            automaton.index(example.next)  # raises UnknownName
        if len(example.values) != len(automaton.features):
            raise DefinitionError(
                what=_named(lesson, example),
                problem=f"it has {len(example.values)} values",
                remedy=f"give one for each of the {len(automaton.features)} features",
            )
    shape = len(examples), len(automaton.features)
    values = np.array([example.values for example in examples], np.float64).reshape(shape)
    for column, bound in enumerate(automaton.features):
        outside = np.flatnonzero(_outside(values[:, column], bound.kind))
        if len(outside):
            example = examples[outside[0]]
            raise DefinitionError(
                what=_named(lesson, example),
                problem=f"{bound} is {example.values[column]}, which is not {bound.kind}",
                remedy=_remedy(bound.kind),
            )
    return TrainingSet(
        examples,
        values,
        np.array([indices[example.next] for example in examples], np.int64),
        np.array([GROUPS[example.kind] for example in examples], np.int64),
        STAY if automaton.stateless else indices[state],
    )


def _named(lesson: Lesson, example: Example) -> str:
    return f"example {example.number} of lesson {lesson.name!r}"


def _outside(column: NDArray[np.float64], kind: Kind) -> NDArray[np.bool_]:
    if isinstance(kind, Toroidal):
        return (column < 0) | (column >= kind.period)
    if isinstance(kind, Categorical):
        label = np.isin(column, np.arange(len(kind.labels)))
        return ~(label | np.isnan(column))
    return np.isinf(column)


def _remedy(kind: Kind) -> str:
    if isinstance(kind, Toroidal):
        return f"give a number from 0 up to {kind.period!r}, or leave it absent"
    if isinstance(kind, Categorical):
        return f"give the index of one of its labels {', '.join(kind.labels)}, or leave it absent"
    return "give a finite number, or leave it absent"


def group_by_feature_vector(examples: Sequence[Example]) -> dict[tuple[float | None, ...], list[Example]]:
    """Group examples by feature vector, where absent equals absent; absent values are None in the keys."""
    groups: dict[tuple[float | None, ...], list[Example]] = {}
    for example in examples:
        key = tuple(None if value != value else value for value in example.values)
        groups.setdefault(key, []).append(example)
    return groups
