"""Tests of pairs beside SciPy's, and beside all assignments of signs where there are ties."""

from __future__ import annotations

from importlib import import_module
from itertools import product
from math import isnan

import numpy as np
import pytest

from understudy.judging.paired_tests import (
    MOST_EXACT_PAIRS,
    compare_signed_ranks,
    compute_mcnemar_p,
    interval_of_paired_difference,
)

stats = import_module("scipy.stats")

FLIPS = [(0, 0, 1.0), (5, 5, 1.0), (0, 1, 1.0), (0, 5, 2 / 32), (1, 5, 14 / 64), (0, 10, 2 / 1024)]


@pytest.mark.parametrize(("only_first", "only_second", "p"), FLIPS)
def test_mcnemar_is_the_toss_of_a_coin(only_first: int, only_second: int, p: float) -> None:
    assert compute_mcnemar_p(only_first, only_second) == compute_mcnemar_p(only_second, only_first) == p
    if only_first + only_second:
        expected = stats.binomtest(only_first, only_first + only_second).pvalue
        assert compute_mcnemar_p(only_first, only_second) == pytest.approx(float(expected))


@pytest.mark.parametrize("n", [1, 2, 6, 25, 50])
def test_signed_ranks_without_ties_as_scipy(n: int) -> None:
    differences = np.random.default_rng(n).normal(0.3, 1.0, n)
    found = compare_signed_ranks(differences)
    assert found.p == pytest.approx(float(stats.wilcoxon(differences, method="exact").pvalue))
    assert (found.pairs, found.equal, found.is_exact) == (n, 0, True)


@pytest.mark.parametrize("seed", range(6))
def test_signed_ranks_with_ties_as_all_assignments_of_signs(seed: int) -> None:
    differences = np.random.default_rng(seed).integers(-2, 5, 11).astype(np.float64)
    apart = differences[differences != 0]
    ranks = stats.rankdata(np.abs(apart))
    observed = ranks[apart > 0].sum()
    sums = np.array([ranks[np.array(signs, np.bool_)].sum() for signs in product((0, 1), repeat=len(apart))])
    expected = min(1.0, 2 * min((sums <= observed).mean(), (sums >= observed).mean()))
    found = compare_signed_ranks(differences)
    assert found.p == pytest.approx(expected, rel=1e-12)
    assert found.equal == 11 - len(apart)
    assert found.rank_biserial == pytest.approx((2 * observed - ranks.sum()) / ranks.sum())


def test_many_pairs_are_approximated_as_scipy_does() -> None:
    differences = np.random.default_rng(3).integers(-9, 11, MOST_EXACT_PAIRS + 100).astype(np.float64)
    found = compare_signed_ranks(differences)
    expected = stats.wilcoxon(differences, zero_method="wilcox", correction=True, method="asymptotic")
    assert not found.is_exact
    assert found.p == pytest.approx(float(expected.pvalue))


def test_exact_and_approximate_agree_where_they_meet() -> None:
    differences = np.random.default_rng(4).normal(0.1, 1.0, MOST_EXACT_PAIRS)
    expected = stats.wilcoxon(differences, correction=True, method="asymptotic")
    assert compare_signed_ranks(differences).p == pytest.approx(float(expected.pvalue), rel=0.01)


EFFECTS = [([1.0, 2.0, 3.0], 1.0), ([-1.0, -2.0, 0.0], -1.0), ([1.0, -1.0], 0.0), ([1.0, 2.0, -3.0], 0.0)]


@pytest.mark.parametrize(("differences", "effect"), EFFECTS)
def test_the_rank_biserial_correlation(differences: list[float], effect: float) -> None:
    assert compare_signed_ranks(np.array(differences)).rank_biserial == effect


def test_without_pairs_there_is_no_test() -> None:
    assert isnan(compare_signed_ranks(np.zeros(0)).p)


def test_pairs_that_are_all_equal() -> None:
    found = compare_signed_ranks(np.zeros(4))
    assert (found.p, found.equal) == (1.0, 4)
    assert isnan(found.rank_biserial)


SHARES = [(0.05, 0.05), (0.3, 0.1), (0.5, 0.02), (0.2, 0.6)]


@pytest.mark.parametrize(("losing", "gaining"), SHARES)
def test_the_interval_of_a_paired_difference_covers_it(losing: float, gaining: float) -> None:
    """Summed over all outcomes of 20 pairs, weighted by their probability: at least 93 %."""
    n, covered = 20, 0.0
    for lost in range(n + 1):
        for gained in range(n + 1 - lost):
            low, high = interval_of_paired_difference(lost, gained, n)
            chance = stats.multinomial.pmf(
                [lost, gained, n - lost - gained], n, [losing, gaining, 1 - losing - gaining]
            )
            covered += float(chance) * (low <= gaining - losing <= high)
    assert 0.93 <= covered < 0.999


def test_the_interval_of_a_paired_difference_by_hand() -> None:
    """Of 10 pairs 1 is lost and 5 are gained, each count plus one of twelve: 6/12 - 2/12 = 1/3."""
    low, high = interval_of_paired_difference(1, 5, 10)
    assert (low + high) / 2 == pytest.approx(1 / 3)
    assert high - low == pytest.approx(2 * 1.959964 * ((8 / 12 - 1 / 9) / 12) ** 0.5)
