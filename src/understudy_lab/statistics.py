"""Statistics for small samples: spread, intervals, and tests of differences."""

from __future__ import annotations

from collections.abc import Sequence
from math import comb, erfc, sqrt
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.judging.intervals import interval_of_share
from understudy.judging.paired_tests import compute_mcnemar_p

Numbers: TypeAlias = Sequence[float] | NDArray[np.float64]


def spread(values: Numbers) -> dict[str, float]:
    """Return minimum, median and maximum."""
    low, middle, high = np.percentile(np.asarray(values, np.float64), [0, 50, 100])
    return {"min": round(float(low), 4), "median": round(float(middle), 4), "max": round(float(high), 4)}


def format_median(values: Numbers, digits: int = 0, *, percent: bool = False) -> str:
    """Format the median with minimum and maximum: "40 (31–55)"; for shares in percent: "98 % (93–100)"."""
    if len(values) == 0:
        return "none"
    low, middle, high = np.percentile(np.asarray(values, np.float64) * (100 if percent else 1), [0, 50, 100])
    return f"{middle:.{digits}f}{' %' if percent else ''} ({low:.{digits}f}–{high:.{digits}f})"


def format_share(count: int, of: int) -> str:
    """Format a count with the 95 % interval of its share: "12 of 20 (39–78 %)"."""
    low, high = interval_of_share(count, of)
    return f"{count} of {of} ({100 * low:.0f}–{100 * high:.0f} %)"


def interval_of_median(values: Numbers, *, draws: int = 4_000) -> tuple[float, float]:
    """Return a 95 % interval of the median by the percentile bootstrap (Efron 1979), always with the same draws."""
    numbers = np.asarray(values, np.float64)
    drawn = np.random.default_rng(0).integers(len(numbers), size=(draws, len(numbers)))
    low, high = np.percentile(np.median(numbers[drawn], axis=1), [2.5, 97.5])
    return float(low), float(high)


def compute_paired_p(first: Numbers, second: Numbers) -> float:
    """Return the two-sided p-value of the signed-rank test on pairs (Wilcoxon 1945).

    The normal approximation is used, with a correction for ties; equal pairs are left out.
    """
    apart = np.asarray(first, np.float64) - np.asarray(second, np.float64)
    apart = apart[apart != 0]
    n = len(apart)
    if n == 0:
        return 1.0
    _, place, count = np.unique(np.abs(apart), return_inverse=True, return_counts=True)
    ranks = (np.cumsum(count) - (count - 1) / 2)[place]
    ties = float((count.astype(np.float64) ** 3 - count).sum())
    variance = n * (n + 1) * (2 * n + 1) / 24 - ties / 48
    off = max(0.0, abs(float(ranks[apart > 0].sum()) - n * (n + 1) / 4) - 0.5)
    return float(erfc(off / sqrt(variance) / sqrt(2)))


def compute_unpaired_p(first: Numbers, second: Numbers) -> float:
    """Return the two-sided p-value of the rank-sum test on two groups (Mann and Whitney 1947).

    The normal approximation is used, with a correction for ties.
    """
    sizes = n, m = len(first), len(second)
    pooled = np.concatenate([np.asarray(first, np.float64), np.asarray(second, np.float64)])
    _, place, count = np.unique(pooled, return_inverse=True, return_counts=True)
    ranks = (np.cumsum(count) - (count - 1) / 2)[place]
    statistic = float(ranks[:n].sum()) - n * (n + 1) / 2
    total = sum(sizes)
    ties = float((count.astype(np.float64) ** 3 - count).sum())
    variance = n * m / 12 * (total + 1 - ties / (total * (total - 1)))
    if variance <= 0:
        return 1.0
    off = max(0.0, abs(statistic - n * m / 2) - 0.5)
    return float(erfc(off / sqrt(variance) / sqrt(2)))


def shares_differ(first: Sequence[bool], second: Sequence[bool]) -> float:
    """Return the two-sided p-value that two groups have the same share (Fisher's exact test).

    It adds up the probabilities of all tables that are no likelier than the observed one.
    """
    n, m = len(first), len(second)
    having = sum(first) + sum(second)
    ways = [comb(n, k) * comb(m, having - k) for k in range(having + 1)]
    return sum(way for way in ways if way <= ways[sum(first)]) / sum(ways)


def pairs_differ(first: Sequence[bool], second: Sequence[bool]) -> float:
    """Return the two-sided p-value that pairs differ equally often in both directions (McNemar's test, exact)."""
    won = sum(now and not before for before, now in zip(first, second, strict=True))
    lost = sum(before and not now for before, now in zip(first, second, strict=True))
    return compute_mcnemar_p(lost, won)


def apply_holm_correction(chances: Sequence[float], level: float = 0.05) -> list[bool]:
    """Return which p-values are significant at the family-wise error rate `level` (Holm 1979)."""
    remain = [False] * len(chances)
    for passed, k in enumerate(sorted(range(len(chances)), key=lambda k: chances[k])):
        if chances[k] > level / (len(chances) - passed):
            break
        remain[k] = True
    return remain
