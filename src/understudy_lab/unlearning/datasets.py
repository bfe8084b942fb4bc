"""The bundled data sets of scikit-learn as sparse lessons, some of their examples labeled wrong."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from importlib import import_module
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.automaton import START, Automaton, State
from understudy.model.features import BoundFeature, Feature
from understudy.model.kinds import Continuous
from understudy.model.lesson import Example, ExampleKind, Learner, LearnerOptions, Lesson

DATA_SETS = ("iris", "wine", "breast_cancer", "digits")
SIZES = ("4 a class", "60 in all")
NOISES = (0.05, 0.1, 0.2)
MOST = 300
"""How many the robot meets at most, and how many it is judged on."""

Labels: TypeAlias = NDArray[np.int64]
Vectors: TypeAlias = NDArray[np.float64]


class SparseLesson(NamedTuple):
    """A sparse lesson: what is shown, as it is labeled; what the robot meets then; and what it is judged on.

    Vectors [n, F] and labels [n]. `bad` [n] says which of the shown are labeled wrong.
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
    """All vectors, each feature in units of its spread, and their labels.

    Neither nearest neighbors nor an SVM can be used with features on scales that differ; trees do not care.
    """
    load = getattr(import_module("sklearn.datasets"), f"load_{name}")
    vectors, labels = load(return_X_y=True)
    spread = vectors.std(axis=0)
    return (vectors - vectors.mean(axis=0)) / np.where(spread > 0, spread, 1.0), labels.astype(np.int64)


def draw_sparse_lesson(name: str, size: str, noise: float, seed: int) -> SparseLesson:
    """A sparse lesson drawn from a data set; each label is another one with probability `noise`."""
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
    """The lesson: without states, its examples directives to the state of each label."""
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
    """A directive to the state of a label."""
    return Example(
        number, START.name, tuple(values), state_of(label), ExampleKind.DIRECTIVE, correction=correction
    )


def state_of(label: int) -> str:
    """The name of the state that stands for a label."""
    return f"class{label}"
