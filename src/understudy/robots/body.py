"""A real robot as a body: its last messages are its readings, its commands go out as limited speeds."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isnan, nan
from pathlib import Path
from typing import Any, Self

import numpy as np

from understudy.errors import FileError, UnderstudyError, UnknownName
from understudy.model.feature import Percept, ReadingKey
from understudy.robots.dds import DDS
from understudy.robots.extracting import Extract, extraction
from understudy.robots.file import ReadingOf, RobotFile
from understudy.robots.messages import MessageRefused, decode, twist
from understudy.robots.transport import Transport
from understudy.runtime.body import Channel, Commands, Reading
from understudy.worlds.commands import table_of
from understudy.worlds.kits import COLUMNS, MOVING
from understudy.worlds.mismatch import Mismatch

STILL = (0.0, 0.0)
"""Neither driving nor turning, m/s and rad/s."""


@dataclass(slots=True)
class Latest:
    """What has arrived for a reading: its last value, when (s, `time.monotonic`), how often, how often in vain."""

    value: float = nan
    at_s: float = -inf
    first_s: float = nan
    count: int = 0
    refused: int = 0
    problem: str = ""

    @property
    def rate_hz(self) -> float:
        """Messages per second from the first to the last; NaN where there were not two."""
        return (self.count - 1) / (self.at_s - self.first_s) if self.at_s > self.first_s else nan


@dataclass(frozen=True, slots=True)
class _Source:
    """A reading of the file, and what takes it out of a message."""

    of: ReadingOf
    extract: Extract
    latest: Latest


class Robot:
    """One robot behind a transport: a Body with N = 1 that sends nothing but stop until it is armed.

    Message threads write the last values, the deciding thread reads them. A call to `act` sends one command and
    returns; whoever runs the robot keeps its ticks. FileError where the file asks for what no message has.
    """

    agents = 1
    targets: Sequence[str] = ()
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
        self._snapshot: tuple[float, dict[ReadingKey, float]] | None = None
        self._speeds, self._sent_s, self._sent = STILL, clock(), False
        self.armed = False
        self.stopped = "not armed"
        """Why the last command was a stop; empty where it was none."""
        self._sources, self.readings = _sources(file, path)
        for topic, type in dict.fromkeys(
            (source.of.topic, source.of.type) for source in self._sources.values()
        ):
            transport.subscribe(file.topic(topic), type, self._listener(topic, type))
        self._publish = transport.publisher(file.topic(file.commands.topic), file.commands.type)

    @property
    def tick_s(self) -> float:
        """The nominal length of a tick, s."""
        return self.file.tick_s

    @property
    def time_s(self) -> float:
        """Time since the robot was connected, s."""
        return self._clock() - self._began

    @property
    def latest(self) -> Mapping[str, Latest]:
        """What has arrived for each reading."""
        return {name: source.latest for name, source in self._sources.items()}

    def since_start(self, at_s: float) -> float:
        """A moment of the clock as one of `time_s`."""
        return at_s - self._began

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        """The last values, each as a column [1]; NaN where older than its limit. The same until the next tick."""
        now = self._clock()
        if self._snapshot is None or now - self._snapshot[0] >= self.tick_s:
            fresh: dict[ReadingKey, float] = {
                (name, None): self._value(source, now) for name, source in self._sources.items()
            }
            self._snapshot = now, fresh
        values = self._snapshot[1]
        for reading, target in keys:
            if (reading, target) not in values:
                name = reading if target is None else f"{reading}({target})"
                raise UnknownName(what="reading", name=name, where=self._where, known=list(self._sources))
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

    def _listener(self, topic: str, type: str) -> Callable[[bytes, float], None]:
        """What takes the readings of a topic out of its messages; never fails, whatever the message."""
        here = [each for each in self._sources.values() if (each.of.topic, each.of.type) == (topic, type)]

        def received(data: bytes, at_s: float) -> None:
            try:
                message: Any = decode(type, data)
            except MessageRefused as error:
                for source in here:
                    source.latest.refused += 1
                    source.latest.problem = error.problem
                return
            for source in here:
                latest = source.latest
                try:
                    latest.value = source.extract(message)
                except Exception as error:  # what somebody made up must not end the thread that listens
                    latest.value, latest.problem = nan, str(error)
                    latest.refused += 1
                    continue
                latest.at_s = at_s
                if not latest.count:
                    latest.first_s = at_s
                latest.count += 1

        return received

    def _value(self, source: _Source, now: float) -> float:
        return source.latest.value if now - source.latest.at_s <= source.of.stale_s else nan

    def _reason_to_stop(self) -> str:
        """Why it must not move now; empty where it may."""
        now = self._clock()
        if not self.armed:
            return "not armed"
        for name, source in self._sources.items():
            if source.of.required and isnan(self._value(source, now)):
                return f"{name} is absent"
        if (fence := self.file.limits.geofence) is not None:
            x, y = (self._value(self._sources[name], now) for name in ("x", "y"))
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


def _sources(file: RobotFile, path: Path | str) -> tuple[dict[str, _Source], tuple[Reading, ...]]:
    """What each reading comes from, and what the body says of it."""
    sources, readings = {}, []
    for name, reading in file.readings.items():
        found = extraction(reading)
        if isinstance(found, Mismatch):
            place = f"readings.{name}.{found.key}"
            raise FileError(path=path, place=place, problem=found.problem, remedy=found.remedy)
        kind, unit, extract = found
        sources[name] = _Source(reading, extract, Latest())
        readings.append(Reading(name, kind, unit, doc=reading.doc))
    return sources, tuple(readings)


def _toward(want: float, last: float, step: float | None) -> float:
    """The value wanted, but no further than a step from the last one."""
    return float(want if step is None else np.clip(want, last - step, last + step))
