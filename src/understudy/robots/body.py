"""A real robot as a body: its last messages are its readings, its commands go out as limited speeds."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Self

import numpy as np

from understudy.errors import FileError, UnderstudyError, UnknownName, listed
from understudy.model.feature import Percept, ReadingKey
from understudy.robots.dds import DDS
from understudy.robots.deriving import Derived
from understudy.robots.file import RobotFile
from understudy.robots.messages import twist
from understudy.robots.senses import Senses
from understudy.robots.transport import Transport
from understudy.runtime.body import Channel, Commands, Reading
from understudy.worlds.catalog import find_world
from understudy.worlds.commands import table_of
from understudy.worlds.kits import COLUMNS, MOVING
from understudy.worlds.scenario import RobotType, Scenario

STILL = (0.0, 0.0)
"""Neither driving nor turning, m/s and rad/s."""


class Robot:
    """One robot behind a transport: a Body with N = 1 that sends nothing but stop until it is armed.

    Message threads write the last values, the deciding thread reads them. A call to `act` sends one command and
    returns; whoever runs the robot keeps its ticks. FileError where the file asks for what no message has.
    """

    agents = 1
    channels: Sequence[Channel] = MOVING

    def __init__(
        self,
        file: RobotFile,
        transport: Transport,
        *,
        path: Path | str = "robot.toml",
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.file, self.transport = file, transport
        self._clock = clock
        self._began = clock()
        self._snapshot: dict[ReadingKey, float] | None = None
        self._at = self._began
        self._speeds, self._sent_s, self._sent = STILL, clock(), False
        self.armed = False
        self.stopped = "not armed"
        """Why the last command was a stop; empty where it was none."""
        self.scenario, self.kind = _world_of(file, path)
        """The scenario whose lessons it runs, and what it is there; None where its file names none."""
        self.senses = Senses(file, transport, path=path)
        self.targets: Sequence[str] = self.senses.targets
        self._derived = Derived(self.kind, self.senses.readings, self.targets)
        self.readings: Sequence[Reading] = (*self.senses.readings, *self._derived.readings)
        self._publish = transport.publisher(file.topic(file.commands.topic), file.commands.type)

    @property
    def tick_s(self) -> float:
        """The nominal length of a tick, s."""
        return self.file.tick_s

    @property
    def time_s(self) -> float:
        """Time from when the robot was connected to the beginning of this tick, s."""
        return self._at - self._began

    @property
    def now_s(self) -> float:
        """Now, by the clock that messages are stamped with on arrival, s."""
        return self._clock()

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """The last values, a column [1] each; NaN where older than its limit. The same until `act` or the next tick."""
        now = self._clock()
        if self._snapshot is None or now - self._at >= self.tick_s:
            self._at = now
            values = self.senses.values(now)
            self._snapshot = values | self._derived.at(self.time_s, values, self._speeds[0])
        values = self._snapshot
        for reading, target in keys:
            if (reading, target) not in values:
                name = reading if target is None else f"{reading}({target})"
                known = [each if target is None else f"{each}({target})" for each, target in values]
                raise UnknownName(what="reading", name=name, where=self._where, known=known)
        return {key: np.array([values[key]]) for key in keys}

    def act(self, commands: Commands) -> None:
        """Send one command, within the limits; stop where the robot is not armed, or must not move.

        A command that makes no sense stops the robot, too, and raises.
        """
        try:
            known = [channel.name for channel in self.channels]
            table = table_of(commands, agents=1, channels=known, where=self._where)
        except UnderstudyError:
            self.stopped = "a command that makes no sense"
            self._send(STILL)
            raise
        self._snapshot = None
        drive, turn = (float(table[0, COLUMNS.index(name)]) for name in ("drive", "turn"))
        self.stopped = self._reason_to_stop()
        self._send(STILL if self.stopped else self._limited(drive, turn))

    def arm(self) -> None:
        """From now on, obey: only a person asks for this."""
        self.armed = True

    def stop(self) -> None:
        """Stop at once, and stay so until armed again."""
        self.armed, self.stopped = False, "not armed"
        self._send(STILL)

    def close(self) -> None:
        """Stop if anything was ever sent, and leave: who only looked must not stop a robot that others drive."""
        try:
            if self._sent:
                self.stop()
        finally:
            self.transport.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def _where(self) -> str:
        return f"robot {self.file.name!r}"

    def _reason_to_stop(self) -> str:
        """Why it must not move now; empty where it may."""
        now = self._clock()
        if not self.armed:
            return "not armed"
        if (name := self.senses.missing(now)) is not None:
            return f"{name} is absent"
        if (fence := self.file.limits.geofence) is not None:
            x, y = (self.senses.value(name, now) for name in ("x", "y"))
            if not (fence[0] <= x <= fence[2] and fence[1] <= y <= fence[3]):
                return "outside its geofence"
        return ""

    def _limited(self, drive: float, turn: float) -> tuple[float, float]:
        """Speeds within the limits, m/s and rad/s, no further from those sent last than accelerations allow."""
        limits, commands = self.file.limits, self.file.commands
        elapsed = min(self._clock() - self._sent_s, 2 * self.tick_s)  # after a pause no leap
        asked = drive * commands.drive_m_s, turn * commands.turn_rad_s
        within = (
            (limits.speed_m_s, limits.acceleration_m_s2),
            (limits.turn_rad_s, limits.turn_acceleration_rad_s2),
        )
        speed, turning = (
            _toward(np.clip(want, -most, most), last, None if rate is None else rate * elapsed)
            for want, last, (most, rate) in zip(asked, self._speeds, within, strict=True)
        )
        return speed, turning

    def _send(self, speeds: tuple[float, float]) -> None:
        commands = self.file.commands
        self._speeds, self._sent_s, self._sent = speeds, self._clock(), True
        speed, turning = speeds
        self._publish(
            twist(
                commands.type,
                speed_m_s=speed,
                turn_rad_s=turning,
                frame=commands.frame,
                time_s=time.time(),
            )
        )


def connect(file: RobotFile, *, path: Path | str = "robot.toml") -> Robot:
    """The robot of a file, over its transport; ExtraMissing where that is not installed."""
    transport = DDS(file.domain)
    try:
        return Robot(file, transport, path=path)
    except BaseException:
        transport.close()
        raise


def _world_of(file: RobotFile, path: Path | str) -> tuple[Scenario | None, RobotType | None]:
    """The scenario that a file names, a path beside it or one that is known, and the robot's type there."""
    if file.world is None:
        return None, None
    beside = Path(path).parent / file.world
    scenario = find_world(beside if beside.is_file() else file.world)
    kind = file.kind or next(iter(scenario.types))
    if kind not in scenario.types or (file.kind is None and len(scenario.types) > 1):
        problem = "is missing" if file.kind is None else f"is {kind!r:.60}, which {file.world} has not"
        raise FileError(path=path, place="kind", problem=problem, remedy=f"give {listed(scenario.types)}")
    return scenario, scenario.types[kind]


def _toward(want: float, last: float, step: float | None) -> float:
    """The value wanted, but no further than a step from the last one."""
    return float(want if step is None else np.clip(want, last - step, last + step))
