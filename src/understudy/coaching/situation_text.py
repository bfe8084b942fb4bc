"""Situations in words: behind you, close, in the left of the picture.

Each feature's values are divided into a few cells that have names: quarters of a turn, thirds of the observed range of
a number, labels, absence. A cell is a number; a situation is a cell for each feature.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import degrees, inf
from types import MappingProxyType
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import join_names
from understudy.model.features import BoundFeature, Feature, FlagFeature
from understudy.model.tree_regions import Box, Interval, ValueSet, make_full_value_set
from understudy.model.value_kinds import TAU, Categorical, Column, Toroidal
from understudy.sim.kit import FEATURES

Cells: TypeAlias = Mapping[int, frozenset[int]]
"""By feature, the cells a situation may be in; a feature that is left out may be anything."""

NOT_THERE = -1
"""The cell of an absent reading."""
QUARTERS, THIRDS = 4, 3
USUALLY = 0.7
"""A label that this share of examples has, or more, is the usual one."""
AROUND = ("ahead", "to the left", "behind you", "to the right")
READ: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "range": ("close", "neither close nor far", "far"),
        "bearing": AROUND,
        "blob_x": (
            "in the left of the picture",
            "in the middle of the picture",
            "in the right of the picture",
        ),
        "blob_size": (
            "small in the picture",
            "neither small nor large in the picture",
            "large in the picture",
        ),
    }
)
"""The words for the cells of readings of a target, in rising order."""
USUAL: Mapping[str, str] = MappingProxyType({FEATURES.get(reading, reading): reading for reading in READ})
"""The reading that a feature of a usual name has, by that name."""
ABSENT_WORDS: Mapping[str, str] = MappingProxyType({"blob_x": "not seen", "blob_size": "not seen"})
PRESENT_WORDS: Mapping[str, str] = MappingProxyType({"not seen": "seen"})


@dataclass(frozen=True, slots=True)
class FeaturePhrases:
    """The phrases for one feature whose values lie between `low` and `high`."""

    bound: BoundFeature
    low: float
    high: float

    @property
    def extent(self) -> float:
        """The largest difference between two values: half a turn, the range of a number, or 1."""
        if isinstance(self.bound.kind, Toroidal):
            return self.bound.kind.period / 2
        return self.high - self.low if self._ordered and self.low < self.high else 1.0

    @property
    def steps(self) -> tuple[float, float]:
        """The values that separate low, middle and high."""
        third = (self.high - self.low) / THIRDS
        return self.low + third, self.high - third

    @property
    def cells(self) -> tuple[int, ...]:
        """All cells of present values."""
        kind = self.bound.kind
        if isinstance(kind, Categorical):
            return tuple(range(len(kind.labels)))
        if isinstance(kind, Toroidal):
            return tuple(range(QUARTERS))
        return tuple(range(THIRDS)) if self.low < self.high else (0,)

    def cells_of(self, values: Column) -> NDArray[np.int64]:
        """Return the cell of each value [n]."""
        kind = self.bound.kind
        absent = np.isnan(values)
        present = np.where(absent, 0.0, values)
        if isinstance(kind, Categorical):
            cells = present.astype(np.int64)
        elif isinstance(kind, Toroidal):
            cells = np.floor(present / kind.period * QUARTERS + 0.5).astype(np.int64) % QUARTERS
        elif self.low < self.high:
            cells = np.searchsorted(self.steps, present, side="right").astype(np.int64)
        else:
            cells = np.zeros(len(values), np.int64)
        return np.where(absent, NOT_THERE, cells)

    def region(self, cells: Iterable[int]) -> ValueSet:
        """Return the values of some cells."""
        region = ValueSet((), False)
        for cell in cells:
            region |= ValueSet((), True) if cell == NOT_THERE else ValueSet(self._parts(cell), False)
        return region

    def _parts(self, cell: int) -> tuple[Interval, ...]:
        kind = self.bound.kind
        if isinstance(kind, Categorical):
            return ((float(cell), cell + 1.0),)
        if isinstance(kind, Toroidal):
            quarter = kind.period / QUARTERS
            low, high = (cell - 0.5) * quarter, (cell + 0.5) * quarter
            return ((low, high),) if low >= 0 else ((0.0, high), (low + kind.period, kind.period))
        if len(self.cells) == 1:
            return ((-inf, inf),)
        ends = (-inf, *self.steps, inf)
        return ((ends[cell], ends[cell + 1]),)

    @property
    def subject(self) -> str:
        """The subject of a sentence: the target if there is one, otherwise the feature."""
        reads = self._reads
        spoken = reads in READ and len(self.bound.binding) == 1
        return next(iter(self.bound.binding.values())) if spoken else str(self.bound)

    def describe_cells(self, cells: frozenset[int]) -> str:
        """Describe some cells: "close (below 1.2 m)", "to the left or behind you", "not seen"."""
        present = sorted(cells - {NOT_THERE})
        absent = ABSENT_WORDS.get(self._reads, "absent")
        if present == list(self.cells):
            return "anything" if NOT_THERE in cells else PRESENT_WORDS.get(absent, "there")
        missing = [cell for cell in self.cells if cell not in cells]
        if self._ordered and len(present) > 1:
            words = [self._side(present)]
        elif len(missing) == 1 < len(present) == len(cells):
            words = [f"not {self._word(missing[0])}"]
        else:
            words = [self._word(each) for each in present]
        return " or ".join([*words, *([absent] if NOT_THERE in cells else [])])

    @property
    def _ordered(self) -> bool:
        return not isinstance(self.bound.kind, Categorical | Toroidal)

    def _side(self, cells: Sequence[int]) -> str:
        """Describe two of the three cells of a number."""
        words, (low, _, high) = READ.get(self._reads), self._bounds
        if 1 not in cells:
            return f"{words[0]} or {words[2]}" if words else f"{low} or {high}"
        bounds = high.replace("above", "below") if 0 in cells else low.replace("below", "above")
        return f"not {words[2 if 0 in cells else 0]} ({bounds})" if words else bounds

    @property
    def _bounds(self) -> tuple[str, str, str]:
        """Describe the three cells of a number by values: below 1.3 m, 1.3 to 2.7 m, above 2.7 m."""
        unit = f" {self.bound.feature.unit}" if self.bound.feature.unit else ""
        low, high = map(_short, self.steps)
        return f"below {low}{unit}", f"{low} to {high}{unit}", f"above {high}{unit}"

    @property
    def _reads(self) -> str:
        """Return the reading; if only the feature's name is known, the reading that features of this name have."""
        feature = self.bound.feature
        if not isinstance(feature, Feature):
            return ""
        return feature.reading if feature.reading and feature.reading in READ else USUAL.get(feature.name, "")

    def _word(self, cell: int) -> str:
        kind, feature = self.bound.kind, self.bound.feature
        if isinstance(kind, Categorical):
            return ("not raised", "raised")[cell] if isinstance(feature, FlagFeature) else kind.labels[cell]
        words = READ.get(self._reads, ())
        if isinstance(kind, Toroidal):
            if words and kind.period == TAU:
                return words[cell]
            middle = cell * kind.period / QUARTERS
            return f"around {degrees(middle):.0f}°" if feature.unit == "rad" else f"around {middle:.3g}"
        if len(self.cells) == 1:
            return "anything"
        bounds = self._bounds[cell]
        return f"{words[cell]} ({bounds})" if words else bounds


