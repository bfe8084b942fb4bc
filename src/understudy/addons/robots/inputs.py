"""Conversion of a real robot's latest messages to readings, which are absent if the messages are too old."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import atan2, hypot, inf, isfinite, isnan, nan, tau
from pathlib import Path
from typing import Any, Protocol, TypeAlias, TypeVar

from understudy.addons.robots.camera.config import CAMERA, CameraSpec
from understudy.addons.robots.camera.live_camera import LiveCamera
from understudy.addons.robots.robot_file import POSE, FrameSpec, ReadingSpec, TargetPlaceSpec
from understudy.addons.robots.ros.frame_tree import TRANSFORMS, FrameTree
from understudy.addons.robots.ros.message_readings import (
    MAY_LACK,
    Extract,
    make_extractor,
    make_position_extractor,
)
from understudy.errors import FileError, UnderstudyError
from understudy.extras import ExtraMissing
from understudy.model.features import ReadingKey
from understudy.model.value_kinds import Continuous, Toroidal
from understudy.records.messages import MessageRefused, decode_message
from understudy.runtime.body import Reading
from understudy.sim.scenario.toml_decode import DecodeProblem
from understudy.sim.sensing.sensor_table import BLOBS, LOCATIONS

Values: TypeAlias = Callable[[Any], Mapping[ReadingKey, float]]
FRAMES = "frames"
"""The name of the input of the robot's pose."""
PLACE = ("x", "y")
"""The names of the coordinates that a topic gives for a target, from which the target's readings are computed."""


@dataclass(frozen=True, slots=True)
class TopicInput:
    """A topic and the readings that are taken from its messages.

    If `always` is True, every valid message has a value for each reading.
    """

    name: str
    topic: str
    type: str
    stale_s: float
    rate_hz: float | None
    required: bool
    always: bool
    keys: Sequence[ReadingKey]
    readings: Sequence[Reading]
    extract: Values


class InputFile(Protocol):
    """What of a robot file says which messages become readings."""

    @property
    def readings(self) -> Mapping[str, ReadingSpec]:
        """The readings of fields of messages, by name."""
        ...

    @property
    def targets(self) -> Mapping[str, TargetPlaceSpec]:
        """The places of targets, by name."""
        ...

    @property
    def frames(self) -> FrameSpec | None:
        """The frames between which the robot's pose is read."""
        ...

    @property
    def camera(self) -> CameraSpec | None:
        """The camera and the colors of targets."""
        ...

    def topic(self, name: str) -> str:
        """Return the full name of a topic."""
        ...


class Subscriber(Protocol):
    """What of a transport brings messages."""

    def subscribe(
        self, topic: str, type: str, received: Callable[[Any, float], None], *, kept: bool = False
    ) -> None:
        """Pass each message of a topic on, with its time."""
        ...


def make_topic_inputs(
    file: InputFile, camera: LiveCamera | None, targets: Sequence[str]
) -> Sequence[TopicInput] | DecodeProblem:
    """Make the inputs of a robot file, in its order, or return what in the file is invalid.

    `targets` are names of targets that may get a color later, for which the camera input provides readings too.
    """
    inputs: list[TopicInput] = []
    for result in (*_numbers(file), *_places(file)):
        if isinstance(result, DecodeProblem):
            return result
        inputs.append(result)
    if file.frames is not None:
        inputs.append(_pose(file.frames))
    if camera is not None and file.camera is not None:
        inputs.append(_images(file.camera, camera, targets))
    return tuple(inputs)


def make_live_camera(file: InputFile) -> LiveCamera | DecodeProblem | None:
    """Make the camera of a robot file; return None if it has none, or what in the file is invalid."""
    if file.camera is None:
        return None
    try:
        return LiveCamera(file.camera)
    except ExtraMissing:  # it is not the file that is wrong
        raise
    except UnderstudyError as error:
        return DecodeProblem(CAMERA, f"cannot be: {error}", "correct it there")


def _numbers(file: InputFile) -> Iterator[TopicInput | DecodeProblem]:
    for name, reading in file.readings.items():
        taken = make_extractor(reading)
        if isinstance(taken, DecodeProblem):
            yield DecodeProblem(f"readings.{name}.{taken.key}", taken.problem, taken.remedy)
            return
        kind, unit, extract = taken
        yield TopicInput(
            name, reading.topic, reading.type, reading.stale_s, reading.rate_hz, reading.required,
            (reading.type, reading.field) not in MAY_LACK,
            ((name, None),), (Reading(name, kind, unit, doc=reading.doc),), _of_number(name, extract),
        )  # fmt: skip


def _of_number(name: str, extract: Extract) -> Values:
    return lambda message: {(name, None): extract(message)}


