"""Real robots as bodies: readings come from the latest messages, and commands are sent as limited speeds.

`robots.safety` decides what may move a robot. This module adds the rules about its readings (required ones, geofence)
and sends the messages.
"""

from __future__ import annotations

import atexit
import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Self
from zlib import crc32

import numpy as np

from understudy.addons.robots.derived_readings import DerivedReadings
from understudy.addons.robots.inputs import SensorInputs
from understudy.addons.robots.recording_transport import RecordingTransport
from understudy.addons.robots.robot_file import DiagnosticsSpec, RobotFile
from understudy.addons.robots.ros.diagnostic_messages import (
    DIAGNOSTICS,
    DiagnosticStatus,
    StatusLevel,
    StatusListener,
    StatusPublisher,
)
from understudy.addons.robots.ros.open_transport import open_transport
from understudy.addons.robots.ros.simulation_clock import SimulationClock
from understudy.addons.robots.ros.transport import Publish, Transport
from understudy.addons.robots.safety.guard import Guard
from understudy.addons.robots.safety.self_monitor import StopReason
from understudy.addons.robots.safety.speed_limits import Speeds
from understudy.addons.robots.safety.stop_log import StopEvent, StopLog, find_stop_log
from understudy.addons.robots.safety.watchdog_client import WatchdogClient
from understudy.addons.robots.skills.cancel_all import make_cancel_sender
from understudy.addons.robots.skills.robot_skills import RobotSkills
from understudy.clock import REAL_TIME, Clock
from understudy.errors import FileError, UnderstudyError, UnknownName, join_names
from understudy.model.features import Percept, ReadingKey, format_reading_label
from understudy.records.messages import encode_twist
from understudy.records.recorder import RunRecorder
from understudy.runtime.body import ISSUED, SKILL, Channel, Commands, Reading
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import COLUMNS, MOVING, list_type_readings, make_command_table
from understudy.sim.scenario.schema import RobotType, Scenario
from understudy.sim.skill_parts import SKILL_CHANNELS

_DRIVE, _TURN = COLUMNS.index("drive"), COLUMNS.index("turn")
"""The columns of the channels by which robots move."""


