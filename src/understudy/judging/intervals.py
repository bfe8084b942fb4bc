"""Confidence intervals of shares and medians, exact where that is possible.

An exact interval for a fixed number of trials is too narrow if the number depends on the results. Intervals that hold
at any time, so that a test may stop as soon as they decide, contain the true share at all times at once with the stated
probability. Each limit inverts a family of sequential likelihood ratio tests whose alternative is uniform over all
shares on the other side (mixture tests; Robbins and Siegmund 1974, Annals of Statistics 2, 415-436): the ratio is a
nonnegative supermartingale for every share up to the one that is tested, so it ever reaches 1 / a with a probability of
at most a (Ville 1939).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, inf, lgamma, log, log1p, nan, sqrt

import numpy as np

from understudy.model.value_kinds import Column

Z95 = 1.959964

LEVEL = 0.95
"""The share of repetitions of an experiment in which its interval contains the true value."""


def interval_of_share(count: int, of: int) -> tuple[float, float]:
    """Compute the 95 % score interval of the share `count` / `of` (Wilson 1927, without continuity correction)."""
    if of == 0:
        return 0.0, 1.0
    share, square = count / of, Z95 * Z95 / of
    middle = (share + square / 2) / (1 + square)
    half = Z95 * sqrt(share * (1 - share) / of + square / (4 * of)) / (1 + square)
    return max(0.0, middle - half), min(1.0, middle + half)


def exact_interval_of_share(count: int, of: int, *, level: float = LEVEL) -> tuple[float, float]:
    """Compute the exact interval of the share `count` / `of` (Clopper and Pearson 1934).

    It contains the true share in at least `level` of all cases, for every true share, and so is wider than others.
    """
    tail = (1 - level) / 2
    low = 0.0 if count == 0 else find_beta_quantile(tail, count, of - count + 1)
    high = 1.0 if count == of else find_beta_quantile(1 - tail, count + 1, of - count)
    return low, high


@dataclass(frozen=True, slots=True)
class MedianEstimate:
    """A median with its 95 % interval, over `count` values; NaN without values."""

    median: float
    low: float
    """The lower limit; minus infinity where there are too few values for one."""
    high: float
    """The upper limit; infinity where there are too few values for one."""
    count: int


def find_median(values: Column, *, level: float = LEVEL) -> MedianEstimate:
    """Find the median of the values that are not NaN, and an interval between two of them (order statistics).

    The interval contains the median of the distribution that the values were drawn from in at least `level` of all
    cases, for every distribution. From fewer than six values there is no such interval of 95 %.
    """
    present = np.sort(values[~np.isnan(values)])
    n = len(present)
    if n == 0:
        return MedianEstimate(nan, -inf, inf, 0)
    below = count_outer_values(n, level)
    low, high = (float(present[below - 1]), float(present[n - below])) if below else (-inf, inf)
    return MedianEstimate(float(np.median(present)), low, high, n)


def count_outer_values(n: int, level: float = LEVEL) -> int:
    """Return the rank k of the limits of a median's interval: the k-th smallest and the k-th largest of n values.

    It is the largest k such that fewer than k of n values lie on one given side of the median with a probability of at
    most (1 - level) / 2; 0 if there is none.
    """
    tail, low, high = (1 - level) / 2, 0, n // 2
    while low < high:  # P(at most k - 1 of n) rises with k
        k = (low + high + 1) // 2
        if compute_beta_probability(0.5, n - k + 1, k) <= tail:
            low = k
        else:
            high = k - 1
    return low


def find_beta_quantile(probability: float, a: float, b: float) -> float:
    """Find the value below which a beta distribution with parameters a and b has this probability, by bisection."""
    low, high = 0.0, 1.0
    while low < (middle := (low + high) / 2) < high:
        if compute_beta_probability(middle, a, b) < probability:
            low = middle
        else:
            high = middle
    return middle


def compute_beta_probability(x: float, a: float, b: float) -> float:
    """Compute the probability that a beta distribution with parameters a and b gives to values below x, from 0 to 1.

    It is the regularized incomplete beta function. For whole a and b it is the probability of at least a successes in
    a + b - 1 trials that succeed with probability x.
    """
    if not 0 < x < 1:
        return 0.0 if x <= 0 else 1.0
    front = exp(a * log(x) + b * log1p(-x) + lgamma(a + b) - lgamma(a) - lgamma(b))
    if x < (a + 1) / (a + b + 2):
        return front * _beta_fraction(x, a, b) / a
    return 1 - front * _beta_fraction(1 - x, b, a) / b


TINY, CLOSE = 1e-300, 3e-15


def _beta_fraction(x: float, a: float, b: float) -> float:
    """Evaluate the continued fraction of the incomplete beta function (Abramowitz and Stegun 26.5.8) as Lentz does."""
    c, d = 1.0, 1 / _apart_from_zero(1 - (a + b) * x / (a + 1))
    fraction, m = d, 0
    while True:
        m += 1
        for numerator in (
            m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)),
        ):
            d = 1 / _apart_from_zero(1 + numerator * d)
            c = _apart_from_zero(1 + numerator / c)
            fraction *= c * d
        if abs(c * d - 1) < CLOSE:
            return fraction


def _apart_from_zero(value: float) -> float:
    return value if abs(value) > TINY else TINY


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
