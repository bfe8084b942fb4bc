"""Random draws keyed by their purpose, so that a world draws the same alone or among a thousand others.

A draw is a hash of (world seed, id within its world, tick, stream), independent of other draws. The hash is the
finalizer of SplitMix64 (Steele, Lea & Flood 2014), applied once per part of the key.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import Column

Seeds: TypeAlias = NDArray[np.int64]
Words: TypeAlias = NDArray[np.uint64]

_WEYL = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)


def _mix(words: Words) -> Words:
    words = (words ^ (words >> np.uint64(30))) * _FIRST
    words = (words ^ (words >> np.uint64(27))) * _SECOND
    return words ^ (words >> np.uint64(31))


def draw_uniform_column(seeds: Seeds, *, item: int, tick: int, stream: int) -> Column:
    """Return one number in [0, 1) per seed [N], for this item of its world, at this tick, in this stream."""
    words = seeds.astype(np.uint64)
    for part in (item, tick, stream):
        words = _mix(words + _WEYL) + np.uint64(part)
    return (_mix(words + _WEYL) >> np.uint64(11)).astype(np.float64) * 2.0**-53
