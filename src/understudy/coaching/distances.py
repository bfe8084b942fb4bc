"""Distances between situations, feature by feature: 0 for equal ones, 1 for the largest difference."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.situation_text import FeaturePhrases
from understudy.model.automaton import Transition
from understudy.model.kinds import Categorical, Toroidal
from understudy.model.tree import TestKind, Tree

UNASKED = 0.25
"""What a feature counts that a state's tree does not ask about: the lesson chose it, so it may matter all the same."""
FAR = 0.35
"""From here on a situation is far from an example: a third of what was seen of a number, or 60 degrees."""


class FeatureDistances:
    """Distances between feature vectors in one state.

    Features that the state's transition function tests have weight 1, all others `UNASKED`.

    Numbers differ by their share of the observed range, angles by their share of half a turn, labels and absence by 0
    or 1.
    """

    def __init__(self, words: Sequence[FeaturePhrases], transition: Transition | None) -> None:
        self._weights = np.where(_asked(transition, len(words)), 1.0, UNASKED)
        self._scale, self._turn = np.ones(len(words)), np.zeros(len(words))
        self._labels = np.zeros(len(words), np.bool_)
        for column, word in enumerate(words):
            kind = word.bound.kind
            if isinstance(kind, Categorical):
                self._labels[column] = True
            elif isinstance(kind, Toroidal):
                self._turn[column], self._scale[column] = kind.period, kind.period / 2
            elif word.high > word.low:
                self._scale[column] = word.high - word.low

    def compute_by_feature(
        self, rows: NDArray[np.float64], values: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Compute distances, from 0 to 1, between vectors [..., F] and others, broadcast, for each feature."""
        off = np.abs(rows - values)
        off = np.where(off > self._turn / 2, np.abs(self._turn - off), off)  # of what has no period: itself
        off = np.where(self._labels & (off > 0), 1.0, np.minimum(off / self._scale, 1.0))
        missing = np.isnan(off)
        return np.where(missing, (np.isnan(rows) != np.isnan(values)) * 1.0, off) if missing.any() else off

    def compute(self, rows: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute distances between vectors [..., F] and others, broadcast, over all features; 1 is far."""
        return self.combine(self.compute_by_feature(rows, values))

    def combine(self, apart: NDArray[np.float64]) -> NDArray[np.float64]:
        """Combine distances `apart` [..., F] of features into one."""
        found: NDArray[np.float64] = np.minimum(np.sqrt(apart * apart @ self._weights), 1.0)
        return found


def _asked(transition: Transition | None, features: int) -> NDArray[np.bool_]:
    """Return a mask [F] of the features that a transition function tests; all if it is no tree or has no test."""
    if not isinstance(transition, Tree) or len(transition.nodes) == 1:
        return np.ones(features, np.bool_)
    asked = {node.feature for node in transition.nodes if node.test != TestKind.LEAF}
    return np.isin(np.arange(features), list(asked))
