"""What the presses for a flag had in common: the values of a feature at which the demonstrator raised it.

A flag says that something is reached, and the presses show what: *done* was pressed at 0.17 to 0.44 m, at any angle.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, isinf

import numpy as np
from numpy.typing import NDArray

from understudy.learning._growth_kernels import ENOUGH_STAYS
from understudy.learning.training_set import select_teaching_examples
from understudy.model.describe import format_value
from understudy.model.features import BoundFeature, Feature
from understudy.model.kinds import Categorical, Column, Toroidal
from understudy.model.lesson import Lesson
from understudy.model.tree_regions import ValueSet
from understudy.model.tree_text import FeatureText

FEWEST_PRESSES = 2
"""The least number of presses from which it is concluded what they had in common."""
LARGEST_SHARE = 0.25
"""The largest share of a feature's values in a lesson that presses can cover and still have the feature in common."""


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
    """

    feature: BoundFeature
    low: float
    high: float
    below: float
    above: float
    presses: int

    def contains(self, values: Column) -> NDArray[np.bool_]:
        """Return which values agree with what was shown: those nearer to it than anything else that was right.

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

    def measure_gap(self, values: Column) -> Column:
        """Return how far values, any shape, are from what was shown: 0 where they agree, inf where absent."""
        placed = place_above(self.low, values, self.feature)
        above = placed - self.above
        if isinstance(self.feature.kind, Toroidal):
            gap = np.minimum(above, self.below + self.feature.kind.period - placed)
        else:
            gap = np.maximum(above, self.below - placed)
        found: Column = np.where(np.isnan(gap), np.inf, np.maximum(gap, 0.0))
        return found

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


def find_shown_range(lesson: Lesson, flag: str) -> ShownRange | None:
    """Find the feature whose values the presses for a flag have most in common, and these values.

    Parameters
    ----------
    lesson
        The lesson.
    flag
        The flag.

    Returns
    -------
    ShownRange | None
        The range of a feature beyond all values at which something else was right, if there is one, as in learning
        flags first: few presses often agree by chance in a range that has other values on both sides. Of several, the
        one of which the presses cover the smallest share of all its values in the lesson. None if there are fewer than
        FEWEST_PRESSES, or they cover more than LARGEST_SHARE of each feature.
    """
    best = min(_list_ranges(lesson, flag), key=lambda each: each[:2], default=None)
    return None if best is None else best[2]


def _list_ranges(lesson: Lesson, flag: str) -> Iterator[tuple[bool, float, ShownRange]]:
    """Yield the features that the presses for a flag have in common: not beyond all else, the share, the range."""
    automaton = lesson.automaton
    raising = {state.name for state in automaton.states if state.flag == flag}
    ends = {state.name for state in automaton.states if state.flag is not None}
    teaching = [each for each in select_teaching_examples(lesson) if each.state not in ends]
    presses = np.array([each.values for each in teaching if each.next in raising and each.is_shown])
    others = [each for each in teaching if each.next not in ends]
    pressed = np.array([each.is_from_press for each in others], np.bool_)
    if len(presses) < FEWEST_PRESSES:
        return
    for index, feature in enumerate(automaton.features):
        if not isinstance(feature.feature, Feature):
            continue  # of the automaton itself: no other world has it
        column = presses[:, index]
        rest = np.array([each.values[index] for each in others])
        here = ~np.isnan(rest)
        asked, watched, rest = rest[pressed & here], rest[~pressed & here], rest[here]
        if np.isnan(column).any():
            continue
        shown = _find_range(feature, column, asked, watched)
        size = _find_size(feature, np.concatenate([column, rest]))
        share = (shown.high - shown.low) / size if size > 0 else inf
        several = isinstance(feature.kind, Categorical) and shown.low != shown.high
        if share <= LARGEST_SHARE and not several and not shown.contains(rest).all():
            within = ((asked >= shown.low) & (asked <= shown.high)).any()
            beyond = isinf(shown.below) or isinf(shown.above) or isinstance(feature.kind, Categorical)
            yield bool(within) or not beyond, share, shown


def _find_range(feature: BoundFeature, presses: Column, asked: Column, watched: Column) -> ShownRange:
    """Find the range of presses between what else was right: where presses asked for it, or enough silence shows it.

    That a flag was not pressed at once does not say that it is wrong. So watched examples limit it as they limit other
    decisions, ENOUGH_STAYS of them together, and only towards values at which presses asked for something else.
    """
    values = np.unique(presses)
    if isinstance(feature.kind, Toroidal):  # begin after the widest gap
        gaps = np.diff(values, append=values[0] + feature.kind.period)
        values = place_above(float(values[(int(gaps.argmax()) + 1) % len(values)]), values, feature)
    low, high = float(values.min()), float(values.max())
    if isinstance(feature.kind, Categorical):
        return ShownRange(feature, low, high, low - 0.5, high + 0.5, len(presses))
    sides = zip(*(_list_beside(feature, low, high, values) for values in (asked, watched)), strict=True)
    below, above = (_list_limits(*side, alone=not len(asked)) for side in sides)
    return ShownRange(feature, low, high, max(below, default=-inf), min(above, default=inf), len(presses))


def _list_beside(feature: BoundFeature, low: float, high: float, values: Column) -> tuple[Column, Column]:
    """Return the values below and above a range, the nearest first; on a circle, each is on both sides."""
    placed = np.sort(place_above(low, values, feature))
    above = placed[placed > high]
    below = above - feature.kind.period if isinstance(feature.kind, Toroidal) else placed[placed < low]
    return below[::-1], above


def _list_limits(asked: Column, watched: Column, *, alone: bool) -> list[float]:
    """List the nearest value that presses asked for, and the one at which enough silence shows what was right."""
    silent = watched[ENOUGH_STAYS - 1 : ENOUGH_STAYS] if len(asked) or alone else watched[:0]
    return [*asked[:1].tolist(), *silent.tolist()]


def _find_size(feature: BoundFeature, values: Column) -> float:
    if isinstance(feature.kind, Toroidal):
        return feature.kind.period
    if isinstance(feature.kind, Categorical):
        return float(len(feature.kind.labels))
    return float(values.max() - values.min())


def place_above(low: float, values: Column, feature: BoundFeature) -> Column:
    """Return values as they are or, on a circle, each less than one round above `low`."""
    if not isinstance(feature.kind, Toroidal):
        return values
    placed: Column = low + np.mod(values - low, feature.kind.period)
    return placed
