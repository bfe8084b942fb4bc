"""Who comes by which node of a tree: all at once as one by one; what is no feature vector of a lesson."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from tests.learning.reference import Row
from tests.make.automata import make_goto
from tests.make.lessons import draw_tables, learn_tree

from understudy.errors import DefinitionError, KindError, UnderstudyError
from understudy.learning.explain import explain, find_rows_by_node
from understudy.model.tree import STAY
from understudy.model.value_kinds import Kind


@given(draw_tables(watched=True), draw_tables())
def test_as_each_goes_down_by_itself(
    drawn: tuple[list[Row], list[Kind]], others: tuple[list[Row], list[Kind]]
) -> None:
    """Those of the lesson, and those of another one where that has the same features."""
    rows, kinds = drawn
    tree = learn_tree(rows, kinds)
    vectors = [row.values for row in rows]
    vectors += [row.values for row in others[0]] if others[1] == kinds else []
    passing: list[list[int]] = [[] for _ in tree.nodes]
    for place, values in enumerate(vectors):
        steps, last = tree.path(values)
        for node in (*(step.node for step in steps), *([] if last == STAY else [last])):
            passing[node].append(place)
    found = find_rows_by_node(tree, np.array(vectors, np.float64).reshape(len(vectors), len(kinds)))
    assert [here.tolist() for here in found] == passing


def test_nobody_comes_by_any() -> None:
    tree = learn_tree([Row((), 0, 1), Row((), 1, 1)], [])
    assert [here.tolist() for here in find_rows_by_node(tree, np.zeros((0, 0)))] == [[]]


GOTO = make_goto()
LESSON = GOTO.lesson
LABELS = [str(bound) for bound in GOTO.automaton.features]


def right() -> list[Any]:
    """A feature vector of the lesson."""
    assert LESSON is not None
    return list(LESSON.examples[0].values)


BAD_VECTORS: dict[str, tuple[Callable[[], Any], type[UnderstudyError], str]] = {
    "short": (lambda: right()[:1], DefinitionError, f"it has 1 values; give {len(LABELS)}: distance_to"),
    "long": (
        lambda: [*right(), 0.0],
        DefinitionError,
        f"it has {len(LABELS) + 1} values; give {len(LABELS)}",
    ),
    "none": (lambda: None, DefinitionError, "it is None; give a list of numbers"),
    "a number": (lambda: 1.0, DefinitionError, r"it is 1\.0; give a list of numbers"),
    "of texts": (lambda: ["near"] * len(LABELS), KindError, "'near' is not a number"),
    "of nothing": (lambda: [None] * len(LABELS), KindError, "None is not a number"),
    "infinite": (lambda: [inf] * len(LABELS), KindError, "inf is not"),
}


@pytest.mark.parametrize(("vector", "error", "said"), BAD_VECTORS.values(), ids=BAD_VECTORS)
def test_a_feature_vector_that_is_none_of_the_lesson(
    vector: Callable[[], Any], error: type[UnderstudyError], said: str
) -> None:
    assert LESSON is not None
    for state, transition in GOTO.automaton.transitions.items():
        with pytest.raises(error, match=said):
            explain(LESSON, state, vector(), transition)


def test_a_feature_vector_of_numpy_is_as_good() -> None:
    assert LESSON is not None
    for example in LESSON.examples:
        transition = GOTO.automaton.transitions[example.state]
        expected = explain(LESSON, example.state, example.values, transition)
        vector = cast("Sequence[float]", np.array(example.values))
        assert explain(LESSON, example.state, vector, transition) == expected
