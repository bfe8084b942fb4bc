"""What a tree decides, in words: when an automaton goes from one state to another.

Tests of one feature on the way to a leaf become one statement, leaves that lead to one state are put
together, and a statement that makes no difference is left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from typing import TypeAlias

from understudy.model.features import BoundFeature
from understudy.model.tree import STAY, Step, Tree
from understudy.model.tree_regions import Box, Region, boxes, covers, known_absent, path_box
from understudy.model.words import Words

Vectors: TypeAlias = Sequence[Sequence[float]]
"""The feature vectors that were shown: numbers in words keep them on their sides."""
MOST_LEAVES = 48
"""A tree with more leaves is put in words leaf by leaf: nobody would read it, and joining them takes long."""


def conditions(
    tree: Tree, features: Sequence[BoundFeature], shown: Vectors = ()
) -> Mapping[int, tuple[str, ...]]:
    """For each outcome of a tree, when: a condition for each way; "always" where there is no other outcome.

    Every feature vector decided so fulfills one of them, and no other vector does.
    """
    found = simplified(tree, features)
    return {outcome: worded(tree, features, boxes, shown) for outcome, boxes in found.items()}


def worded(
    tree: Tree, features: Sequence[BoundFeature], found: Sequence[Box], shown: Vectors = ()
) -> tuple[str, ...]:
    """A condition for each of some boxes that the tree tells apart."""
    words = _words(tree, features, shown)
    return tuple(" and ".join(_statements(box, words)) or "always" for box in found)


def sentences(
    tree: Tree,
    features: Sequence[BoundFeature],
    state_names: Sequence[str],
    state: str,
    shown: Vectors = (),
) -> tuple[str, ...]:
    """When a state is left, a sentence for each way: "load when food_below_me is yes"; the last: when not."""
    found = conditions(tree, features, shown)
    here = list(state_names).index(state) if state in state_names else STAY
    leaves = tuple(
        f"{state_names[outcome]} {text if text == 'always' else 'when ' + text}"
        for outcome in sorted(found)
        if outcome != here
        for text in found[outcome]
    )
    if here not in found:
        return leaves
    return (*leaves, "stays otherwise" if leaves else "stays always")


def path_conditions(
    tree: Tree, steps: Iterable[Step], features: Sequence[BoundFeature], shown: Vectors = ()
) -> tuple[str, ...]:
    """What held on the way of one decision: a statement for each feature that was asked about."""
    steps = tuple(steps)
    words = _words(tree, features, shown)
    box = path_box(tree, steps, [bound.kind for bound in features])
    asked = {tree.nodes[step.node].feature for step in steps}
    return tuple(words[feature].statement(box[feature]) for feature in sorted(asked))


def simplified(tree: Tree, features: Sequence[BoundFeature]) -> dict[int, list[Box]]:
    """The feature vectors of each outcome as few, wide boxes; only those of one outcome may overlap."""
    leaves = boxes(tree, [bound.kind for bound in features])
    found: dict[int, list[Box]] = {}
    for outcome in sorted({outcome for outcome, _ in leaves if outcome != STAY}):
        mine = [box for leads_to, box in leaves if leads_to == outcome]
        if len(leaves) <= MOST_LEAVES:
            others = [box for leads_to, box in leaves if leads_to != outcome]
            whole = _whole(box for _, box in leaves)
            mine = _joined(_without_covered([_widened(box, whole, others) for box in mine]))
        found[outcome] = mine
    return found


def _words(tree: Tree, features: Sequence[BoundFeature], shown: Vectors) -> list[Words]:
    cuts: list[list[float]] = [[] for _ in features]
    for node in tree.nodes:
        if node.feature >= 0:
            cuts[node.feature] += [cut for cut in (node.low, node.high) if cut == cut]
    knows = known_absent(tree, len(features))
    values = list(zip(*shown, strict=True)) or [()] * len(features)
    return [
        Words(bound, own, known_absent=known, values=there)
        for bound, own, known, there in zip(features, cuts, knows, values, strict=True)
    ]


def _statements(box: Box, words: Sequence[Words]) -> list[str]:
    return [
        word.statement(region) for region, word in zip(box, words, strict=True) if not word.is_whole(region)
    ]


def _whole(all_boxes: Iterable[Box]) -> Box:
    first, *rest = all_boxes
    whole = list(first)
    for box in rest:
        whole = [region | region2 for region, region2 in zip(whole, box, strict=True)]
    return tuple(whole)


def _widened(box: Box, whole: Box, others: Sequence[Box]) -> Box:
    """The box without what makes no difference: first whole statements, then ends of intervals."""
    wide = list(box)
    apart = [  # the features that keep each other box out
        {feature for feature, region in enumerate(box) if not region.meets(other[feature])}
        for other in others
    ]

    def widen(feature: int, region: Region) -> None:
        kept_out = [other for other, by in zip(others, apart, strict=True) if by == {feature}]
        if any(region.meets(other[feature]) for other in kept_out):
            return
        wide[feature] = region
        for other, by in zip(others, apart, strict=True):
            if feature in by and region.meets(other[feature]):
                by.remove(feature)

    for feature in reversed(range(len(box))):
        widen(feature, whole[feature])
    for feature, full in enumerate(whole):
        low, high = (full.parts[0][0], full.parts[-1][1]) if full.parts else (0.0, 0.0)
        if len(wide[feature].parts) == 1:
            ((start, stop),) = wide[feature].parts
            widen(feature, Region(((low, stop),), wide[feature].absent))
            ((start, stop),) = wide[feature].parts
            widen(feature, Region(((start, high),), wide[feature].absent))
    return tuple(wide)


def _without_covered(found: Sequence[Box]) -> list[Box]:
    kept: list[Box] = []
    for box in found:
        if not any(covers(other, box) for other in kept):
            kept = [other for other in kept if not covers(box, other)] + [box]
    return kept


def _joined(found: list[Box]) -> list[Box]:
    """Boxes that differ in one feature only become one, where that reads well."""
    while True:
        for first, second in combinations(found, 2):
            apart = [feature for feature in range(len(first)) if first[feature] != second[feature]]
            if len(apart) == 1:
                union = first[apart[0]] | second[apart[0]]
                if len(union.parts) <= 2:
                    both = (*first[: apart[0]], union, *first[apart[0] + 1 :])
                    found = _without_covered(
                        [both if box is first else box for box in found if box is not second]
                    )
                    break
        else:
            return found
