"""Cells: the finite partition of the feature space that the trees of an automaton, and of those it runs, cut.

Every threshold of any tree divides the axis of its feature, so that all trees decide alike everywhere in a cell. A set
of cells that is a product of sets of values is one integer with a bit for each value's part of its axis: the
intersection of two such boxes is a single `&`, and no product of axes is ever listed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import inf, isinf, nan, nextafter
from typing import NamedTuple

from understudy.model.features import BoundFeature, CounterFeature, FlagFeature, TimeInState, TimerFeature
from understudy.model.tree import STAY, TestKind, Tree
from understudy.model.tree_regions import ABSENT_ONLY, ValueSet, list_children, make_full_value_set
from understudy.model.value_kinds import Categorical

NO_VALUES = ValueSet((), False)
NONEMPTY = 1
"""A bit that every box has besides those of its axes, so that a space without axes has one cell and is not empty."""


def make_feature_domain(bound: BoundFeature) -> ValueSet:
    """Return the values that a feature can have by its definition.

    The automaton's own features are known: a flag or the time in a state is never absent, and no time is negative.
    """
    feature = bound.feature
    if isinstance(feature, FlagFeature):
        return ValueSet(((0.0, 2.0),), False)
    if isinstance(feature, CounterFeature):
        return ValueSet(((-inf, inf),), False)
    if isinstance(feature, TimeInState | TimerFeature):
        return ValueSet(((0.0, inf),), isinstance(feature, TimerFeature))
    return make_full_value_set(bound.kind)


@dataclass(frozen=True, slots=True)
class Axis:
    """The values of one feature, divided at all thresholds.

    `parts` are intervals in rising order and, last, absence, if the feature can be absent. `shift` is the position of
    the first part's bit in a box.
    """

    bound: BoundFeature
    parts: tuple[ValueSet, ...]
    shift: int
    whole: int = field(init=False)
    """The bits of all parts."""
    bits: tuple[int, ...] = field(init=False)
    """The bit of each part."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "whole", ((1 << len(self.parts)) - 1) << self.shift)
        object.__setattr__(self, "bits", tuple(1 << (self.shift + at) for at in range(len(self.parts))))

    @property
    def absence(self) -> int:
        """The bit of absence; 0 if the feature is never absent."""
        return self.bits[-1] if self.parts and self.parts[-1].absent else 0

    def mask(self, region: ValueSet) -> int:
        """Return the bits of the parts in a region whose ends are among the thresholds."""
        bits = 0
        for bit, part in zip(self.bits, self.parts, strict=True):
            if part.absent:
                inside = region.absent
            else:
                start = part.parts[0][0]
                inside = any(low <= start < high for low, high in region.parts)
            bits |= bit if inside else 0
        return bits

    def region(self, box: int) -> ValueSet:
        """Return the values of a box."""
        region = NO_VALUES
        for _, part in self.list_parts(box):
            region |= part
        return region

    def list_parts(self, box: int) -> Iterator[tuple[int, ValueSet]]:
        """Yield the parts of the axis in a box, each with its bit."""
        for bit, part in zip(self.bits, self.parts, strict=True):
            if box & bit:
                yield bit, part

    def find_bit(self, value: float) -> int:
        """Return the bit of the part with a value; 0 if it lies outside the domain."""
        for bit, part in zip(self.bits, self.parts, strict=True):
            if value in part:
                return bit
        return 0


def divide_axis(bound: BoundFeature, domain: ValueSet, cuts: Iterable[float], shift: int) -> Axis:
    """Divide the values in a feature's domain at cuts; labels are always divided."""
    if isinstance(bound.kind, Categorical):
        cuts = [float(label) for label in range(len(bound.kind.labels) + 1)]
    parts = []
    inner = sorted({cut for cut in cuts if cut == cut and not isinf(cut)})
    for low, high in domain.parts:
        ends = [low, *(cut for cut in inner if low < cut < high), high]
        parts += [ValueSet(((a, b),), False) for a, b in pairwise(ends)]
    return Axis(bound, (*parts, ABSENT_ONLY) if domain.absent else tuple(parts), shift)


