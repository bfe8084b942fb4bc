"""What the inputs of a robot make of recorded messages: each value with the time at which its message was recorded.

The messages pass through the same inputs as those of a robot that is connected, so that the same message gives the same
reading, recorded or live.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf, nan
from typing import Any, NamedTuple, NoReturn, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.mapping_file import UNITS, ReadingColumn, RecordingMap
from understudy.addons.recordings.message_files import MessageFile, RecordedTopic
from understudy.addons.robots.camera.config import CAMERA, CameraSpec
from understudy.addons.robots.inputs import FRAMES, SensorInputs, TopicInput
from understudy.addons.robots.robot_file import FrameSpec, ReadingSpec, TargetPlaceSpec
from understudy.addons.robots.ros.message_readings import find_field, make_extractor
from understudy.errors import FileError, join_names, suggest_known_name
from understudy.model.features import ReadingKey, format_reading_label
from understudy.model.value_kinds import Column, Continuous, Kind
from understudy.records.messages import BASE
from understudy.runtime.body import Reading
from understudy.sim.scenario.toml_decode import DecodeProblem

COMMAND, TIME = "command.", "time_s"
"""The beginning of the names of inputs of commands, and the name of that of times."""
Extract: TypeAlias = Callable[[Any], Any]


@dataclass(frozen=True, slots=True)
class _Sources:
    """What a mapping says of messages as a robot file does."""

    targets: Mapping[str, TargetPlaceSpec]
    frames: FrameSpec | None
    camera: CameraSpec | None
    readings: Mapping[str, ReadingSpec] = field(default_factory=dict)

    def topic(self, name: str) -> str:
        return name if name.startswith("/") else f"/{name}"


class InputSamples(NamedTuple):
    """What an input had, in order of time: when [n], as old as which message [n], both in s, and its values [n, K]."""

    times: Column
    heard: Column
    values: NDArray[np.float64]


@dataclass(slots=True)
class _Log:
    """The values of an input as they come."""

    times: array[float] = field(default_factory=lambda: array("d"))
    heard: array[float] = field(default_factory=lambda: array("d"))
    values: array[float] = field(default_factory=lambda: array("d"))

    def sort(self, width: int) -> InputSamples:
        times, heard = (np.array(each, np.float64) for each in (self.times, self.heard))
        order = np.argsort(times, kind="stable")
        values = np.array(self.values, np.float64).reshape(len(times), width)
        return InputSamples(times[order], heard[order], values[order])


class RecordedInputs:
    """The inputs that a mapping asks for, on the topics of a recording.

    FileError is raised if there is no such topic or field. A topic that cannot be decoded is left out, unless it has
    commands; `omissions` says so. `columns` are the readings of fields, in their units, by the names of their inputs.
    """

    def __init__(
        self, file: MessageFile, mapping: RecordingMap, omissions: list[str], *, stale_s: float
    ) -> None:
        self._file, self._omissions, self._stale_s = file, omissions, stale_s
        self.columns: dict[str, ReadingColumn] = {}
        self.texts: dict[str, dict[str, float]] = {}
        """The texts of readings of texts, each with the number that stands for it, by the names of their inputs."""
        self.undecoded: dict[str, tuple[int, str]] = {}
        """How many messages of a topic cannot be decoded, and why the first of them cannot."""
        inputs = [each for column in mapping.readings if (each := self._make_reading(column)) is not None]
        inputs += [
            self._make_number(each.column, "the commands", f"{COMMAND}{each.name}")
            for each in mapping.commands
        ]
        if isinstance(mapping.time, str) and mapping.time != TIME:
            inputs.append(self._make_number(mapping.time, "the time", TIME))
        sources = _Sources(mapping.targets, mapping.frames, mapping.camera)
        self._received: dict[str, list[Callable[[Any, float], None]]] = {}
        self.inputs = SensorInputs(
            sources, self, path=file.path, more=inputs, decode=lambda type, message: message
        )
        self._listeners: dict[str, list[str]] = {}
        for name, source in self.inputs.sources.items():
            for topic in [source.topic] if name != FRAMES or mapping.frames is None else [
                mapping.frames.topic, mapping.frames.static
            ]:  # fmt: skip
                self._listeners.setdefault(sources.topic(topic), []).append(name)
            if name == CAMERA or name.startswith("targets."):
                self._find_topic(sources.topic(source.topic), f"{name!r}")
        if mapping.frames is not None and not any(name in file.topics for name in self._listeners):
            self._find_topic(sources.topic(mapping.frames.topic), "the frames")

    def subscribe(
        self, topic: str, type: str, received: Callable[[Any, float], None], *, kept: bool = False
    ) -> None:
        """Pass the recorded messages of a topic on, as a transport does."""
        self._received.setdefault(topic, []).append(received)

    def play(self) -> dict[str, InputSamples]:
        """Pass all messages to the inputs, and return what each input had after each of its messages."""
        topics = {
            name: topic
            for name in self._listeners
            if (topic := self._file.topics.get(name)) is not None and not topic.problem
        }
        logs = {name: _Log() for name in self.inputs.sources}
        for message in self._file.read_messages(topics, self._omissions):
            if self._file.first_ns is None:
                self._file.first_ns = message.time_ns
            at_s = (message.time_ns - self._file.first_ns) * 1e-9
            try:
                decoded = topics[message.topic].decode(message.data)
            except (
                Exception
            ) as error:  # a decoder can raise any error on bytes that do not fit their definition
                count, first = self.undecoded.get(message.topic, (0, f"{type(error).__name__}: {error}"))
                self.undecoded[message.topic] = count + 1, first
                continue
            for received in self._received.get(message.topic, ()):
                received(decoded, at_s)
            for name in self._listeners[message.topic]:
                self._log(name, logs[name], at_s)
        return {name: log.sort(len(self.inputs.sources[name].keys)) for name, log in logs.items()}

    def _log(self, name: str, log: _Log, at_s: float) -> None:
        latest = self.inputs.latest[name]
        if not latest.count or (name == FRAMES and latest.count == len(log.times)):
            return
        log.times.append(at_s)
        log.heard.append(latest.at_s)
        for key in self.inputs.sources[name].keys:
            value: Any = latest.values.get(key, nan)
            if isinstance(value, str):
                numbers = self.texts.setdefault(name, {})
                value = numbers.setdefault(value, float(len(numbers)))
            log.values.append(value)

    def describe_problem(self, topic: str) -> str:
        """Describe why nothing of a topic could be read; empty if there was no message."""
        if topic in self.undecoded:
            return self.undecoded[topic][1]
        listeners = (self.inputs.latest[name] for name in self._listeners.get(topic, ()))
        return next((each.problem for each in listeners if each.problem), "")

    def note_problems(self) -> None:
        """Say which messages could not be read."""
        for name, (count, problem) in self.undecoded.items():
            self._omissions.append(
                f"{self._file.path} at topic {name!r}: {count} messages cannot be decoded ({problem}); left out"
            )
        for name, latest in self.inputs.latest.items():
            if latest.refused:
                problem = f"{latest.refused} messages do not have {name!r} ({latest.problem})"
                self._omissions.append(f"{self._file.path}: {problem}; it is absent there")

    def refuse(self, place: str, problem: str, remedy: str) -> NoReturn:
        """Raise the error that something of the recording cannot be used."""
        raise FileError(path=self._file.path, place=place, problem=problem, remedy=remedy)

    def _find_topic(self, name: str, of: str) -> RecordedTopic | None:
        """Find a topic; None if it cannot be decoded and can be left out."""
        topics = self._file.topics
        if name not in topics:
            remedy = f"{suggest_known_name(name, sorted(topics))}the topics are {join_names(sorted(topics))}"
            self.refuse(f"topic {name!r}", f"there is no message of it for {of}", remedy)
        topic = topics[name]
        if not topic.problem:
            return topic
        if of in ("the commands", "the time"):
            remedy = "record it as JSON, or as CDR with the definitions of its types, as ROS 2 does with MCAP"
            self.refuse(f"topic {name!r}", topic.problem, remedy)
        sentence = f"{self._file.path} at topic {name!r}: {topic.problem}; left out"
        if sentence not in self._omissions:
            self._omissions.append(sentence)
        return None

    def _split(self, column: str) -> tuple[str, str]:
        """Split the name of a column, such as /odom.twist.linear.x, into the topic and the path of the field."""
        topic, _, path = column.partition(".")
        if not (topic and path):
            remedy = "write its topic and its field in the mapping file: /cmd_vel.linear.x"
            self.refuse(f"column {column!r}", "it is no field of a message", remedy)
        return topic, path

    def _make_reading(self, column: ReadingColumn) -> TopicInput | None:
        """Make the input of a reading; None if its topic cannot be decoded."""
        name, path = (column.topic, column.field) if column.topic else self._split(column.column)
        topic = self._find_topic(name, f"reading {column.quantity!r}")
        if topic is None:
            return None
        place = f"column {column.column!r}" if column.column else f"reading {column.name!r}"
        kind, unit, extract = self._make_extract(topic, column, path, place)
        if column.column and unit and column.unit not in ("", unit):
            self.refuse(place, f"it is read in {unit}, and unit is {column.unit!r}", "leave unit out")
        if column.column and not unit:
            unit, factor = UNITS[column.unit]
            extract = _multiply(extract, factor)
        key = (column.quantity, column.target)
        label = format_reading_label(key)
        self.columns[label] = ReadingColumn(
            column=label, name=key[0], target=key[1], unit=unit or column.unit,
            kind=column.kind or (None if kind is None else str(kind)), doc=column.doc,
        )  # fmt: skip
        return _make_input(
            label, topic, key, self._stale_s if column.stale_s is None else column.stale_s, extract
        )

    def _make_extract(
        self, topic: RecordedTopic, column: ReadingColumn, path: str | None, place: str
    ) -> tuple[Kind | None, str, Extract]:
        """Make the kind, unit and extracting function of a reading; no kind for texts, and for what brings no types."""
        of_scan = column.sector_deg is not None or path is None
        if topic.list_fields is None and not of_scan:
            return None, "", self._make_walk(path or "", place)
        if topic.list_fields is not None and path is not None:
            leaf = find_field(topic.type, path, topic.list_fields)
            if not isinstance(leaf, DecodeProblem) and leaf[0] == BASE and leaf[1][0] == "string":
                return None, "", self._make_walk(path, place)
        spec = ReadingSpec(
            topic=topic.name, type=topic.type, field=path, sector_deg=column.sector_deg, offset_m=column.offset_m,
            clear_m=column.clear_m, unit="" if column.column else column.unit,
        )  # fmt: skip
        made = make_extractor(spec, topic.list_fields or (lambda _: {}))
        if isinstance(made, DecodeProblem):
            self.refuse(place, f"{made.key} {made.problem}", made.remedy)
        return made

    def _make_number(self, column: str, of: str, name: str) -> TopicInput:
        """Make the input of a number that is no reading; FileError is raised if its topic cannot be decoded."""
        topic_name, path = self._split(column)
        topic, place = self._find_topic(topic_name, of), f"column {column!r}"
        if topic is None:
            raise AssertionError  # it was refused
        extract = self._make_walk(path, place)
        if topic.list_fields is not None:
            spec = ReadingSpec(topic=topic_name, type=topic.type, field=path)
            made = make_extractor(spec, topic.list_fields)
            if isinstance(made, DecodeProblem):
                self.refuse(place, f"{made.key} {made.problem}", made.remedy)
            extract = made[2]
        return _make_input(name, topic, (name, None), inf, extract)

    def _make_walk(self, path: str, place: str) -> Extract:
        """Make the function that takes a value out of a message by the names of its fields, as JSON has them."""

        def extract(message: Any) -> Any:
            value = message
            for name in path.split("."):
                if isinstance(value, list) and name.isdecimal():
                    value = value[int(name)] if int(name) < len(value) else None
                elif hasattr(value, name):
                    value = getattr(value, name)
                elif hasattr(value, "__dict__"):
                    value = None
                elif value is not None:
                    self.refuse(place, f"there is no {name!r} in it", "end the path before it")
            if hasattr(value, "sec") and hasattr(value, "nanosec"):
                return value.sec + value.nanosec * 1e-9
            if isinstance(value, list) or hasattr(value, "__dict__"):
                fields = vars(value) if hasattr(value, "__dict__") else map(str, range(len(value)))
                self.refuse(place, "it is no number", f"name one of {join_names(list(fields))} in it")
            if isinstance(value, str):
                return value.strip() or nan
            return nan if value is None else value

        return extract


def _multiply(extract: Extract, factor: float) -> Extract:
    """Return a function whose values are in another unit; texts stay as they are."""
    if factor == 1.0:
        return extract

    def extract_in_unit(message: Any) -> Any:
        value = extract(message)
        return value if isinstance(value, str) else value * factor

    return extract_in_unit


def _make_input(
    label: str, topic: RecordedTopic, key: ReadingKey, stale_s: float, extract: Extract
) -> TopicInput:
    readings = (Reading(key[0], Continuous(), of_targets=key[1] is not None),)
    return TopicInput(
        label, topic.name, topic.type, stale_s, None, False, False, (key,), readings,
        lambda message: {key: extract(message)},
    )  # fmt: skip
