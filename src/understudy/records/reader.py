"""Reader of recordings, which returns every complete tick even if the run was killed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.errors import FileError, SettingError, UnderstudyError
from understudy.extras import ExtraMissing
from understudy.model.features import ReadingKey, format_reading_label
from understudy.model.value_kinds import Column
from understudy.records.header import (
    AGENT,
    METADATA,
    PART,
    RecordingHeader,
    decode_header,
    name_metadata,
)
from understudy.records.message_types import (
    DUTY,
    READINGS,
    STATES,
    TEXT,
    ReadingsEncoder,
    decode_reading_names,
    decode_states,
    register_message_types,
    resolve_topic_name,
)
from understudy.records.messages import MessageRefused, decode_message
from understudy.records.record import (
    PRESS,
    TEACH,
    TEST,
    TRAIN,
    Episode,
    Floats,
    Record,
    RecordedPress,
)
from understudy.records.recorder import COMMANDS, DUTIES, PRESSES, STEPS, TOPICS
from understudy.runtime.body import Channel

MOST_BYTES = 2**30
"""The largest size of a record, so that a damaged length cannot fill the memory."""
REMEDY = "name a file that `understudy run --record FILE.mcap` wrote"


@dataclass(frozen=True, slots=True)
class RecordedDuty:
    """What an agent of a team begins at a tick, counted from 0.

    Attributes
    ----------
    tick
        The tick before whose decision it begins.
    time_s
        The agent's time, s.
    logged_ns
        When it was recorded, ns since 1970.
    order
        The order (term, number) that tells it; None without one.
    leader
        The agent that gave the order.
    alone
        Whether it begins the program that it runs without an order.
    behavior
        The behavior that the order names; empty if it does nothing.
    binding
        The target of each of its parameters.
    frames
        The run state in which a coordinator goes on, as JSON; empty if it begins at the start.
    """

    tick: int
    time_s: float
    logged_ns: int
    order: tuple[int, int] | None
    leader: str
    alone: bool
    behavior: str
    binding: Mapping[str, str]
    frames: str


@dataclass(frozen=True, slots=True)
class Recording:
    """A run in a recording.

    `records` has the record of each agent, with the same ticks. `whole` is True if the file was closed, not killed.
    `runs` is the number of runs in the file, of which this is one. `logged_ns` [T] are the times at which the ticks
    were recorded, in ns since 1970, and `duties` has what each agent of a team began, by agent.
    """

    path: Path
    head: RecordingHeader
    records: tuple[Record, ...]
    whole: bool
    runs: int = 1
    logged_ns: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    duties: Sequence[Sequence[RecordedDuty]] = ()

    @property
    def times(self) -> Column:
        """The body's times of the ticks, shape [T], s."""
        return self.records[0].times

    @property
    def ticks(self) -> int:
        """The number of ticks, T."""
        return self.records[0].ticks


def has_own_header(path: Path | str) -> bool | None:
    """Return whether an MCAP file has the header of a recording of ours; None if it is no MCAP file."""
    try:
        from mcap.reader import make_reader
        from mcap.records import Metadata
    except ImportError:
        raise ExtraMissing(what="a recording", extra="ros2") from None
    with suppress(Exception), Path(path).open("rb") as file:  # a reader can raise any error on damaged bytes
        summary = make_reader(file).get_summary()
        if summary is not None:
            return any(each.name.startswith(METADATA) for each in summary.metadata_indexes)
    has_header = None
    with suppress(Exception):
        for record in iterate_records(path):  # one that was cut short has no summary
            has_header = isinstance(record, Metadata) and record.name.startswith(METADATA)
            if has_header:
                break
    return has_header


def read_recording(path: Path | str, *, run: int | None = None, part: str = "") -> Recording:
    """Read a run up to its last complete tick; raise FileError if the file is no recording or has no decisions.

    If the file has several runs, such as an afternoon's lessons, `run` is the number of the one to read, from 1; the
    last by default. SettingError is raised if there is no such run. `part` names one of several agents or coordinators
    whose runs the file has (`list_recorded_parts`).
    """
    path = Path(path)
    reader = _FileReader(run, part)
    whole = reader.read(path)
    if reader.runs and run is not None and not 1 <= run <= reader.runs:
        remedy = f"count from 1 to {reader.runs}"
        raise SettingError(where=str(path), setting="its run", problem=f"is {run}", remedy=remedy)
    if isinstance(reader.head, str) and reader.parts:
        remedy = "name the recording of one of them, or ask `understudy why --agent NAME`"
        raise FileError(path=path, place="", problem="is of several agents of a team", remedy=remedy)
    if isinstance(reader.head, str):
        raise _no_recording(path, reader.head)
    return reader.recording(path, reader.head, whole=whole)


