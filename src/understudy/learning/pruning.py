"""Pruning: questions of a tree taken back that set too few examples right, the least useful first.

Weakest-link pruning: Breiman, Friedman, Olshen and Stone, Classification and Regression Trees, 1984, chapter 3. What a
question and all below it are worth is how many examples they set right for each leaf that they add. Its units are
examples, so that people can say how much a leaf must be worth: with 1, whatever is held up by one example goes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from understudy.learning._kernels import WATCHED
from understudy.learning.arrays import Shown
from understudy.model.tree import STAY, Node, Test, Tree, leaf

PRESSED, SEEN = 10, 1
"""What an example weighs: watched ones count a tenth, as in the score of splits."""
SAME = 1e-9


def pruned(tree: Tree, shown: Shown, pruning: float) -> Tree:
    """The tree without the questions whose leaves do not each set more than `pruning` examples right."""
    for worth, simpler in links(tree, shown):
        if worth > pruning + SAME:
            break
        tree = simpler
    return tree


def links(tree: Tree, shown: Shown) -> Iterator[tuple[float, Tree]]:
    """The tree pruned step by step, the weakest question first: what it was worth, in examples, and what is left.

    No step is worth less than the one before it; of several equally weak questions the topmost goes first.
    """
    worth, reach = 0.0, _reaching(tree, shown)
    while len(tree.nodes) > 1:
        weakest = min(_questions(tree, shown, reach), key=lambda each: (each.worth, each.node), default=None)
        if weakest is None:
            return
        tree, kept = _without(tree, weakest)
        reach = [reach[index] for index in kept]
        worth = max(worth, weakest.worth)
        yield worth, tree


@dataclass(frozen=True, slots=True)
class _Question:
    """A node that could become a leaf: with which outcome, and what it and those below it are worth."""

    node: int
    outcome: int
    worth: float


def _questions(tree: Tree, shown: Shown, reach: Sequence[NDArray[np.intp]]) -> list[_Question]:
    """All questions at which something was pressed; `reach` has the examples that come by each node."""
    weights = np.where(shown.groups == WATCHED, SEEN, PRESSED)
    wrong = [0] * len(tree.nodes)
    leaves: list[set[int]] = [set() for _ in tree.nodes]
    found = []
    for index in reversed(range(len(tree.nodes))):  # children come after their parents
        node, here = tree.nodes[index], reach[index]
        if node.test == Test.LEAF:
            leaves[index], wrong[index] = {index}, _wrong(node.yes, here, shown, weights)
            continue
        below = {following for following in _children(node) if following != STAY}
        leaves[index] = set().union(*(leaves[following] for following in below))
        wrong[index] = sum(wrong[each] for each in leaves[index])
        outcome = _outcome(here, shown)
        if outcome is not None:
            lost = _wrong(outcome, here, shown, weights) - wrong[index]
            found.append(_Question(index, outcome, lost / PRESSED / max(1, len(leaves[index]) - 1)))
    return found


def _reaching(tree: Tree, shown: Shown) -> list[NDArray[np.intp]]:
    """The examples that come by each node, in their order."""
    coming: list[list[NDArray[np.intp]]] = [[] for _ in tree.nodes]
    coming[0] = [np.arange(len(shown.values))]
    reach: list[NDArray[np.intp]] = []
    for node, parts in zip(tree.nodes, coming, strict=True):  # children come after their parents
        rows = np.sort(np.concatenate(parts)) if parts else np.empty(0, np.intp)
        reach.append(rows)
        for following, there in _parted(node, shown.values[rows, node.feature]):
            if following != STAY:
                coming[following].append(rows[there])
    return reach


def _parted(node: Node, values: NDArray[np.float64]) -> Iterator[tuple[int, NDArray[np.bool_]]]:
    """Where a question leads, and which of these values go there."""
    absent = np.isnan(values)
    match node.test:
        case Test.LEAF:
            return
        case Test.LABEL:
            yield from ((following, values == label) for label, following in enumerate(node.branches))
        case Test.ABSENT:
            yield node.yes, absent
            yield node.no, ~absent
            return
        case _:
            inside = values < node.high
            if node.test == Test.ARC:
                since = values >= node.low
                inside = inside & since if node.low <= node.high else inside | since
            yield node.yes, inside
            yield node.no, ~inside & ~absent
    yield node.absent, absent


def _outcome(rows: NDArray[np.intp], shown: Shown) -> int | None:
    """What most press-made examples show; a tie stays, or is what is declared first. None where nothing was pressed."""
    pressed = shown.outcomes[rows[shown.groups[rows] != WATCHED]]
    if not len(pressed):
        return None
    counts = np.bincount(pressed)
    tied = np.flatnonzero(counts == counts.max()).tolist()
    return shown.current if shown.current in tied else int(tied[0])


def _wrong(outcome: int, rows: NDArray[np.intp], shown: Shown, weights: NDArray[np.int64]) -> int:
    """The weight of the examples that show something else."""
    decided = shown.current if outcome == STAY else outcome
    return int(weights[rows[shown.outcomes[rows] != decided]].sum())


def _children(node: Node) -> Sequence[int]:
    return (*node.branches, node.absent) if node.test == Test.LABEL else (node.yes, node.no, node.absent)


def _without(tree: Tree, question: _Question) -> tuple[Tree, list[int]]:
    """The tree with a question made a leaf, and which of its nodes are left: those that something leads to."""
    nodes = list(tree.nodes)
    nodes[question.node] = leaf(question.outcome)
    kept = [False] * len(nodes)
    kept[0] = True
    for index, node in enumerate(nodes):
        if kept[index] and node.test != Test.LEAF:
            for following in _children(node):
                if following != STAY:
                    kept[following] = True
    left = [index for index, is_kept in enumerate(kept) if is_kept]
    place = {STAY: STAY, **{index: number for number, index in enumerate(left)}}
    return Tree(tuple(_moved(nodes[index], place) for index in left)), left


def _moved(node: Node, place: dict[int, int]) -> Node:
    if node.test == Test.LEAF:
        return node
    return node._replace(
        yes=place[node.yes],
        no=place[node.no],
        absent=place[node.absent],
        branches=tuple(place[each] for each in node.branches),
    )
