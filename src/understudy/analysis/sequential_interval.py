"""Intervals of a share that hold at any time, so that a test may stop as soon as they decide.

An exact interval for a fixed number of trials is too narrow if the number depends on the results. These intervals
contain the true share at all times at once with the stated probability. Each limit inverts a family of sequential
likelihood ratio tests whose alternative is uniform over all shares on the other side (mixture tests; Robbins and
Siegmund 1974, Annals of Statistics 2, 415-436): the ratio is a nonnegative supermartingale for every share up to the
one that is tested, so it ever reaches 1 / a with a probability of at most a (Ville 1939).
"""

from __future__ import annotations

from math import inf, lgamma, log, log1p

from understudy.analysis.intervals import LEVEL, compute_beta_probability


def interval_of_share_at_any_time(count: int, of: int, *, level: float = LEVEL) -> tuple[float, float]:
    """Compute an interval of the share `count` / `of` that is valid however it was decided to stop.

    Parameters
    ----------
    count
        The number of successes.
    of
        The number of trials so far.
    level
        The probability with which the interval contains the true share after every number of trials.

    Returns
    -------
    tuple[float, float]
        Its limits, between 0 and 1.
    """
    tail = (1 - level) / 2
    return _find_lower_limit(count, of, tail), 1.0 - _find_lower_limit(of - count, of, tail)


def compute_evidence_above(share: float, count: int, of: int) -> float:
    """Compute the logarithm of the evidence that the true share is above `share`, after `count` successes of `of`.

    It is the likelihood ratio of shares above, weighted uniformly, against `share`. If the true share is not above,
    it ever reaches log(1 / a) with a probability of at most a.
    """
    a, b = count + 1, of - count + 1
    above = compute_beta_probability(1.0 - share, b, a)
    if above <= 0.0:
        return -inf
    whole = lgamma(a) + lgamma(b) - lgamma(a + b)
    return whole + log(above) - log1p(-share) - count * log(share) - (of - count) * log1p(-share)


def count_fewest_trials(share: float, *, level: float = LEVEL) -> int:
    """Return after how many trials, all successful, an interval at any time lies above a share."""
    tail = (1 - level) / 2
    low, high = 1, 2
    while compute_evidence_above(share, high, high) < -log(tail):
        low, high = high, 2 * high
    while low < high:
        middle = (low + high) // 2
        if compute_evidence_above(share, middle, middle) < -log(tail):
            low = middle + 1
        else:
            high = middle
    return high


def _find_lower_limit(count: int, of: int, tail: float) -> float:
    """Find the largest share that the evidence is sufficient against, by bisection; 0 if there is none."""
    if count == 0:
        return 0.0
    low, high = 0.0, count / of
    while low < (middle := (low + high) / 2) < high:
        if compute_evidence_above(middle, count, of) >= -log(tail):
            low = middle
        else:
            high = middle
    return low