class _FileReader:
    """The contents of a file as far as it has been read."""

    def __init__(self, run: int | None, part: str) -> None:
        self._run, self.runs, self._metadata = run, 0, name_metadata(part)
        self._host = part.rpartition("/")[2]
        self.parts = False
        """Whether the file has headers of other parts."""
        self.head: RecordingHeader | str = "it does not say which behavior ran"
        self._channels: dict[int, tuple[str, str]] = {}
        self._wanted: dict[tuple[str, str], tuple[str, int]] = {}
        self._schemas: dict[int, str] = {}
        self._readings: list[_ReadingColumn] = []
        self._paths: list[list[tuple[str, ...]]] = []
        self._presses: list[list[RecordedPress]] = []
        self._duties: list[list[RecordedDuty]] = []
        self._commands: list[_ReadingColumn] = []

    def read(self, path: Path) -> bool:
        """Read a file; return whether it ends properly."""
        begun = False
        try:
            for record in iterate_records(path):
                begun = True
                self._take(record, path)
        except UnderstudyError:
            raise
        except OSError as error:
            problem = (
                "there is no such file"
                if isinstance(error, FileNotFoundError)
                else str(error.strerror or error)
            )
            raise _no_recording(path, problem) from None
        except Exception as error:  # a reader can raise any error on incomplete or damaged bytes
            if not begun:
                raise _no_recording(path, f"it is not an MCAP file ({error.__class__.__name__})") from None
            return False  # all until here is good
        return True

    def _take(self, record: Any, path: Path) -> None:
        from mcap.records import Channel, Message, Metadata, Schema

        if isinstance(record, Message):
            what = self._wanted.get(self._channels.get(record.channel_id, ("", "")))
            if what is not None:
                try:
                    self._keep(*what, record)
                except MessageRefused as error:
                    raise _no_recording(path, str(error)) from None
        elif isinstance(record, Schema):
            self._schemas[record.id] = record.name
        elif isinstance(record, Channel):
            if record.metadata.get(AGENT, self._host) == self._host:
                self._channels[record.id] = record.topic, self._schemas.get(record.schema_id, "")
        elif isinstance(record, Metadata) and record.name == self._metadata:
            self.runs += 1
            if self.runs == (self._run or self.runs):
                self.head = decode_header(record.metadata)
                self._begin(self.head.names if isinstance(self.head, RecordingHeader) else ())
            elif self.runs > (self._run or self.runs):
                self._wanted = {}  # that run is over
        elif isinstance(record, Metadata) and record.name.startswith(METADATA + PART):
            self.parts = True

    def _begin(self, names: Sequence[str]) -> None:
        """Begin another run, and discard those before."""
        register_message_types()
        topics = {READINGS: TOPICS[READINGS], STATES: TOPICS[STATES]}
        self._wanted = {
            (resolve_topic_name(name, topic), type): (topic, agent)
            for agent, name in enumerate(names)
            for type, topic in (
                *topics.items(),
                (READINGS, COMMANDS),
                (TEXT, PRESSES),
                (TEXT, STEPS),
                (DUTY, DUTIES),
            )
        }
        self._commands = [_ReadingColumn() for _ in names]
        self._readings = [_ReadingColumn() for _ in names]
        self._paths = [[] for _ in names]
        self._presses = [[] for _ in names]
        self._duties = [[] for _ in names]

    def _keep(self, topic: str, agent: int, message: Any) -> None:
        data = message.data
        if topic == TOPICS[READINGS]:
            self._readings[agent].add(data, message.log_time)
        elif topic == COMMANDS:
            self._commands[agent].add(data, message.log_time)
        elif topic == DUTIES:
            self._duties[agent].append(_decode_duty(len(self._paths[agent]), data, message.log_time))
        elif topic == TOPICS[STATES]:
            self._paths[agent].append(decode_states(data)[1])
        else:
            text, tick = decode_message(TEXT, data).data, len(self._paths[agent])
            self._presses[agent].append(
                _step(tick, text) if topic == STEPS else RecordedPress(tick, text or None)
            )

    def recording(self, path: Path, head: RecordingHeader, *, whole: bool) -> Recording:
        ticks = min(
            (min(len(one.times), len(two)) for one, two in zip(self._readings, self._paths, strict=True)),
            default=0,
        )
        if not ticks:
            several = f"the run that was begun last, of {self.runs}," if self.runs > 1 else "it"
            raise _no_recording(path, f"{several} holds no tick")
        names = self._readings[0].names
        key_of = {format_reading_label(key): key for key in _keys(head)}
        if any(column.names != names for column in self._readings) or not key_of.keys() >= set(names):
            raise _no_recording(path, "its readings are not those of its head")
        times = np.array(self._readings[0].times[:ticks])
        records = [
            self._make_record(path, head, agent, times, tuple(key_of[name] for name in names))
            for agent in range(len(head.names))
        ]
        logged_ns = np.array(self._readings[0].logged_ns[:ticks], np.int64)
        return Recording(path, head, tuple(records), whole, self.runs, logged_ns, self._duties)

    def _make_record(
        self, path: Path, head: RecordingHeader, agent: int, times: Column, keys: Sequence[ReadingKey]
    ) -> Record:
        values = np.array(self._readings[agent].values[: len(times)])
        names = next((each.names for each in self._commands if each.times), ())
        name = head.names[agent].strip("/")
        return Record(
            times=times,
            values={key: values[:, column] for column, key in enumerate(keys)},
            commands=self._arrange_commands(agent, names, times),
            channels=tuple(_find_channel(head, each) for each in names),
            readings=tuple(head.readings),
            targets=tuple(head.targets),
            tick_s=head.tick_s,
            episodes=(Episode(path.name, 0, len(times)),),
            states=tuple(self._paths[agent][: len(times)]),
            presses=tuple(_mark_corrections(self._presses[agent])),
            agent=name or f"robot {agent}",
            source=str(path),
            seed=head.ran.seed if head.ran.scenario is not None else None,
            behavior=head.ran.behavior or "",
        )

    def _arrange_commands(self, agent: int, names: tuple[str, ...], times: Column) -> Floats:
        """Return the commands [T, C] of an agent; NaN in ticks that have none."""
        tick_of = {time_s: tick for tick, time_s in enumerate(times.tolist())}
        table, column = np.full((len(times), len(names)), np.nan), self._commands[agent]
        if column.names == names:
            for time_s, values in zip(column.times, column.values, strict=True):
                if time_s in tick_of:
                    table[tick_of[time_s]] = values
        return table


