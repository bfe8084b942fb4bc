"""Pruning: questions of a tree taken back that set too few examples right, the least useful first.

Weakest-link pruning: Breiman, Friedman, Olshen and Stone, Classification and Regression Trees, 1984, chapter 3. What a
question and all below it are worth is how many examples they set right for each leaf that they add. Its units are
examples, so that people can say how much a leaf must be worth: with 1, whatever is held up by one example goes.
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
"""What an example weighs: watched ones count a tenth, as in the score of splits."""
SAME = 1e-9


def prune_tree(tree: Tree, shown: TrainingSet, pruning: float) -> Tree:
    """The tree without the questions whose leaves do not each set more than `pruning` examples right."""
    for worth, simpler in list_pruning_steps(tree, shown):
        if worth > pruning + SAME:
            break
        tree = simpler
    return tree


def list_pruning_steps(tree: Tree, shown: TrainingSet) -> Iterator[tuple[float, Tree]]:
    """The tree pruned step by step, the weakest question first: what it was worth, in examples, and what is left.

    No step is worth less than the one before it; of several equally weak questions the topmost goes first.
    """
    worth, answers = 0.0, _answers(tree, shown)
    while len(tree.nodes) > 1:
        weakest = min(_questions(tree, answers), key=lambda each: (each.worth, each.node), default=None)
        if weakest is None:
            return
        tree, kept = _without(tree, weakest)
        answers = [answers[index] for index in kept]
        worth = max(worth, weakest.worth)
        yield worth, tree


class _LeafCost(NamedTuple):
    """What a node answers as a leaf, and the weight of the examples that show something else."""

    outcome: int
    wrong: int


class _SplitCost(NamedTuple):
    """A node that could become a leaf: with which outcome, and what it and those below it are worth."""

    node: int
    outcome: int
    worth: float


def _answers(tree: Tree, shown: TrainingSet) -> list[_LeafCost | None]:
    """By node; None for a question at which nothing was pressed."""
    weights = np.where(shown.groups == WATCHED, SEEN, PRESSED)
    found = []
    for node, here in zip(tree.nodes, find_rows_by_node(tree, shown.values), strict=True):
        outcome = node.yes if node.test == TestKind.LEAF else _outcome(here, shown)
        found.append(
            None if outcome is None else _LeafCost(outcome, _weigh_wrong(outcome, here, shown, weights))
        )
    return found


def _questions(tree: Tree, answers: Sequence[_LeafCost | None]) -> Iterator[_SplitCost]:
    """All questions at which something was pressed."""
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


def _outcome(rows: RowNumbers, shown: TrainingSet) -> int | None:
    """What most press-made examples show; a tie stays, or is what is declared first. None where nothing was pressed."""
    pressed = shown.outcomes[rows[shown.groups[rows] != WATCHED]]
    if not len(pressed):
        return None
    counts = np.bincount(pressed)
    tied = np.flatnonzero(counts == counts.max()).tolist()
    return shown.current if shown.current in tied else int(tied[0])


def _weigh_wrong(outcome: int, rows: RowNumbers, shown: TrainingSet, weights: NDArray[np.int64]) -> int:
    """The weight of the examples that show something else."""
    decided = shown.current if outcome == STAY else outcome
    return int(weights[rows[shown.outcomes[rows] != decided]].sum())


def _children(node: Node) -> Sequence[int]:
    return (*node.branches, node.absent) if node.test == TestKind.LABEL else (node.yes, node.no, node.absent)


def _without(tree: Tree, question: _SplitCost) -> tuple[Tree, list[int]]:
    """The tree with a question made a leaf, and which of its nodes are left: those that something leads to."""
    nodes = list(tree.nodes)
    nodes[question.node] = make_leaf(question.outcome)
    kept = [False] * len(nodes)
    kept[0] = True
    for index, node in enumerate(nodes):
        if kept[index] and node.test != TestKind.LEAF:
            for following in _children(node):
                if following != STAY:
                    kept[following] = True
    left = [index for index, is_kept in enumerate(kept) if is_kept]
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
