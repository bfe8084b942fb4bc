"""Intervals that hold at any time: their error rate is computed exactly, over all ways in which trials can come out."""

from __future__ import annotations

from math import log

import numpy as np
import pytest

from understudy.analysis.intervals import (
    compute_evidence_above,
    count_fewest_trials,
    exact_interval_of_share,
    interval_of_share_at_any_time,
)


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
