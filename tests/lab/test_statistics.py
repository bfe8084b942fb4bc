"""Statistics beside SciPy's, and cases that can be checked by hand."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest

from understudy.judging.intervals import interval_of_share
from understudy_lab import statistics

stats = import_module("scipy.stats")


@pytest.mark.parametrize("seed", range(8))
def test_mann_whitney_as_scipy(seed: int) -> None:
    draws = np.random.default_rng(seed)
    first, second = draws.integers(0, 9, 25).astype(float), draws.integers(2, 11, 31).astype(float)
    found = stats.mannwhitneyu(first, second, method="asymptotic")
    assert statistics.compute_unpaired_p(first, second) == pytest.approx(float(found.pvalue))


@pytest.mark.parametrize("seed", range(8))
def test_signed_ranks_as_scipy(seed: int) -> None:
    draws = np.random.default_rng(seed)
    first, second = draws.integers(0, 9, 20).astype(float), draws.integers(1, 10, 20).astype(float)
    found = stats.wilcoxon(first, second, zero_method="wilcox", correction=True, method="asymptotic")
    assert statistics.compute_paired_p(first, second) == pytest.approx(float(found.pvalue))


def test_pairs_all_alike_do_not_differ() -> None:
    assert statistics.compute_paired_p([1.0, 2.0], [1.0, 2.0]) == 1.0


def test_groups_all_alike_do_not_differ() -> None:
    assert statistics.compute_unpaired_p([1.0, 1.0], [1.0, 1.0, 1.0]) == 1.0


@pytest.mark.parametrize(("count", "of"), [(0, 10), (10, 10), (7, 20), (99, 100)])
def test_wilson_as_scipy(count: int, of: int) -> None:
    found = stats.binomtest(count, of).proportion_ci(method="wilson")
    assert interval_of_share(count, of) == pytest.approx((found.low, found.high), abs=1e-6)


def test_the_interval_of_a_median_holds_it() -> None:
    low, high = statistics.interval_of_median(list(range(101)))
    assert 35 < low < 50 < high < 65


def test_told() -> None:
    assert statistics.format_median([3.0, 1.0, 2.0]) == "2 (1–3)"
    assert statistics.format_median([0.5, 1.0], percent=True) == "75 % (50–100)"
    assert statistics.format_median([]) == "none"
