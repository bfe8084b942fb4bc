"""Decision trees as flat frozen records: what a transition function is once learned (paper section 3.2).

A tree maps a feature vector to the index of the next state, or to `STAY`. It runs without the learner.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from math import isnan, nan
from numbers import Real
from typing import Any, NamedTuple, TypeAlias

from understudy.errors import KindError

STAY = -1  # as an outcome: keep the current state; as a child: nothing was ever shown there, so keep it too


class TestKind(IntEnum):
    """What a node asks of its feature's value x."""

    __test__ = False  # not a test case, whatever pytest thinks of the name

    LEAF = 0
    BELOW = 1  # x < high
    ARC = 2  # low <= x < high, across the seam where low > high
    ABSENT = 3  # x is absent
    LABEL = 4  # which label: one branch each


class Node(NamedTuple):
    """One node; children are indices of nodes, or STAY. A leaf keeps its outcome in `yes`."""

    test: int
    feature: int = -1
    low: float = nan
    high: float = nan
    yes: int = STAY
    no: int = STAY
    absent: int = STAY
    branches: tuple[int, ...] = ()


def make_leaf(outcome: int) -> Node:
    """A leaf that answers `outcome`: the index of a state, or STAY."""
    return Node(TestKind.LEAF, yes=outcome)


class PathStep(NamedTuple):
    """One node passed on the way down: the node's index, and which child was taken."""

    node: int
    side: str  # "yes", "no", "absent" or "label"
    label: int = -1


Nested: TypeAlias = tuple[Any, ...]
"""A node with its children in place of their indices, and a leaf that stays in place of STAY: quicker to walk."""


def _nested(nodes: Sequence[Node]) -> Nested:
    below: dict[int, Nested] = {STAY: tuple(make_leaf(STAY))}
    for index in reversed(range(len(nodes))):  # children come after their parents
        node = nodes[index]
        if node.test == TestKind.LEAF:
            below[index] = tuple(node)
            continue
        branches = tuple(below[child] for child in node.branches)
        test, feature, low, high, yes, no, absent, _ = node
        below[index] = (int(test), feature, low, high, below[yes], below[no], below[absent], branches)
    return below[0]


@dataclass(frozen=True, slots=True)
class Tree:
    """A decision tree; `nodes[0]` is the root, children come after their parents."""

    nodes: tuple[Node, ...]
    _nested: Nested = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_nested", _nested(self.nodes))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the nodes alone: what is nested in them may be deeper than Python recurses."""
        return _make_tree, (self.nodes,)

    def decide(self, values: Sequence[float]) -> int:
        """The next state's index for a feature vector, or STAY; KindError where a value it asks for is none.

        Values beyond the last one that it asks for are not looked at.
        """
        node = self._nested
        try:
            while True:
                test, feature, low, high, yes, no, absent, branches = node
                if test == 0:
                    return yes  # type: ignore[no-any-return]
                x = values[feature]
                if x != x:
                    node = yes if test == 3 else absent
                elif test == 1:
                    node = yes if x < high else no
                elif test == 4:
                    node = branches[int(x)]
                elif test == 3:
                    node = no
                elif low <= high:
                    node = yes if low <= x < high else no
                else:
                    node = yes if x >= low or x < high else no
        except _NO_VECTOR:  # tried only once it failed: every tick of every robot decides
            raise _explain_failure(self.nodes, values) from None

    def path(self, values: Sequence[float]) -> tuple[tuple[PathStep, ...], int]:
        """The steps `decide` takes for a feature vector, and the leaf reached (STAY where it ends before one)."""
        steps = []
        index = 0
        try:
            while index >= 0 and self.nodes[index].test != TestKind.LEAF:
                node = self.nodes[index]
                step = _step(index, node, values[node.feature])
                steps.append(step)
                index = get_child(node, step)
        except _NO_VECTOR:
            raise _explain_failure(self.nodes, values) from None
        return tuple(steps), index

    def leaves(self) -> Iterator[tuple[tuple[PathStep, ...], int]]:
        """Every leaf with the steps that lead to it, from the first side to the last."""
        waiting: list[tuple[int, tuple[PathStep, ...]]] = [(0, ())]  # no recursion: noise grows trees deep
        while waiting:
            index, steps = waiting.pop()
            node = self.nodes[index]
            if node.test == TestKind.LEAF:
                yield steps, index
                continue
            below = [(get_child(node, step), (*steps, step)) for step in _sides(index, node)]
            waiting.extend(reversed([each for each in below if each[0] != STAY]))

    @property
    def depth(self) -> int:
        """Tests on the longest path; 0 for a single leaf."""
        deepest = [0] * len(self.nodes)
        for index, node in enumerate(self.nodes):  # children come after their parents
            for following in (
                (node.yes, node.no, node.absent, *node.branches) if node.test != TestKind.LEAF else ()
            ):
                if following != STAY:
                    deepest[following] = deepest[index] + 1
        return max(deepest)


