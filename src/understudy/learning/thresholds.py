"""Where a boundary goes between two neighboring values, and what a leaf answers, in plain rules."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf, nextafter
from typing import NamedTuple

from understudy.learning._split_kernels import DEFAULT, SHOWN


class Gap(NamedTuple):
    """Two neighboring values, and where the default is: above (1), below (-1), or both or neither (0)."""

    lower: float
    upper: float
    default: int


def compute_threshold(gap: Gap, *, midpoints: bool) -> float:
    """The t of `x < t` for a cut in a gap: the default keeps the gap, otherwise the middle."""
    lower, upper, default = gap
    if default and not midpoints:
        return nextafter(lower, inf) if default > 0 else upper
    middle = lower / 2 + upper / 2  # halved first: the sum may overflow
    return middle if lower < middle <= upper else upper


def measure_gap_span(gap: Gap, period: float) -> float:
    """How far it is from one value to the other round the circle."""
    return gap.upper - gap.lower if gap.lower < gap.upper else period - gap.lower + gap.upper


def compute_arc(first: Gap, second: Gap, period: float, *, midpoints: bool) -> tuple[float, float]:
    """The ends of an arc that starts in one gap and stops in another.

    Of the ends between a directive and a default the narrower is cut beside the directive (a tie: the first),
    so that one directive between two defaults keeps an arc of some width; other ends go to the middle.
    """
    follows = None
    if not midpoints:
        sided = [gap for gap in (first, second) if gap.default]
        follows = min(sided, key=lambda gap: round(measure_gap_span(gap, period) / period, 9), default=None)
    return _arc_end(first, period, follows is first), _arc_end(second, period, follows is second)


def _arc_end(gap: Gap, period: float, follows: bool) -> float:
    lower, upper, default = gap
    if follows:
        cut = upper if default < 0 else nextafter(lower, inf)
        return cut if cut < period else 0.0
    cut = lower + measure_gap_span(gap, period) / 2
    if lower < upper:
        return cut if lower < cut <= upper else upper
    if cut >= period:
        return min(cut - period, upper)
    return cut if cut > lower else upper


def vote(votes: Iterable[tuple[int, int]], *, current: int) -> int:
    """The outcome of examples (outcome, group) with one feature vector.

    Directives and confirmations decide; defaults where there are neither; watched ones never. A tie stays in
    the current state if that is among the tied, else it is the state declared first.
    """
    heard: dict[int, int] = {}
    fallback: dict[int, int] = {}
    for outcome, group in votes:
        if group in (SHOWN, DEFAULT):
            counts = heard if group == SHOWN else fallback
            counts[outcome] = counts.get(outcome, 0) + 1
    counts = heard or fallback
    most = max(counts.values())
    tied = [outcome for outcome, count in counts.items() if count == most]
    return current if current in tied else min(tied)
