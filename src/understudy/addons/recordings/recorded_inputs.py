"""What the inputs of a robot make of recorded messages: each value with the time at which its message was recorded.

The messages pass through the same inputs as those of a robot that is connected, so that the same message gives the same
reading, recorded or live.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import inf, nan
from typing import Any, NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.mapping_file import (
    UNITS,
    InvalidMapping,
    ReadingColumn,
    RecordingMap,
    complete_topic,
)
from understudy.addons.recordings.message_fields import (
    Extract,
    make_walk,
    multiply_values,
    parse_command,
    parse_stamp,
)
from understudy.addons.recordings.recorded_topics import MessageFile, RecordedMessage, RecordedTopic
from understudy.addons.recordings.row_times import SHORTEST_GAP_S
from understudy.addons.robots.camera.config import CameraSpec
from understudy.addons.robots.inputs import FRAMES, SensorInputs, TopicInput
from understudy.addons.robots.robot_file import FrameSpec, ReadingSpec, TargetPlaceSpec
from understudy.addons.robots.ros.message_readings import find_message_field, make_extractor
from understudy.errors import FileError, join_names, suggest_known_name
from understudy.model.features import ReadingKey, format_reading_label
from understudy.model.value_kinds import Column, Continuous, Kind
from understudy.records.messages import BASE
from understudy.runtime.body import Reading
from understudy.sim.scenario.toml_decode import DecodeProblem

COMMAND, TIME = "command.", "time_s"
"""The beginning of the names of inputs of commands, and the name of that of times."""


@dataclass(frozen=True, slots=True)
class _Sources:
    """What a mapping says of messages as a robot file does."""

    targets: Mapping[str, TargetPlaceSpec]
    frames: FrameSpec | None
    camera: CameraSpec | None
    readings: Mapping[str, ReadingSpec] = field(default_factory=dict)

    def topic(self, name: str) -> str:
        return complete_topic(name)


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

    FileError is raised if there is no such column. A topic that cannot be decoded is left out, unless it has commands,
    and so is one that was not recorded, where the mapping names topics as a robot file does; `omissions` says so.
    `columns` are the readings of fields, in their units, by the names of their inputs.
    """

    def __init__(
        self, file: MessageFile, mapping: RecordingMap, omissions: list[str], *, stale_s: float
    ) -> None:
        self._file, self._omissions, self._stale_s = file, omissions, stale_s
        self.columns: dict[str, ReadingColumn] = {}
        self.held: set[str] = set()
        """The names of the inputs of which the mapping does not say when they are too old."""
        self.texts: dict[str, dict[str, float]] = {}
        """The texts of readings of texts, each with the number that stands for it, by the names of their inputs."""
        self._last_s: dict[str, float] = {}
        self._top_s, self._shift_s = -inf, 0.0
        self.undecoded: dict[str, tuple[int, str]] = {}
        """How many messages of a topic cannot be decoded, and why the first of them cannot."""
        inputs = [each for column in mapping.readings if (each := self._make_reading(column)) is not None]
        inputs += [
            self._make_number(each.column, "the commands", f"{COMMAND}{each.name}", parse_command)
            for each in mapping.commands
        ]
        if isinstance(mapping.time, tuple):
            problem, remedy = (
                f"it is {join_names(mapping.time)}",
                "name the stamp itself, as /odom.header.stamp",
            )
            self.refuse("time", problem, remedy)
        if mapping.time is not None and mapping.time != TIME:
            unit_s = UNITS[mapping.time_unit][1]
            inputs.append(
                self._make_number(mapping.time, "the time", TIME, lambda value: parse_stamp(value, unit_s))
            )
        sources = _Sources(mapping.targets, mapping.frames, mapping.camera)
        self._note_missing(sources)
        if sources.camera is not None and sources.topic(sources.camera.topic) not in file.topics:
            sources = replace(sources, camera=None)  # which would need OpenCV
        self._received: dict[str, list[Callable[[Any, float], None]]] = {}
        try:
            self.inputs = SensorInputs(
                sources, self, path=file.path, more=inputs, decode=lambda type, message: message
            )
        except FileError as error:  # about the targets, frames or camera that the mapping names
            raise InvalidMapping(
                path=file.path, place=error.place, problem=error.problem, remedy=error.remedy
            ) from None
        self._listeners: dict[str, list[str]] = {}
        for name, source in self.inputs.sources.items():
            for topic in [source.topic] if name != FRAMES or sources.frames is None else [
                sources.frames.topic, sources.frames.static
            ]:  # fmt: skip
                self._listeners.setdefault(sources.topic(topic), []).append(name)

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
            at_s = self._find_time(message)
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
        samples = {name: log.sort(len(self.inputs.sources[name].keys)) for name, log in logs.items()}
        for name, latest in self.inputs.latest.items():
            if latest.refused and not latest.count and name in self.columns:
                self.refuse(f"reading {name!r}", f"no message has it ({latest.problem})", "map another field")
        return {name: self._spread(name, each) for name, each in samples.items()}

    def _spread(self, name: str, samples: InputSamples) -> InputSamples:
        """Spread messages evenly until the next stamp if most of them have that of another one."""
        begins = np.flatnonzero(np.diff(samples.times, prepend=-inf))
        if name == FRAMES or not 1 < len(begins) <= len(samples.times) / 2:
            return samples
        counts = np.diff([*begins.tolist(), len(samples.times)])
        ahead = np.diff(samples.times[begins])
        ahead = np.append(ahead, np.median(ahead))
        later = np.concatenate([np.arange(count) / count for count in counts]) * np.repeat(ahead, counts)
        self._omissions.append(
            f"{self._file.path}: {name!r} has {counts.max()} messages of one time, and so on; spread evenly until the "
            "next"
        )
        return InputSamples(samples.times + later, samples.heard + later, samples.values)

    def _find_time(self, message: RecordedMessage) -> float:
        """Return the time of a message, s since the first one; where the clock was set back, time goes on after a gap.

        A topic whose messages go back in time says that; those of different topics may be in any order in a file.
        """
        if self._file.first_ns is None:
            self._file.first_ns = message.time_ns
        at_s = (message.time_ns - self._file.first_ns) * 1e-9 + self._shift_s
        last_s = self._last_s.get(message.topic, -inf)
        if at_s < last_s - SHORTEST_GAP_S:
            ahead_s = self._top_s + 10 * self._stale_s - at_s
            self._shift_s += ahead_s
            self._omissions.append(
                f"{self._file.path} at topic {message.topic!r}: time goes back by {last_s - at_s:.6g} s, "
                f"{last_s:.6g} s after the beginning; another episode begins"
            )
            at_s += ahead_s
        self._last_s[message.topic] = at_s
        self._top_s = max(self._top_s, at_s)
        return at_s

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

    def _note_missing(self, sources: _Sources) -> None:
        """Say which topics of targets, frames and the camera were not recorded or cannot be decoded."""
        topics = {f"target {name!r}": each.topic for name, each in sources.targets.items() if each.topic}
        if sources.frames is not None:
            names = [sources.topic(each) for each in (sources.frames.topic, sources.frames.static)]
            topics["the frames"] = next((each for each in names if each in self._file.topics), names[0])
        if sources.camera is not None:
            topics["the camera"] = sources.camera.topic
        for of, name in topics.items():
            self._find_topic(sources.topic(name), of, needed=False)

    def _find_topic(self, name: str, of: str, *, needed: bool = True) -> RecordedTopic | None:
        """Find a topic; None if it can be left out, and was not recorded or cannot be decoded."""
        topics = self._file.topics
        if name not in topics:
            problem = f"there is no message of it for {of}"
            meant = suggest_known_name(name, sorted(topics))
            if needed:
                self.refuse(f"topic {name!r}", problem, f"{meant}the topics are {join_names(sorted(topics))}")
            self._omissions.append(f"{self._file.path} at topic {name!r}: {problem}; {meant}left out")
            return None
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
        topic = self._find_topic(name, f"reading {column.quantity!r}", needed=column.topic is None)
        if topic is None:
            return None
        place = f"column {column.column!r}" if column.column else f"reading {column.name!r}"
        kind, unit, extract = self._make_extract(topic, column, path, place)
        if column.column and unit and column.unit not in ("", unit):
            self.refuse(place, f"it is read in {unit}, and unit is {column.unit!r}", "leave unit out")
        if column.column and not unit:
            unit, factor = UNITS[column.unit]
            extract = multiply_values(extract, factor)
        key = (column.quantity, column.target)
        label = format_reading_label(key)
        self.columns[label] = ReadingColumn(
            column=label, name=key[0], target=key[1], unit=unit or column.unit,
            kind=column.kind or (None if kind is None else str(kind)), doc=column.doc,
        )  # fmt: skip
        if label == TIME or label.startswith(COMMAND):
            self.refuse(place, f"it is called {label!r}, as times and commands are", "give another name")
        if column.stale_s is None:
            self.held.add(label)
        return _make_input(label, topic, key, column.stale_s or self._stale_s, extract)

    def _make_extract(
        self, topic: RecordedTopic, column: ReadingColumn, path: str | None, place: str
    ) -> tuple[Kind | None, str, Extract]:
        """Make the kind, unit and extracting function of a reading; no kind for texts, and for what brings no types."""
        of_scan = column.sector_deg is not None or path is None
        if topic.list_fields is None and not of_scan:
            return None, "", make_walk(path or "")
        if topic.list_fields is not None and path is not None:
            leaf = find_message_field(topic.type, path, topic.list_fields)
            if not isinstance(leaf, DecodeProblem) and leaf[0] == BASE and leaf[1][0] == "string":
                return None, "", make_walk(path)
        spec = ReadingSpec(
            topic=topic.name, type=topic.type, field=path, sector_deg=column.sector_deg, offset_m=column.offset_m,
            clear_m=column.clear_m, unit="" if column.column else column.unit,
        )  # fmt: skip
        extractor = make_extractor(spec, topic.list_fields or (lambda _: {}))
        if isinstance(extractor, DecodeProblem):
            self.refuse(place, f"{extractor.key} {extractor.problem}", extractor.remedy)
        return extractor

    def _make_number(self, column: str, of: str, name: str, parse: Callable[[Any], float]) -> TopicInput:
        """Make the input of a number that is no reading; FileError is raised if its topic cannot be decoded.

        `parse` makes a number of what a message has.
        """
        topic_name, path = self._split(column)
        topic, place = self._find_topic(topic_name, of), f"column {column!r}"
        if topic is None:
            raise AssertionError  # it was refused
        extract = make_walk(path)
        if topic.list_fields is not None:
            spec = ReadingSpec(topic=topic_name, type=topic.type, field=path)
            extractor = make_extractor(spec, topic.list_fields)
            if isinstance(extractor, DecodeProblem):
                self.refuse(place, f"{extractor.key} {extractor.problem}", extractor.remedy)
            if extractor[1] == "s":  # a stamp of ROS
                return _make_input(name, topic, (name, None), inf, extractor[2])
            extract = extractor[2]
        return _make_input(name, topic, (name, None), inf, lambda message: parse(extract(message)))


def _make_input(
    label: str, topic: RecordedTopic, key: ReadingKey, stale_s: float, extract: Extract
) -> TopicInput:
    readings = (Reading(key[0], Continuous(), of_targets=key[1] is not None),)
    return TopicInput(
        label, topic.name, topic.type, stale_s, None, False, False, (key,), readings,
        lambda message: {key: extract(message)},
    )  # fmt: skip
