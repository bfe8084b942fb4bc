"""Situations that a robot may meet: feature vectors to query a lesson with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from understudy.model.features import BoundFeature
from understudy.model.lesson import Lesson
from understudy.model.value_kinds import Categorical, Toroidal

IMAGINED = 192
SEED = 0


def stack_example_vectors(lesson: Lesson) -> NDArray[np.float64]:
    """Return the feature vectors of all examples [n, F], of any state."""
    rows = [example.values for example in lesson.examples]
    return np.array(rows, np.float64).reshape(len(rows), len(lesson.automaton.features))


def sample_similar_situations(
    lesson: Lesson, vectors: NDArray[np.float64], count: int = IMAGINED
) -> NDArray[np.float64]:
    """Sample feature vectors [count, F] like the given `vectors` [n, F].

    Readings are absent together as in these vectors. Other readings of the body are drawn evenly from their observed
    range, angles and labels from all possible values. The automaton's own features are as in one of them.
    Without any vectors, none are sampled.
    """
    features = lesson.automaton.features
    if not len(vectors) or not features:
        return np.zeros((0, len(features)))
    draws = np.random.default_rng(SEED)
    situations = vectors[draws.integers(len(vectors), size=count)]
    for column, bound in enumerate(features):
        present = ~np.isnan(situations[:, column])
        if bound.is_own or not present.any():
            continue
        fresh = _drawn(bound, vectors[:, column], draws, count)
        situations[:, column] = np.where(present, fresh, np.nan)
    return situations


def fill_own_features(
    lesson: Lesson, situations: NDArray[np.float64], vectors: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return situations [M, F] with the automaton's own features as in some of `vectors` [n, F]."""
    own = [column for column, bound in enumerate(lesson.automaton.features) if bound.is_own]
    filled = situations.copy()
    if len(vectors) and own:
        rows = np.random.default_rng(SEED).integers(len(vectors), size=len(filled))
        filled[:, own] = vectors[rows][:, own]
    return filled


def _drawn(
    bound: BoundFeature, column: NDArray[np.float64], draws: np.random.Generator, count: int
) -> NDArray[np.float64]:
    kind = bound.kind
    if isinstance(kind, Categorical):
        return draws.integers(len(kind.labels), size=count).astype(np.float64)
    if isinstance(kind, Toroidal):
        return draws.random(count) * kind.period
    low, high = float(np.nanmin(column)), float(np.nanmax(column))
    return low + draws.random(count) * (high - low)
