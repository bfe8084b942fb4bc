"""Predict every example from all others (leave-one-out), with the pairwise distances that this needs.

A Gaussian process fits each outcome's 0 and 1 (least-squares classification); what it predicts for an example
without that example follows from one inverse for all of them (Rasmussen and Williams, Gaussian Processes for Machine
Learning, 2006, equations 5.12 and section 6.5). Far from every other example it says: no idea.
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
"""How far absence lies beside the middle of all values, so that it is 1 away from the farthest."""


def compute_pairwise_distances(values: NDArray[np.float64], kinds: Sequence[Kind]) -> Square:
    """The mean over features of the squared distance of each two of n feature vectors [n, F], each from 0 to 1.

    A continuous feature counts as a share of its range over the vectors, a toroidal one as a share of the circle's
    diameter, straight across; labels are 0 or 1 apart. What is absent lies beside the middle. A feature that is the
    same everywhere says nothing and is left out; 0 throughout where all are.
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
    """Where values [n] lie, an axis at a time: as points of a plain space, which is what keeps likeness sound."""
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
"""How far likeness may reach, in median distances between examples; the one that predicts best is taken."""


@dataclass(frozen=True)
class LeaveOneOut:
    """Examples seen from the others: how `like` each two are [n, n], 0 to 1, and which `outcome` each has [n].

    `inverse` [n, n] is that of the likeness with the doubt about each example added. Leaving an example out of it is
    cheap, see `exclude`.
    """

    like: Square
    outcomes: NDArray[np.int64]
    inverse: Square
    here: NDArray[np.int64]

    def score_mislabels(self, choices: int) -> Column:
        """By how much the others speak for another outcome than each example's own [n]: about -1 to 1.

        0 where they say nothing; -1 for those left out. `choices` is how many outcomes there are.
        """
        own = _one_hot(self.outcomes[self.here], choices)
        predicted = _predicted(self.inverse, own)
        found = np.full(len(self.outcomes), -1.0)
        against = np.where(own > 0, -np.inf, predicted).max(axis=1)
        found[self.here] = against - predicted[own > 0]
        return found

    def exclude(self, example: int) -> LeaveOneOut:
        """The same without one more example, by its place."""
        at = int(np.flatnonzero(self.here == example)[0])
        rest = np.delete(np.arange(len(self.here)), at)
        column = self.inverse[rest, at]
        smaller = self.inverse[np.ix_(rest, rest)] - np.outer(column, column) / self.inverse[at, at]
        return LeaveOneOut(self.like, self.outcomes, smaller, self.here[rest])


def fit_leave_one_out(unlike: Square, outcomes: NDArray[np.int64], noise: Column) -> LeaveOneOut:
    """Examples by how unlike each two are [n, n] and by their outcomes [n], each with its variance of `noise` [n].

    The reach of likeness is the one under which the examples predict each other best (the highest leave-one-out
    likelihood, its variance fitted).
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
    """What the others predict for each example [n, choices]; with none near, every outcome alike."""
    weights = inverse @ (own - 1 / own.shape[1])
    found: NDArray[np.float64] = own - weights / np.diag(inverse)[:, None]
    return found


def _one_hot(outcomes: NDArray[np.int64], choices: int) -> NDArray[np.float64]:
    return np.eye(choices)[outcomes]
