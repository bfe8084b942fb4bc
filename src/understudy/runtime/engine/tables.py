"""Tables: programs as arrays, and the run state of N agents as arrays, which is all that kernels get.

Kernels unpack these tuples by position, so an order that is changed here must be changed in every kernel file. An
index of -1 means "none" everywhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import accumulate
from math import inf, isnan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError
from understudy.model.automaton import Automaton
from understudy.model.tree import STAY, Node, TestKind, Tree
from understudy.model.value_kinds import Categorical

FLAG, COUNTER, TIMER, TIME, FALLEN, RISEN = range(6)
OWN_SOURCES = 8
"""What an automaton reads of itself: FLAG to RISEN, with a flag's id, a memory slot or a column.

As the source of a node it is -1 - (FLAG to RISEN + OWN_SOURCES * (id, slot or column)).

FALLEN and RISEN are columns that read 0 or 1 in the tick in which the state was entered.
"""

SET, ADD, CLOCK = 0, 1, 2
"""The effect of a change on a memory slot: it becomes the value (NaN: as if never set), grows by it, or becomes the
time."""

ASKED = -(2**31)
"""The mark, in place of a tree's entry, of a transition function that Python has to call."""

NODE = np.dtype(
    [("low", "f8"), ("high", "f8"), ("source", "i4"), ("inside", "i4"), ("outside", "i4"), ("absent", "i4")],
    align=True,
)
"""One question: is low <= x < high? `source` is where x comes from: a column, or one of the automaton's own.

What follows is `inside`, `outside`, or `absent` where x is NaN: a node (>= 0), -1 to stay, or a state, as -2 - its
index. 32 bytes: a cache line holds two.
"""

STATE = np.dtype(
    [("asks", "i4"), ("child", "i4"), ("basic", "i4"), ("flag", "i4"), ("changes", "i4"), ("stop", "i4")],
    align=True,
)
"""A state of a ground instance. `asks` is what its transition begins with, spelled as what follows a node, or ASKED.

It runs the instance `child` or, where that is -1, the basic behavior `basic`, and raises the flag with the id `flag`.
Entering it does the changes from `changes` up to `stop`.
"""

INSTANCE = np.dtype([("start", "i4"), ("memory", "i4"), ("stop", "i4")], align=True)
"""A ground instance: its start state's index, and its memory slots from `memory` up to `stop`."""

CHANGE = np.dtype([("action", "i4"), ("slot", "i4"), ("value", "f8")], align=True)
"""A change of a counter or timer: SET, ADD or CLOCK, and the memory slot it is kept in."""


class Tables(NamedTuple):
    """Programs as arrays; the numbers of states count those of all instances."""

    nodes: NDArray[np.void]
    states: NDArray[np.void]
    instances: NDArray[np.void]
    changes: NDArray[np.void]


class Stacks(NamedTuple):
    """The run state of N agents; rows are independent.

    `root` [N] is the instance that an agent runs, or -1 minus the number of a basic behavior. `state` and `entered` [N,
    D] are the state's number and the time at which it was entered, level by level. `memory` [N, M] has counters, and
    timers as the times at which they were set; NaN if never set. Values below the running levels have no meaning.
    """

    root: NDArray[np.int32]
    state: NDArray[np.int32]
    entered: NDArray[np.float64]
    memory: NDArray[np.float64]

    def copy(self) -> Stacks:
        """Copy the run state into arrays of its own."""
        return Stacks(self.root.copy(), self.state.copy(), self.entered.copy(), self.memory.copy())


class NodeRow(NamedTuple):
    """A record of `NODE`."""

    low: float
    high: float
    source: int
    inside: int
    outside: int
    absent: int


def flatten_tree(tree: Tree, *, sources: Sequence[int], first: int, at: int) -> tuple[int, list[NodeRow]]:
    """Return the entry of a tree and its nodes, if these are put at the index `at`.

    `sources` are those of its features; `first` is the number of the first state that it can lead to.
    """
    *begins, _ = accumulate(map(_rows, tree.nodes), initial=at)

    def after(child: int) -> int:
        """Return a child as `NODE` stores it."""
        if child != STAY and tree.nodes[child].test != TestKind.LEAF:
            return begins[child]
        outcome = STAY if child == STAY else tree.nodes[child].yes
        return STAY if outcome == STAY else -2 - (first + outcome)

    rows: list[NodeRow] = []
    for node in tree.nodes:
        if node.test == TestKind.LEAF:
            continue
        yes, no, absent = after(node.yes), after(node.no), after(node.absent)
        if node.test == TestKind.LABEL:
            branches = [after(branch) for branch in node.branches]
            rows.extend(_halved(branches, sources[node.feature], absent, at=at + len(rows)))
        elif node.test == TestKind.BELOW:
            rows.append(NodeRow(-inf, node.high, sources[node.feature], yes, no, absent))
        elif node.test == TestKind.ABSENT:
            rows.append(NodeRow(inf, -inf, sources[node.feature], no, no, yes))
        elif node.test == TestKind.ARC and node.low <= node.high:
            rows.append(NodeRow(node.low, node.high, sources[node.feature], yes, no, absent))
        elif node.test == TestKind.ARC:
            rows.append(NodeRow(node.high, node.low, sources[node.feature], no, yes, absent))
    return after(0), rows


def _rows(node: Node) -> int:
    if node.test == TestKind.LABEL:
        return max(len(node.branches) - 1, 1)
    return int(node.test != TestKind.LEAF)


def _halved(branches: Sequence[int], source: int, absent: int, *, at: int) -> Iterator[NodeRow]:
    """Yield the nodes that find a label's branch, from the index `at` on; they come before those below them."""
    if len(branches) == 1:
        yield NodeRow(-inf, inf, source, branches[0], branches[0], absent)
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
        yield NodeRow(-inf, middle, source, sides[0], sides[1], absent)


def check_tree(tree: Tree, automaton: Automaton, state: str) -> None:
    """Refuse a tree that tests a feature or leads to a state that its automaton does not have, with DefinitionError."""
    problem = next(filter(None, (_problem(node, automaton) for node in tree.nodes)), None)
    if problem is not None:
        raise DefinitionError(
            what=f"automaton {automaton.name!r}, state {state!r}",
            problem=f"its tree {problem}",
            remedy="learn the automaton again, or correct the tree",
        )


def _problem(node: Node, automaton: Automaton) -> str | None:
    if node.test == TestKind.LEAF:
        valid = STAY <= node.yes < len(automaton.states)
        return None if valid else f"answers state {node.yes} of {len(automaton.states)}"
    if not 0 <= node.feature < len(automaton.features):
        return f"asks for feature {node.feature} of {len(automaton.features)}"
    bound = automaton.features[node.feature]
    if node.test == TestKind.LABEL:
        labels = len(bound.kind.labels) if isinstance(bound.kind, Categorical) else 0
        valid = 0 < len(node.branches) == labels
        return None if valid else f"has {len(node.branches)} branches for the {labels} labels of {bound}"
    cuts = {TestKind.BELOW: (node.high,), TestKind.ARC: (node.low, node.high)}.get(TestKind(node.test), ())
    return f"has a boundary of {bound} that is not a number" if any(map(isnan, cuts)) else None
