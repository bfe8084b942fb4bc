"""Flat learners of scikit-learn: a tree, nearest neighbors, a multilayer perceptron."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np

from understudy_lab.baselines.inputs import Classifier, Floats, LabeledTicks

Fit: TypeAlias = Callable[[LabeledTicks, int], Classifier]
"""A function that fits a classifier to training data with a seed."""


def fit_tree(lesson: LabeledTicks, seed: int, *, leaf: int = 5) -> Classifier:
    """Fit a CART tree by entropy (Breiman et al. 1984), with at least `leaf` ticks in a leaf."""
    from sklearn.tree import DecisionTreeClassifier

    tree = DecisionTreeClassifier(criterion="entropy", min_samples_leaf=leaf, random_state=seed)
    tree.fit(lesson.x, lesson.y, sample_weight=lesson.weight)
    counts = tree.tree_.value[:, 0, :]
    shares: Floats = counts / counts.sum(axis=1, keepdims=True)

    def classify(inputs: Floats) -> Floats:
        chances: Floats = shares[tree.tree_.apply(inputs.astype(np.float32))]
        return chances

    return classify


def fit_nearest(lesson: LabeledTicks, seed: int, *, neighbors: int = 5) -> Classifier:
    """Fit a classifier by the majority of the nearest ticks (Fix and Hodges 1951)."""
    from sklearn.neighbors import KDTree

    tree, places = KDTree(lesson.x), np.arange(len(lesson.behaviors))
    k = min(neighbors, len(lesson.y))

    def classify(inputs: Floats) -> Floats:
        near = tree.query(inputs, k=k, return_distance=False)
        votes = ((lesson.y[near][..., None] == places) * lesson.weight[near][..., None]).sum(axis=1)
        chances: Floats = votes / votes.sum(axis=1, keepdims=True)
        return chances

    return classify


def fit_perceptron(lesson: LabeledTicks, seed: int, *, alpha: float = 1e-4, steps: int = 1_500) -> Classifier:
    """Fit a perceptron with two hidden layers of 64 (Rumelhart et al. 1986), trained with Adam."""
    from sklearn.neural_network import MLPClassifier

    if len(lesson.behaviors) == 1:
        return lambda inputs: np.ones((len(inputs), 1))
    rounds = int(np.clip(steps * 200 / len(lesson.y), 10, 300))
    net = MLPClassifier((64, 64), alpha=alpha, max_iter=rounds, random_state=seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that it might go on
        net.fit(lesson.x, lesson.y)
    return MlpWeights(list(zip(net.coefs_, net.intercepts_, strict=True)))


class MlpWeights:
    """A net of rectified linear layers, by weights and offsets."""

    def __init__(self, layers: list[tuple[Floats, Floats]]) -> None:
        self._layers = layers

    def __call__(self, inputs: Floats) -> Floats:
        """Return the probability of each behavior for each row (softmax)."""
        *hidden, (weights, offset) = self._layers
        for before, beside in hidden:
            inputs = np.maximum(inputs @ before + beside, 0.0)
        outputs = inputs @ weights + offset
        if outputs.shape[1] == 1:  # scikit-learn has one output for two
            outputs = np.hstack([np.zeros_like(outputs), outputs])
        likely = np.exp(outputs - outputs.max(axis=1, keepdims=True))
        shares: Floats = likely / likely.sum(axis=1, keepdims=True)
        return shares


CLASSICAL: Mapping[str, Fit] = {"tree": fit_tree, "nearest": fit_nearest, "perceptron": fit_perceptron}
