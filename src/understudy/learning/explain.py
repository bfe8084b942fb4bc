"""Explanations of decisions: the conditions that were fulfilled, and the examples with the same decision."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, KindError, join_names
from understudy.learning.training_set import group_examples_by_state
from understudy.model.automaton import Automaton, Transition, name_next_state
from understudy.model.describe import list_shown_vectors as vectors_shown
from understudy.model.lesson import Example, Lesson
from understudy.model.tree import STAY, Node, PathStep, TestKind, Tree
from understudy.model.tree_text import describe_path
from understudy.model.value_kinds import Column


@dataclass(frozen=True, slots=True)
class Explanation:
    """The explanation of one decision, as `explain` returns it.

    Parameters
    ----------
    state
        Name of the state in which the decision was made.
    next
        Name of the next state; equal to `state` if the automaton stays.
    conditions
        The conditions that were fulfilled, as text. Empty without a tree.
    examples
        The examples that reach the same leaf of the tree.
    shown
        False if no example was ever given for such a feature vector, so that the state is kept.
    """

    state: str
    next: str
    conditions: tuple[str, ...] = ()
    examples: tuple[Example, ...] = ()
    shown: bool = False

    def __str__(self) -> str:
        why = f" because {' and '.join(self.conditions)}" if self.conditions else ""
        if not self.shown:
            return f"stays in {self.state}{why}; there are no examples there"
        return f"{'stays in' if self.next == self.state else 'goes to'} {self.next}{why}"


def explain(
    lesson: Lesson, state: str, values: Sequence[float], transition: Transition | None
) -> Explanation:
    """Explain how an automaton decides in a state for a feature vector.

    Parameters
    ----------
    lesson
        The lesson from which `transition` was learned.
    state
        Name of the state.
    values
        Feature vector: a number for each of the lesson's features; NaN if absent, the index of a label if
        categorical.
    transition
        The state's transition function. None if it has none, so that the state is kept.

    Returns
    -------
    Explanation
        The decision, the conditions and the examples. For a classifier of scikit-learn only the decision is known.

    Raises
    ------
    UnknownName
        If the automaton has no such state.
    DefinitionError
        If `values` is no list, or does not have one number for each feature.
    KindError
        If a value is no number, or is outside its feature's kind.

    Examples
    --------
    >>> from understudy import Automaton, BoundFeature, Continuous, Feature, Lesson
    >>> distance = BoundFeature(Feature("distance", Continuous(), reading="distance", unit="m"))
    >>> print(explain(Lesson(Automaton("approach", features=(distance,))), "start", [0.5], None))
    stays in start; there are no examples there
    """
    automaton = lesson.automaton
    automaton.index(state)
    values = _check_vector(automaton, values)
    if transition is None:
        return Explanation(state, state)
    outcome = transition.decide(values)
    following = name_next_state(automaton, state, outcome)
    if not isinstance(transition, Tree):
        return Explanation(state, following, shown=True)
    return _explain_path(lesson, state, transition, *transition.path(values))


def explain_leaf(lesson: Lesson, state: str, tree: Tree, leaf: int) -> Explanation:
    """Explain the decisions that end at a leaf of a state's tree, given the index of its node; -1 if at none.

    Of several ways to the leaf, the conditions are those of the first.
    """
    if leaf == STAY:
        return Explanation(state, state)
    steps = next((steps for steps, at in tree.leaves() if at == leaf), ())
    return _explain_path(lesson, state, tree, steps, leaf)


def _explain_path(
    lesson: Lesson, state: str, tree: Tree, steps: tuple[PathStep, ...], leaf: int
) -> Explanation:
    """Explain a decision by its way through the tree."""
    outcome = STAY if leaf == STAY else tree.nodes[leaf].yes
    following = name_next_state(lesson.automaton, state, outcome)
    alike = tuple(
        example
        for example in group_examples_by_state(lesson).get(state, ())
        if leaf != STAY and tree.path(example.values)[1] == leaf
    )
    held = describe_path(tree, steps, lesson.automaton.features, vectors_shown(lesson, state))
    return Explanation(state, following, held, alike, shown=leaf != STAY)


def _check_vector(automaton: Automaton, values: Sequence[float]) -> tuple[float, ...]:
    """Convert a feature vector to floats; refuse one that does not fit the automaton's features."""
    labels, what = [str(bound) for bound in automaton.features], "feature vector"
    if isinstance(values, str | Mapping) or not hasattr(values, "__len__"):
        problem = f"it is {values!r:.60}"
        raise DefinitionError(what=what, problem=problem, remedy="give a list of numbers")
    if len(values) != len(labels):
        remedy = f"give {len(labels)}: {join_names(labels)}"
        raise DefinitionError(what=what, problem=f"it has {len(values)} values", remedy=remedy)
    for label, value in zip(labels, values, strict=True):
        if not isinstance(value, Real):
            problem, remedy = f"{value!r:.60} is not a number", "give a number, or NaN if it is absent"
            raise KindError(where=f"{what}, {label}", problem=problem, remedy=remedy)
    return tuple(
        bound.kind.check(float(value), where=f"{what}, {label}")
        for bound, label, value in zip(automaton.features, labels, values, strict=True)
    )


RowNumbers = NDArray[np.intp]


def find_rows_by_node(tree: Tree, values: NDArray[np.float64]) -> list[RowNumbers]:
    """Return for each node the rows of the feature vectors [n, F] that pass it, in order."""
    passing = [np.zeros(len(values), np.bool_) for _ in tree.nodes]
    passing[0][:] = True
    rows_by_node: list[RowNumbers] = []
    for node, here in zip(tree.nodes, passing, strict=True):  # children come after their parents
        rows_by_node.append(np.flatnonzero(here))
        if node.test != TestKind.LEAF:
            rows = rows_by_node[-1]
            for following, side in _sides(node, values[rows, node.feature]):
                if following != STAY:
                    passing[following][rows[side]] = True
    return rows_by_node


def _sides(node: Node, column: Column) -> Iterator[tuple[int, NDArray[np.bool_]]]:
    """Yield each child of a node with a mask of the values that lead to it."""
    absent = np.isnan(column)
    if node.test == TestKind.LABEL:
        yield node.absent, absent
        yield from ((following, column == label) for label, following in enumerate(node.branches))
        return
    if node.test == TestKind.ABSENT:
        inside = absent
    else:
        yield node.absent, absent
        inside = column < node.high
        if node.test == TestKind.ARC:
            after = column >= node.low
            inside = after & inside if node.low <= node.high else after | inside
    yield node.yes, inside
    yield node.no, ~inside & ~absent
