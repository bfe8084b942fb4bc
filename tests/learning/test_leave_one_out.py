"""What the other examples say about each: distances that a reader can check by hand, and predictions the plain way."""

from __future__ import annotations

from math import nan

import numpy as np
import pytest
from tests.make.lessons import make_lesson

from understudy.learning._linalg_kernels import invert_matrix
from understudy.learning.leave_one_out import compute_pairwise_distances, fit_leave_one_out
from understudy.model.value_kinds import Categorical, Continuous, Kind, Toroidal

LIGHT = Categorical(("red", "amber", "green"))

UNLIKE = [  # a kind, two values, how far apart they are where 0 and 10 are also shown
    (Continuous(), 2.0, 7.0, 0.5),
    (Continuous(), nan, nan, 0.0),
    (Continuous(), 10.0, nan, 1.0),
    (Toroidal(40.0), 37.5, 2.5, 0.3826834),  # the sine of an eighth of a turn
    (Toroidal(40.0), 1.0, 21.0, 1.0),
    (LIGHT, 0.0, 2.0, 1.0),
    (LIGHT, nan, 1.0, 1.0),
]


@pytest.mark.parametrize(("kind", "first", "second", "apart"), UNLIKE)
def test_unlikeness(kind: Kind, first: float, second: float, apart: float) -> None:
    column = [[first], [second], [0.0], [2.0 if kind == LIGHT else 10.0]]
    assert compute_pairwise_distances(np.array(column), [kind])[0, 1] == pytest.approx(apart**2)


def test_features_count_alike() -> None:
    """Half of the way by one, all of it by the other: the mean of the squares."""
    values = np.array([[0.0, 0.0], [5.0, 180.0], [10.0, 0.0]])
    assert compute_pairwise_distances(values, [Continuous(), Toroidal(360)])[0, 1] == pytest.approx(
        (0.25 + 1.0) / 2
    )


def test_a_feature_that_never_changes_says_nothing() -> None:
    values = np.array([[0.0, 5.0], [10.0, 5.0]])
    assert compute_pairwise_distances(values, [Continuous()] * 2)[0, 1] == 1.0


def test_hindsight_predicts_as_if_each_had_been_left_out() -> None:
    """The shortcut against the plain way: fit without the example, and ask about it."""
    draws = np.random.default_rng(5)
    values, outcomes = draws.normal(size=(12, 2)), draws.integers(0, 3, 12)
    shown = [
        ("a", row, "abc"[k], "directive") for row, k in zip(values.tolist(), outcomes.tolist(), strict=True)
    ]
    made = make_lesson(shown, [Continuous()] * 2)
    seen = fit_leave_one_out(made, made.examples)
    own = np.eye(3)[outcomes]
    for left_out in ([4], [4, 9]):
        kept = np.setdiff1d(np.arange(12), left_out)
        weights = np.linalg.solve(seen.like[np.ix_(kept, kept)] + 0.1 * np.eye(len(kept)), own[kept] - 1 / 3)
        predicted = seen.like[4, kept] @ weights + 1 / 3
        against = max(np.delete(predicted, outcomes[4])) - predicted[outcomes[4]]
        found = seen.exclude(9) if 9 in left_out else seen
        assert found.score_mislabels()[4] == pytest.approx(against)
    assert 9 not in seen.exclude(9).score_mislabels()


def test_where_all_have_one_outcome_nothing_is_contradicted() -> None:
    made = make_lesson([("a", [k], "b", "directive") for k in range(4)])
    seen = fit_leave_one_out(made, made.examples[::-1])
    assert [example.number for example in seen.examples] == [0, 1, 2, 3]
    assert seen.exclude(2).score_mislabels() == {0: 0.0, 1: 0.0, 3: 0.0}


def test_the_inverse() -> None:
    draws = np.random.default_rng(1).normal(size=(40, 40))
    matrix = draws @ draws.T / 40 + 0.02 * np.eye(40)
    np.testing.assert_allclose(invert_matrix(matrix) @ matrix, np.eye(40), atol=1e-9)
