"""What the presses for a flag had in common: the values of a feature at which the demonstrator raised it.

A flag says that something is reached, and the presses show what: *done* was pressed at 0.17 to 0.44 m, at any angle.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import inf, isinf

import numpy as np
from numpy.typing import NDArray

from understudy.learning._growth_kernels import ENOUGH_STAYS
from understudy.learning.fisher_test import compute_fisher_p
from understudy.learning.training_set import select_teaching_examples
from understudy.model.describe import format_value
from understudy.model.features import BoundFeature, Feature
from understudy.model.lesson import Lesson
from understudy.model.tree_regions import ValueSet
from understudy.model.tree_text import FeatureText
from understudy.model.value_kinds import Categorical, Column, Toroidal

FEWEST_PRESSES = 2
"""The least number of presses from which it is concluded what they had in common."""
CHANCE, CHANCE_BETWEEN = 0.5, 0.05
"""The largest p-values (Fisher's exact test, times the number of ranges) at which presses are not together by chance:
beyond other values or at a label, and between other values, where a few presses soon lie side by side."""
SURELY_AGREES, FARTHEST, SHIFTED = 0.05, 0.25, 0.1
"""Distances by which two versions of a behavior are compared, as shares of a feature's extent: the difference between
its largest and smallest value at presses. A value at most SURELY_AGREES beyond the shown ones agrees with them. One
more than FARTHEST beyond does not, nor does one more than SHIFTED beyond the values at which the first version raises
the flag."""


@dataclass(frozen=True, slots=True)
class ShownRange:
    """The values of a feature at which a flag was pressed.

    Parameters
    ----------
    feature
        The feature.
    low
        The lowest of the values.
    high
        The highest of the values; on a circle, the last one counterclockwise from `low`.
    below
        The nearest value below `low` at which something else was right, or -inf. Values between were not shown.
    above
        The nearest value above `high` at which something else was right, or inf.
    presses
        The number of presses.
    extent
        Difference between the largest and smallest value at all presses, for any state; 0 on a circle and for labels.
    """

    feature: BoundFeature
    low: float
    high: float
    below: float
    above: float
    presses: int
    extent: float = 0.0

    def contains(self, values: Column) -> NDArray[np.bool_]:
        """Return which values agree with the range: those up to the nearest value at which something else was right.

        Parameters
        ----------
        values
            Values of the feature, any shape.

        Returns
        -------
        NDArray[bool]
            True for each value between `below` and `above`; False where absent.
        """
        placed = place_above(self.low, values, self.feature)
        inside: NDArray[np.bool_] = (placed > self.below) & (placed < self.above)
        if isinstance(self.feature.kind, Toroidal):
            inside |= placed - self.feature.kind.period > self.below
        return inside

    def is_near(self, values: Column) -> NDArray[np.bool_]:
        """Return which values are in the range or at most SURELY_AGREES of its extent beyond it.

        Ranges of labels and on circles have an extent of 0, so that only the values in them are near.
        """
        if self.extent == 0.0:
            return self.contains(values)
        near = SURELY_AGREES * self.extent
        inside: NDArray[np.bool_] = (values >= self.low - near) & (values <= self.high + near)
        return inside

    def restrict_limits(self) -> ShownRange:
        """Return the range with limits between SURELY_AGREES and FARTHEST of the extent beyond what was shown.

        Two presses far apart say that the truth lies between them, anywhere. Open sides remain open.
        """
        near, far = SURELY_AGREES * self.extent, FARTHEST * self.extent
        if far == 0.0:
            return self
        return self._limit(
            below=min(max(self.below, self.low - far), self.low - near),
            above=max(min(self.above, self.high + far), self.high + near),
        )

    def limit_near(self, values: Column) -> ShownRange:
        """Return the range with limits at most SHIFTED of the extent beyond what was shown and some values."""
        shift = SHIFTED * self.extent
        if shift == 0.0 or values.size == 0:
            return self
        return self._limit(
            below=max(self.below, min(self.low, float(values.min())) - shift),
            above=min(self.above, max(self.high, float(values.max())) + shift),
        )

    def _limit(self, *, below: float, above: float) -> ShownRange:
        return replace(
            self,
            below=self.below if isinf(self.below) else below,
            above=self.above if isinf(self.above) else above,
        )

    def measure_gap(self, values: Column) -> Column:
        """Return how far values, any shape, are from what was shown: 0 where they agree, inf where absent."""
        placed = place_above(self.low, values, self.feature)
        above = placed - self.above
        if isinstance(self.feature.kind, Toroidal):
            gap = np.minimum(above, self.below + self.feature.kind.period - placed)
        else:
            gap = np.maximum(above, self.below - placed)
        distances: Column = np.where(np.isnan(gap), np.inf, np.maximum(gap, 0.0))
        return distances

    @property
    def condition(self) -> str:
        """What agrees with what was shown, as a condition in words: "distance_to(A) is below 0.47 m"."""
        low, high, kind = self.below, self.above, self.feature.kind
        parts: tuple[tuple[float, float], ...] = ((low, high),)
        if isinstance(kind, Toroidal):
            low, high = low % kind.period, high % kind.period
            parts = ((low, high),) if low < high else ((0.0, high), (low, kind.period))
        ends = [end for end in (low, high) if not isinf(end)]
        text = FeatureText(self.feature, ends, known_absent=False, values=(self.low, self.high))
        return text.statement(ValueSet(parts, absent=False))

    def find_ends(self, values: Column) -> tuple[float, float]:
        """Return the first and the last of some values, none absent, as they lie around what was shown."""
        placed = place_above(self.low, values, self.feature)
        if isinstance(self.feature.kind, Toroidal):
            period = self.feature.kind.period
            placed = np.where(placed - self.high > self.low + period - placed, placed - period, placed)
        return float(placed.min()), float(placed.max())

    def describe(self) -> str:
        """Return the values in words: "0.17 to 0.44 m", or "yes"."""
        return describe_range(self.feature, self.low, self.high)


def describe_range(feature: BoundFeature, low: float, high: float) -> str:
    """Describe a range of a feature's values in words: "0.17 to 0.44 m"; a single value if both look the same."""
    first, last = format_value(feature, low), format_value(feature, high)
    return last if first == last else f"{format_value(feature, low, unit=False)} to {last}"


def find_shown_range(
    lesson: Lesson, flag: str, *, fewest: int = FEWEST_PRESSES, chance: float = CHANCE
) -> ShownRange | None:
    """Find the feature whose values the presses for a flag have in common, and these values.

    The values of most of these presses are compared with those at which presses asked for something else, by Fisher's
    exact test: presses to which the demonstrator slipped may lie elsewhere, on either side.

    Parameters
    ----------
    lesson
        The lesson.
    flag
        The flag.
    fewest
        The least number of presses.
    chance
        The largest p-value of a range beyond other values or at a label.

    Returns
    -------
    ShownRange | None
        Of all features, a range with no other values beyond one of its ends is preferred, and then the range that is
        least likely by chance. None if there are too few presses, or if every range is likely by chance.
    """
    automaton = lesson.automaton
    raising = {state.name for state in automaton.states if state.flag == flag}
    ends = {state.name for state in automaton.states if state.flag is not None}
    teaching = [each for each in select_teaching_examples(lesson) if each.state not in ends]
    presses = [each.values for each in teaching if each.next in raising and each.is_shown]
    others = [each for each in teaching if each.next not in ends]
    other_presses = list(
        dict.fromkeys(each.values for each in others if each.is_from_press)
    )  # a press makes two
    watched = [each.values for each in others if not each.is_from_press]
    best: tuple[_Candidate, ShownRange] | None = None
    for index, feature in enumerate(automaton.features):
        columns = [np.array([values[index] for values in rows]) for rows in (presses, other_presses, watched)]
        if not isinstance(feature.feature, Feature) or np.isnan(columns[0]).any():
            continue  # of the automaton itself: no other world has it
        at_flag, *rest = (column[~np.isnan(column)] for column in columns)
        for candidate in _list_candidates(feature, at_flag, rest[0], fewest, chance):
            if best is None or candidate.rank < best[0].rank:
                best = candidate, _limit_range(feature, candidate, at_flag, *rest)
    return None if best is None else best[1]


@dataclass(frozen=True, slots=True)
class _Candidate:
    """A range from press to press, how likely it is by chance, and whether it is open below or above, or at a label."""

    likelihood: float
    low: float
    high: float
    below: bool = False
    above: bool = False
    label: bool = False

    @property
    def rank(self) -> tuple[bool, float]:
        """The key by which candidates are compared, the best first."""
        return not (self.below or self.above or self.label), self.likelihood


def _list_candidates(
    feature: BoundFeature, at_flag: Column, other_presses: Column, fewest: int, chance: float
) -> Iterator[_Candidate]:
    """Yield the ranges that most presses have in common, unless they may well be chance."""
    lowest, highest = at_flag.min(initial=inf), at_flag.max(initial=-inf)
    for low in np.unique(at_flag).tolist():
        placed = np.sort(place_above(low, at_flag, feature)).tolist()
        others = np.sort(place_above(low, other_presses, feature)).tolist()
        first_inside = bisect_left(placed, low)
        for high in sorted(set(placed[first_inside:])):
            inside = bisect_right(placed, high) - first_inside
            if inside < max(fewest, len(at_flag) // 2 + 1):
                continue
            sides: list[tuple[float, float, dict[str, bool], int]]
            sides = [(low, high, {}, len(at_flag) + len(other_presses))]
            if isinstance(feature.kind, Categorical):
                sides = [(low, high, {"label": True}, len(feature.kind.labels))] if low == high else []
            elif not isinstance(feature.kind, Toroidal):
                sides += [(-inf, high, {"below": True}, 2)] if low == lowest else []
                sides += [(low, inf, {"above": True}, 2)] if high == highest else []
            for first, last, how, ranges in sides:
                wrong = bisect_right(others, last) - bisect_left(others, first)
                likelihood = ranges * compute_fisher_p(inside, len(at_flag), wrong, len(other_presses))
                candidate = _Candidate(likelihood, low, high, **how)
                if likelihood <= (CHANCE_BETWEEN if candidate.rank[0] else chance):
                    yield candidate


def _limit_range(
    feature: BoundFeature, of: _Candidate, at_flag: Column, other_presses: Column, watched: Column
) -> ShownRange:
    """Find the limits of a range: the nearest values at which presses, or enough watched examples, show something else.

    That a flag was not pressed at once does not say that it is wrong. So watched examples limit it as they limit other
    decisions, ENOUGH_STAYS of them together, and only towards values at which presses asked for something else.
    """
    placed = place_above(of.low, at_flag, feature)
    presses = int(((placed >= of.low) & (placed <= of.high)).sum())
    if of.label:
        return ShownRange(feature, of.low, of.high, of.low - 0.5, of.high + 0.5, presses)
    presses_at = np.concatenate((at_flag, other_presses))
    extent = 0.0 if isinstance(feature.kind, Toroidal) else float(np.ptp(presses_at))
    beside = (_list_beside(feature, of.low, of.high, values) for values in (other_presses, watched))
    below, above = (_list_limits(*side) for side in zip(*beside, strict=True))
    lowest, highest = max(below, default=-inf), min(above, default=inf)
    return ShownRange(
        feature,
        of.low,
        of.high,
        -inf if of.below else lowest,
        inf if of.above else highest,
        presses,
        extent,
    )


def _list_beside(feature: BoundFeature, low: float, high: float, values: Column) -> tuple[Column, Column]:
    """Return the values below and above a range, the nearest first; on a circle, each value is in both lists."""
    placed = np.sort(place_above(low, values, feature))
    above = placed[placed > high]
    below = above - feature.kind.period if isinstance(feature.kind, Toroidal) else placed[placed < low]
    return below[::-1], above


def _list_limits(other_presses: Column, watched: Column) -> list[float]:
    """List the nearest value of a press, and the nearest at which enough watched examples show what was right."""
    silent = watched[ENOUGH_STAYS - 1 : ENOUGH_STAYS] if len(other_presses) else watched[:0]
    return [*other_presses[:1].tolist(), *silent.tolist()]


def place_above(low: float, values: Column, feature: BoundFeature) -> Column:
    """Return values unchanged or, on a circle, shifted by full turns to at least `low` and less than a turn above."""
    if not isinstance(feature.kind, Toroidal):
        return values
    placed: Column = low + np.mod(values - low, feature.kind.period)
    return placed
