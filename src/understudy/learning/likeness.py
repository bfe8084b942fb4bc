"""How unlike feature vectors are, whatever the kinds of their features: what doubting an example measures with."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import Categorical, Column, Kind, Toroidal

Square = NDArray[np.float64]
"""A number for each pair of n examples [n, n]."""


def unlikeness(values: NDArray[np.float64], kinds: Sequence[Kind]) -> Square:
    """The mean over features of the squared difference of each two of n feature vectors [n, F], each from 0 to 1.

    A continuous feature counts as a share of its range over the vectors, a toroidal one the shorter way round as a
    share of half the circle; labels differ or not, and so do absent and present. A feature that is the same
    everywhere says nothing and is left out; 0 throughout where all are.
    """
    total, counted = np.zeros((len(values), len(values))), 0
    for column, kind in zip(values.T, kinds, strict=True):
        apart = _apart(column, kind)
        if apart.any():
            total += apart * apart
            counted += 1
    return total / max(counted, 1)


def _apart(column: Column, kind: Kind) -> Square:
    absent = np.isnan(column)
    known = np.where(absent, 0.0, column)
    apart: Square = np.abs(known[:, None] - known[None, :])
    if isinstance(kind, Categorical):
        apart = (apart > 0).astype(np.float64)
    elif isinstance(kind, Toroidal):
        apart = np.minimum(apart, kind.period - apart) / (kind.period / 2)
    else:
        there = column[~absent]
        extent = float(np.ptp(there)) if len(there) else 0.0
        apart = apart / extent if extent > 0 else np.zeros_like(apart)
    apart[absent[:, None] ^ absent[None, :]] = 1.0
    apart[absent[:, None] & absent[None, :]] = 0.0
    return apart
