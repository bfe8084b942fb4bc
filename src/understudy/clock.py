"""Monotonic time, and waiting by it, as one value that a test can replace; and how far clocks are apart."""

from __future__ import annotations

import time
from collections.abc import Callable
from math import inf
from threading import Event
from typing import Protocol

PROMPT_S = 1e-5
"""Two readings of a clock within this time are close enough to say what another clock showed in between, s."""
ATTEMPTS = 100
"""The largest number of attempts at such readings; of them, the two closest count."""


class Clock(Protocol):
    """A monotonic clock that is called for the time, and that waits.

    Code that measures intervals or waits takes a clock, `REAL_TIME` unless another is given. Code that only asks for
    the time takes any function that returns seconds.
    """

    def __call__(self) -> float:
        """Return the time, s; only differences have a meaning."""

    def sleep(self, seconds: float) -> None:
        """Return after some seconds; at once if there are none or fewer."""

    def wait(self, event: Event, timeout_s: float) -> bool:
        """Wait until an event is set, for some seconds at most; return whether it is."""


class MonotonicClock:
    """The time of this computer since some moment, which setting the date does not change."""

    def __call__(self) -> float:
        """Return the time, s."""
        return time.monotonic()

    def sleep(self, seconds: float) -> None:
        """Return after some seconds."""
        time.sleep(max(0.0, seconds))

    def wait(self, event: Event, timeout_s: float) -> bool:
        """Wait until an event is set, for some seconds at most; return whether it is."""
        return event.wait(max(0.0, timeout_s))


REAL_TIME: Clock = MonotonicClock()


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
