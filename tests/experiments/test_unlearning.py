"""Sparse lessons with wrong labels, and that both ways of correcting meet the same."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.experiments.unlearning.correcting import LEARNERS, compared, corrected
from understudy.experiments.unlearning.run import SETTINGS, Setting, outcomes
from understudy.experiments.unlearning.sparse import DATA_SETS, NOISES, SIZES, data_set, lesson_of, sparse


@pytest.mark.parametrize("name", DATA_SETS)
@pytest.mark.parametrize("size", SIZES)
def test_lessons_are_sparse_and_apart_from_what_is_met(name: str, size: str) -> None:
    drawn = sparse(name, size, 0.2, seed=1)
    classes = len(np.unique(data_set(name)[1]))
    assert len(drawn.shown) == (4 * classes if size == "4 a class" else 60)
    assert len(drawn.met) == len(drawn.test) <= 300
    vectors, counts = np.unique(data_set(name)[0], axis=0, return_counts=True)
    once = {tuple(vector) for vector in vectors[counts == 1].tolist()}
    parts = [{tuple(row) for row in part.tolist()} & once for part in (drawn.shown, drawn.met, drawn.test)]
    assert sum(map(len, parts)) == len(set().union(*parts))


def test_so_many_labels_are_wrong() -> None:
    for noise in NOISES:
        shares = [sparse("digits", SIZES[1], noise, seed).bad.mean() for seed in range(40)]
        assert np.mean(shares) == pytest.approx(noise, abs=0.02)
    vectors, labels = data_set("digits")
    known = {tuple(vector): label for vector, label in zip(vectors.tolist(), labels.tolist(), strict=True)}
    drawn = sparse("digits", SIZES[1], 0.2, 1)
    truth = [known[tuple(row)] for row in drawn.shown.tolist()]
    assert (np.not_equal(truth, drawn.labels) == drawn.bad).all()


def test_corrections_are_few_and_right() -> None:
    drawn = sparse("digits", SIZES[0], 0.2, 3)
    alone = corrected(drawn, LEARNERS["trees"], unlearn=False)
    assert (alone.corrections, alone.quarantined) == (20, frozenset())
    unlearned = corrected(drawn, LEARNERS["trees"], unlearn=True)
    assert unlearned.quarantined
    assert max(unlearned.quarantined) <= len(lesson_of(drawn, LEARNERS["trees"]).examples)


def test_a_lesson_without_mistakes_loses_little() -> None:
    """Nobody is suspected where nobody slipped, but at the borders of classes."""
    drawn = sparse("iris", SIZES[1], 0.0, 2)
    *_, bad, found, good, lost = compared(drawn, LEARNERS["trees"])
    assert (bad, found, good) == (0, 0, 60)
    assert lost <= 4


def test_outcomes_are_means_and_sums_by_setting() -> None:
    plain = [[0.5, 0.75, 20, 10, 4, 3, 56, 1]] * len(SETTINGS)
    better = [[0.5, 0.85, 20, 12, 2, 2, 58, 0], *plain[1:]]
    found = outcomes([{"outcomes": plain}, {"outcomes": better}])
    first = found[Setting("iris", "4 a class", 0.05, "trees")]
    assert (first.alone, first.unlearned, first.gain) == (0.5, 0.8, 0.3)
    assert (first.corrections_unlearned, first.bad, first.found, first.lost) == (11, 6, 5, 1)
