"""Fisher's exact test: whether something is more frequent in one of two independent samples."""

from __future__ import annotations

from functools import lru_cache
from math import comb


@lru_cache(10_000)
def compute_fisher_p(count: int, of: int, other_count: int, other_of: int) -> float:
    """Compute the probability that at least `count` of all cases are in the first sample by chance.

    Parameters
    ----------
    count
        The number of cases in the first sample.
    of
        The size of the first sample.
    other_count
        The number of cases in the second sample.
    other_of
        The size of the second sample.

    Returns
    -------
    float
        The one-sided p-value: Fisher, The Design of Experiments (1935), section 2.
    """
    total = count + other_count
    ways = sum(comb(of, each) * comb(other_of, total - each) for each in range(count, min(of, total) + 1))
    return ways / comb(of + other_of, total)
