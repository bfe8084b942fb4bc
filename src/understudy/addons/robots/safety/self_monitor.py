"""Detection that this process stood still, that the computer was suspended, or that the watchdog is gone.

The guard queries this before each command and at each check, and reports each check; every report is a heartbeat to
the watchdog. Nothing here has a thread or sends to the robot: `SelfMonitor` returns a reason, and the guard acts on
it.

Times are of `time.monotonic`, which no change of the date moves. On Linux it stands still while the computer is
suspended, so that a suspension is no delay: it is measured as the growth of CLOCK_BOOTTIME over CLOCK_MONOTONIC. On
other systems that is unknown and taken as 0; whether a suspension is noticed there depends on their monotonic clock.
"""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import time
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

from understudy.addons.robots.ros.transport import Publisher
from understudy.addons.robots.safety.watchdog import MOVING, PRIORITY, RESTING, TAKEN_OVER
from understudy.addons.robots.safety.watchdog_client import WatchdogClient
from understudy.clock import measure_clock_offset

LOST_S = 1.0
"""Longest delay of a tick or reading, or standstill of the process, s, before the robot is disarmed."""
ASLEEP_S = 0.5
"""Longest suspension after arming, s, before the robot is disarmed; it must not start as a computer wakes."""


class StopReason(NamedTuple):
    """The reason why a robot must not move now.

    If `lost` is True the robot is disarmed, until a person arms it; otherwise it is stopped until the cause is gone.
    """

    cause: str
    lost: bool = True


class SelfMonitor:
    """A monitor of what makes this process unfit to move a robot; it also sends heartbeats to the robot's watchdog.

    `watchdog` is the connection to the watchdog; without one (tests, replays) nothing is detected. `deadline_s` is
    how long the process may go without a check by the guard, s. The guard calls `begin`, `find_stop_reason`,
    `check_overrun`, `send_heartbeat` and `leave_to_watchdog` with its lock held.
    """

    def __init__(self, watchdog: WatchdogClient | None, *, deadline_s: float) -> None:
        self._watchdog, self._deadline_s = watchdog, deadline_s
        self._looked_s, self._asleep_s, self._takes_over = 0.0, 0.0, False

    @property
    def has_watchdog(self) -> bool:
        """True if there is a watchdog to start and to send heartbeats to."""
        return self._watchdog is not None

    @property
    def watchdogs(self) -> int:
        """The number of watchdogs of this process that may be connected to the robot, and so publish its commands."""
        return 0 if self._watchdog is None else self._watchdog.count

    def start(self, peers: Sequence[Publisher]) -> None:
        """Start the watchdog unless it runs, and wait until it has discovered these publishers.

        WatchdogFailed is raised if that fails.
        """
        if self._watchdog is not None:
            self._watchdog.start(peers)

    def begin(self, now: float) -> None:
        """Begin to measure at arming: forget earlier delays and interventions, and end the watchdog's stops."""
        self._looked_s, self._asleep_s = now, measure_time_asleep()
        if self._watchdog is not None:
            self._watchdog.begin()
            self._watchdog.send(TAKEN_OVER)

    def find_stop_reason(self, now: float) -> StopReason | None:
        """Return why this process must not move the robot now, or None.

        Reasons to disarm (`lost`) are no check for more than LOST_S, a suspension, and a watchdog that ended or does
        not answer. Reasons to stop until the next command are no check for more than `deadline_s`, and a watchdog
        that had to send stops since.
        """
        if self._watchdog is None:
            return None
        if danger := self.check_overrun(self._looked_s, now):
            return danger
        if measure_time_asleep() - self._asleep_s > ASLEEP_S:
            return StopReason("this computer slept")
        if problem := self._watchdog.problem():
            return StopReason(problem)
        if self._watchdog.poll_intervention():
            self._takes_over = True
            return StopReason("the watchdog had to stop it", lost=False)
        return None

    def check_overrun(self, since_s: float, now: float) -> StopReason | None:
        """Return a reason to stop if the time from `since_s` to `now` exceeds `deadline_s`.

        The watchdog has sent stops in that case.
        """
        still_s = now - since_s
        if self._watchdog is None or still_s <= self._deadline_s:
            return None
        self._takes_over = True
        return StopReason(f"this program stood still for {still_s:.2f} s", lost=still_s > LOST_S)

    def send_heartbeat(self, now: float, *, armed: bool, moving: bool) -> None:
        """Send the watchdog a heartbeat after a check: whether the robot is armed, and whether it may be moving.

        TAKEN_OVER is sent after this process stood still or the watchdog intervened: it ends the watchdog's stops,
        which would go on for 1 s, because the guard's check has just sent the right command.
        """
        self._looked_s = now
        if self._watchdog is not None:
            self._watchdog.send(TAKEN_OVER if armed and self._takes_over else MOVING if moving else RESTING)
            if not armed:  # its answers are read nowhere else then, and a full pipe would block it
                self._watchdog.problem()
                self._watchdog.poll_intervention()
        self._takes_over = False

    def leave_to_watchdog(self) -> None:
        """Close the watchdog's pipe without a goodbye, so that it stops a moving robot for 1 s, and ends."""
        if self._watchdog is not None:
            self._watchdog.close_without_goodbye()

    def shut_watchdog_down(self) -> None:
        """End the watchdog process without stops, and wait for its end."""
        if self._watchdog is not None:
            self._watchdog.shut_down()


def raise_thread_priority() -> None:
    """Raise this thread's scheduling priority on Linux, if permitted (root, CAP_SYS_NICE); else do nothing."""
    if sys.platform == "linux":  # elsewhere threads have no numbers that this takes
        with contextlib.suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), PRIORITY)


def measure_time_asleep() -> float:
    """Measure how long this computer was suspended since it was started, s; 0 if that is unknown (not Linux)."""
    if sys.platform != "linux":
        return 0.0
    return measure_clock_offset(time.monotonic, partial(time.clock_gettime_ns, time.CLOCK_BOOTTIME)) / 1e9
