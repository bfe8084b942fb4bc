"""Regions of a tree: the sets of a feature's values, and the boxes of feature vectors, that its tests separate."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf
from typing import NamedTuple, TypeAlias

from understudy.model.tree import STAY, Node, PathStep, TestKind, Tree, get_child
from understudy.model.value_kinds import Categorical, Kind, Toroidal

Interval: TypeAlias = tuple[float, float]
"""Values from the first number up to, not including, the second; label k is the interval from k to k + 1."""


class ValueSet(NamedTuple):
    """A set of values of one feature: disjoint intervals in rising order, and whether it includes absence."""

    parts: tuple[Interval, ...]
    absent: bool

    @property
    def empty(self) -> bool:
        """True if the set contains neither a value nor absence."""
        return not self.parts and not self.absent

    def __and__(self, other: ValueSet) -> ValueSet:
        parts = [
            (max(low, low2), min(high, high2))
            for low, high in self.parts
            for low2, high2 in other.parts
            if max(low, low2) < min(high, high2)
        ]
        return ValueSet(tuple(sorted(parts)), self.absent and other.absent)

    def __or__(self, other: ValueSet) -> ValueSet:
        parts: list[Interval] = []
        for low, high in sorted((*self.parts, *other.parts)):
            if parts and low <= parts[-1][1]:
                parts[-1] = (parts[-1][0], max(high, parts[-1][1]))
            else:
                parts.append((low, high))
        return ValueSet(tuple(parts), self.absent or other.absent)

    def overlaps(self, other: ValueSet) -> bool:
        """Return whether some value, or absence, is in both sets."""
        return (self.absent and other.absent) or any(
            low < high2 and low2 < high for low, high in self.parts for low2, high2 in other.parts
        )

    def __contains__(self, value: object) -> bool:
        return isinstance(value, float) and (
            self.absent if value != value else any(low <= value < high for low, high in self.parts)
        )


Box: TypeAlias = tuple[ValueSet, ...]
"""A set of values for each feature: the feature vectors whose every value is in its set."""

ABSENT_ONLY = ValueSet((), True)


def make_full_value_set(kind: Kind) -> ValueSet:
    """Return the set of all values of a kind, including absence."""
    if isinstance(kind, Toroidal):
        return ValueSet(((0.0, kind.period),), True)
    if isinstance(kind, Categorical):
        return ValueSet(((0.0, float(len(kind.labels))),), True)
    return ValueSet(((-inf, inf),), True)


def list_leaf_boxes(
    tree: Tree, kinds: Sequence[Kind], *, known_absent: Sequence[bool] | None = None
) -> list[tuple[int, Box]]:
    """List the outcome of each leaf of a tree with the box of feature vectors that reach it.

    The outcome is the index of a state, or STAY for vectors that no example had. Absence of a feature is left out of
    all boxes unless `known_absent` says that it occurs; if that is None, unless an example of the tree had it absent.
    """
    knows = find_known_absent(tree, len(kinds)) if known_absent is None else known_absent
    leaves: list[tuple[int, Box]] = []
    whole = tuple(
        ValueSet(make_full_value_set(kind).parts, can_be_absent)
        for kind, can_be_absent in zip(kinds, knows, strict=True)
    )
    waiting: list[tuple[int, Box]] = [(0, whole)]
    while waiting:
        index, box = waiting.pop()
        if index == STAY or tree.nodes[index].test == TestKind.LEAF:
            leaves.append((STAY if index == STAY else tree.nodes[index].yes, box))
            continue
        node = tree.nodes[index]
        below = []
        for following, region in list_children(node, kinds[node.feature]):
            narrowed = box[node.feature] & region
            if not narrowed.empty:
                below.append((following, (*box[: node.feature], narrowed, *box[node.feature + 1 :])))
        waiting.extend(reversed(below))
    return leaves


def find_tested_features(trees: Iterable[Tree]) -> set[int]:
    """Return the positions of the features that some node of the trees tests."""
    return {node.feature for tree in trees for node in tree.nodes if node.test != TestKind.LEAF}


def find_known_absent(tree: Tree, features: int) -> list[bool]:
    """Return for each feature whether some training example had it absent."""
    knows = [False] * features
    for node in tree.nodes:
        if node.test == TestKind.ABSENT or (node.test != TestKind.LEAF and node.absent != STAY):
            knows[node.feature] = True
    return knows


def make_path_box(tree: Tree, steps: Iterable[PathStep], kinds: Sequence[Kind]) -> Box:
    """Return the box of feature vectors that pass the given steps of one decision."""
    box = [make_full_value_set(kind) for kind in kinds]
    for step in steps:
        node = tree.nodes[step.node]
        kind = kinds[node.feature]
        region = ABSENT_ONLY
        if step.side == "label":
            region = ValueSet(((float(step.label), step.label + 1.0),), False)
        elif step.side != "absent" and not (node.test == TestKind.ABSENT and step.side == "yes"):
            inside = list_yes_values(node, kind) if node.test != TestKind.ABSENT else ValueSet((), True)
            region = inside if step.side == "yes" else _rest(inside, kind)
        box[node.feature] &= region
    return tuple(box)


def contains_box(box: Box, other: Box) -> bool:
    """Return whether `other` lies inside `box`."""
    return all(region & region2 == region2 for region, region2 in zip(box, other, strict=True))


def list_children(node: Node, kind: Kind) -> list[tuple[int, ValueSet]]:
    """List the children of a node, each with the set of its feature's values that lead there."""
    sides: dict[int, ValueSet] = {}
    if node.test == TestKind.LABEL:
        for label, following in enumerate(node.branches):
            region = ValueSet(((float(label), label + 1.0),), False)
            sides[following] = sides.get(following, ValueSet((), False)) | region
    else:
        inside = list_yes_values(node, kind)
        for side, region in (("yes", inside), ("no", _rest(inside, kind))):
            following = get_child(node, PathStep(0, side))
            sides[following] = sides.get(following, ValueSet((), False)) | region
    if node.test != TestKind.ABSENT:
        sides[node.absent] = sides.get(node.absent, ValueSet((), False)) | ABSENT_ONLY
    return list(sides.items())


def list_yes_values(node: Node, kind: Kind) -> ValueSet:
    """List the values of its feature for which the test of a node answers yes."""
    if node.test == TestKind.ABSENT:
        return ABSENT_ONLY
    if node.test == TestKind.BELOW:
        return ValueSet(((-inf, node.high),), False)
    if node.low <= node.high:
        return ValueSet(((node.low, node.high),), False)
    whole = make_full_value_set(kind).parts[0]
    return ValueSet(((whole[0], node.high),), False) | ValueSet(((node.low, whole[1]),), False)


def _rest(inside: ValueSet, kind: Kind) -> ValueSet:
    """Return the present values that are not in `inside`."""
    low, high = make_full_value_set(kind).parts[0]
    parts = []
    for start, stop in inside.parts:
        if low < start:
            parts.append((low, start))
        low = stop
    if low < high:
        parts.append((low, high))
    return ValueSet(tuple(parts), False)
