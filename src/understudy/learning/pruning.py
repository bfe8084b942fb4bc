"""Pruning: remove tests of a tree that classify too few examples correctly, the least useful first.

Weakest-link pruning: Breiman, Friedman, Olshen and Stone, Classification and Regression Trees, 1984, chapter 3. The
worth of a test, with all below it, is how many examples it saves from a wrong decision per leaf that it adds. It is
measured in examples so that people can choose it: with 1, each branch that a single example supports is removed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.learning._split_kernels import WATCHED
from understudy.learning.explain import RowNumbers, find_rows_by_node
from understudy.learning.training_set import TrainingSet
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf

PRESSED, SEEN = 10, 1
"""The weights of press-made and of watched examples; watched ones count a tenth, as in the score of splits."""
SAME = 1e-9


def prune_tree(tree: Tree, training_set: TrainingSet, pruning: float) -> Tree:
    """Prune a tree: remove the tests that save at most `pruning` examples from a wrong decision per leaf they add.

    `training_set` is the one from which the tree was learned.
    """
    for worth, simpler in list_pruning_steps(tree, training_set):
        if worth > pruning + SAME:
            break
        tree = simpler
    return tree


def list_pruning_steps(tree: Tree, training_set: TrainingSet) -> Iterator[tuple[float, Tree]]:
    """Yield, the weakest test first, the worth of the removed test in examples and the tree without it.

    No step is worth less than the one before it; of several equally weak tests the topmost is removed first.
    """
    worth, answers = 0.0, _answers(tree, training_set)
    while len(tree.nodes) > 1:
        weakest = min(_questions(tree, answers), key=lambda each: (each.worth, each.node), default=None)
        if weakest is None:
            return
        tree, remaining = _without(tree, weakest)
        answers = [answers[index] for index in remaining]
        worth = max(worth, weakest.worth)
        yield worth, tree


class _LeafCost(NamedTuple):
    """The outcome that a node would have as a leaf, and the weight of the examples it would then decide wrongly."""

    outcome: int
    wrong: int


class _SplitCost(NamedTuple):
    """A node that could become a leaf: its index, its outcome as a leaf, and the worth of its test."""

    node: int
    outcome: int
    worth: float


def _answers(tree: Tree, training_set: TrainingSet) -> list[_LeafCost | None]:
    """Compute for each node its cost as a leaf; None for a test that no press-made example reaches."""
    weights = np.where(training_set.groups == WATCHED, SEEN, PRESSED)
    costs = []
    for node, here in zip(tree.nodes, find_rows_by_node(tree, training_set.values), strict=True):
        outcome = node.yes if node.test == TestKind.LEAF else _outcome(here, training_set)
        costs.append(
            None
            if outcome is None
            else _LeafCost(outcome, _weigh_wrong(outcome, here, training_set, weights))
        )
    return costs


def _questions(tree: Tree, answers: Sequence[_LeafCost | None]) -> Iterator[_SplitCost]:
    """Yield all tests that some press-made example reaches."""
    leaves, wrong = [1] * len(tree.nodes), [0] * len(tree.nodes)
    for index in reversed(range(len(tree.nodes))):  # children come after their parents
        node, answer = tree.nodes[index], answers[index]
        if node.test == TestKind.LEAF:
            wrong[index] = 0 if answer is None else answer.wrong
            continue
        below = {following for following in _children(node) if following != STAY}
        leaves[index] = sum(leaves[following] for following in below)
        wrong[index] = sum(wrong[following] for following in below)
        if answer is not None:
            lost = answer.wrong - wrong[index]
            yield _SplitCost(index, answer.outcome, lost / PRESSED / max(1, leaves[index] - 1))


def _outcome(rows: RowNumbers, training_set: TrainingSet) -> int | None:
    """Return the outcome of most press-made examples, or None if there is none.

    Of tied outcomes it is that of staying in the state, else that of the state declared first.
    """
    pressed = training_set.outcomes[rows[training_set.groups[rows] != WATCHED]]
    if not len(pressed):
        return None
    counts = np.bincount(pressed.astype(np.intp))
    tied = np.flatnonzero(counts == counts.max()).tolist()
    return training_set.current if training_set.current in tied else int(tied[0])


def _weigh_wrong(
    outcome: int, rows: RowNumbers, training_set: TrainingSet, weights: NDArray[np.int64]
) -> int:
    """Return the weight of the examples whose outcome is another."""
    decided = training_set.current if outcome == STAY else outcome
    return int(weights[rows[training_set.outcomes[rows] != decided]].sum())


def _children(node: Node) -> Sequence[int]:
    return (*node.branches, node.absent) if node.test == TestKind.LABEL else (node.yes, node.no, node.absent)


def _without(tree: Tree, question: _SplitCost) -> tuple[Tree, list[int]]:
    """Replace a test by a leaf; return the tree, and the indices of its former nodes that are left."""
    nodes = list(tree.nodes)
    nodes[question.node] = make_leaf(question.outcome)
    is_left = [False] * len(nodes)
    is_left[0] = True
    for index, node in enumerate(nodes):
        if is_left[index] and node.test != TestKind.LEAF:
            for following in _children(node):
                if following != STAY:
                    is_left[following] = True
    left = [index for index, is_kept in enumerate(is_left) if is_kept]
    place = {STAY: STAY, **{index: number for number, index in enumerate(left)}}
    return Tree(tuple(_moved(nodes[index], place) for index in left)), left


def _moved(node: Node, place: dict[int, int]) -> Node:
    if node.test == TestKind.LEAF:
        return node
    return node._replace(
        yes=place[node.yes],
        no=place[node.no],
        absent=place[node.absent],
        branches=tuple(place[each] for each in node.branches),
    )