def _images(of: CameraSpec, camera: LiveCamera, targets: Sequence[str]) -> TopicInput:
    """Make the input of a camera, with readings of its colors and of targets that may get a color later."""
    keys = tuple((blob.name, name) for name in dict.fromkeys((*of.colors, *targets)) for blob in BLOBS)
    return TopicInput(
        CAMERA, of.topic, of.type, of.stale_s, of.rate_hz, of.required, False, keys, BLOBS, camera.read_message
    )  # fmt: skip


def _pose(of: FrameSpec) -> TopicInput:
    """Make the input of the robot's pose in a frame, whose values `SensorInputs` takes from all transforms."""
    about = f"of {of.robot} in {of.fixed}"
    readings = (
        Reading("x", Continuous(), "m", doc=f"Place {about}."),
        Reading("y", Continuous(), "m", doc=f"Place {about}."),
        Reading("heading", Toroidal(), "rad", doc=f"Direction {about}."),
    )
    return TopicInput(
        FRAMES, of.topic, TRANSFORMS, of.stale_s, of.rate_hz, of.required, True,
        tuple((name, None) for name in POSE), readings, lambda message: {},
    )  # fmt: skip


def _places(file: InputFile) -> Iterator[TopicInput | DecodeProblem]:
    """Yield the inputs of targets whose places come from topics."""
    for name, target in file.targets.items():
        if target.topic is None:
            continue
        taken = make_position_extractor(target)
        if isinstance(taken, DecodeProblem):
            yield DecodeProblem(f"targets.{name}.{taken.key}", taken.problem, taken.remedy)
            return
        keys: Sequence[ReadingKey] = tuple((axis, name) for axis in PLACE)
        yield TopicInput(
            f"targets.{name}", target.topic, target.type, target.stale_s, target.rate_hz, target.required, True,
            keys, (), _of_place(keys, taken),
        )  # fmt: skip


def _of_place(keys: Sequence[ReadingKey], taken: Callable[[Any], tuple[float, float]]) -> Values:
    return lambda message: dict(zip(keys, taken(message), strict=True))


def compute_ranges_and_bearings(
    targets: Mapping[str, TargetPlaceSpec], values: Mapping[ReadingKey, float]
) -> dict[ReadingKey, float]:
    """Compute `range` (m) and `bearing` (rad, in [0, tau)) of each target; NaN if unknown.

    `values` has the robot's pose and the places of those targets that come from topics.
    """
    readings: dict[ReadingKey, float] = {}
    pose = tuple(values.get((name, None), nan) for name in POSE)
    for name, target in targets.items():
        x, y = target.at or (values.get((axis, name), nan) for axis in PLACE)
        readings["range", name], readings["bearing", name] = _polar(
            x, y, (0.0, 0.0, 0.0) if target.relative else pose
        )
    return readings


def _polar(x: float, y: float, pose: tuple[float, ...]) -> tuple[float, float]:
    ahead, left, heading = x - pose[0], y - pose[1], pose[2]
    distance = hypot(ahead, left)
    if not isfinite(distance) or isnan(heading):  # what is far beyond all places is none, either
        return nan, nan
    return distance, (atan2(left, ahead) - heading) % tau % tau


Right = TypeVar("Right")


@dataclass(slots=True)
class LatestSample:
    """The latest values from a source, and statistics of its messages.

    `at_s` and `first_s` are the times of the last and first message, in s of `time.monotonic`. `count` is the number
    of valid messages, `refused` that of invalid ones, and `problem` the reason of the last refusal.
    """

    values: Mapping[ReadingKey, float] = field(default_factory=dict)
    at_s: float = -inf
    first_s: float = nan
    count: int = 0
    refused: int = 0
    problem: str = ""

    @property
    def rate_hz(self) -> float:
        """The average number of messages per second; NaN if fewer than two have arrived."""
        return (self.count - 1) / (self.at_s - self.first_s) if self.at_s > self.first_s else nan


