"""Leave-one-out prediction of every example from all others, with the pairwise distances that this needs.

A Gaussian process fits 0 and 1 for each outcome (least-squares classification); one matrix inverse gives its
prediction for every example from the others (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006,
equation 5.12 and section 6.5). Far from all other examples, all outcomes are predicted alike.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import sqrt, tau

import numpy as np
from numpy.typing import NDArray

from understudy.learning import _linalg_kernels
from understudy.model.kinds import Categorical, Column, Kind, Toroidal

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


@dataclass(frozen=True)
class LeaveOneOut:
    """A fit of examples from which each can be predicted by all others.

    `like` [n, n] is the similarity of each two examples, 0 to 1. `outcomes` [n] is the index of each example's
    outcome. `here` lists the examples not left out. `inverse` is that of their similarity matrix with noise
    variances added to the diagonal.
    """

    like: Square
    outcomes: NDArray[np.int64]
    inverse: Square
    here: NDArray[np.int64]

    def score_mislabels(self, choices: int) -> Column:
        """Compute how strongly the others predict another outcome than each example's own [n], about -1 to 1.

        0 means that the others predict nothing; -1 stands for examples left out. `choices` is the number of
        outcomes.
        """
        own = _one_hot(self.outcomes[self.here], choices)
        predicted = _predicted(self.inverse, own)
        found = np.full(len(self.outcomes), -1.0)
        against = np.where(own > 0, -np.inf, predicted).max(axis=1)
        found[self.here] = against - predicted[own > 0]
        return found

    def exclude(self, example: int) -> LeaveOneOut:
        """Make the fit without one more example, given by its index among all; this is cheaper than a new fit."""
        at = int(np.flatnonzero(self.here == example)[0])
        rest = np.delete(np.arange(len(self.here)), at)
        column = self.inverse[rest, at]
        smaller = self.inverse[np.ix_(rest, rest)] - np.outer(column, column) / self.inverse[at, at]
        return LeaveOneOut(self.like, self.outcomes, smaller, self.here[rest])


def fit_leave_one_out(unlike: Square, outcomes: NDArray[np.int64], noise: Column) -> LeaveOneOut:
    """Fit a Gaussian process, given squared distances [n, n], outcomes [n] and noise variances [n] of examples.

    Of SCALES, the length scale with the highest leave-one-out likelihood is used (Rasmussen and Williams 2006,
    section 5.4.2); for each the signal variance is fitted too.
    """
    choices = int(outcomes.max()) + 1
    own = _one_hot(outcomes, choices)
    positive = unlike[unlike > 0]
    middle = float(np.median(positive)) if len(positive) else 1.0
    best: tuple[float, Square, Square] | None = None
    for scale in SCALES:
        like = np.exp(-unlike / (2 * middle * scale * scale))
        inverse = _linalg_kernels.invert_matrix(like + np.diag(noise))
        variance = 1 / np.diag(inverse)
        off = own - _predicted(inverse, own)
        size = float((off * off / variance[:, None]).mean())
        likelihood = -float(np.log(variance).mean()) - float(np.log(max(size, 1e-12)))
        if best is None or likelihood > best[0]:
            best = likelihood, like, inverse
    _, like, inverse = best or (0.0, unlike, unlike)
    return LeaveOneOut(like, outcomes, inverse, np.arange(len(outcomes)))


def _predicted(inverse: Square, own: NDArray[np.float64]) -> NDArray[np.float64]:
    """Predict each example's outcomes from the others [n, choices]; with none near, every outcome alike."""
    weights = inverse @ (own - 1 / own.shape[1])
    found: NDArray[np.float64] = own - weights / np.diag(inverse)[:, None]
    return found


def _one_hot(outcomes: NDArray[np.int64], choices: int) -> NDArray[np.float64]:
    return np.eye(choices)[outcomes]