class Robot:
    """One robot behind a transport: a body with N = 1, which sends no commands until a person arms it.

    The transport's threads write the latest values; the deciding thread reads them. If such a thread ends, readings
    become absent after their `stale_s`, which stops the robot if one of them is `required` or the geofence needs it.

    `act` sends one command and returns; the caller keeps the time of ticks. The guard's thread repeats the command,
    and sends a stop if the next one does not come (`robots.safety.guard`). Without a watchdog there is no such
    thread; use `connect_robot_body`, which makes one. FileError is raised if the robot file asks for something that
    messages do not contain.

    `clock` must be the one that messages are stamped with on arrival. The time of day is used only
    in the stamp of a TwistStamped: a robot whose clock differs by more than its command timeout may refuse such
    commands.
    """

    agents = 1

    def __init__(
        self,
        file: RobotFile,
        transport: Transport,
        *,
        path: Path | str = "robot.toml",
        clock: Clock = REAL_TIME,
        watchdog: WatchdogClient | None = None,
    ) -> None:
        self.file, self.transport, self.path = file, transport, Path(path)
        self._clock = clock
        self._began = clock()
        self._snapshot: dict[ReadingKey, float] | None = None
        self._at = self._began
        self.simulation_clock = SimulationClock(transport) if file.use_sim_time else None
        """The clock by which it ticks, if that is a simulation's. Stops go by this computer's clock."""
        self._time_s = 0.0
        self.scenario, self.kind = find_robot_scenario(file, path)
        """The scenario whose lessons it runs, and its type there; None if its file names no scenario."""
        colored = () if self.scenario is None else tuple(self.scenario.targets)
        self.senses = SensorInputs(file, transport, path=path, targets=colored)
        self.targets: Sequence[str] = self.senses.targets
        check_readings_fit(file, self.senses.readings, self.kind, path)
        seed = crc32(f"{file.domain} {file.namespace} {file.name}".encode())
        self._derived = DerivedReadings(self.kind, self.senses.readings, self.targets, seed=seed)
        self.skills = RobotSkills(file, transport, path=path, locate=self._locate, clock=clock)
        """Its skills, which are carried out by the robot itself."""
        self.channels: Sequence[Channel] = (*MOVING, *(SKILL_CHANNELS if file.skills else ()))
        self._channel_names = [channel.name for channel in self.channels]
        self._where = f"robot {file.name!r}"
        self.readings: Sequence[Reading] = (
            *self.senses.readings,
            *self._derived.readings,
            *self.skills.readings,
        )
        self._publish: Publish | None = None
        self._diagnosed = of = file.diagnostics or DiagnosticsSpec()
        self.statuses = StatusListener((*of.unfit, *of.stop))
        """Statuses of the robot's own drivers, which its file names."""
        if of.unfit or of.stop:
            transport.subscribe(file.topic(of.topic), DIAGNOSTICS, self.statuses.receive)
        self.status_publisher: StatusPublisher | None = None
        """The publisher of its state as diagnostics; None if its file does not ask for that."""
        if of.publish:
            publish = transport.publisher(file.topic(of.topic), DIAGNOSTICS)
            self.status_publisher = StatusPublisher(publish, [self.describe_status])
        self._cancel_all = make_cancel_sender(file, transport, clock=clock)
        self._owner = os.getpid()
        self.guard = Guard(
            file,
            send=self._send,
            danger=self._danger,
            halt=self.skills.stop,
            peers=transport.peers,
            heard={file.topic(source.topic) for source in self.senses.sources.values()},
            clock=clock,
            log=StopLog(file.name, None if watchdog is None else find_stop_log(file, path)),
            watchdog=watchdog,
        )

    @property
    def armed(self) -> bool:
        """True if the program's commands are sent; otherwise stops or nothing are."""
        return self.guard.armed

    @property
    def stop_cause(self) -> str:
        """The reason why the robot is stopped or disarmed; empty while it may move."""
        return self.guard.stopped

    @property
    def unfitness(self) -> str:
        """The reason why the robot must not be counted as a member of its squad; empty if it is fit.

        A robot that is disarmed, that its readings forbid to move (outside its geofence, a required one absent), or
        whose messages have all ceased is not fit.
        """
        if not self.armed:
            return self.stop_cause or "is disarmed"
        now = self._clock()
        if (danger := self._danger(now)) is not None:
            return danger.cause
        if (error := self.statuses.find_error((*self._diagnosed.unfit, *self._diagnosed.stop))) is not None:
            return error
        fresh = any(self.senses.read_fresh(name, now) for name in self.senses.sources)
        return "" if fresh or not self.senses.sources else "sends nothing"

    @property
    def stops(self) -> Sequence[StopEvent]:
        """All stops since it was connected, oldest first."""
        return tuple(self.guard.log.stops)

    @property
    def tick_s(self) -> float:
        """The nominal length of a tick, in s."""
        return self.file.tick_s

    @property
    def time_s(self) -> float:
        """The time from connecting the robot to the beginning of this tick, in s, by the clock of its ticks."""
        return self._time_s

    @property
    def now_s(self) -> float:
        """The present time in s, by the clock that messages are stamped with on arrival."""
        return self._clock()

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """Return the latest values, a column [1] for each key; NaN where older than its limit.

        All calls return the same values until `act` or the next tick.
        """
        return {key: np.array([value]) for key, value in self.read_values(keys).items()}

    def read_values(self, keys: Sequence[ReadingKey]) -> dict[ReadingKey, float]:
        """Return the latest values, a number for each key, as `sense` does."""
        now = self._clock()
        if self._snapshot is None or now - self._at >= self.tick_s:
            self._at = now
            self._time_s = now - self._began if self.simulation_clock is None else self.simulation_clock()
            values = self.senses.values(now)
            derived = self._derived.compute(self.time_s, values, self.guard.speeds[0])
            self._snapshot = values | derived | self.skills.values(now)
        values = self._snapshot
        for key in keys:
            if key not in values:
                name, labels = format_reading_label(key), list(map(format_reading_label, values))
                raise UnknownName(what="reading", name=name, where=self._where, known=labels)
        return {key: values[key] for key in keys}

    def act(self, commands: Commands) -> None:
        """Send one command within the limits, or a stop if the robot must not move; start and cancel skills.

        If it is not armed, no command is sent and no skill is started. A command that cannot be carried out (an
        unknown channel, a wrong shape) sends a stop and raises. A transport that fails to send raises too, after which
        the watchdog stops the robot.
        """
        try:
            table = make_command_table(commands, agents=1, channels=self._channel_names, where=self._where)
        except UnderstudyError:
            self.guard.stop_until_next_command("a command that makes no sense")
            raise
        sensed_s = None if self._snapshot is None else self._at
        self._snapshot = None
        if self.status_publisher is not None:
            self.status_publisher.update(self._clock(), time_s=self._stamp_s)
        drive, turn = float(table[0, _DRIVE]), float(table[0, _TURN])
        of, number, issued = self.file.commands, 0.0, 0.0
        if self.file.skills:
            number, issued = (
                float(np.asarray(commands[name])[0]) if name in commands else 0.0 for name in (SKILL, ISSUED)
            )
        if not number:
            self.skills.ask(0, issued)
        if self.skills.will_drive(int(number), issued):
            self.guard.yield_to_skill(sensed_s=sensed_s)
        else:
            self.guard.command((drive * of.drive_m_s, turn * of.turn_rad_s), sensed_s=sensed_s)
        if number and not self.guard.stopped:
            self.skills.ask(int(number), issued)
            if self.guard.stopped:  # by another thread, meanwhile
                self.skills.stop(self.guard.stopped)

    def describe_status(self) -> DiagnosticStatus:
        """Describe the robot for its diagnostics: ERROR if it is stopped, WARN if it is disarmed."""
        stopped, now = self.guard.stopped, self._clock()
        level = StatusLevel.OK if not stopped else StatusLevel.ERROR if self.armed else StatusLevel.WARN
        ages = {
            f"age of {name} (s)": f"{now - latest.at_s:.1f}" if latest.count else "never came"
            for name, latest in self.senses.latest.items()
        }
        speeds = {
            "speed (m/s)": f"{self.guard.speeds[0]:.2f}",
            "turning (rad/s)": f"{self.guard.speeds[1]:.2f}",
        }
        armed = {"armed": str(self.armed).lower()}
        return DiagnosticStatus(
            f"understudy: {self.file.name}", level, stopped or "armed", armed | speeds | ages
        )

    def index_skill(self, name: str, binding: Mapping[str, str]) -> int:
        """Return the number of a skill with targets, for the channel `skill`."""
        return self.skills.index(name, binding)

    @property
    def stop_count(self) -> int:
        """The number of orders to stop or disarm it so far, armed or not."""
        return self.guard.stop_count

    def arm(self, by: str, *, stop_count: int | None = None) -> None:
        """Send the program's commands from now on, because the person `by` orders it; never call this without one.

        ArmingRefused, WatchdogFailed or FileError (the stop log) is raised if it must not be armed, such as if another
        thread stopped it since the order: `stop_count` is that of the moment of the order, if that was earlier. The
        robot is stopped when the program ends: by `close` at exit, or by the watchdog if the program has no time for
        that.
        """
        self.guard.arm(by, stop_count=stop_count)
        atexit.register(self.close)

    def prepare(self) -> None:
        """Start the watchdog before arming, which blocks for about 0.5 s; raise WatchdogFailed if that fails."""
        self.guard.prepare()

    def disarm(self, cause: str = "disarmed") -> None:
        """Send a stop at once and disarm the robot; do nothing if it is not armed."""
        self.guard.disarm(cause)

    def emergency_stop(self, cause: str) -> None:
        """Send a stop at once and disarm the robot, even if it is not armed: another program may be driving it."""
        self.guard.emergency_stop(cause)
        self._cancel_all()

    def hold_key(self, for_s: float) -> None:
        """Count the hold-to-run key as held for the given time (s, at most 1), or as released if it is 0.

        This matters only for robot files with `hold_to_run`.
        """
        self.guard.hold_key(for_s)

    def close(self, cause: str = "its program left") -> None:
        """Disconnect, and stop the robot first if this program may be moving it; one that others drive is left alone.

        In a fork of the process that connected the robot it does nothing. If it is interrupted, it runs again at
        exit.
        """
        if os.getpid() != self._owner:
            return
        self.guard.close(cause)
        self.transport.close()
        atexit.unregister(self.close)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        self.close(describe_exit_reason(error))

    def _locate(self, target: str) -> tuple[float, float] | None:
        return self.senses.locate(target, self._clock())

    def _danger(self, now: float) -> StopReason | None:
        """Return why the robot's readings forbid it to move now, or None.

        The reasons are a required reading that is absent, an error in the diagnostics that its file names, and a
        place outside the geofence. The robot is disarmed at once if a sensor is silent for `stale_s`, or the place is
        outside or unknown; after `LOST_S` if the sensor sends but its value is absent, or the error lasts. In other
        cases it moves again when the cause is gone.
        """
        if (name := self.senses.find_missing(now)) is not None:
            return StopReason(f"{name} is absent", lost=not self.senses.read_fresh(name, now))
        if (error := self.statuses.find_error(self._diagnosed.stop)) is not None:
            return StopReason(error, lost=False)
        if (fence := self.file.limits.geofence) is not None:
            x, y = (self.senses.value(name, now) for name in ("x", "y"))
            if not (fence[0] <= x <= fence[2] and fence[1] <= y <= fence[3]):
                return StopReason("outside its geofence")
        return None

    def _send(self, speeds: Speeds) -> None:
        commands = self.file.commands
        if self._publish is None:  # made late: a program that only reads must not be a publisher of commands
            self._publish = self.transport.publisher(self.file.topic(commands.topic), commands.type)
        speed, turning = speeds
        self._publish(
            encode_twist(
                commands.type,
                speed_m_s=speed,
                turn_rad_s=turning,
                frame=commands.frame,
                time_s=self._stamp_s,
            )
        )

    @property
    def _stamp_s(self) -> float:
        """The time for stamps of messages: of day, or of the simulation, s."""
        return time.time() if self.simulation_clock is None else self.simulation_clock.stamp_s


