"""Monotonic time, and waiting by it, as one value that a test can replace by simulated time."""

from __future__ import annotations

import time
from threading import Event
from typing import Protocol


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
