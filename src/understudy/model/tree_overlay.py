"""Overlays of two trees: the boxes in which both decide in one way each, and the share of readings in a box."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from math import isnan, prod
from typing import NamedTuple, TypeAlias

from understudy.model.tree_regions import Box, ValueSet
from understudy.model.value_kinds import Categorical, Kind, Toroidal


class OverlayCell(NamedTuple):
    """A box of feature vectors for which the next state was `was` formerly, and is `now` now."""

    box: Box
    was: str
    now: str


Leaves: TypeAlias = Sequence[tuple[str, Box]]
"""The next state of each leaf of a tree, with the box of feature vectors that reach it."""


def overlay_boxes(old: Leaves, new: Leaves) -> list[OverlayCell]:
    """List the boxes of feature vectors that reach one leaf of either of two trees; they do not overlap."""
    former, present = {box: was for was, box in old}, {box: now for now, box in new}
    moved = [(now, box) for box, now in present.items() if box not in former]
    cells = []
    for box, was in former.items():
        if box in present:  # most leaves stay as they are, and then overlap no other
            cells.append(OverlayCell(box, was, present[box]))
            continue
        pairs = ((now, _intersect(box, other)) for now, other in moved)
        cells += [OverlayCell(common, was, now) for now, common in pairs if common is not None]
    return cells


def _intersect(box: Box, other: Box) -> Box | None:
    """Return the box of the vectors that are in both; None if there are none."""
    common = []
    for region, region2 in zip(box, other, strict=True):
        both = region & region2
        if both.empty:
            return None
        common.append(both)
    return tuple(common)


def find_features_between(inside: Iterable[Box], outside: Sequence[Box]) -> set[int]:
    """Return the positions of the features each of which alone can separate vectors inside from those outside.

    A feature does if a change of its value alone leads from a vector of some box inside to one of some box outside.
    """
    features: set[int] = set()
    for box in inside:
        for other in outside:
            apart = [
                feature
                for feature, (region, region2) in enumerate(zip(box, other, strict=True))
                if not region.overlaps(region2)
            ]
            if len(apart) == 1:
                features.add(apart[0])
    return features


class ReadingSpread:
    """The spread of the readings of one state, by which parts of its feature space are measured.

    Features are taken as independent: what no example had may happen, and matters most.

    Parameters
    ----------
    vectors
        The feature vectors of the state's examples. NaN means absent.
    kinds
        The kinds of the features.
    """

    def __init__(self, vectors: Sequence[Sequence[float]], kinds: Sequence[Kind]) -> None:
        columns = zip(*vectors, strict=True) if vectors else [()] * len(kinds)
        self._features = [_FeatureSpread(values, kind) for values, kind in zip(columns, kinds, strict=True)]

    def count_values(self, boxes: Iterable[Box]) -> float:
        """Return the share of the examples' values, from 0 to 1, in boxes that do not overlap."""
        return sum(
            prod(feature.count(region) for feature, region in zip(self._features, box, strict=True))
            for box in boxes
        )

    def cover_range(self, boxes: Iterable[Box]) -> float:
        """Return the share of the range of the examples' values, from 0 to 1, in boxes that do not overlap."""
        return sum(
            prod(feature.cover(region) for feature, region in zip(self._features, box, strict=True))
            for box in boxes
        )


class _FeatureSpread:
    """The values of one feature in the examples of a state."""

    def __init__(self, values: Sequence[float], kind: Kind) -> None:
        self._present = sorted(value for value in values if not isnan(value))
        self._share = len(self._present) / len(values) if values else 1.0
        if isinstance(kind, Toroidal):
            self._ends = 0.0, kind.period
        elif isinstance(kind, Categorical):
            self._ends = 0.0, float(len(kind.labels))
        else:
            self._ends = (self._present[0], self._present[-1]) if self._present else (0.0, 0.0)

    def count(self, region: ValueSet) -> float:
        """Return the share of the values that are in a set."""
        if not self._present:
            return self.cover(region)
        inside = sum(
            bisect_left(self._present, high) - bisect_left(self._present, low) for low, high in region.parts
        )
        return self._share * inside / len(self._present) + (1.0 - self._share) * region.absent

    def cover(self, region: ValueSet) -> float:
        """Return the share of the range of the values that a set covers."""
        low, high = self._ends
        if low == high:
            covered = float(any(start <= low < stop for start, stop in region.parts))
        else:
            lengths = (min(stop, high) - max(start, low) for start, stop in region.parts)
            covered = sum(max(length, 0.0) for length in lengths) / (high - low)
        return self._share * covered + (1.0 - self._share) * region.absent
