"""The senses of a real robot: what its messages said last, as readings, absent where that is too long ago."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isnan, nan
from pathlib import Path
from typing import Any, TypeVar

from understudy.errors import FileError
from understudy.model.features import ReadingKey
from understudy.robots.places import located
from understudy.robots.robot_file import RobotFile
from understudy.robots.ros.messages import MessageRefused, decode
from understudy.robots.ros.transport import Transport
from understudy.robots.sources import PLACE, Source, eye_of, sources
from understudy.runtime.body import Reading
from understudy.sim.kit import LOCATOR
from understudy.sim.scenario.toml_decode import Mismatch

Right = TypeVar("Right")


@dataclass(slots=True)
class Latest:
    """What has arrived of a source: its last values, when (s, `time.monotonic`), how often, how often in vain."""

    values: Mapping[ReadingKey, float] = field(default_factory=dict)
    at_s: float = -inf
    first_s: float = nan
    count: int = 0
    refused: int = 0
    problem: str = ""

    @property
    def rate_hz(self) -> float:
        """Messages per second from the first to the last; NaN where there were not two."""
        return (self.count - 1) / (self.at_s - self.first_s) if self.at_s > self.first_s else nan


class Senses:
    """All sources of a robot's file, listening. Message threads write what came last; anybody may read it.

    FileError where the file asks for what no message has.
    """

    def __init__(
        self,
        file: RobotFile,
        transport: Transport,
        *,
        path: Path | str = "robot.toml",
        targets: Sequence[str] = (),
    ) -> None:
        """`targets` may get a color while it runs."""
        self.eye = _right(eye_of(file), path)
        found = _right(sources(file, self.eye, targets), path)
        self._places = file.targets
        self.sources: Mapping[str, Source] = {source.name: source for source in found}
        self.latest: Mapping[str, Latest] = {name: Latest() for name in self.sources}
        readings = {each.name: each for source in found for each in source.readings}
        if file.targets:
            readings.update({each.name: each for each in LOCATOR})
        self.readings: Sequence[Reading] = tuple(readings.values())
        seen = () if file.camera is None else (*file.camera.colors, *targets)
        self.targets: Sequence[str] = tuple(dict.fromkeys((*seen, *file.targets)))
        for topic, type in dict.fromkeys((source.topic, source.type) for source in found if source.topic):
            transport.subscribe(file.topic(topic), type, self._listener(topic, type))

    def values(self, now: float) -> dict[ReadingKey, float]:
        """A value for each key; NaN where absent."""
        found: dict[ReadingKey, float] = {}
        for name, source in self.sources.items():
            fresh = self.fresh(name, now)
            found.update({key: fresh.get(key, nan) for key in source.keys})
        found.update(located(self._places, found))
        return {
            (each.name, target): found.get((each.name, target), nan)
            for each in self.readings
            for target in (self.targets if each.of_targets else (None,))
        }

    def fresh(self, name: str, now: float) -> Mapping[ReadingKey, float]:
        """The values of one source; none where they are older than its limit."""
        latest = self.latest[name]
        return latest.values if now - latest.at_s <= self.sources[name].stale_s else {}

    def value(self, reading: str, now: float) -> float:
        """The value of a reading of the robot itself; NaN where absent."""
        for name, source in self.sources.items():
            if (reading, None) in source.keys:
                return self.fresh(name, now).get((reading, None), nan)
        return nan

    def place(self, target: str, now: float) -> tuple[float, float] | None:
        """Where a target of the file is, as it or a topic says; None where that is unknown."""
        of = self._places[target]
        if of.at is not None:
            return of.at
        fresh = self.fresh(f"targets.{target}", now)
        x, y = (fresh.get((axis, target), nan) for axis in PLACE)
        return None if isnan(x) or isnan(y) else (x, y)

    def missing(self, now: float) -> str | None:
        """The name of a required source that is absent now. A camera that sees none of its colors is not."""
        for name, source in self.sources.items():
            if source.required:
                fresh = self.fresh(name, now)
                if not fresh or (source.always and any(isnan(value) for value in fresh.values())):
                    return name
        return None

    def _listener(self, topic: str, type: str) -> Callable[[bytes, float], None]:
        """What takes the readings of a topic out of its messages; never fails, whatever the message."""
        here = [
            (source, self.latest[name])
            for name, source in self.sources.items()
            if (source.topic, source.type) == (topic, type)
        ]

        def received(data: bytes, at_s: float) -> None:
            try:
                message: Any = decode(type, data)
            except MessageRefused as error:
                for _, latest in here:
                    latest.refused += 1
                    latest.problem = error.problem
                return
            for source, latest in here:
                try:
                    latest.values = source.extract(message)
                except Exception as error:  # what somebody made up must not end the thread that listens
                    latest.values, latest.problem = {}, str(error)
                    latest.refused += 1
                    continue
                latest.at_s = at_s
                if not latest.count:
                    latest.first_s = at_s
                latest.count += 1

        return received


def _right(found: Right | Mismatch, path: Path | str) -> Right:
    """What a file asks for, where it can be."""
    if isinstance(found, Mismatch):
        raise FileError(path=path, place=found.key, problem=found.problem, remedy=found.remedy)
    return found