_NO_VECTOR = (LookupError, TypeError, ValueError, OverflowError)
"""What fails where a value is asked for that is not there, or is no number."""


def _explain_failure(nodes: Sequence[Node], values: Sequence[float]) -> KindError:
    """Find what is wrong with values that a tree could not decide on."""
    asked = {node.feature: node for node in nodes if node.test != TestKind.LEAF}
    if isinstance(values, Mapping) or not hasattr(values, "__len__"):
        return _wrong(f"it is {values!r:.60}", "give a list of numbers")
    if len(values) <= max(asked):
        problem = f"it has {len(values)} values, and the tree asks for number {max(asked) + 1}"
        return _wrong(problem, "give one for each feature")
    for feature, node in sorted(asked.items()):
        if not isinstance(values[feature], Real):
            return _wrong(_value(feature, values), "give a number, or NaN where it is absent")
        labels = len(node.branches)
        if node.test == TestKind.LABEL and not (isnan(values[feature]) or 0 <= values[feature] < labels):
            return _wrong(_value(feature, values), f"give the index of one of {labels} labels")
    return _wrong(f"it is {values!r:.60}", "give a list of numbers")


def _value(feature: int, values: Sequence[float]) -> str:
    return f"value {feature + 1} is {values[feature]!r:.60}"


def _wrong(problem: str, remedy: str) -> KindError:
    return KindError(where="feature vector", problem=problem, remedy=remedy)


def _make_tree(nodes: Sequence[Node]) -> Tree:
    """A tree that was pickled; what is absent is the one `nan`, by which equal nodes are equal."""
    return Tree(
        tuple(
            node._replace(
                low=nan if isnan(node.low) else node.low, high=nan if isnan(node.high) else node.high
            )
            for node in nodes
        )
    )


def get_child(node: Node, step: PathStep) -> int:
    """The node that a step leads to, or STAY."""
    if step.side == "label":
        return node.branches[step.label]
    return {"yes": node.yes, "no": node.no, "absent": node.absent}[step.side]


def _step(index: int, node: Node, x: float) -> PathStep:
    if x != x:
        return PathStep(index, "yes" if node.test == TestKind.ABSENT else "absent")
    if node.test == TestKind.LABEL:
        return PathStep(index, "label", int(x))
    if node.test == TestKind.BELOW:
        inside = x < node.high
    elif node.test == TestKind.ARC:
        inside = is_in_arc(x, node.low, node.high)
    else:
        inside = False
    return PathStep(index, "yes" if inside else "no")


def _sides(index: int, node: Node) -> Iterator[PathStep]:
    if node.test == TestKind.LABEL:
        yield from (PathStep(index, "label", label) for label in range(len(node.branches)))
        if node.absent not in node.branches:
            yield PathStep(index, "absent")
        return
    yield PathStep(index, "yes")
    yield PathStep(index, "no")


def is_in_arc(x: float, low: float, high: float) -> bool:
    """Whether low <= x < high, going round across the seam where low > high."""
    return low <= x < high if low <= high else x >= low or x < high
