"""Fisher's exact test of two independent samples, against a count of all ways."""

from __future__ import annotations

from itertools import combinations

import pytest

from understudy.learning.fisher_test import compute_fisher_p

TABLES = [  # cases in the first sample and its size, cases in the second and its size, p
    (2, 2, 0, 2, 1 / 6),  # both of the first two of four: one of six ways to choose two
    (0, 2, 2, 2, 1.0),
    (3, 4, 1, 4, 17 / 70),  # the tea tasting of Fisher: 16 + 1 of 70 ways
    (4, 4, 0, 4, 1 / 70),
    (0, 5, 0, 7, 1.0),
]


@pytest.mark.parametrize(("count", "of", "other", "other_of", "p"), TABLES)
def test_tables_that_are_counted_by_hand(count: int, of: int, other: int, other_of: int, p: float) -> None:
    assert compute_fisher_p(count, of, other, other_of) == pytest.approx(p)


def test_it_counts_the_ways_in_which_cases_fall_into_the_first_sample() -> None:
    for of, total, cases in ((3, 8, 4), (5, 9, 2), (4, 7, 5)):
        ways = [sum(each < of for each in chosen) for chosen in combinations(range(total), cases)]
        for count in range(max(0, cases - (total - of)), min(of, cases) + 1):
            p = sum(each >= count for each in ways) / len(ways)
            assert compute_fisher_p(count, of, cases - count, total - of) == pytest.approx(p)
