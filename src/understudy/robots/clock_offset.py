"""How far one clock of this computer is ahead of another, in a program that may be held up at any moment."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

PROMPT_S = 1e-5
"""Two readings of a clock within this time are close enough to say what another clock showed in between, s."""
ATTEMPTS = 100
"""The largest number of attempts at such readings; of them, the two closest count."""


def measure_clock_offset(clock: Callable[[], float], other: Callable[[], int]) -> int:
    """Measure how far another clock is ahead of a clock.

    A program may be held up between its readings of two clocks, for seconds on a busy computer, and the offset would be
    wrong by as much. Therefore `clock` is read before and after `other`, again if that took long.

    Parameters
    ----------
    clock
        A function that returns the time of a clock, s.
    other
        A function that returns the time of the other clock, ns.

    Returns
    -------
    int
        The offset, ns. It is wrong by at most half the time between the two closest readings of `clock`, which is
        `PROMPT_S` unless each of `ATTEMPTS` was held up.
    """
    closest_s, offset_ns = inf, 0
    for _ in range(ATTEMPTS):
        before_s, other_ns, after_s = clock(), other(), clock()
        if after_s - before_s < closest_s:
            closest_s = after_s - before_s
            offset_ns = other_ns - round((before_s + after_s) / 2 * 1e9)
        if closest_s <= PROMPT_S:
            break
    return offset_ns
