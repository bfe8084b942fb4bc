"""How unlike feature vectors are, whatever the kinds of their features: what doubting an example measures with."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import sqrt, tau

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import Categorical, Column, Kind, Toroidal

Square = NDArray[np.float64]
"""A number for each pair of n examples [n, n]."""

AWAY = sqrt(0.75)
"""How far absence lies beside the middle of all values, so that it is 1 away from the farthest."""


def unlikeness(values: NDArray[np.float64], kinds: Sequence[Kind]) -> Square:
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
