"""Trees as functions: a feature vector in, the index of the next state out."""

from __future__ import annotations

from math import inf, nan
from typing import Any

import numpy as np
import pytest

from understudy.errors import KindError
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import LARGEST

TREE = Tree(
    (
        Node(TestKind.LABEL, feature=1, branches=(1, 2, STAY), absent=3),
        Node(TestKind.BELOW, feature=0, high=0.5, yes=2, no=3, absent=3),
        make_leaf(0),
        make_leaf(1),
    )
)
"""Two features: a number, and one of three labels."""

DECIDED: list[tuple[Any, int]] = [
    ((0.4, 0.0), 0),
    ((0.6, 0.0), 1),
    ((nan, 0.0), 1),
    ([0.6, 1.0], 0),
    (np.array([0.6, 2.0]), STAY),
    ((0.6, nan), 1),
    ((0.6, 1.0, 7.0), 0),  # what it does not ask for may be anything
]


@pytest.mark.parametrize(("values", "outcome"), DECIDED)
def test_decide(values: Any, outcome: int) -> None:
    assert TREE.decide(values) == outcome
    _, leaf = TREE.path(values)
    assert (STAY if leaf == STAY else TREE.nodes[leaf].yes) == outcome


NO_VECTORS: list[tuple[Any, str]] = [
    ((), "feature vector: it has 0 values, and the tree asks for number 2; give one for each feature"),
    ((0.4,), "it has 1 values, and the tree asks for number 2"),
    (None, "it is None; give a list of numbers"),
    (0.4, r"it is 0\.4; give a list of numbers"),
    ({"x": 0.4, "y": 1.0}, "give a list of numbers"),
    (("near", 0.0), "value 1 is 'near'; give a number, or NaN if it is absent"),
    ((None, 0.0), "value 1 is None; give a number"),
    ((0.4, "stuck"), "value 2 is 'stuck'; give a number"),
    ((0.4, 3.0), r"value 2 is 3\.0; give the index of one of 3 labels"),
    ((0.4, 4e9), r"value 2 is 4000000000\.0; give the index of one of 3 labels"),
    (np.zeros((2, 2)), "value 1 is array"),
]


@pytest.mark.parametrize(("values", "said"), NO_VECTORS)
def test_what_is_no_feature_vector(values: Any, said: str) -> None:
    for ask in (TREE.decide, TREE.path):
        with pytest.raises(KindError, match=said):
            ask(values)


def test_what_is_infinite_is_absent() -> None:
    """Whatever a node asks: the one below asks each, and leads elsewhere where the value is absent."""
    leaves = tuple(map(make_leaf, range(4)))
    for node in (
        Node(TestKind.BELOW, 0, high=0.5, yes=1, no=2, absent=3),
        Node(TestKind.ARC, 0, low=-0.5, high=0.5, yes=1, no=2, absent=3),
        Node(TestKind.ARC, 0, low=0.5, high=-0.5, yes=1, no=2, absent=3),
        Node(TestKind.ABSENT, 0, yes=3, no=2),
        Node(TestKind.LABEL, 0, absent=3, branches=(1, 2)),
    ):
        tree = Tree((node, *leaves))
        for value in (inf, -inf, nan):
            assert tree.decide((value,)) == 2  # the leaf at 3
            assert tree.path((value,)) == tree.path((nan,))
        largest = 1.0 if node.test == TestKind.LABEL else LARGEST
        assert tree.decide((largest,)) != 2