def _find_channel(head: RecordingHeader, name: str) -> Channel:
    return next((each for each in head.channels if each.name == name), Channel(name))


def _mark_corrections(steps: Sequence[RecordedPress]) -> Iterator[RecordedPress]:
    """Yield steps of a session; those presses are corrections that end a test of the automaton."""
    is_tested = False
    for step in steps:
        if step.does in (TEST, TRAIN, TEACH):
            is_tested = step.does == TEST
        is_press = step.does == PRESS
        yield replace(step, correction=is_tested) if is_press and is_tested else step
        is_tested = is_tested and not is_press


def _step(tick: int, text: str) -> RecordedPress:
    """Parse a recorded step with its time, such as "restart 12.5"."""
    does, _, at = text.partition(" ")
    try:
        return RecordedPress(tick, None, does=does, at_s=float(at) if at else None)
    except ValueError:
        raise MessageRefused(type=TEXT, problem=f"{text!r:.60} is not a step of a session") from None


def _decode_duty(tick: int, data: bytes, logged_ns: int) -> RecordedDuty:
    message = decode_message(DUTY, data)
    return RecordedDuty(
        tick,
        float(message.time_s),
        logged_ns,
        (int(message.term), int(message.number)) if message.term else None,
        message.leader,
        bool(message.alone),
        message.behavior,
        dict(zip(message.parameters, message.targets, strict=True)),
        message.frames,
    )


class _ReadingColumn:
    """The readings of one agent, tick by tick."""

    def __init__(self) -> None:
        self.names: tuple[str, ...] = ()
        self.times: list[float] = []
        self.logged_ns: list[int] = []
        self.values: list[Column] = []
        self._reader = ReadingsEncoder(())

    def add(self, data: bytes, logged_ns: int) -> None:
        decoded = self._reader.decode(data)
        if decoded is None:
            names = decode_reading_names(data)
            if self.times and names != self.names:
                raise MessageRefused(type=READINGS, problem="other readings than in the ticks before")
            self.names, self._reader = names, ReadingsEncoder(names)
            decoded = self._reader.decode(data)
        if decoded is None:
            raise MessageRefused(type=READINGS, problem="not as Understudy writes them")
        self.times.append(decoded[0])
        self.logged_ns.append(logged_ns)
        self.values.append(decoded[1])


def iterate_records(path: Path | str) -> Iterator[Any]:
    """Yield the records of an MCAP file; any error is raised after the last valid record."""
    try:
        from mcap.stream_reader import StreamReader
    except ImportError:
        raise ExtraMissing(what="a recording", extra="ros2") from None
    with Path(path).open("rb") as file:
        yield from StreamReader(file, record_size_limit=MOST_BYTES, validate_crcs=True).records


def _keys(head: RecordingHeader) -> list[ReadingKey]:
    return [
        (reading.name, target)
        for reading in head.readings
        for target in (head.targets if reading.of_targets else (None,))
    ]


def list_recorded_parts(path: Path | str) -> list[str]:
    """List the agents and coordinators of a file of which runs can be read, as far as it can be read."""
    from mcap.records import Metadata

    parts: dict[str, None] = {}
    with suppress(Exception):  # a reader can raise any error on incomplete or damaged bytes
        for record in iterate_records(Path(path)):
            if isinstance(record, Metadata) and record.name.partition(PART)[0] == METADATA:
                parts[record.name.partition(PART)[2]] = None
    return list(parts)


def _no_recording(path: Path, problem: str) -> FileError:
    return FileError(path=path, place="", problem=problem, remedy=REMEDY)
