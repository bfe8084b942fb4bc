"""Which feature vectors come by each node of a tree, all of them sent down it together."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import Column
from understudy.model.tree import STAY, Node, Test, Tree

Rows = NDArray[np.intp]


def reaching(tree: Tree, values: NDArray[np.float64]) -> list[Rows]:
    """By node, the rows of feature vectors [n, F] that come by it, in order."""
    passing = [np.zeros(len(values), np.bool_) for _ in tree.nodes]
    passing[0][:] = True
    found: list[Rows] = []
    for node, here in zip(tree.nodes, passing, strict=True):  # children come after their parents
        found.append(np.flatnonzero(here))
        if node.test != Test.LEAF:
            rows = found[-1]
            for following, side in _sides(node, values[rows, node.feature]):
                if following != STAY:
                    passing[following][rows[side]] = True
    return found


def _sides(node: Node, column: Column) -> Iterator[tuple[int, NDArray[np.bool_]]]:
    """Each child with those values that lead to it."""
    absent = np.isnan(column)
    if node.test == Test.LABEL:
        yield node.absent, absent
        yield from ((following, column == label) for label, following in enumerate(node.branches))
        return
    if node.test == Test.ABSENT:
        inside = absent
    else:
        yield node.absent, absent
        inside = column < node.high
        if node.test == Test.ARC:
            after = column >= node.low
            inside = after & inside if node.low <= node.high else after | inside
    yield node.yes, inside
    yield node.no, ~inside & ~absent
