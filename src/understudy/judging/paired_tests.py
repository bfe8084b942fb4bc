"""Tests and effect sizes of differences between pairs, exact where that is possible."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb, erfc, nan, sqrt

import numpy as np
from numpy.typing import NDArray

from understudy.judging.intervals import Z95
from understudy.model.value_kinds import Column

MOST_EXACT_PAIRS = 500
"""The largest number of differing pairs for which the signed-rank test is exact."""


def compute_mcnemar_p(only_first: int, only_second: int) -> float:
    """Compute the two-sided p-value that pairs differ equally often in both directions (McNemar's test, exact).

    It is that of the sign test: twice the probability that a fair coin lands on one side as rarely as this.
    """
    differing = only_first + only_second
    as_rare = sum(comb(differing, k) for k in range(min(only_first, only_second) + 1))
    return min(1.0, 2 * as_rare / (1 << differing))


def interval_of_paired_difference(only_first: int, only_second: int, pairs: int) -> tuple[float, float]:
    """Compute a 95 % interval of the second share minus the first, over the same cases (Bonett and Price 2012).

    It is an approximation that adds one to each count of differing pairs, and good from about ten pairs up.
    """
    gained, lost = (only_second + 1) / (pairs + 2), (only_first + 1) / (pairs + 2)
    difference = gained - lost
    half = Z95 * sqrt((gained + lost - difference * difference) / (pairs + 2))
    return max(-1.0, difference - half), min(1.0, difference + half)


@dataclass(frozen=True, slots=True)
class SignedRankTest:
    """The test whether differences of pairs are symmetric around 0 (Wilcoxon 1945), with its effect size.

    Equal pairs are left out of both. Equal differences share the mean of their ranks.
    """

    pairs: int
    """The number of pairs."""
    equal: int
    """The number of pairs without a difference."""
    p: float
    """The two-sided p-value; 1 if no pair differs, NaN if there is none."""
    is_exact: bool
    """Whether it was computed from all assignments of signs, ties included; a normal approximation otherwise."""
    rank_biserial: float
    """The matched-pairs rank-biserial correlation (Kerby 2014), from -1 to 1; NaN if no pair differs.

    It is the sum of the ranks of positive differences minus that of negative ones, over the sum of all.
    """


def compare_signed_ranks(differences: Column) -> SignedRankTest:
    """Test differences of pairs [n], none of which is NaN, with the signed-rank test."""
    apart = differences[differences != 0]
    n = len(apart)
    if n == 0:
        return SignedRankTest(len(differences), len(differences), 1.0 if len(differences) else nan, True, nan)
    doubled, ties = rank_doubled(np.abs(apart))
    positive, total = int(doubled[apart > 0].sum()), int(doubled.sum())
    exact = n <= MOST_EXACT_PAIRS
    p = _compute_exact_p(doubled, positive) if exact else _compute_normal_p(n, positive / 2, ties)
    return SignedRankTest(len(differences), len(differences) - n, p, exact, (2 * positive - total) / total)


def rank_doubled(values: Column) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return twice the rank of each value [n], and how many share each; mean ranks of equal values become whole so."""
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    doubled: NDArray[np.int64] = (2 * np.cumsum(count) - count + 1)[place]
    return doubled, count


def _compute_exact_p(doubled: NDArray[np.int64], positive: int) -> float:
    """Compute the two-sided p-value from the distribution of the sum of positive ranks over all 2^n signs."""
    chances = np.zeros(int(doubled.sum()) + 1)
    chances[0], reach = 1.0, 0
    for rank in doubled.tolist():
        chances[: reach + rank + 1] *= 0.5
        chances[rank : reach + rank + 1] += chances[: reach + 1].copy()
        reach += rank
    lower, upper = float(chances[: positive + 1].sum()), float(chances[positive:].sum())
    return min(1.0, 2 * min(lower, upper))


def _compute_normal_p(n: int, positive: float, ties: NDArray[np.int64]) -> float:
    """Compute the two-sided p-value by the normal approximation, corrected for ties and continuity."""
    variance = n * (n + 1) * (2 * n + 1) / 24 - float((ties.astype(np.float64) ** 3 - ties).sum()) / 48
    off = max(0.0, abs(positive - n * (n + 1) / 4) - 0.5)
    return float(erfc(off / sqrt(variance) / sqrt(2)))
