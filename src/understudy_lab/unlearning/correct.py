"""Teaching by correction: the learner predicts one vector after another and is corrected where it errs."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from understudy.learning.fit import learn_state
from understudy.learning.mislabels import diagnose_correction
from understudy.learning.sklearn_adapter import ClassifierTransition, encode_features
from understudy.learning.training_set import group_examples_by_state
from understudy.model.automaton import START, Transition
from understudy.model.kinds import Continuous
from understudy.model.learner_options import Learner, SklearnOptions, TreeOptions
from understudy.model.lesson import Lesson
from understudy_lab.unlearning.datasets import Labels, SparseLesson, Vectors, example, lesson_of

CORRECTIONS = 20
"""Number of corrections after which the teacher stops."""
LEARNERS: dict[str, Learner] = {
    "trees": TreeOptions(),
    "k-NN": SklearnOptions("KNeighborsClassifier", {"n_neighbors": 3}),
    "SVM": SklearnOptions("SVC", {"C": 10.0}),
}
AT_ONCE = 16


class CorrectionResult(NamedTuple):
    """The share of correct test predictions, the number of corrections, and the numbers of quarantined examples."""

    accuracy: float
    corrections: int
    quarantined: frozenset[int]


class PreparedRows:
    """Feature vectors encoded once for repeated prediction by a classifier."""

    def __init__(self, vectors: Vectors) -> None:
        kinds = [Continuous()] * vectors.shape[1]
        self.plain: list[list[float]] = vectors.tolist()
        self.ready = [encode_features(row, kinds) for row in self.plain]

    def decided(self, function: Transition, first: int, stop: int) -> list[int]:
        """Return the labels that the learned function predicts for rows `first` to `stop` (exclusive)."""
        if isinstance(function, ClassifierTransition):  # many in one go: a call a row would take hours
            outcomes = function.classifier.predict(self.ready[first:stop]).tolist()
        else:
            outcomes = [function.decide(row) for row in self.plain[first:stop]]
        return [int(outcome) - 1 for outcome in outcomes]


def teach_and_correct(drawn: SparseLesson, learner: Learner, *, unlearn: bool) -> CorrectionResult:
    """Learn from the shown examples, correct up to 20 wrong predictions, and measure accuracy on the test vectors.

    With `unlearn`, each correction is diagnosed, and the examples suspected to have caused the error are quarantined.
    """
    lesson = lesson_of(drawn, learner)
    met, at, corrections = PreparedRows(drawn.met), 0, 0
    function = _learned(lesson)
    while corrections < CORRECTIONS:
        at = _first_wrong(function, met, drawn.right, at)
        if at == len(drawn.right):
            break
        corrections += 1
        number = len(lesson.examples) + 1
        correction = example(number, met.plain[at], int(drawn.right[at]), correction=True)
        lesson = replace(lesson, examples=(*lesson.examples, correction))
        if unlearn:
            lesson = _without(lesson, diagnose_correction(lesson, correction).reasons)
        function, at = _learned(lesson), at + 1
    right = np.equal(PreparedRows(drawn.test).decided(function, 0, len(drawn.test)), drawn.truth)
    out = frozenset(each.number for each in lesson.examples if each.quarantined)
    return CorrectionResult(float(right.mean()), corrections, out)


def _learned(lesson: Lesson) -> Transition:
    return learn_state(lesson, START.name, group_examples_by_state(lesson)[START.name])


def _first_wrong(function: Transition, met: PreparedRows, right: Labels, at: int) -> int:
    while at < len(right):
        decided = met.decided(function, at, at + AT_ONCE)
        wrong = np.flatnonzero(np.not_equal(decided, right[at : at + AT_ONCE]))
        if len(wrong):
            return at + int(wrong[0])
        at += AT_ONCE
    return len(right)


def _without(lesson: Lesson, reasons: dict[int, str]) -> Lesson:
    return replace(
        lesson,
        examples=tuple(
            replace(each, quarantined=reasons.get(each.number, each.quarantined)) for each in lesson.examples
        ),
    )


def compare_with_unlearning(drawn: SparseLesson, learner: Learner) -> list[float]:
    """Run the same corrections without and with unlearning, and return both results as one list of numbers.

    The list holds: accuracy without and with unlearning, number of corrections without and with unlearning, wrongly
    labeled examples, those of them quarantined, correctly labeled examples, those of them quarantined.
    """
    alone = teach_and_correct(drawn, learner, unlearn=False)
    unlearned = teach_and_correct(drawn, learner, unlearn=True)
    bad = {int(place) + 1 for place in np.flatnonzero(drawn.bad)}
    bad_found, lost = bad & unlearned.quarantined, unlearned.quarantined - bad
    return [
        round(alone.accuracy, 4),
        round(unlearned.accuracy, 4),
        alone.corrections,
        unlearned.corrections,
        len(bad),
        len(bad_found),
        len(drawn.bad) - len(bad),
        len(lost),
    ]
