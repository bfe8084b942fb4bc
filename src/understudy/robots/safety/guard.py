"""The guard: every command to a robot passes here, and is stopped here when anything is wrong.

A thread repeats the last command between ticks, so that a robot which waits for commands is fed, and sends stop instead
where a tick does not come, a reading is lost, the robot leaves its geofence, a key is let go, somebody else commands it
or the watchdog is gone. One lock orders all that is sent: no older command overtakes a stop.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Collection, Sequence
from math import inf
from threading import Event, Lock, RLock, Thread, current_thread
from typing import NoReturn

from understudy.errors import UnderstudyError
from understudy.robots.robot_file import RobotFile
from understudy.robots.ros.transport import Publisher
from understudy.robots.safety.self_monitor import LOST_S, SelfMonitor, StopReason, raise_thread_priority
from understudy.robots.safety.speed_limits import STILL, Speeds, limit_speeds
from understudy.robots.safety.stop_log import StopLog
from understudy.robots.safety.watchdog_client import WatchdogClient

NOT_ARMED = "not armed"
NO_KEY = "nobody holds the key"
PERIOD_S = 0.02
"""From one look to the next, and from one repeated command to the next."""
FIRST_S = 10.0
"""For so long after arming the first command may take."""
STOPPING_S = 5.0
"""For so long after disarming a robot is sent stop, over and over; then others may drive it."""
PARTING = 3
"""So often stop is sent when the program ends."""
OTHERS_S = 0.2
"""From one look for others who command to the next."""
KEY_S = 1.0
"""No key counts as held for longer without a new sign."""


class ArmingRefused(UnderstudyError, json_type="ArmingRefused"):
    """A robot that cannot be armed now."""

    def __init__(self, *, robot: str, problem: str, remedy: str) -> None:
        self.robot, self.problem, self.remedy = robot, problem, remedy
        super().__init__(f"robot {robot!r} stays disarmed: {problem}; {remedy}")


class Guard:
    """What a robot may do now, and what it was told last.

    `send` sends speeds, `danger` says what the readings have against moving at a moment, `peers` who else publishes,
    and `heard` are the topics that the robot is heard on. Without a leash there is no watchdog, no log and no thread,
    and `check` has to be called: that is for tests and replays, `connect` gives a robot a leash.
    """

    def __init__(
        self,
        file: RobotFile,
        *,
        send: Callable[[Speeds], None],
        danger: Callable[[float], StopReason | None],
        peers: Callable[[], Sequence[Publisher]],
        heard: Collection[str],
        clock: Callable[[], float],
        log: StopLog | None = None,
        leash: WatchdogClient | None = None,
    ) -> None:
        self._file, self._send, self._danger, self._peers = file, send, danger, peers
        self._heard, self._clock = heard, clock
        self._vigil = SelfMonitor(leash, deadline_s=file.safety.deadline_s)
        self.log = log or StopLog(file.name)
        self._topic = file.topic(file.commands.topic)
        self._hold_s = file.tick_s + file.safety.deadline_s
        self._lock, self._arming, self._end = RLock(), Lock(), Event()
        self._thread: Thread | None = None
        self._by, self._orders = "", 0
        self.stopped = NOT_ARMED
        """Why the last command was a stop; empty where it may move."""
        self.speeds = STILL
        """What the robot was told last."""
        self._asked_s = self._told_s = self._stopped_s = -inf
        self._due_s = self._held_s = self._quiet_s = -inf

    @property
    def armed(self) -> bool:
        """Whether it obeys."""
        return bool(self._by)

    def prepare(self) -> None:
        """Start the watchdog, so that arming takes no time; WatchdogFailed where it does not start."""
        with self._arming:
            if not self.armed:
                self._start()

    def _start(self) -> None:
        self._refuse_closed()
        self._vigil.start([peer for peer in self._peers() if peer.topic in self._heard])
        if self._end.is_set():  # who closed it found no watchdog yet to send home
            self._vigil.shut_watchdog_down()
        self._refuse_closed()

    def arm(self, by: str) -> None:
        """Obey from now on, since a person says so. ArmingRefused, WatchdogFailed or FileError where it must not.

        The first time this takes about half a second: until the watchdog has found the robot.
        """
        with self._arming:
            if self.armed:
                return
            self._refuse_closed()
            orders = self._orders
            if not by.strip():
                self._refuse("nobody says who arms it", "give a person's name")
            self._refuse_danger()
            self.log.begin()
            if self._vigil.has_watchdog:
                self._start()
                self._refuse_danger()  # it took a while
            with self._lock:
                if orders != self._orders:
                    self._refuse("it was told to stop meanwhile", "arm again")
                now = self._clock()
                self._by, self.stopped, self.speeds = by, "", STILL
                if self._file.safety.hold_to_run:
                    self.stopped = NO_KEY
                self._told_s = now
                self._vigil.begin(now)
                self._due_s, self._held_s = now + FIRST_S, -inf
            self._watch()

    def command(self, asked: Speeds, *, sensed_s: float | None = None) -> None:
        """Tell the robot this, within the limits, until the next tick; stop where it must not move.

        `sensed_s` is when that was read on which this was decided.
        """
        with self._lock:
            now = self._clock()
            if not self.armed:
                self._repeat(now)
                return
            danger = self._against(now)
            if danger is None and sensed_s is not None and now - sensed_s > self._hold_s:
                danger = StopReason(
                    f"a command was decided on what was {now - sensed_s:.2f} s ago", lost=False
                )
            elapsed_s = min(now - self._told_s, 2 * self._file.tick_s)  # after a pause no leap
            self._told_s = now
            self._due_s = now + self._hold_s
            if danger is None:
                self.stopped = ""
                self._issue(
                    limit_speeds(self._file.limits, asked, last=self.speeds, elapsed_s=elapsed_s), now
                )
            else:
                self._heed(danger, now)

    def check(self) -> None:
        """Stop it where it must not move, else repeat what it was told; the thread does this all the time."""
        others, seen = 0, self._clock()
        if self.armed and seen - self._asked_s > OTHERS_S:
            others, self._asked_s = self._others(), seen
        with self._lock:
            now = self._clock()
            if self.armed:
                danger = self._against(now, others)
                if danger is None and now > self._due_s:
                    danger = StopReason(f"no command came for {now - self._told_s:.2f} s", lost=False)
                if danger is None:
                    self._issue(self.speeds, now)
                else:
                    self._heed(danger, now)
            else:
                self._repeat(now)
            self._vigil.confirm_check(now, armed=self.armed, moving=self.armed or now < self._quiet_s)

    def hold(self, for_s: float) -> None:
        """A person's key is down, and counts as held for so long, at most KEY_S; 0: it was let go."""
        with self._lock:
            self._held_s = self._clock() + min(for_s, KEY_S) if for_s > 0 else -inf

    def refuse(self, cause: str) -> None:
        """Stop it until the next command; it stays armed."""
        with self._lock:
            if self.armed:
                self._heed(StopReason(cause, lost=False), self._clock())

    def disarm(self, cause: str) -> None:
        """Stop it, and let it obey no more."""
        with self._lock:
            self._orders += 1
            if self.armed:
                self._disarm(cause, "program")

    def emergency_stop(self, cause: str) -> None:
        """Stop it, whether it was armed or not, and let it obey no more."""
        with self._lock:
            self._orders += 1
            if not self._end.is_set():
                self._disarm(f"emergency: {cause}", "program")
        self._watch()

    def close(self, cause: str) -> None:
        """Stop it if it may still be moving, and end the thread and the watchdog."""
        with self._lock:
            self._orders += 1
            if self.armed:
                self._disarm(cause, "program")
        self._end.set()
        if self._thread is not None and self._thread is not current_thread():
            self._thread.join()
            for _ in range(PARTING):
                self._repeat(self._clock())
                time.sleep(PERIOD_S)
        self._quiet_s = -inf
        self._vigil.shut_watchdog_down()

    def _others(self) -> int:
        """How many publish commands besides us and our watchdog."""
        count = sum(peer.topic == self._topic for peer in self._peers())
        return max(0, count - self._vigil.watchdogs)

    def _refuse_closed(self) -> None:
        if self._end.is_set():
            self._refuse("it was closed", "connect to it again")

    def _refuse_danger(self) -> None:
        danger = self._danger(self._clock())
        if danger is not None:
            self._refuse(danger.cause, "put that right, and arm again")
        if self._others():
            remedy = "stop that; if it was killed, wait ten seconds"
            self._refuse(f"somebody else publishes on {self._topic}", remedy)

    def _refuse(self, problem: str, remedy: str) -> NoReturn:
        raise ArmingRefused(robot=self._file.name, problem=problem, remedy=remedy)

    def _against(self, now: float, others: int = 0) -> StopReason | None:
        """What speaks against moving now, but for a tick that is a little late."""
        if danger := self._vigil.find_stop_reason(now):
            return danger
        if others:
            return StopReason(f"somebody else publishes on {self._topic}")
        if now - self._due_s > LOST_S:
            return StopReason(f"no command came for {now - self._told_s:.2f} s")
        danger = self._danger(now)
        if danger is not None:
            lasts = danger.cause == self.stopped and now - self._stopped_s > LOST_S
            return StopReason(danger.cause, danger.lost or lasts)
        if self._file.safety.hold_to_run and now > self._held_s:
            return StopReason(NO_KEY, lost=False)
        return None

    def _heed(self, danger: StopReason, now: float) -> None:
        if danger.lost:
            self._disarm(danger.cause, "guard")
            return
        before, self.stopped = self.stopped, danger.cause
        self._stop(now)
        if danger.cause != before:
            self._stopped_s = now
        if not before:
            self.log.add(danger.cause, "guard")

    def _disarm(self, cause: str, by: str) -> None:
        now = self._clock()
        self._by, self.stopped, self._quiet_s = "", cause, now + STOPPING_S
        self._stop(now)
        self.log.add(cause, by)

    def _repeat(self, now: float) -> None:
        """Disarmed, send stop for a while."""
        if now < self._quiet_s:
            self._stop(now)

    def _stop(self, now: float) -> None:
        with contextlib.suppress(Exception):  # it was left to the watchdog, and who stops several goes on
            self._issue(STILL, now)

    def _issue(self, speeds: Speeds, now: float) -> None:
        self.speeds = speeds
        try:
            self._send(speeds)
        except Exception:
            self._give_up("commands cannot be sent")
            raise
        if speeds != STILL and (danger := self._vigil.overrun(now, self._clock())):
            # It was frozen just here: this command may have come after the watchdog's stop.
            self._heed(danger, now)

    def _give_up(self, cause: str) -> None:
        """Leave it to the watchdog, which stops it."""
        with self._lock:
            self._by, self.stopped, self.speeds, self._quiet_s = "", cause, STILL, -inf
            self._vigil.abandon_robot()
            self.log.add(cause, "guard")

    def _watch(self) -> None:
        """Look all the time from now on."""
        with self._lock:
            if self._vigil.has_watchdog and self._thread is None and not self._end.is_set():
                self._thread = Thread(target=self._run, name="guard", daemon=True)
                self._thread.start()

    def _run(self) -> None:
        raise_thread_priority()
        while not self._end.wait(PERIOD_S):
            try:
                self.check()
            except Exception as error:  # whatever it was, nobody would guard the robot
                with self._lock:
                    if self.armed:
                        self._disarm(f"the guard failed ({error})", "guard")
