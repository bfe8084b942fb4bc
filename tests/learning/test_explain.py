"""Who comes by which node of a tree: all at once as one by one."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from tests.learning.lessons import tables, tree_of
from tests.learning.reference import Row

from understudy.learning.explain import find_rows_by_node
from understudy.model.kinds import Kind
from understudy.model.tree import STAY


@settings(deadline=None)
@given(tables(watched=True), tables())
def test_as_each_goes_down_by_itself(
    drawn: tuple[list[Row], list[Kind]], others: tuple[list[Row], list[Kind]]
) -> None:
    """Those of the lesson, and those of another one where that has the same features."""
    rows, kinds = drawn
    tree = tree_of(rows, kinds)
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
    tree = tree_of([Row((), 0, 1), Row((), 1, 1)], [])
    assert [here.tolist() for here in find_rows_by_node(tree, np.zeros((0, 0)))] == [[]]
