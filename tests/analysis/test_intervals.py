"""Exact intervals beside SciPy's, closed forms, and their coverage; the error rate of those that hold at any time."""

from __future__ import annotations

from importlib import import_module
from math import comb, inf, isnan, log

import numpy as np
import pytest

from understudy.judging.intervals import (
    compute_beta_probability,
    compute_evidence_above,
    count_fewest_trials,
    count_outer_values,
    exact_interval_of_share,
    find_median,
    interval_of_share_at_any_time,
)

stats = import_module("scipy.stats")

COUNTS = [(0, 1), (1, 1), (0, 10), (10, 10), (7, 20), (50, 100), (99, 100), (3, 4_000), (499_999, 1_000_000)]


@pytest.mark.parametrize(("count", "of"), COUNTS)
def test_the_interval_of_a_share_as_scipy(count: int, of: int) -> None:
    expected = stats.binomtest(count, of).proportion_ci(method="exact")
    assert exact_interval_of_share(count, of) == pytest.approx((expected.low, expected.high), abs=1e-10)


@pytest.mark.parametrize("n", [1, 5, 30, 1_000])
def test_without_failures_the_interval_has_a_closed_form(n: int) -> None:
    """The lower limit p is where n successes of n have a probability of 2.5 %: p ** n = 0.025."""
    assert exact_interval_of_share(n, n) == pytest.approx((0.025 ** (1 / n), 1.0))
    assert exact_interval_of_share(0, n) == pytest.approx((0.0, 1 - 0.025 ** (1 / n)))


@pytest.mark.parametrize("share", [0.01, 0.2, 0.5, 0.93])
def test_the_interval_of_a_share_is_never_too_narrow(share: float) -> None:
    n = 25
    intervals = [exact_interval_of_share(count, n) for count in range(n + 1)]
    chances = [comb(n, k) * share**k * (1 - share) ** (n - k) for k in range(n + 1)]
    within = [chance for chance, (low, high) in zip(chances, intervals, strict=True) if low <= share <= high]
    assert sum(within) >= 0.95


@pytest.mark.parametrize(("a", "b"), [(1, 1), (0.5, 0.5), (2, 7), (300, 4)])
def test_the_incomplete_beta_function_as_scipy(a: float, b: float) -> None:
    for x in (0.0, 1e-6, 0.2, 0.5, 0.97, 1.0):
        assert compute_beta_probability(x, a, b) == pytest.approx(float(stats.beta.cdf(x, a, b)), abs=1e-13)


RANKS = [  # n, k, from tables of the sign test at 5 %
    (1, 0), (5, 0), (6, 1), (8, 1), (9, 2), (11, 2), (12, 3), (20, 6), (25, 8), (100, 40),
]  # fmt: skip


@pytest.mark.parametrize(("n", "rank"), RANKS)
def test_the_ranks_of_the_limits_of_a_median(n: int, rank: int) -> None:
    assert count_outer_values(n) == rank
    tail = [sum(comb(n, k) for k in range(least)) / 2**n for least in (rank, rank + 1)]
    assert tail[0] <= 0.025 < tail[1]


def test_the_interval_of_a_median_lies_between_two_values() -> None:
    values = np.array([np.nan, *np.random.default_rng(1).permutation(np.arange(1.0, 21.0))])
    found = find_median(values)
    assert (found.median, found.low, found.high, found.count) == (10.5, 6.0, 15.0, 20)


def test_from_few_values_there_is_no_interval() -> None:
    found = find_median(np.array([3.0, 1.0, 2.0]))
    assert (found.median, found.low, found.high) == (2.0, -inf, inf)
    nothing = find_median(np.array([np.nan]))
    assert isnan(nothing.median)
    assert nothing.count == 0


def compute_error_rate(true: float, claimed: float, trials: int) -> tuple[float, float]:
    """Return the probabilities that a test looking after every trial ever says "at least" and "less than" `claimed`.

    The number of successes is a Markov chain: its distribution is carried along, without the paths that have stopped.
    """
    alive, above, below = np.array([1.0]), 0.0, 0.0
    for of in range(1, trials + 1):
        alive = np.append(alive, 0.0) * (1 - true) + np.append(0.0, alive) * true
        for count in range(of + 1):
            if alive[count] < 1e-12:
                continue
            if compute_evidence_above(claimed, count, of) >= log(40):
                above, alive[count] = above + alive[count], 0.0
            elif compute_evidence_above(1 - claimed, of - count, of) >= log(40):
                below, alive[count] = below + alive[count], 0.0
    return above, below


@pytest.mark.parametrize("share", [0.5, 0.9, 0.97])
def test_it_errs_at_most_once_in_forty(share: float) -> None:
    """The share is exactly what is claimed, so each limit lies wrong at most 2.5 % of the time, after any number."""
    above, below = compute_error_rate(share, share, 300)
    assert 0.001 < above <= 0.025
    assert 0.001 < below <= 0.025


def test_it_decides_where_the_share_is_another() -> None:
    above, below = compute_error_rate(0.99, 0.9, 300)
    assert above > 0.99
    assert below < 1e-3
    above, below = compute_error_rate(0.6, 0.9, 300)
    assert below > 0.99
    assert above < 1e-6


@pytest.mark.parametrize(("count", "of"), [(0, 10), (5, 10), (10, 10), (990, 1000), (1000, 1000)])
def test_its_limits_are_where_the_evidence_suffices(count: int, of: int) -> None:
    low, high = interval_of_share_at_any_time(count, of)
    exact_low, exact_high = exact_interval_of_share(count, of)
    assert 0.0 <= low <= exact_low <= exact_high <= high <= 1.0
    if count:
        assert compute_evidence_above(low, count, of) == pytest.approx(log(40), abs=1e-6)
    assert interval_of_share_at_any_time(of - count, of) == pytest.approx((1 - high, 1 - low))


@pytest.mark.parametrize("share", [0.5, 0.9, 0.99])
def test_so_many_without_a_failure_decide(share: float) -> None:
    fewest = count_fewest_trials(share)
    assert interval_of_share_at_any_time(fewest, fewest)[0] >= share
    assert interval_of_share_at_any_time(fewest - 1, fewest - 1)[0] < share
