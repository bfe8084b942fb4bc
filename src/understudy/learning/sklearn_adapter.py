"""Classifiers of scikit-learn in place of trees: only allowed ones, fitted again on loading, never pickled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from math import cos, sin, tau
from types import MappingProxyType
from typing import Any, NamedTuple
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, UnderstudyError, join_names
from understudy.extras import format_install_command
from understudy.learning._split_kernels import WATCHED
from understudy.learning.thresholds import vote
from understudy.learning.training_set import TrainingSet
from understudy.model.automaton import Transition
from understudy.model.learner_options import SklearnOptions
from understudy.model.tree import STAY, PathStep, Tree, make_leaf
from understudy.model.value_kinds import Categorical, Kind, Toroidal


class AllowedClassifier(NamedTuple):
    """A classifier's module, the parameters that a lesson may set, and those that are always set."""

    module: str
    parameters: tuple[str, ...]
    always: Mapping[str, Any] = MappingProxyType({})


SEEDED = MappingProxyType({"random_state": 0})
"""The parameters that make a classifier's random choices repeatable."""

ALLOWED: Mapping[str, AllowedClassifier] = MappingProxyType(
    {
        "DecisionTreeClassifier": AllowedClassifier(
            "sklearn.tree",
            (
                "criterion",
                "max_depth",
                "min_samples_split",
                "min_samples_leaf",
                "max_leaf_nodes",
                "ccp_alpha",
            ),
            SEEDED,
        ),
        "GaussianNB": AllowedClassifier("sklearn.naive_bayes", ("var_smoothing",)),
        "KNeighborsClassifier": AllowedClassifier("sklearn.neighbors", ("n_neighbors", "weights", "p")),
        "LogisticRegression": AllowedClassifier("sklearn.linear_model", ("C", "max_iter", "tol"), SEEDED),
        "MLPClassifier": AllowedClassifier(
            "sklearn.neural_network",
            ("hidden_layer_sizes", "activation", "alpha", "learning_rate_init", "max_iter", "tol"),
            MappingProxyType({**SEEDED, "solver": "lbfgs"}),
        ),
        "RandomForestClassifier": AllowedClassifier(
            "sklearn.ensemble",
            ("n_estimators", "criterion", "max_depth", "min_samples_split", "min_samples_leaf"),
            MappingProxyType({**SEEDED, "n_jobs": 1}),
        ),
        "SVC": AllowedClassifier("sklearn.svm", ("C", "kernel", "degree", "gamma", "coef0", "tol"), SEEDED),
    }
)
"""The classifiers that lessons may use, by class name."""

ROWS_APART = ("DecisionTreeClassifier", "RandomForestClassifier")
"""The classifiers that decide rows together exactly as one by one; others round by the size of the batch."""


class SklearnMissing(UnderstudyError, json_type="ScikitMissing"):
    """The error that a lesson needs scikit-learn, which is not installed."""

    def __init__(self, *, classifier: str) -> None:
        self.classifier = classifier
        super().__init__(
            f"this lesson is learned with {classifier} of scikit-learn, which is not installed; "
            f"install it with: {format_install_command('sklearn')}"
        )


@dataclass(frozen=True, slots=True)
class ClassifierTransition:
    """A transition function that decides with a fitted classifier; it cannot report conditions."""

    classifier: Any
    kinds: tuple[Kind, ...]

    def decide(self, values: Sequence[float]) -> int:
        """Return the index of the next state for a feature vector."""
        return int(self.classifier.predict([encode_features(values, self.kinds)])[0])

    def decide_all(self, values: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the index of the next state for each of n feature vectors [n, F], exactly as `decide` does."""
        rows = [encode_features(row, self.kinds) for row in values.tolist()]
        if type(self.classifier).__name__ in ROWS_APART:
            return np.asarray(self.classifier.predict(rows), np.int64)
        return np.array([self.classifier.predict([row])[0] for row in rows], np.int64)

    def decide_at_once(self, values: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return what `decide_all` returns, but in one call of the classifier, which is many times faster.

        A decision that depends on the last bit may differ from that of `decide`.
        """
        rows = [encode_features(row, self.kinds) for row in values.tolist()]
        return np.asarray(self.classifier.predict(rows), np.int64) if rows else np.zeros(0, np.int64)

    def path(self, values: Sequence[float]) -> tuple[tuple[PathStep, ...], int]:
        """Return no steps and STAY, since a classifier makes no tests."""
        return (), STAY


def encode_features(values: Sequence[float], kinds: Sequence[Kind]) -> list[float]:
    """Encode a feature vector for classifiers: for each feature whether it is absent (0 or 1), then its value.

    A label is one-hot, a toroidal value its sine and cosine. All numbers of an absent value are 0.
    """
    row: list[float] = []
    for value, kind in zip(values, kinds, strict=True):
        absent = value != value
        row.append(float(absent))
        if isinstance(kind, Categorical):
            row.extend(float(value == label) for label in range(len(kind.labels)))
        elif isinstance(kind, Toroidal):
            angle = 0.0 if absent else tau * value / kind.period
            row.extend((0.0, 0.0) if absent else (sin(angle), cos(angle)))
        else:
            row.append(0.0 if absent else value)
    return row


def fit_classifier(learner: SklearnOptions, training_set: TrainingSet, kinds: Sequence[Kind]) -> Transition:
    """Fit a classifier to the press-made examples; if all agree, return a tree with one leaf instead.

    Examples are sorted first, so that their order in the lesson makes no difference.
    """
    classifier = _build(learner)
    pressed = training_set.groups != WATCHED
    outcomes: NDArray[np.int64] = training_set.outcomes[pressed]
    rows = sorted(
        zip(
            (encode_features(row, kinds) for row in training_set.values[pressed].tolist()),
            outcomes.tolist(),
            strict=True,
        )
    )
    if len(set(outcomes.tolist())) == 1:
        return Tree((make_leaf(int(outcomes[0])),))
    if not kinds:
        ballot = zip(outcomes.tolist(), training_set.groups[pressed].tolist(), strict=True)
        return Tree((make_leaf(vote(ballot, current=training_set.current)),))
    try:
        with catch_warnings():
            simplefilter("ignore")  # a lesson too small to converge on is fitted all the same
            classifier.fit([row for row, _ in rows], [outcome for _, outcome in rows])
        fitted = ClassifierTransition(classifier, tuple(kinds))
        fitted.decide(training_set.values[0].tolist())  # some parameters are only found wanting when asked
    except (ValueError, TypeError) as error:
        raise DefinitionError(
            what=f"classifier {learner.classifier}",
            problem=f"scikit-learn cannot fit it: {' '.join(str(error).split())}",
            remedy="change its parameters, or learn trees",
        ) from None
    return fitted


def _build(learner: SklearnOptions) -> Any:
    allowed = ALLOWED.get(learner.classifier)
    if allowed is None:
        raise DefinitionError(
            what="lesson options",
            problem=f"classifier {learner.classifier!r} is not allowed",
            remedy=f"choose one of {join_names(ALLOWED)}",
        )
    unknown = sorted(set(learner.parameters) - set(allowed.parameters))
    if unknown:
        raise DefinitionError(
            what=f"classifier {learner.classifier}",
            problem=f"parameter {unknown[0]!r} is not allowed",
            remedy=f"choose from {join_names(allowed.parameters)}",
        )
    try:
        module = import_module(allowed.module)
    except ImportError:
        raise SklearnMissing(classifier=learner.classifier) from None
    return getattr(module, learner.classifier)(**learner.parameters, **allowed.always)
