"""Random draws keyed by their purpose, so that a world draws the same alone or among a thousand others.

A draw is a hash of (world seed, id within its world, tick, stream), independent of other draws. The hash is the
finalizer of SplitMix64 (Steele, Lea & Flood 2014), applied once per part of the key. Kernels and columns draw the same
for the same key.
"""

import math
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.jit.decorators import inlined, uint64

Seeds: TypeAlias = NDArray[np.int64]
Words: TypeAlias = NDArray[np.uint64]

_WEYL = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)


@inlined
def mix_bits(word: Any) -> Any:
    """Scramble the bits of a 64-bit word with the finalizer of SplitMix64 (Steele, Lea & Flood 2014)."""
    word = uint64(word)
    word = uint64((word ^ (word >> uint64(30))) * uint64(0xBF58476D1CE4E5B9))
    word = uint64((word ^ (word >> uint64(27))) * uint64(0x94D049BB133111EB))
    return word ^ (word >> uint64(31))


@inlined
def draw_uniform(seed: Any, item: Any, tick: Any, stream: Any) -> Any:
    """Return a uniform number in [0, 1) that depends only on the world's seed, the item, the tick and the stream."""
    weyl = uint64(0x9E3779B97F4A7C15)
    word = mix_bits(uint64(seed) + weyl) + uint64(item)
    word = mix_bits(word + weyl) + uint64(tick)
    word = mix_bits(word + weyl) + uint64(stream)
    return float(mix_bits(word + weyl) >> uint64(11)) * 2.0**-53


@inlined
def draw_normal(seed: Any, item: Any, tick: Any, stream: Any) -> Any:
    """Return a standard normal number (Box & Muller 1958) for such a key; it uses `stream` and `stream` + 1."""
    radius = math.sqrt(-2.0 * math.log(1.0 - draw_uniform(seed, item, tick, stream)))
    return radius * math.cos(2.0 * math.pi * draw_uniform(seed, item, tick, stream + 1))


def _mix(words: Words) -> Words:
    words = (words ^ (words >> np.uint64(30))) * _FIRST
    words = (words ^ (words >> np.uint64(27))) * _SECOND
    return words ^ (words >> np.uint64(31))


def draw_uniform_column(seeds: Seeds, *, item: int, tick: int, stream: int) -> NDArray[np.float64]:
    """Return one number in [0, 1) per seed [N], for this item of its world, at this tick, in this stream."""
    words = seeds.astype(np.uint64)
    for part in (item, tick, stream):
        words = _mix(words + _WEYL) + np.uint64(part)
    return (_mix(words + _WEYL) >> np.uint64(11)).astype(np.float64) * 2.0**-53
