"""Decision trees as two-way branches, in which nothing is left to be inferred, for targets to write as code.

A tree's node asks one question with three or more answers: yes, no, absent, or a label each. Here every question has
two answers, and a comparison with an absent value is false, as it is in the arithmetic of every target.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from understudy.model.tree import STAY, Node, TestKind, Tree

Comparison: TypeAlias = Literal["absent", "below", "from", "inside", "outside", "across", "between", "label"]
"""The comparison of a feature's value x with `low` and `high`; all but "absent" are false if x is absent.

absent: x is absent. below: x < high. from: x >= low. inside: low <= x < high. outside: x < low or x >= high.
across: x >= low or x < high. between: high <= x < low. label: x is the label with index `low`.
"""

DEEPEST = 10
"""The largest number of nested conditions in one routine; a deeper tree continues in further routines."""


@dataclass(frozen=True, slots=True)
class ValueCondition:
    """A question about the value of one feature, by its index in the automaton."""

    feature: int
    comparison: Comparison
    low: float = 0.0
    high: float = 0.0


@dataclass(frozen=True, slots=True)
class Answer:
    """An end of a tree: the index of the next state or STAY, and the index of the leaf, -1 if nothing was shown."""

    outcome: int
    leaf: int


@dataclass(frozen=True, slots=True)
class Continuation:
    """A place at which a deep tree goes on in another routine."""

    routine: int


@dataclass(frozen=True, slots=True)
class Branch:
    """A question with what follows if it holds and if not."""

    condition: ValueCondition
    yes: Step
    no: Step


Step: TypeAlias = Branch | Answer | Continuation


@dataclass(frozen=True, slots=True)
class TreeRoutines:
    """How some states of an automaton decide, by their indices: with one tree as routines, of which the first begins.

    `state` is the state if it is the only one, and None if several share the tree.
    """

    states: tuple[int, ...]
    routines: tuple[Step, ...]

    @property
    def state(self) -> int | None:
        """The only state, or None."""
        return self.states[0] if len(self.states) == 1 else None


def make_routines(tree: Tree, can_be_absent: Callable[[int], bool]) -> tuple[Step, ...]:
    """Write a tree as routines of two-way branches, of which the first is the beginning.

    `can_be_absent` says of a feature whether its value can be absent; if not, the question is left out.
    """
    return _Writer(tree.nodes, can_be_absent).write()


class _Writer:
    def __init__(self, nodes: Sequence[Node], can_be_absent: Callable[[int], bool]) -> None:
        self.nodes, self.can_be_absent = nodes, can_be_absent
        self.begins: dict[int, int] = {0: 0}

    def write(self) -> tuple[Step, ...]:
        written: list[Step] = []
        while len(written) < len(self.begins):
            written.append(self.step(list(self.begins)[len(written)], DEEPEST, frozenset()))
        return tuple(written)

    def step(self, index: int, left: int, present: frozenset[int]) -> Step:
        """Write what follows from a node on, with `left` questions to nest and features known to be present."""
        if index == STAY:
            return Answer(STAY, -1)
        node = self.nodes[index]
        if node.test == TestKind.LEAF:
            return Answer(node.yes, index)
        if left <= 0:
            return self.later(index)
        feature = node.feature
        can_be_absent = feature not in present and self.can_be_absent(feature)
        is_there = present | {feature}
        if node.test == TestKind.LABEL:
            return self.label(index, left, present, can_be_absent=can_be_absent)
        if node.test == TestKind.ABSENT:
            if not can_be_absent:
                return self.step(node.no, left, present)
            condition = ValueCondition(feature, "absent")
            return Branch(
                condition, self.step(node.yes, left - 1, present), self.step(node.no, left - 1, is_there)
            )
        inside, outside = _compare(node)
        if not can_be_absent:
            return Branch(
                inside, self.step(node.yes, left - 1, present), self.step(node.no, left - 1, present)
            )
        if node.absent == node.no:
            return Branch(
                inside, self.step(node.yes, left - 1, is_there), self.step(node.no, left - 1, present)
            )
        if node.absent == node.yes:
            return Branch(
                outside, self.step(node.no, left - 1, is_there), self.step(node.yes, left - 1, present)
            )
        comparison = Branch(
            inside, self.step(node.yes, left - 2, is_there), self.step(node.no, left - 2, is_there)
        )
        return Branch(
            ValueCondition(feature, "absent"), self.step(node.absent, left - 1, present), comparison
        )

    def label(self, index: int, left: int, present: frozenset[int], *, can_be_absent: bool) -> Step:
        """Ask for one label after the other; what absence leads to is the rest, with all labels that lead there."""
        node = self.nodes[index]
        last = node.absent if can_be_absent else node.branches[-1]
        branches = [(label, child) for label, child in enumerate(node.branches) if child != last]
        if left < min(len(branches), DEEPEST):
            return self.later(index)
        below = max(0, left - 1)
        step = self.step(last, below, present)
        for label, child in reversed(branches):
            question = ValueCondition(node.feature, "label", float(label))
            step = Branch(question, self.step(child, below, present | {node.feature}), step)
        return step

    def later(self, index: int) -> Continuation:
        return Continuation(self.begins.setdefault(index, len(self.begins)))


def _compare(node: Node) -> tuple[ValueCondition, ValueCondition]:
    """Return the question whether a present value passes the test of a node, and the question whether it fails."""
    feature, low, high = node.feature, node.low, node.high
    if node.test == TestKind.BELOW:
        return ValueCondition(feature, "below", high=high), ValueCondition(feature, "from", low=high)
    if low <= high:
        return ValueCondition(feature, "inside", low, high), ValueCondition(feature, "outside", low, high)
    return ValueCondition(feature, "across", low, high), ValueCondition(feature, "between", low, high)
