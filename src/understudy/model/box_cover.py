"""Covers of regions: sets of boxes of feature vectors written with few, wide boxes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

from understudy.model.tree_regions import Box, ValueSet, contains_box


def cover_boxes(mine: Sequence[Box], others: Sequence[Box]) -> list[Box]:
    """Cover the boxes `mine` with few, wide boxes that do not overlap `others`.

    Vectors that are in none of them all may be covered, too.
    """
    whole = find_hull([*mine, *others])
    return _joined(_without_covered([_widened(box, whole, others) for box in mine]))


def find_hull(boxes: Iterable[Box]) -> Box:
    """Find the box of all values that each feature has in some of the boxes."""
    first, *rest = boxes
    whole = list(first)
    for box in rest:
        whole = [region | region2 for region, region2 in zip(whole, box, strict=True)]
    return tuple(whole)


def _widened(box: Box, whole: Box, others: Sequence[Box]) -> Box:
    """Widen a box where this makes no difference: drop whole statements first, then ends of intervals."""
    wide = list(box)
    apart = [  # the features that keep each other box out
        {feature for feature, region in enumerate(box) if not region.overlaps(other[feature])}
        for other in others
    ]

    def widen(feature: int, region: ValueSet) -> None:
        kept_out = [other for other, by in zip(others, apart, strict=True) if by == {feature}]
        if any(region.overlaps(other[feature]) for other in kept_out):
            return
        wide[feature] = region
        for other, by in zip(others, apart, strict=True):
            if feature in by and region.overlaps(other[feature]):
                by.remove(feature)

    for feature in reversed(range(len(box))):
        widen(feature, whole[feature])
    for feature, full in enumerate(whole):
        low, high = (full.parts[0][0], full.parts[-1][1]) if full.parts else (0.0, 0.0)
        if len(wide[feature].parts) == 1:
            ((start, stop),) = wide[feature].parts
            widen(feature, ValueSet(((low, stop),), wide[feature].absent))
            ((start, stop),) = wide[feature].parts
            widen(feature, ValueSet(((start, high),), wide[feature].absent))
    return tuple(wide)


def _without_covered(boxes: Sequence[Box]) -> list[Box]:
    largest: list[Box] = []
    for box in boxes:
        if not any(contains_box(other, box) for other in largest):
            largest = [other for other in largest if not contains_box(box, other)] + [box]
    return largest


def _joined(boxes: list[Box]) -> list[Box]:
    """Join boxes that differ in one feature only, where the union has at most two intervals."""
    while True:
        for first, second in combinations(boxes, 2):
            apart = [feature for feature in range(len(first)) if first[feature] != second[feature]]
            if len(apart) == 1:
                union = first[apart[0]] | second[apart[0]]
                if len(union.parts) <= 2:
                    both = (*first[: apart[0]], union, *first[apart[0] + 1 :])
                    boxes = _without_covered(
                        [both if box is first else box for box in boxes if box is not second]
                    )
                    break
        else:
            return boxes
