"""Keyed random draws in kernels, equal to those of `layout/rng.py` for the same key."""

import math
from typing import Any

from understudy._jit_kernels import njit, uint64


@njit(error_model="numpy", forceinline=True)
def mix_bits(word: Any) -> Any:
    """Scramble the bits of a 64-bit word with the finalizer of SplitMix64 (Steele, Lea & Flood 2014)."""
    word = uint64(word)
    word = uint64((word ^ (word >> uint64(30))) * uint64(0xBF58476D1CE4E5B9))
    word = uint64((word ^ (word >> uint64(27))) * uint64(0x94D049BB133111EB))
    return word ^ (word >> uint64(31))


@njit(error_model="numpy", forceinline=True)
def draw_uniform(seed: Any, item: Any, tick: Any, stream: Any) -> Any:
    """Return a uniform number in [0, 1) that depends only on the world's seed, the item, the tick and the stream."""
    weyl = uint64(0x9E3779B97F4A7C15)
    word = mix_bits(uint64(seed) + weyl) + uint64(item)
    word = mix_bits(word + weyl) + uint64(tick)
    word = mix_bits(word + weyl) + uint64(stream)
    return float(mix_bits(word + weyl) >> uint64(11)) * 2.0**-53


@njit(error_model="numpy", forceinline=True)
def draw_normal(seed: Any, item: Any, tick: Any, stream: Any) -> Any:
    """Return a standard normal number (Box & Muller 1958) for such a key; it uses `stream` and `stream` + 1."""
    radius = math.sqrt(-2.0 * math.log(1.0 - draw_uniform(seed, item, tick, stream)))
    return radius * math.cos(2.0 * math.pi * draw_uniform(seed, item, tick, stream + 1))
