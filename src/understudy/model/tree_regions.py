"""Regions: the parts of one feature's values, and of all features' together, that a tree tells apart."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf
from typing import NamedTuple, TypeAlias

from understudy.model.kinds import Categorical, Kind, Toroidal
from understudy.model.tree import STAY, Node, Step, Test, Tree, child

Part: TypeAlias = tuple[float, float]
"""Values from the first up to but not including the second; a label k is the part from k to k + 1."""


class Region(NamedTuple):
    """Some of a feature's values: rising parts, none touching the next; and whether absence belongs."""

    parts: tuple[Part, ...]
    absent: bool

    @property
    def empty(self) -> bool:
        """Whether nothing belongs."""
        return not self.parts and not self.absent

    def __and__(self, other: Region) -> Region:
        parts = [
            (max(low, low2), min(high, high2))
            for low, high in self.parts
            for low2, high2 in other.parts
            if max(low, low2) < min(high, high2)
        ]
        return Region(tuple(sorted(parts)), self.absent and other.absent)

    def __or__(self, other: Region) -> Region:
        parts: list[Part] = []
        for low, high in sorted((*self.parts, *other.parts)):
            if parts and low <= parts[-1][1]:
                parts[-1] = (parts[-1][0], max(high, parts[-1][1]))
            else:
                parts.append((low, high))
        return Region(tuple(parts), self.absent or other.absent)

    def meets(self, other: Region) -> bool:
        """Whether some value, or absence, belongs to both."""
        return (self.absent and other.absent) or any(
            low < high2 and low2 < high for low, high in self.parts for low2, high2 in other.parts
        )

    def __contains__(self, value: object) -> bool:
        return isinstance(value, float) and (
            self.absent if value != value else any(low <= value < high for low, high in self.parts)
        )


Box: TypeAlias = tuple[Region, ...]
"""A region for each feature: the feature vectors with every value in its region."""

ABSENT_ONLY = Region((), True)


def everything(kind: Kind) -> Region:
    """All values of a kind, and absence."""
    if isinstance(kind, Toroidal):
        return Region(((0.0, kind.period),), True)
    if isinstance(kind, Categorical):
        return Region(((0.0, float(len(kind.labels))),), True)
    return Region(((-inf, inf),), True)


def boxes(tree: Tree, kinds: Sequence[Kind]) -> list[tuple[int, Box]]:
    """The tree's leaves, first to last: the outcome of each (STAY: nothing was shown) and what leads to it.

    A feature that was never shown absent has no absence in any of them.
    """
    knows = known_absent(tree, len(kinds))
    found: list[tuple[int, Box]] = []
    whole = tuple(Region(everything(kind).parts, known) for kind, known in zip(kinds, knows, strict=True))
    waiting: list[tuple[int, Box]] = [(0, whole)]
    while waiting:
        index, box = waiting.pop()
        if index == STAY or tree.nodes[index].test == Test.LEAF:
            found.append((STAY if index == STAY else tree.nodes[index].yes, box))
            continue
        node = tree.nodes[index]
        below = []
        for following, region in _children(node, kinds[node.feature]):
            narrowed = box[node.feature] & region
            if not narrowed.empty:
                below.append((following, (*box[: node.feature], narrowed, *box[node.feature + 1 :])))
        waiting.extend(reversed(below))
    return found


def known_absent(tree: Tree, features: int) -> list[bool]:
    """For each feature, whether the tree was ever shown it absent."""
    knows = [False] * features
    for node in tree.nodes:
        if node.test == Test.ABSENT or (node.test != Test.LEAF and node.absent != STAY):
            knows[node.feature] = True
    return knows


def path_box(tree: Tree, steps: Iterable[Step], kinds: Sequence[Kind]) -> Box:
    """What held on the way of one decision."""
    box = [everything(kind) for kind in kinds]
    for step in steps:
        node = tree.nodes[step.node]
        kind = kinds[node.feature]
        region = ABSENT_ONLY
        if step.side == "label":
            region = Region(((float(step.label), step.label + 1.0),), False)
        elif step.side != "absent" and not (node.test == Test.ABSENT and step.side == "yes"):
            inside = _inside(node, kind) if node.test != Test.ABSENT else Region((), True)
            region = inside if step.side == "yes" else _rest(inside, kind)
        box[node.feature] &= region
    return tuple(box)


def covers(box: Box, other: Box) -> bool:
    """Whether all of the other is in the first."""
    return all(region & region2 == region2 for region, region2 in zip(box, other, strict=True))


def _children(node: Node, kind: Kind) -> list[tuple[int, Region]]:
    """A node's children, each with all the values of its feature that lead there."""
    sides: dict[int, Region] = {}
    if node.test == Test.LABEL:
        for label, following in enumerate(node.branches):
            region = Region(((float(label), label + 1.0),), False)
            sides[following] = sides.get(following, Region((), False)) | region
    else:
        inside = _inside(node, kind)
        for side, region in (("yes", inside), ("no", _rest(inside, kind))):
            following = child(node, Step(0, side))
            sides[following] = sides.get(following, Region((), False)) | region
    if node.test != Test.ABSENT:
        sides[node.absent] = sides.get(node.absent, Region((), False)) | ABSENT_ONLY
    return list(sides.items())


def _inside(node: Node, kind: Kind) -> Region:
    if node.test == Test.ABSENT:
        return ABSENT_ONLY
    if node.test == Test.BELOW:
        return Region(((-inf, node.high),), False)
    if node.low <= node.high:
        return Region(((node.low, node.high),), False)
    whole = everything(kind).parts[0]
    return Region(((whole[0], node.high),), False) | Region(((node.low, whole[1]),), False)


def _rest(inside: Region, kind: Kind) -> Region:
    """The present values that are not inside."""
    low, high = everything(kind).parts[0]
    parts = []
    for start, stop in inside.parts:
        if low < start:
            parts.append((low, start))
        low = stop
    if low < high:
        parts.append((low, high))
    return Region(tuple(parts), False)