def describe_exit_reason(error: type[BaseException] | None) -> str:
    """Describe why a program leaves a robot, from the exception that ends it, for the log of stops."""
    if error is None or issubclass(error, SystemExit):
        return "its program left"
    if issubclass(error, KeyboardInterrupt):
        return "its program was interrupted"
    return f"its program failed: {error.__name__}"


def connect_robot_body(
    file: RobotFile, *, path: Path | str = "robot.toml", recorder: RunRecorder | None = None
) -> Robot:
    """Connect to the robot of a robot file, optionally with a recorder of its messages.

    ExtraMissing is raised if its transport is not installed.
    """
    opened = open_transport(file)
    transport = opened if recorder is None else RecordingTransport(opened, recorder)
    try:
        return Robot(file, transport, path=path, watchdog=WatchdogClient(file, log=find_stop_log(file, path)))
    except BaseException:
        transport.close()
        raise


def check_readings_fit(
    file: RobotFile, offered: Sequence[Reading], robot_type: RobotType | None, path: Path | str
) -> None:
    """Refuse a reading whose kind or unit differs from that of the same name in the scenario."""
    there = {} if robot_type is None else {each.name: each for _, each in list_type_readings(robot_type)}
    for each in offered:
        of = there.get(each.name)
        if of is None or each.of_targets != of.of_targets:
            continue
        place = f"readings.{each.name}"
        if each.kind != of.kind:
            problem = f"is {each.kind}, and {of.kind} in {file.world}"
            raise FileError(path=path, place=place, problem=problem, remedy="read such a field, or rename it")
        if each.unit and of.unit and each.unit != of.unit:
            problem = f"is {each.unit}, and {of.unit} in {file.world}"
            remedy = f"read a field in {of.unit}, or rename it"
            raise FileError(path=path, place=f"{place}.unit", problem=problem, remedy=remedy)


def find_robot_scenario(file: RobotFile, path: Path | str) -> tuple[Scenario | None, RobotType | None]:
    """Return the scenario that a robot file names and the robot's type in it, or None for both without a scenario.

    The name is a path relative to the robot file, or that of a built-in scenario.
    """
    if file.world is None:
        return None, None
    beside = Path(path).parent / file.world
    scenario = find_scenario(beside if beside.is_file() else file.world)
    return scenario, find_robot_type(file, scenario, path)


def find_robot_type(file: RobotFile, scenario: Scenario, path: Path | str) -> RobotType:
    """Return the type of a robot in a scenario; FileError if its file has to name one, or names another."""
    kind = file.kind or next(iter(scenario.types))
    if kind not in scenario.types or (file.kind is None and len(scenario.types) > 1):
        where = file.world or scenario.name
        problem = "is missing" if file.kind is None else f"is {kind!r:.60}, which {where} has not"
        raise FileError(path=path, place="kind", problem=problem, remedy=f"give {join_names(scenario.types)}")
    return scenario.types[kind]
