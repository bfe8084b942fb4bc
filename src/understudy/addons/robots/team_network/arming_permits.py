"""Permits to arm a robot over the network: an order that a stop has overtaken, or that comes late, arms nothing.

A program that arms a robot first asks its agent for a permit, and arms it with that. The agent notes how often the
robot had been stopped when it was asked. So a stop after the question holds, however late the network delivers the
messages.
"""

from __future__ import annotations

from collections.abc import Callable
from secrets import token_hex
from threading import Lock

from understudy.clock import REAL_TIME

PERMIT_S = 6.0
"""The time in s for which a permit holds, shorter than the wait for the answer to an order to arm."""


class ArmingPermits:
    """The permits that one agent has given, each for one use; they may be given in any thread.

    Parameters
    ----------
    clock
        A monotonic clock, s.
    """

    def __init__(self, clock: Callable[[], float] = REAL_TIME) -> None:
        self._clock, self._lock = clock, Lock()
        self._given: dict[str, tuple[float, int]] = {}

    def give(self, stop_count: int) -> str:
        """Return a new permit to arm the robot, if it has been told to stop `stop_count` times, and is not again."""
        now, permit = self._clock(), token_hex(8)
        with self._lock:
            self._given = {each: (at, of) for each, (at, of) in self._given.items() if now - at <= PERMIT_S}
            self._given[permit] = now, stop_count
        return permit

    def use(self, permit: str) -> int | None:
        """Return the number of stops for which a permit is valid; None if it has expired, or was used."""
        with self._lock:
            at, stop_count = self._given.pop(permit, (None, 0))
        return stop_count if at is not None and self._clock() - at <= PERMIT_S else None
