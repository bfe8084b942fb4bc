"""Sparse lessons with wrong labels, and that both ways of correcting meet the same."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
import pytest

from understudy.learning.mislabels import CorrectionDiagnosis, diagnose_correction
from understudy.model.learner_options import SklearnOptions
from understudy.model.lesson import Example, Lesson
from understudy_lab.study import StudyFindings
from understudy_lab.unlearning import study
from understudy_lab.unlearning.datasets import (
    DATA_SETS,
    NOISES,
    SIZES,
    SparseLesson,
    data_set,
    draw_sparse_lesson,
    lesson_of,
)
from understudy_lab.unlearning.study import (
    LEARNERS,
    SETTINGS,
    Condition,
    Results,
    compare_with_unlearning,
    teach_and_correct,
)


@pytest.mark.parametrize("name", DATA_SETS)
@pytest.mark.parametrize("size", SIZES)
def test_lessons_are_sparse_and_apart_from_what_is_met(name: str, size: str) -> None:
    drawn = draw_sparse_lesson(name, size, 0.2, seed=1)
    classes = len(np.unique(data_set(name)[1]))
    assert len(drawn.shown) == (4 * classes if size == "4 a class" else 60)
    assert len(drawn.met) == len(drawn.test) <= 300
    vectors, counts = np.unique(data_set(name)[0], axis=0, return_counts=True)
    once = {tuple(vector) for vector in vectors[counts == 1].tolist()}
    parts = [{tuple(row) for row in part.tolist()} & once for part in (drawn.shown, drawn.met, drawn.test)]
    assert sum(map(len, parts)) == len(set().union(*parts))


def test_so_many_labels_are_wrong() -> None:
    for noise in NOISES:
        shares = [draw_sparse_lesson("digits", SIZES[1], noise, seed).bad.mean() for seed in range(40)]
        assert np.mean(shares) == pytest.approx(noise, abs=0.02)
    vectors, labels = data_set("digits")
    known = {tuple(vector): label for vector, label in zip(vectors.tolist(), labels.tolist(), strict=True)}
    drawn = draw_sparse_lesson("digits", SIZES[1], 0.2, 1)
    truth = [known[tuple(row)] for row in drawn.shown.tolist()]
    assert (np.not_equal(truth, drawn.labels) == drawn.bad).all()


def test_features_are_in_units_of_their_spread() -> None:
    for name in DATA_SETS:
        vectors, _ = data_set(name)
        np.testing.assert_allclose(vectors.mean(axis=0), 0.0, atol=1e-9)
        spread = vectors.std(axis=0)
        np.testing.assert_allclose(spread[spread > 0], 1.0)


def test_nothing_is_shown_twice() -> None:
    assert len(np.unique(data_set("wine")[0], axis=0)) == 178, "all of them differ"
    for seed in range(5):
        assert len(np.unique(draw_sparse_lesson("wine", SIZES[1], 0.0, seed).shown, axis=0)) == 60


def line(
    shown: dict[float, int], met: dict[float, int], test: dict[float, int], bad: Collection[float] = ()
) -> SparseLesson:
    """A lesson of one feature: labels by what was shown, what the robot meets, and what it is judged on."""

    def columns(of: dict[float, int]) -> tuple[Any, Any]:
        return np.array(list(of), np.float64).reshape(-1, 1), np.array(list(of.values()), np.int64)

    wrong = np.array([each in bad for each in shown])
    return SparseLesson(*columns(shown), wrong, *columns(met), *columns(test))


SPLIT = line(
    {0.0: 0, 1.0: 0, 2.0: 0, 10.0: 1, 11.0: 1, 12.0: 1},
    {0.5: 0, 6.5: 0, 10.5: 1, 7.0: 0, 9.2: 0, 9.1: 0, 9.7: 1},
    {8.9: 0, 9.65: 1, 9.4: 0, 30.0: 0},
)
"""The boundary is between 9.2 and 9.7. Trees have it at 6 first: wrong about 6.5. Then at 8.25: right about 7, and
wrong about 9.2. Then at 9.6, and right from there on. Of what they are judged on the last goes astray."""


@pytest.mark.parametrize("learner", ["trees", "k-NN 1"])
def test_one_is_met_after_another(learner: str) -> None:
    """The nearest neighbor has the boundary at the very same places."""
    learners = {**LEARNERS, "k-NN 1": SklearnOptions("KNeighborsClassifier", {"n_neighbors": 1})}
    assert teach_and_correct(SPLIT, learners[learner], unlearn=False) == (0.75, 2, frozenset())


MISLED = line(
    {0.0: 0, 1.0: 0, 2.0: 0, 3.0: 0, 4.0: 0, 2.5: 1, 20.0: 1, 21.0: 1, 22.0: 1, 23.0: 1, 24.0: 1, 22.5: 0},
    {2.4: 0, 2.6: 0, 22.4: 1, 22.6: 1},
    {2.45: 0, 2.55: 0, 22.45: 1, 22.55: 1},
    bad={2.5, 22.5},
)
"""Two were labeled wrong, at 2.5 and 22.5. Each misleads the robot on either side of it, unless it is found out."""


def test_bad_examples_are_found_one_after_the_other() -> None:
    unlearned = teach_and_correct(MISLED, LEARNERS["trees"], unlearn=True)
    assert unlearned == (1.0, 2, frozenset({6, 12}))
    alone = teach_and_correct(MISLED, LEARNERS["trees"], unlearn=False)
    assert (alone.corrections, alone.quarantined) == (4, frozenset())
    assert alone.accuracy < 1.0
    assert compare_with_unlearning(MISLED, LEARNERS["trees"]) == [alone.accuracy, 1.0, 4, 2, 2, 2, 10, 0]


def test_whom_a_correction_does_not_convince_is_not_corrected_again() -> None:
    """Two of the three nearest still say otherwise."""
    drawn = line({0.0: 0, 1.0: 0, 10.0: 1, 10.5: 1, 11.0: 1}, {10.2: 0, 0.5: 0}, {10.2: 0, 0.5: 0})
    assert teach_and_correct(drawn, LEARNERS["k-NN"], unlearn=False) == (0.5, 1, frozenset())


def test_what_is_judged_is_a_correction(monkeypatch: pytest.MonkeyPatch) -> None:
    judged: list[Example] = []

    def diagnose_and_note(lesson: Lesson, correction: Example) -> CorrectionDiagnosis:
        judged.append(correction)
        return diagnose_correction(lesson, correction)

    monkeypatch.setattr(study, "diagnose_correction", diagnose_and_note)
    teach_and_correct(MISLED, LEARNERS["trees"], unlearn=True)
    assert [(each.number, each.correction) for each in judged] == [(13, True), (14, True)]


def test_good_ones_that_are_lost_are_counted() -> None:
    """Nobody slipped, but it is the same lesson."""
    nobody = MISLED._replace(bad=np.zeros(12, np.bool_))
    assert compare_with_unlearning(nobody, LEARNERS["trees"])[4:] == [0, 0, 12, 2]


def test_a_lesson_is_without_states() -> None:
    lesson = lesson_of(draw_sparse_lesson("iris", SIZES[0], 0.2, 1), LEARNERS["trees"])
    assert lesson.automaton.stateless
    assert (len(lesson.examples), {each.state for each in lesson.examples}) == (12, {"start"})


def test_corrections_are_few_and_right() -> None:
    drawn = draw_sparse_lesson("digits", SIZES[0], 0.2, 3)
    alone = teach_and_correct(drawn, LEARNERS["trees"], unlearn=False)
    assert (alone.corrections, alone.quarantined) == (20, frozenset())
    unlearned = teach_and_correct(drawn, LEARNERS["trees"], unlearn=True)
    assert unlearned.quarantined
    assert max(unlearned.quarantined) <= len(lesson_of(drawn, LEARNERS["trees"]).examples)


def test_a_lesson_without_mistakes_loses_little() -> None:
    """Nobody is suspected where nobody slipped, but at the borders of classes."""
    drawn = draw_sparse_lesson("iris", SIZES[1], 0.0, 2)
    *_, bad, found, good, lost = compare_with_unlearning(drawn, LEARNERS["trees"])
    assert (bad, found, good) == (0, 0, 60)
    assert lost <= 4


def test_outcomes_are_means_and_sums_by_setting() -> None:
    plain = [[0.5, 0.75, 20, 10, 4, 3, 56, 1]] * len(SETTINGS)
    better = [[0.5, 0.85, 20, 12, 2, 2, 58, 0], *plain[1:]]
    found = Results([{"outcomes": plain}, {"outcomes": better}])
    first = found[Condition("iris", "4 a class", 0.05, "trees")]
    assert (first.alone, first.unlearned, first.gain) == (0.5, 0.8, 0.3)
    assert (first.corrections_unlearned, first.bad, first.found, first.lost) == (11, 6, 5, 1)


def test_every_setting_has_its_own_lesson_and_learner(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study, "draw_sparse_lesson", lambda *which: which)
    monkeypatch.setattr(study, "compare_with_unlearning", lambda lesson, learner: (lesson, learner))
    assert study.work({"seed": 5})["outcomes"] == [
        ((setting.data, setting.size, setting.noise, 5), LEARNERS[setting.learner]) for setting in SETTINGS
    ]


def conclude_from(*rows: list[float]) -> StudyFindings:
    """What is concluded where the first settings come out so, and all others like the first."""
    outcomes = [*rows, *[rows[0]] * (len(SETTINGS) - len(rows))]
    return study.EXPERIMENT.conclude([{"task": {"seed": 61_000}, "outcomes": outcomes}])


BETTER, SAME, WORSE = ([0.5, after, 20, 12, 10, 7, 50, 4] for after in (0.6, 0.5, 0.48))


def test_what_is_concluded() -> None:
    found = conclude_from(BETTER, WORSE, SAME)
    assert [(goal.measured, goal.held) for goal in found.goals] == [
        ("97%", True),
        ("-2.00 points", False),
        ("70%", True),
        ("8.0%", True),
    ]
    assert found.headline.startswith(
        "With unlearning, corrections lead to more right decisions in 70 of 72 settings, "
    )
    assert (
        "the worst setting loses 2.0. Of the examples with wrong labels it finds 70%, and puts 8%"
        in found.headline
    )
    learners, settings = found.tables
    assert learners.rows[0] == ("trees", "24 of 24", "+10.0", "+10.0", "70%", "8.0%")
    assert learners.rows[1] == ("k-NN", "23 of 24", "+9.5", "-2.0", "70%", "8.0%")
    assert [row[0] for row in learners.rows[-4:]] == ["5% wrong", "10% wrong", "20% wrong", "all"]
    assert [row[1] for row in learners.rows[-4:]] == ["22 of 24", "24 of 24", "24 of 24", "70 of 72"]
    assert settings.rows[0] == ("iris, 4 a class", "5%", "50.0 → 60.0", "50.0 → 48.0", "50.0 → 50.0")
    assert found.notes[0].startswith("Corrected 12.0 times in the mean with unlearning, 20.0 times without")
    assert found.notes[1] == "Not better: k-NN on iris, 4 a class, 5%; SVM on iris, 4 a class, 5%."


def test_what_is_not_held() -> None:
    found = conclude_from(SAME)
    assert [goal.held for goal in found.goals] == [False, True, True, True]
    assert found.notes[1] == "Not better in 72 settings."
    lost = conclude_from([0.5, 0.6, 20, 12, 10, 5, 50, 6])
    assert [goal.held for goal in lost.goals] == [True, True, False, False]
    assert lost.notes[1] == "Not better in 0 settings."