class SensorInputs:
    """All inputs of a robot file, subscribed to their topics.

    The transport's threads write the latest values; any thread may read them. FileError is raised if the file asks
    for something that its messages do not contain. `targets` names targets that may get a color later. `more` are
    inputs besides those of the file, and `decode` decodes a message of a type, or raises MessageRefused.
    """

    def __init__(
        self,
        file: InputFile,
        transport: Subscriber,
        *,
        path: Path | str = "robot.toml",
        targets: Sequence[str] = (),
        more: Sequence[TopicInput] = (),
        decode: Callable[[str, Any], Any] = decode_message,
    ) -> None:
        self._decode = decode
        self.camera = _right(make_live_camera(file), path)
        inputs = (*more, *_right(make_topic_inputs(file, self.camera, targets), path))
        self._places = file.targets
        self.sources: Mapping[str, TopicInput] = {source.name: source for source in inputs}
        self.latest: Mapping[str, LatestSample] = {name: LatestSample() for name in self.sources}
        readings = {each.name: each for source in inputs for each in source.readings}
        if file.targets:
            readings.update({each.name: each for each in LOCATIONS})
        self.readings: Sequence[Reading] = tuple(readings.values())
        colors = () if file.camera is None else (*file.camera.colors, *targets)
        about = [target for source in more for _, target in source.keys if target is not None]
        self.targets: Sequence[str] = tuple(dict.fromkeys((*about, *colors, *file.targets)))
        self.keys: Sequence[ReadingKey] = [
            (each.name, target)
            for each in self.readings
            for target in (self.targets if each.of_targets else (None,))
        ]
        self._source_of: dict[ReadingKey, str] = {}
        for source in inputs:
            for key in source.keys:
                self._source_of.setdefault(key, source.name)
        for topic, type in dict.fromkeys(
            (source.topic, source.type) for source in inputs if source.name != FRAMES
        ):
            transport.subscribe(file.topic(topic), type, self._listener(topic, type))
        self._frames = FrameTree()
        if file.frames is not None:
            of = file.frames
            self._frames_between = of.fixed.lstrip("/"), of.robot.lstrip("/")
            transport.subscribe(file.topic(of.topic), TRANSFORMS, self._hear_frames)
            transport.subscribe(file.topic(of.static), TRANSFORMS, self._hear_static_frames, kept=True)

    def values(self, now: float) -> dict[ReadingKey, float]:
        """Return a value for each reading at time `now` (s, `time.monotonic`); NaN if absent."""
        values: dict[ReadingKey, float] = {}
        for name in self.sources:
            values.update(self.read_fresh(name, now))
        values.update(compute_ranges_and_bearings(self._places, values))
        return {key: values.get(key, nan) for key in self.keys}

    def read_fresh(self, name: str, now: float) -> Mapping[ReadingKey, float]:
        """Return the values of one source; empty if they are older than its limit at time `now` (s)."""
        latest = self.latest[name]
        return latest.values if now - latest.at_s <= self.sources[name].stale_s else {}

    def value(self, reading: str, now: float) -> float:
        """Return the value of a reading of the robot itself at time `now` (s); NaN if absent."""
        source = self._source_of.get((reading, None))
        return nan if source is None else self.read_fresh(source, now).get((reading, None), nan)

    def locate(self, target: str, now: float) -> tuple[float, float] | None:
        """Return the place (x, y) of a target, from the robot file or a topic, or None if it is unknown."""
        of = self._places[target]
        if of.at is not None:
            return of.at
        fresh = self.read_fresh(f"targets.{target}", now)
        x, y = (fresh.get((axis, target), nan) for axis in PLACE)
        return None if isnan(x) or isnan(y) else (x, y)

    def find_missing(self, now: float) -> str | None:
        """Return the name of a required source that is absent at time `now` (s), or None.

        A camera that sees none of its colors is not absent, nor is the bearing of a scan in which nothing is in
        range.
        """
        for name, source in self.sources.items():
            if source.required:
                fresh = self.read_fresh(name, now)
                if not fresh or (source.always and any(isnan(value) for value in fresh.values())):
                    return name
        return None

    def _hear_static_frames(self, data: bytes, at_s: float) -> None:
        self._hear_frames(data, inf)

    def _hear_frames(self, data: bytes, at_s: float) -> None:
        """Take transforms, and the robot's pose if one of them changes it; raise no errors."""
        latest, of = self.latest[FRAMES], self._frames_between
        try:
            changed = self._frames.update(self._decode(TRANSFORMS, data), at_s)
        except MessageRefused as error:
            latest.refused += 1
            latest.problem = error.problem
            return
        if changed.isdisjoint(self._frames.list_links(*of)) or (pose := self._frames.locate(*of)) is None:
            return
        latest.values = dict(zip(self.sources[FRAMES].keys, pose[:3], strict=True))
        latest.at_s = pose.at_s
        if not latest.count:
            latest.first_s = pose.at_s
        latest.count += 1

    def _listener(self, topic: str, type: str) -> Callable[[bytes, float], None]:
        """Make the function that takes the readings of a topic out of its messages; it raises no errors."""
        here = [
            (source, self.latest[name])
            for name, source in self.sources.items()
            if (source.topic, source.type) == (topic, type)
        ]

        def received(data: bytes, at_s: float) -> None:
            try:
                message: Any = self._decode(type, data)
            except MessageRefused as error:
                for _, latest in here:
                    latest.refused += 1
                    latest.problem = error.problem
                return
            for source, latest in here:
                try:
                    latest.values = source.extract(message)
                except Exception as error:  # a forged message must not end the thread that listens
                    latest.values, latest.problem = {}, str(error)
                    latest.refused += 1
                    continue
                latest.at_s = at_s
                if not latest.count:
                    latest.first_s = at_s
                latest.count += 1

        return received


def _right(result: Right | DecodeProblem, path: Path | str) -> Right:
    """Return a valid result, or raise its problem as a FileError."""
    if isinstance(result, DecodeProblem):
        raise FileError(path=path, place=result.key, problem=result.problem, remedy=result.remedy)
    return result
