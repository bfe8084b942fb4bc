"""Whether the program that decides can be relied on itself: it looks often enough, and its watchdog is there."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Sequence
from threading import get_native_id
from typing import NamedTuple

from understudy.robots.ros.transport import Publisher
from understudy.robots.safety.watchdog import ANEW, MOVING, PRIORITY, RESTING
from understudy.robots.safety.watchdog_client import WatchdogClient

LOST_S = 1.0
"""A robot that waits longer than this for a tick, a reading, or a program that stood still is disarmed."""
ASLEEP_S = 0.5
"""A computer that slept longer than this has to be armed again: nobody expects a robot to go on with it."""


class StopReason(NamedTuple):
    """Why a robot must not move now. Where `lost`, a person has to look after it before it may again."""

    cause: str
    lost: bool = True


class SelfMonitor:
    """How a program watches over itself, with a watchdog on a leash. Without one it has no doubts: for tests."""

    def __init__(self, leash: WatchdogClient | None, *, deadline_s: float) -> None:
        self._leash, self._deadline_s = leash, deadline_s
        self._looked_s, self._asleep_s, self._anew = 0.0, 0.0, False

    @property
    def has_watchdog(self) -> bool:
        """Whether there is a watchdog to be kept."""
        return self._leash is not None

    @property
    def watchdogs(self) -> int:
        """How many watchdogs of ours are connected to the robot."""
        return 0 if self._leash is None else self._leash.count

    def start(self, peers: Sequence[Publisher]) -> None:
        """See that the watchdog is there, and has found these others; WatchdogFailed where it does not."""
        if self._leash is not None:
            self._leash.start(peers)

    def begin(self, now: float) -> None:
        """The robot may move from now on."""
        self._looked_s, self._asleep_s = now, measure_time_asleep()
        if self._leash is not None:
            self._leash.begin()
            self._leash.send(ANEW)

    def find_stop_reason(self, now: float) -> StopReason | None:
        """Why the program cannot be relied on now."""
        if self._leash is None:
            return None
        if danger := self.overrun(self._looked_s, now):
            return danger
        if measure_time_asleep() - self._asleep_s > ASLEEP_S:
            return StopReason("this computer slept")
        if problem := self._leash.problem():
            return StopReason(problem)
        if self._leash.poll_intervention():
            self._anew = True
            return StopReason("the watchdog had to stop it", lost=False)
        return None

    def overrun(self, since_s: float, now: float) -> StopReason | None:
        """That the program stood still from then to now, longer than the watchdog allows."""
        still_s = now - since_s
        if self._leash is None or still_s <= self._deadline_s:
            return None
        self._anew = True
        return StopReason(f"this program stood still for {still_s:.2f} s", lost=still_s > LOST_S)

    def confirm_check(self, now: float, *, armed: bool, moving: bool) -> None:
        """The guard has looked, and stopped what had to be stopped: the watchdog is told."""
        self._looked_s = now
        if self._leash is not None:
            self._leash.send(ANEW if armed and self._anew else MOVING if moving else RESTING)
            if not armed:  # its answers must not pile up
                self._leash.problem()
                self._leash.poll_intervention()
        self._anew = False

    def abandon_robot(self) -> None:
        """Leave the robot to the watchdog, which stops it."""
        if self._leash is not None:
            self._leash.abandon()

    def shut_watchdog_down(self) -> None:
        """Send the watchdog home."""
        if self._leash is not None:
            self._leash.shut_down()


def raise_thread_priority() -> None:
    """Let this thread have the processor before others, where the system allows that."""
    if sys.platform == "linux":  # elsewhere threads have no numbers that this takes
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, get_native_id(), PRIORITY)


def measure_time_asleep() -> float:
    """For how long this computer slept since it was started, s: time that no clock of ours has seen; 0 if unknown."""
    if sys.platform != "linux":
        return 0.0
    return time.clock_gettime(time.CLOCK_BOOTTIME) - time.monotonic()
