"""Random draws keyed by their purpose, so that a world draws the same alone or among a thousand others.

A draw is a hash of (world seed, id within its world, tick, stream), independent of other draws. The hash is the
finalizer of SplitMix64 (Steele, Lea & Flood 2014), applied once per part of the key. Kernels and columns draw the same
for the same key, on all machines: logarithm, cosine and sine are our own, since mathematical libraries differ in their
last digit. Generator 1, that of versions before 0.3, used these; a scenario may name it.
"""

import math
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.jit.decorators import inlined, uint64
from understudy.sim.kernels.angles import compute_cosine_and_sine

Seeds: TypeAlias = NDArray[np.int64]
Words: TypeAlias = NDArray[np.uint64]

FORMER = 1
"""The generator of versions before 0.3."""
SQRT_HALF = math.sqrt(0.5)
# The logarithm of 2 in two parts, the first with few digits, so that a thousand times it is exact.
LOG_2_HIGH, LOG_2_LOW = 0.6931471803691238, 1.9082149292705877e-10

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
def compute_logarithm(x: float) -> Any:
    """Return the natural logarithm of a number above 0 that is not subnormal, with error below 1 ulp."""
    part, exponent = math.frexp(x)
    if part < SQRT_HALF:  # then from sqrt(1 / 2) to sqrt(2)
        part, exponent = 2.0 * part, exponent - 1
    f = part - 1.0
    s = f / (2.0 + f)
    u = s * s
    # (log(part) / s - 2) / u for |s| up to 3 - sqrt(8), to 4e-16: interpolated at Chebyshev nodes.
    series = 0.666666666666667 + u * (
        0.39999999999899505
        + u
        * (
            0.28571428625975487
            + u
            * (
                0.2222221113479508
                + u * (0.18182889125261723 + u * (0.15331721600556042 + u * 0.14616449685043406))
            )
        )
    )
    half = 0.5 * f * f
    return exponent * LOG_2_HIGH - ((half - (s * (half + u * series) + exponent * LOG_2_LOW)) - f)


@inlined
def make_normal(uniform: float, turn: float, generator: Any) -> Any:
    """Return a standard normal number made of two uniform ones in [0, 1) (Box & Muller 1958)."""
    if generator == FORMER:
        return math.sqrt(-2.0 * math.log(1.0 - uniform)) * math.cos(2.0 * math.pi * turn)
    cosine, _ = compute_cosine_and_sine(2.0 * math.pi * turn)
    return math.sqrt(-2.0 * compute_logarithm(1.0 - uniform)) * cosine


@inlined
def draw_normal(seed: Any, item: Any, tick: Any, stream: Any, generator: Any) -> Any:
    """Return a standard normal number for such a key; it uses `stream` and `stream` + 1."""
    uniform, turn = draw_uniform(seed, item, tick, stream), draw_uniform(seed, item, tick, stream + 1)
    return make_normal(uniform, turn, generator)


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