def _short(number: float) -> str:
    """Format a number with two digits: 0.38, 1.3, 5100."""
    return f"{float(f'{number:.2g}'):.12g}"


def make_feature_phrases(
    features: Sequence[BoundFeature], vectors: NDArray[np.float64]
) -> tuple[FeaturePhrases, ...]:
    """Make the phrases for features, given observed feature vectors [n, F]."""
    phrases = []
    for column, bound in enumerate(features):
        present = vectors[:, column][~np.isnan(vectors[:, column])]
        low, high = (float(present.min()), float(present.max())) if len(present) else (0.0, 0.0)
        phrases.append(FeaturePhrases(bound, low, high))
    return tuple(phrases)


def find_cells(words: Sequence[FeaturePhrases], rows: NDArray[np.float64]) -> NDArray[np.int64]:
    """Find the cell of each feature in each of n feature vectors [n, F]."""
    return (
        np.stack([word.cells_of(rows[:, column]) for column, word in enumerate(words)], axis=1)
        if words
        else (np.zeros((len(rows), 0), np.int64))
    )


def match_cells(cells: Cells, rows: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which of n situations [n, F], given as cells, are among these."""
    matches = np.ones(len(rows), np.bool_)
    for feature, allowed in cells.items():
        matches &= np.isin(rows[:, feature], list(allowed))
    return matches


def make_situation_box(words: Sequence[FeaturePhrases], cells: Cells) -> Box:
    """Return the box of feature vectors of a situation."""
    return tuple(
        word.region(cells[feature]) if feature in cells else make_full_value_set(word.bound.kind)
        for feature, word in enumerate(words)
    )


def find_usual_cells(rows: NDArray[np.int64], words: Sequence[FeaturePhrases]) -> Cells:
    """Find, by feature, the label that most of n situations [n, F], given as cells, have."""
    usual = {}
    for feature, word in enumerate(words):
        if isinstance(word.bound.kind, Categorical) and len(rows):
            labels, counts = np.unique(rows[:, feature], return_counts=True)
            if counts.max() >= USUALLY * len(rows):
                usual[feature] = frozenset({int(labels[counts.argmax()])})
    return usual


def describe_situation(
    words: Sequence[FeaturePhrases], cells: Cells, usual: Cells = MappingProxyType({})
) -> str:
    """Describe a situation in words: "A is behind you and close"; nothing if it may be any.

    Usual values are omitted, unless nothing else is left to say.
    """
    telling = {feature: cells[feature] for feature in sorted(cells) if cells[feature] != usual.get(feature)}
    parts_of: dict[str, list[str]] = {}
    for feature, chosen in (telling or cells).items():
        parts = parts_of.setdefault(words[feature].subject, [])
        text = words[feature].describe_cells(chosen)
        if text not in parts:
            parts.append(text)
    alike: dict[str, list[str]] = {}
    for subject, parts in parts_of.items():
        alike.setdefault(" and ".join(parts), []).append(subject)
    verbs = (
        (join_names(subjects), "is" if len(subjects) == 1 else "are", text)
        for text, subjects in alike.items()
    )
    return join_names(map(" ".join, verbs)) if parts_of else ""
