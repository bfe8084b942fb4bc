"""Rules for where a threshold lies between two neighboring values, and for the outcome of a leaf."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf, nextafter
from typing import NamedTuple

from understudy.learning._split_kernels import DEFAULT, SHOWN


class Gap(NamedTuple):
    """Two neighboring values, and which of them belongs to defaults only.

    `default` is 1 if the upper one does, -1 if the lower one does, and 0 if both or none do.
    """

    lower: float
    upper: float
    default: int


def compute_threshold(gap: Gap, *, midpoints: bool) -> float:
    """Compute the threshold t of the test `x < t` for a gap.

    It lies in the middle or, if one value belongs to defaults only and not `midpoints`, beside the other value.
    """
    lower, upper, default = gap
    if default and not midpoints:
        return nextafter(lower, inf) if default > 0 else upper
    middle = lower / 2 + upper / 2  # halved first: the sum may overflow
    return middle if lower < middle <= upper else upper


def measure_gap_span(gap: Gap, period: float) -> float:
    """Return the distance from the lower to the upper value of a gap, round the circle if needed."""
    return gap.upper - gap.lower if gap.lower < gap.upper else period - gap.lower + gap.upper


def compute_arc(first: Gap, second: Gap, period: float, *, midpoints: bool) -> tuple[float, float]:
    """Compute the ends of an arc that starts in one gap and stops in another.

    Ends lie in the middle of their gaps, except for the narrower of those gaps that have a default on one side
    (the first of equal ones): without `midpoints` that end lies beside the other value. So a single directive
    between two defaults gets an arc of some width.
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
    """Return the outcome of examples, given as (outcome, group), that have one feature vector.

    Directives and confirmations decide; if there are none, defaults; watched examples never. Of tied outcomes
    it is the current state if among them, else the state declared first.
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
