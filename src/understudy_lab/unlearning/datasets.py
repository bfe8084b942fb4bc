"""The bundled data sets of scikit-learn as small lessons in which some examples have wrong labels."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from importlib import import_module
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature, Feature
from understudy.model.learner_options import Learner, LearnerOptions
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.value_kinds import Continuous

DATA_SETS = ("iris", "wine", "breast_cancer", "digits")
SIZES = ("4 a class", "60 in all")
NOISES = (0.05, 0.1, 0.2)
MOST = 300
"""Largest number of vectors for correction, and of test vectors."""

Labels: TypeAlias = NDArray[np.int64]
Vectors: TypeAlias = NDArray[np.float64]


class SparseLesson(NamedTuple):
    """A small training set with partly wrong labels, vectors to correct on, and test vectors.

    All vectors have shape [n, F], all labels [n]. `shown` and `labels` are the training examples and `bad` marks those
    with a wrong label; `met` and `right` are the vectors predicted during correction and their true labels; `test` and
    `truth` are the test vectors and their true labels.
    """

    shown: Vectors
    labels: Labels
    bad: NDArray[np.bool_]
    met: Vectors
    right: Labels
    test: Vectors
    truth: Labels


@cache
def data_set(name: str) -> tuple[Vectors, Labels]:
    """Return the vectors of a data set, each feature standardized, and their labels.

    Standardizing is needed for nearest neighbors and SVMs, which depend on the scale of features; trees do not.
    """
    load = getattr(import_module("sklearn.datasets"), f"load_{name}")
    vectors, labels = load(return_X_y=True)
    spread = vectors.std(axis=0)
    return (vectors - vectors.mean(axis=0)) / np.where(spread > 0, spread, 1.0), labels.astype(np.int64)


def draw_sparse_lesson(name: str, size: str, noise: float, seed: int) -> SparseLesson:
    """Draw a small lesson from a data set and replace each training label by another with probability `noise`."""
    draws = np.random.default_rng([seed, DATA_SETS.index(name), SIZES.index(size), round(100 * noise)])
    vectors, labels = data_set(name)
    classes = np.unique(labels)
    each = 4 if size == SIZES[0] else 60 // len(classes)
    shown = np.concatenate(
        [draws.choice(np.flatnonzero(labels == label), each, replace=False) for label in classes]
    )
    rest = draws.permutation(np.setdiff1d(np.arange(len(labels)), shown))
    half = min(len(rest) // 2, MOST)
    met, test = rest[:half], rest[half : 2 * half]
    said, bad = labels[shown].copy(), draws.random(len(shown)) < noise
    for place in np.flatnonzero(bad):
        said[place] = draws.choice(classes[classes != said[place]])
    return SparseLesson(vectors[shown], said, bad, vectors[met], labels[met], vectors[test], labels[test])


def lesson_of(drawn: SparseLesson, learner: Learner) -> Lesson:
    """Return a stateless lesson whose examples are directives, one to the state of each training label."""
    names = [state_of(label) for label in range(int(max(drawn.truth.max(), drawn.labels.max())) + 1)]
    features = tuple(
        BoundFeature(Feature(f"feature{column}", Continuous(), reading=f"feature{column}"))
        for column in range(drawn.shown.shape[1])
    )
    automaton = Automaton(
        "classes", (START, *(State(name, name) for name in names)), features, stateless=True
    )
    examples = tuple(
        example(number, values, label)
        for number, (values, label) in enumerate(zip(drawn.shown.tolist(), drawn.labels, strict=True), 1)
    )
    return Lesson(automaton, examples, LearnerOptions(learner=learner))


def example(number: int, values: Sequence[float], label: int, *, correction: bool = False) -> Example:
    """Return a directive to the state of the given label."""
    return Example(
        number, START.name, tuple(values), state_of(label), ExampleKind.DIRECTIVE, correction=correction
    )


def state_of(label: int) -> str:
    """Return the name of the state that represents a label."""
    return f"class{label}"
