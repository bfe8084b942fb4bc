"""Flattening: a decision tree as rows of `NODE`, whose questions are all of one sort: is low <= x < high?

An arc across the seam is what its complement is not; a label is found by halving; leaves are no nodes at all.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import accumulate
from math import inf, isnan
from typing import NamedTuple

from understudy.errors import DefinitionError
from understudy.model.automaton import Automaton
from understudy.model.kinds import Categorical
from understudy.model.tree import STAY, Node, Test, Tree


class Row(NamedTuple):
    """A record of `NODE`."""

    low: float
    high: float
    source: int
    inside: int
    outside: int
    absent: int


def flat(tree: Tree, *, sources: Sequence[int], first: int, at: int) -> tuple[int, list[Row]]:
    """What a tree begins with, and its nodes, when these are put at the index `at`.

    `sources` are those of its features, `first` is the index of the first state it can answer.
    """
    *begins, _ = accumulate(map(_rows, tree.nodes), initial=at)

    def after(child: int) -> int:
        """What follows, as `NODE` spells it."""
        if child != STAY and tree.nodes[child].test != Test.LEAF:
            return begins[child]
        outcome = STAY if child == STAY else tree.nodes[child].yes
        return STAY if outcome == STAY else -2 - (first + outcome)

    rows: list[Row] = []
    for node in tree.nodes:
        if node.test == Test.LEAF:
            continue
        yes, no, absent = after(node.yes), after(node.no), after(node.absent)
        if node.test == Test.LABEL:
            branches = [after(branch) for branch in node.branches]
            rows.extend(_halved(branches, sources[node.feature], absent, at=at + len(rows)))
        elif node.test == Test.BELOW:
            rows.append(Row(-inf, node.high, sources[node.feature], yes, no, absent))
        elif node.test == Test.ABSENT:
            rows.append(Row(inf, -inf, sources[node.feature], no, no, yes))
        elif node.test == Test.ARC and node.low <= node.high:
            rows.append(Row(node.low, node.high, sources[node.feature], yes, no, absent))
        elif node.test == Test.ARC:
            rows.append(Row(node.high, node.low, sources[node.feature], no, yes, absent))
    return after(0), rows


def _rows(node: Node) -> int:
    if node.test == Test.LABEL:
        return max(len(node.branches) - 1, 1)
    return int(node.test != Test.LEAF)


def _halved(branches: Sequence[int], source: int, absent: int, *, at: int) -> Iterator[Row]:
    """The nodes that find a label's branch, from the index `at` on; they come before what is below them."""
    if len(branches) == 1:
        yield Row(-inf, inf, source, branches[0], branches[0], absent)
        return
    waiting = [(0, len(branches))]
    used = 1
    while waiting:
        low, high = waiting.pop(0)
        middle = (low + high) // 2
        sides = []
        for part in ((low, middle), (middle, high)):
            if part[1] - part[0] == 1:
                sides.append(branches[part[0]])
            else:
                sides.append(at + used)
                used += 1
                waiting.append(part)
        yield Row(-inf, middle, source, sides[0], sides[1], absent)


def check_tree(tree: Tree, automaton: Automaton, state: str) -> None:
    """DefinitionError for a tree that asks what its automaton does not sense, or answers a state it has not."""
    problem = next(filter(None, (_problem(node, automaton) for node in tree.nodes)), None)
    if problem is not None:
        raise DefinitionError(
            what=f"automaton {automaton.name!r}, state {state!r}",
            problem=f"its tree {problem}",
            remedy="learn the automaton again, or correct the tree",
        )


def _problem(node: Node, automaton: Automaton) -> str | None:
    if node.test == Test.LEAF:
        known = STAY <= node.yes < len(automaton.states)
        return None if known else f"answers state {node.yes} of {len(automaton.states)}"
    if not 0 <= node.feature < len(automaton.features):
        return f"asks for feature {node.feature} of {len(automaton.features)}"
    bound = automaton.features[node.feature]
    if node.test == Test.LABEL:
        labels = len(bound.kind.labels) if isinstance(bound.kind, Categorical) else 0
        known = 0 < len(node.branches) == labels
        return None if known else f"has {len(node.branches)} branches for the {labels} labels of {bound}"
    cuts = {Test.BELOW: (node.high,), Test.ARC: (node.low, node.high)}.get(Test(node.test), ())
    return f"has a boundary of {bound} that is no number" if any(map(isnan, cuts)) else None
