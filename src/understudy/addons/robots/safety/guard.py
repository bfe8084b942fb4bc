"""The guard of a robot, which checks 50 times a second whether it may move, and sends its last command or a stop.

Every command of this process to a robot passes through its `Guard`. The guard's thread repeats the last command every
`PERIOD_S`, because many drivers stop a robot that receives none, and sends a stop (zero speeds) instead if no tick
comes, a required reading is absent, the robot leaves its geofence, the hold-to-run key is released, another publisher
commands it, or the watchdog is gone. One lock orders everything that is sent, so that no older command follows a
stop.

While a skill of the robot drives it (`yield_to_skill`), no speeds are sent, and all checks go on. What stops the robot
cancels the skill, too.

What happens when a part of this fails:

- The deciding thread ends, hangs or is late: from `tick_s + deadline_s` after its last command on, the guard's thread
  sends stops; `LOST_S` (1 s) later it disarms the robot.
- A check raises an exception in the guard's thread: the robot is disarmed and sent stops; the thread continues.
- The guard's thread ends or hangs, or the whole process is frozen or killed: the watchdog process gets no heartbeat
for
  `deadline_s` and sends stops itself. `command` sends nothing but stops then, too, because the last check is too old.
- The watchdog process ends: the next check disarms the robot, `PERIOD_S` later at most. It hangs: disarmed after
  0.5 s without an answer (`watchdog_client.ANSWER_S`). Until that is noticed the guard's thread alone stops the
  robot.
- A command cannot be sent: the pipe to the watchdog is closed, whereupon the watchdog sends stops over its own
  connection; the robot is disarmed.
- The date is set or NTP steps the clock: no effect, because all intervals are differences of `time.monotonic`. A
  computer that was suspended disarms the robot when it wakes (`self_monitor`; detected on Linux only).
- The link is cut, or the computer loses power: nothing here can stop the robot. Its own command timeout has to.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Collection, Sequence
from math import inf
from threading import Event, Lock, RLock, Thread, current_thread
from typing import NoReturn

from understudy.addons.robots.robot_file import RobotFile
from understudy.addons.robots.ros.transport import Publisher
from understudy.addons.robots.safety.self_monitor import (
    LOST_S,
    SelfMonitor,
    StopReason,
    raise_thread_priority,
)
from understudy.addons.robots.safety.speed_limits import STILL, Speeds, limit_speeds
from understudy.addons.robots.safety.stop_log import StopLog
from understudy.addons.robots.safety.watchdog_client import WatchdogClient
from understudy.clock import Clock
from understudy.errors import UnderstudyError

NOT_ARMED = "not armed"
NO_KEY = "nobody holds the key"
PERIOD_S = 0.02
"""Time between two checks, and between two repetitions of a command, s."""
FIRST_S = 10.0
"""Longest time from arming to the first command, s; until it comes the robot is sent zero speeds."""
STOPPING_S = 5.0
"""Duration of repeating stops after disarming, s; then nothing is sent, and others may drive the robot."""
PARTING = 3
"""Number of further stops sent when the program leaves a robot that it stopped less than STOPPING_S ago."""
OTHERS_S = 0.2
"""Time between two checks for other publishers of commands, s."""
KEY_S = 1.0
"""Longest time for which a hold-to-run key counts as held without a new report, s."""


class ArmingRefused(UnderstudyError, json_type="ArmingRefused"):
    """A refusal to arm a robot, with the reason and a remedy; the robot stays disarmed."""

    def __init__(self, *, robot: str, problem: str, remedy: str) -> None:
        self.robot, self.problem, self.remedy = robot, problem, remedy
        super().__init__(f"robot {robot!r} stays disarmed: {problem}; {remedy}")


class Guard:
    """The armed state of one robot, with limits on its commands and stops in place of those that must not be sent.

    An armed robot either moves or is *stopped* (`stopped` names the cause): that ends with the next command to which
    no check objects. A *disarmed* robot is sent stops for `STOPPING_S`, then nothing, until a person arms it again.

    Methods may be called from any thread; those that send block while another thread sends.

    Parameters
    ----------
    file
        Limits, deadlines and topics of the robot.
    send
        Function that sends speeds (m/s, rad/s) at once. If it raises an exception, the watchdog stops the robot.
    danger
        Function that returns why the robot's readings forbid it to move at a time (s, of `clock`), or None.
    halt
        Function that cancels the skill that runs, if any, for a cause. It must not block.
    peers
        Function that lists the publishers of other processes on the robot's network.
    heard
        Topics of the robot's sensors: the watchdog has to discover their publishers before it counts as ready.
    clock
        Clock with which messages are stamped on arrival. It must not jump; do not pass the time of day.
    log
        Log of stops; by default they are kept in memory only.
    watchdog
        Connection to the robot's watchdog process. Without it there is no watchdog and no thread, and the caller has
        to call `check`: for tests and replays only. `connect_robot_body` always passes one.
    """

    def __init__(
        self,
        file: RobotFile,
        *,
        send: Callable[[Speeds], None],
        danger: Callable[[float], StopReason | None],
        halt: Callable[[str], None] = lambda cause: None,
        peers: Callable[[], Sequence[Publisher]],
        heard: Collection[str],
        clock: Clock,
        log: StopLog | None = None,
        watchdog: WatchdogClient | None = None,
    ) -> None:
        self._file, self._send, self._danger, self._peers = file, send, danger, peers
        self._halt, self._yields = halt, False
        self._skills_drive, self._expected = any(skill.moves for skill in file.skills.values()), 0
        self._heard, self._clock = heard, clock
        self._monitor = SelfMonitor(watchdog, deadline_s=file.safety.deadline_s)
        self.log = log or StopLog(file.name)
        self._topic = file.topic(file.commands.topic)
        self._hold_s = file.tick_s + file.safety.deadline_s
        self._lock, self._arming, self._end = RLock(), Lock(), Event()
        self._thread: Thread | None = None
        self._by = ""
        self.stop_count = 0
        """The number of orders to stop or disarm the robot so far, armed or not."""
        self.stopped = NOT_ARMED
        """The reason why the last command was a stop; empty while the robot may move."""
        self.speeds = STILL
        """The speeds that were sent last, m/s and rad/s."""
        # Times of `clock`, s: the last look for other publishers, the last command of the program, the last new cause
        # of a stop; then until when the next command is due, the key counts as held, and stops go on after disarming.
        self._asked_s = self._told_s = self._stopped_s = -inf
        self._due_s = self._held_s = self._stops_until_s = -inf

    @property
    def armed(self) -> bool:
        """True if the program's commands are sent; otherwise stops or nothing are."""
        return bool(self._by)

    def prepare(self) -> None:
        """Start the watchdog before arming, which is then immediate; block until it is ready, about 0.5 s.

        WatchdogFailed is raised if it does not start, ArmingRefused if the guard is closed. Nothing is sent to the
        robot but the watchdog's first stop.
        """
        with self._arming:
            if not self.armed:
                self._expect_others()
                self._start()

    def _start(self) -> None:
        self._refuse_closed()
        self._monitor.start([peer for peer in self._peers() if peer.topic in self._heard])
        if self._end.is_set():  # `close` ran meanwhile, and found no watchdog yet to shut down
            self._monitor.shut_watchdog_down()
        self._refuse_closed()

    def arm(self, by: str, *, stop_count: int | None = None) -> None:
        """Send the program's commands from now on, because the person `by` orders it; start the guard's thread.

        Nothing happens if it is armed already. The first call blocks for about 0.5 s, until the watchdog has
        discovered the robot. If another thread stops the robot meanwhile, arming is refused. `stop_count` is that of
        the moment at which the person ordered it, if that was earlier.

        ArmingRefused is raised if a required reading is absent, the robot is outside its geofence, another publisher
        commands it, or it was stopped meanwhile or closed; WatchdogFailed or FileError (the stop log cannot be
        written) may be raised too. The robot then stays disarmed.
        """
        with self._arming:
            if self.armed:
                return
            self._refuse_closed()
            stop_count = self.stop_count if stop_count is None else stop_count
            self._expect_others()
            if not by.strip():
                self._refuse("no person is named", "give a person's name")
            self._refuse_danger()
            self.log.begin()
            if self._monitor.has_watchdog:
                self._start()
                self._refuse_danger()  # it took a while
            with self._lock:
                if stop_count != self.stop_count:
                    self._refuse("it was stopped meanwhile", "arm again")
                now = self._clock()
                self._by, self.stopped, self.speeds = by, "", STILL
                if self._file.safety.hold_to_run:
                    self.stopped = NO_KEY
                self._told_s = now
                self._monitor.begin(now)
                self._due_s, self._held_s = now + FIRST_S, -inf
            self._watch()

    def command(self, speeds: Speeds, *, sensed_s: float | None = None) -> None:
        """Send these speeds (m/s, rad/s) within the limits, or a stop if the robot must not move.

        The guard's thread repeats what was sent until the next command, for `tick_s + deadline_s` at most. `sensed_s`
        is the time of the readings that this was decided on (s, of `clock`): a stop is sent if it is longer ago than
        that. If the robot is disarmed, the speeds are ignored. An exception of `send` is raised again, after leaving
        the robot to the watchdog.
        """
        self._decide(speeds, sensed_s)

    def yield_to_skill(self, *, sensed_s: float | None = None) -> None:
        """Let a skill of the robot drive it until the next command: all checks go on, and no speeds are sent.

        The robot is sent zero speeds once before. If it must not move, the skill is cancelled, and stops are sent.
        """
        self._decide(None, sensed_s)

    def _decide(self, speeds: Speeds | None, sensed_s: float | None) -> None:
        with self._lock:
            now = self._clock()
            if not self.armed:
                self._repeat(now)
                return
            danger = self._find_stop_reason(now)
            if danger is None and sensed_s is not None and now - sensed_s > self._hold_s:
                danger = StopReason(
                    f"a command was decided on what was {now - sensed_s:.2f} s ago", lost=False
                )
            elapsed_s = min(now - self._told_s, 2 * self._file.tick_s)  # after a pause no leap
            self._told_s = now
            self._due_s = now + self._hold_s
            if danger is None and speeds is None:
                self.stopped = ""
                if not self._yields:
                    self._issue(STILL, now)
                    self._yields = self.armed
            elif danger is None and speeds is not None:
                self.stopped = ""
                self._issue(
                    limit_speeds(self._file.limits, speeds, last=self.speeds, elapsed_s=elapsed_s), now
                )
            elif danger is not None:
                self._respond(danger, now)

    def check(self) -> None:
        """Send a stop if the robot must not move, else repeat the last speeds; then send the watchdog a heartbeat.

        The guard's thread calls this every `PERIOD_S`.
        """
        others, now_s = 0, self._clock()
        if self.armed and now_s - self._asked_s > OTHERS_S:
            others, self._asked_s = self._others(), now_s
        with self._lock:
            now = self._clock()
            if self.armed:
                danger = self._find_stop_reason(now, others)
                if danger is None and now > self._due_s:
                    danger = StopReason(f"no command came for {now - self._told_s:.2f} s", lost=False)
                if danger is not None:
                    self._respond(danger, now)
                elif not self._yields:
                    self._issue(self.speeds, now)
            else:
                self._repeat(now)
            self._monitor.send_heartbeat(
                now, armed=self.armed, moving=self.armed or now < self._stops_until_s
            )

    def hold_key(self, for_s: float) -> None:
        """Count the hold-to-run key as held for `for_s` (s, at most KEY_S) from now, or as released if it is 0.

        If it is released or not reported again in time, the next check sends a stop; the robot stays armed.
        """
        with self._lock:
            self._held_s = self._clock() + min(for_s, KEY_S) if for_s > 0 else -inf

    def stop_until_next_command(self, cause: str) -> None:
        """Stop the robot until the next command, for a command that cannot be carried out; it stays armed."""
        with self._lock:
            if self.armed:
                self._respond(StopReason(cause, lost=False), self._clock())

    def disarm(self, cause: str) -> None:
        """Send a stop at once and disarm the robot; if it is not armed, only cancel an arming in progress."""
        with self._lock:
            self.stop_count += 1
            if self.armed:
                self._disarm(cause, "program")

    def emergency_stop(self, cause: str) -> None:
        """Send a stop at once and disarm the robot, even one that is not armed: another program may be driving it.

        A failure to send is not raised: an armed robot is then stopped by its watchdog.
        """
        with self._lock:
            self.stop_count += 1
            if not self._end.is_set():
                self._disarm(f"emergency: {cause}", "program")
        self._watch()

    def close(self, cause: str) -> None:
        """Disarm the robot if it is armed, and end the guard's thread and the watchdog; it cannot be armed again.

        A robot that this program never moved is sent nothing, because others may be driving it. The call blocks until
        the thread and the watchdog have ended, which takes 3 s at most for the latter.
        """
        with self._lock:
            self.stop_count += 1
            if self.armed:
                self._disarm(cause, "program")
        self._end.set()
        if self._thread is not None and self._thread is not current_thread():
            self._thread.join()
            for _ in range(PARTING):
                self._repeat(self._clock())
                self._clock.sleep(PERIOD_S)
        self._stops_until_s = -inf
        self._monitor.shut_watchdog_down()

    def _others(self) -> int:
        """Count the publishers of commands besides this process, its watchdog, and those of the robot's skills."""
        return max(0, self._count_publishers() - self._expected)

    def _count_publishers(self) -> int:
        return sum(peer.topic == self._topic for peer in self._peers()) - self._monitor.watchdogs

    def _expect_others(self) -> None:
        """Count the publishers of commands before arming as the robot's own, if it has skills that drive.

        A watchdog that was started just now may not have been discovered, so that more are expected rather than fewer.
        """
        if self._skills_drive:
            before = self._expected if self._monitor.watchdogs else 0
            self._expected = max(self._count_publishers(), before)

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

    def _find_stop_reason(self, now: float, others: int = 0) -> StopReason | None:
        """Return why the robot must not move now, or None; a tick late by up to LOST_S is left to `check`."""
        if danger := self._monitor.find_stop_reason(now):
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

    def _respond(self, danger: StopReason, now: float) -> None:
        """Send a stop for a reason, and log it if the robot moved before; disarm if the reason is `lost`."""
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
        self._by, self.stopped, self._stops_until_s = "", cause, now + STOPPING_S
        self._stop(now)
        self.log.add(cause, by)

    def _repeat(self, now: float) -> None:
        """Repeat the stop of a disarmed robot until `STOPPING_S` have passed."""
        if now < self._stops_until_s:
            self._stop(now)

    def _stop(self, now: float) -> None:
        with contextlib.suppress(Exception):  # the watchdog stops it; others are still to be stopped
            self._issue(STILL, now)
        with contextlib.suppress(Exception):
            self._halt(self.stopped)

    def _issue(self, speeds: Speeds, now: float) -> None:
        self.speeds, self._yields = speeds, False
        try:
            self._send(speeds)
        except Exception:
            self._give_up("commands cannot be sent")
            raise
        if speeds != STILL and (danger := self._monitor.check_overrun(now, self._clock())):
            # The process was frozen while sending: this command may have arrived after the watchdog's stop.
            self._respond(danger, now)

    def _give_up(self, cause: str) -> None:
        """Disarm without sending, and close the watchdog's pipe, whereupon the watchdog sends the stops."""
        with self._lock:
            self._by, self.stopped, self.speeds, self._stops_until_s = "", cause, STILL, -inf
            self._yields = False
            self._monitor.leave_to_watchdog()
            with contextlib.suppress(Exception):
                self._halt(cause)
            self.log.add(cause, "guard")

    def _watch(self) -> None:
        """Start the guard's thread, once; never without a watchdog, or after `close`."""
        with self._lock:
            if self._monitor.has_watchdog and self._thread is None and not self._end.is_set():
                self._thread = Thread(target=self._run, name="guard", daemon=True)
                self._thread.start()

    def _run(self) -> None:
        raise_thread_priority()
        while not self._clock.wait(self._end, PERIOD_S):
            try:
                self.check()
            except Exception as error:  # or this thread would end, and only the watchdog be left
                with self._lock:
                    if self.armed:
                        self._disarm(f"the guard failed ({error})", "guard")
