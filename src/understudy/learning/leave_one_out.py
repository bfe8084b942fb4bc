"""Leave-one-out prediction: what all other examples say about each, with the distances that this needs.

A Gaussian process fits 0 and 1 for each outcome (least-squares classification); one matrix inverse gives its
prediction for every example from the others (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006,
equation 5.12 and section 6.5). Far from all other examples, all outcomes are predicted alike.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import sqrt, tau

import numpy as np
from numpy.typing import NDArray

from understudy.learning import _linalg_kernels
from understudy.learning.training_set import make_training_set
from understudy.model.describe import name_examples
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.model.value_kinds import Categorical, Column, Kind, Toroidal

Square = NDArray[np.float64]
"""A number for each pair of n examples [n, n]."""

AWAY = sqrt(0.75)
"""The distance of absence from the middle of all values, chosen so that it is 1 away from the farthest."""


def compute_pairwise_distances(values: NDArray[np.float64], kinds: Sequence[Kind]) -> Square:
    """Compute the mean over features of the squared distance, 0 to 1, of each two of n feature vectors [n, F].

    A continuous feature is measured in units of its range over the vectors, a toroidal one in diameters of the
    circle (along the chord); different labels are 1 apart. Absent values lie beside the middle of the others. A
    feature with the same value everywhere is left out; if all are, every distance is 0.
    """
    total, counted = np.zeros((len(values), len(values))), 0
    for column, kind in zip(values.T, kinds, strict=True):
        apart = np.zeros_like(total)
        for axis in _axes(column, kind):
            apart += (axis[:, None] - axis[None, :]) ** 2
        if apart.any():
            total += apart
            counted += 1
    return total / max(counted, 1)


def _axes(column: Column, kind: Kind) -> Iterator[Column]:
    """Yield the coordinates [n] of values, one axis at a time, in a Euclidean space.

    Only with Euclidean distances is the similarity matrix of `fit_leave_one_out` positive definite.
    """
    absent = np.isnan(column)
    if isinstance(kind, Categorical):
        for label in range(len(kind.labels)):
            yield (column == label) / sqrt(2)
        yield absent / sqrt(2)
        return
    if absent.any():
        yield absent * AWAY
    if isinstance(kind, Toroidal):
        angle = np.where(absent, 0.0, tau * column / kind.period)
        yield np.where(absent, 0.0, np.cos(angle) / 2)
        yield np.where(absent, 0.0, np.sin(angle) / 2)
        return
    there = column[~absent]
    lowest, highest = (there.min() / 2, there.max() / 2) if len(there) else (0.0, 0.0)
    extent = highest - lowest  # of halves: the difference of wholes may overflow
    yield np.where(absent, 0.5, (column / 2 - lowest) / extent if extent > 0 else 0.5)


SCALES = (0.2, 0.35, 0.6, 1.0)
"""The length scales to try, in units of the median distance between examples."""
TRUST_CORRECTION, TRUST_SAID, TRUST_DEFAULT = 0.02, 0.1, 0.2
"""The noise variances expected of corrections, other directives and confirmations, and defaults.

