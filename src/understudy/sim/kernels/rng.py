"""Keyed random draws inside kernels: the same numbers as `layout/rng.py` gives for the same key."""

import math
from typing import Any

from understudy._jit_kernels import njit, uint64


@njit(error_model="numpy", forceinline=True)
def mix_bits(word: Any) -> Any:
    """SplitMix64's finalizer."""
    word = uint64(word)
    word = uint64((word ^ (word >> uint64(30))) * uint64(0xBF58476D1CE4E5B9))
    word = uint64((word ^ (word >> uint64(27))) * uint64(0x94D049BB133111EB))
    return word ^ (word >> uint64(31))


@njit(error_model="numpy", forceinline=True)
def draw_uniform(seed: Any, item: Any, tick: Any, stream: Any) -> Any:
    """One number in [0, 1) for this item of the world with this seed, at this tick, in this stream."""
    weyl = uint64(0x9E3779B97F4A7C15)
    word = mix_bits(uint64(seed) + weyl) + uint64(item)
    word = mix_bits(word + weyl) + uint64(tick)
    word = mix_bits(word + weyl) + uint64(stream)
    return float(mix_bits(word + weyl) >> uint64(11)) * 2.0**-53


@njit(error_model="numpy", forceinline=True)
def draw_normal(seed: Any, item: Any, tick: Any, stream: Any) -> Any:
    """One number from the standard normal distribution (Box and Muller), keyed likewise; uses streams 2 apart."""
    radius = math.sqrt(-2.0 * math.log(1.0 - draw_uniform(seed, item, tick, stream)))
    return radius * math.cos(2.0 * math.pi * draw_uniform(seed, item, tick, stream + 1))