def list_feature_cuts(trees: Iterable[Tree], feature: int) -> list[float]:
    """List the thresholds at which trees test a feature."""
    return [
        end
        for tree in trees
        for node in tree.nodes
        if node.feature == feature and node.test in (TestKind.BELOW, TestKind.ARC)
        for end in (node.low, node.high)
        if end == end
    ]


def choose_value(part: ValueSet) -> float:
    """Choose a value that represents a part of an axis: its middle, or a value beside its only end."""
    if part.absent and not part.parts:
        return nan
    low, high = part.parts[0]
    if isinf(low) and isinf(high):
        return 0.0
    if isinf(low):
        return high - 1.0 if high - 1.0 < high else nextafter(high, -inf)
    if isinf(high) or (high - low == 1.0 and low == int(low)):
        return low
    middle = low + (high - low) / 2
    return middle if low <= middle < high else low


class Leaf(NamedTuple):
    """A leaf of a tree, or a place in it where nothing was shown, with the box of feature vectors that reach it.

    `node` is the index of the leaf's node, or STAY where nothing was shown; `outcome` the index of the next state, or
    STAY. `box` has all bits of the axes that the path does not test; `tested` are the bits of each axis that it tests.
    """

    node: int
    outcome: int
    box: int
    tested: tuple[int, ...]


def partition_tree(tree: Tree, axes: Sequence[Axis], full: int) -> tuple[Leaf, ...]:
    """Divide a feature space among the leaves of a tree.

    Parameters
    ----------
    tree
        The tree.
    axes
        The axis of each feature of the tree, divided at its thresholds.
    full
        The box of all feature vectors.

    Returns
    -------
    tuple[Leaf, ...]
        The leaves, and the places where nothing was shown. Each feature vector of the box is in exactly one of them.
    """
    leaves: list[Leaf] = []
    waiting: list[tuple[int, int, frozenset[int]]] = [(0, full, frozenset())]
    while waiting:
        index, box, tested = waiting.pop()
        if index == STAY or tree.nodes[index].test == TestKind.LEAF:
            outcome = STAY if index == STAY else tree.nodes[index].yes
            leaves.append(Leaf(index, outcome, box, tuple(axes[each].whole for each in sorted(tested))))
            continue
        node = tree.nodes[index]
        axis = axes[node.feature]
        for following, region in reversed(list_children(node, axis.bound.kind)):
            narrowed = box & (axis.mask(region) | ~axis.whole)
            if narrowed & axis.whole:
                waiting.append((following, narrowed, tested | {node.feature}))
    return tuple(leaves)


def intersect(box: int, leaf: Leaf) -> int:
    """Return the part of a box that reaches a leaf; 0 if no feature vector does."""
    both = box & leaf.box
    return 0 if any(not both & bits for bits in leaf.tested) else both


def is_box_empty(box: int, axes: Iterable[Axis]) -> bool:
    """Return whether some axis has no value in a box."""
    return any(not box & axis.whole for axis in axes)


def join_boxes(boxes: Sequence[int], axes: Sequence[Axis]) -> list[int]:
    """Join boxes that differ in one axis only, and leave out those inside another."""
    merged: list[int] = []
    for box in dict.fromkeys(boxes):
        joined = box
        again = True
        while again:
            again = False
            for other in merged:
                union = joined | other
                apart = [axis for axis in axes if (joined ^ other) & axis.whole]
                if union in (joined, other) or len(apart) <= 1:
                    merged.remove(other)
                    joined, again = union, True
                    break
        merged.append(joined)
    return merged


def choose_vector(box: int, axes: Sequence[Axis]) -> tuple[float, ...]:
    """Choose a feature vector in a box, with present values where there are any."""
    return tuple(choose_value(next(part for _, part in axis.list_parts(box))) for axis in axes)