Corrections are most reliable, because demonstrators who correct have just seen what is wrong.
"""
LONG = 100
"""The number of examples from which waiting for the compiler takes less time than inverting as plain Python."""
WITNESSES = 3
"""The largest number of examples that a reason names."""


@dataclass(frozen=True)
class LeaveOneOut:
    """A fit of examples from which each can be predicted by all others.

    `outcomes` [n] is the index of each example's outcome among those that occur. `unlike` [n, n] is the squared
    distance of each two examples, `like` [n, n] their similarity, 0 to 1. `here` lists the examples not left out.
    `inverse` is that of their similarity matrix with noise variances added to the diagonal.
    """

    examples: tuple[Example, ...]
    outcomes: NDArray[np.int64]
    unlike: Square
    like: Square
    inverse: Square
    here: NDArray[np.int64]

    @property
    def numbers(self) -> list[int]:
        """The numbers of the examples not left out."""
        return [self.examples[place].number for place in self.here.tolist()]

    def score_mislabels(self) -> dict[int, float]:
        """Compute, by number, how strongly others predict another outcome than an example's own, about -1 to 1.

        0 means that the others predict nothing, or that there is one outcome.
        """
        own = _one_hot(self.outcomes)[self.here]
        if own.shape[1] == 1:
            return dict.fromkeys(self.numbers, 0.0)
        predicted = _predicted(self.inverse, own)
        against = np.where(own > 0, -np.inf, predicted).max(axis=1)
        return dict(zip(self.numbers, (against - predicted[own > 0]).tolist(), strict=True))

    def exclude(self, number: int) -> LeaveOneOut:
        """Make the fit without one more example, if it has that; this is cheaper than a new fit."""
        if number not in self.numbers:
            return self
        at = self.numbers.index(number)
        rest = np.delete(np.arange(len(self.here)), at)
        column = self.inverse[rest, at]
        smaller = self.inverse[np.ix_(rest, rest)] - np.outer(column, column) / self.inverse[at, at]
        return replace(self, inverse=smaller, here=self.here[rest])

    def describe_counterevidence(self, example: Example) -> str:
        """Describe which examples contradict an example: the most similar with another outcome."""
        place = self.examples.index(example)
        others = self.here[self.outcomes[self.here] != self.outcomes[place]]
        most = [
            self.examples[other] for other in others[np.argsort(-self.like[place, others], kind="stable")]
        ]
        outcome = most[0].next
        numbers = [other.number for other in most if other.next == outcome][:WITNESSES]
        are, say = ("is", "says") if len(numbers) == 1 else ("are", "say")
        return (
            f"Example {example.number} says {example.next}, but {name_examples(sorted(numbers))}, "
            f"which {are} most like it, {say} {outcome}."
        )


def fit_leave_one_out(lesson: Lesson, examples: Sequence[Example]) -> LeaveOneOut:
    """Fit a Gaussian process to some examples of a lesson, sorted by number.

    Of SCALES, the length scale with the highest leave-one-out likelihood is used (Rasmussen and Williams 2006,
    section 5.4.2); for each the signal variance is fitted too.
    """
    pool = tuple(sorted(examples, key=lambda example: example.number))
    training_set = make_training_set(lesson, pool, pool[0].state)
    outcomes = np.unique(training_set.outcomes, return_inverse=True)[1]
    noise = np.diag([estimate_noise_variance(example) for example in pool])
    unlike = compute_pairwise_distances(
        training_set.values, [bound.kind for bound in lesson.automaton.features]
    )
    positive = unlike[unlike > 0]
    middle = float(np.median(positive)) if len(positive) else 1.0
    fits = (_fit(unlike / (2 * middle * scale * scale), _one_hot(outcomes), noise) for scale in SCALES)
    _, like, inverse = max(fits, key=lambda fit: fit[0])
    return LeaveOneOut(pool, outcomes, unlike, like, inverse, np.arange(len(pool)))


def _fit(unlike: Square, own: NDArray[np.float64], noise: Square) -> tuple[float, Square, Square]:
    """Return the leave-one-out likelihood of one length scale, the similarities, and the inverse of their matrix."""
    like = np.exp(-unlike)
    invert = _linalg_kernels.invert_matrix
    inverse = (invert if len(like) < LONG else invert.run_long)(like + noise)
    variance = 1 / np.diag(inverse)
    off = own - _predicted(inverse, own)
    size = float((off * off / variance[:, None]).mean())
    return -float(np.log(variance).mean()) - float(np.log(max(size, 1e-12))), like, inverse


def estimate_noise_variance(example: Example) -> float:
    """Return the noise variance expected of an example: lowest for corrections, highest for defaults."""
    if example.correction and example.is_shown:
        return TRUST_CORRECTION
    return TRUST_DEFAULT if example.kind is ExampleKind.DEFAULT else TRUST_SAID


def _predicted(inverse: Square, own: NDArray[np.float64]) -> NDArray[np.float64]:
    """Predict each example's outcomes from the others [n, choices]; with none near, every outcome alike."""
    weights = inverse @ (own - 1 / own.shape[1])
    predictions: NDArray[np.float64] = own - weights / np.diag(inverse)[:, None]
    return predictions


def _one_hot(outcomes: NDArray[np.int64]) -> NDArray[np.float64]:
    return np.eye(int(outcomes.max()) + 1)[outcomes]
