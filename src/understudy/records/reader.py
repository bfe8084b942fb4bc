"""Reader of recordings, which returns every complete tick even if the run was killed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
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
from understudy.records.recorder import COMMANDS, DUTIES, PRESSES, STEPS, TOPICS

PRESS, TEST, TRAIN, TEACH, RESTART, GO_ON = "press", "test", "train", "teach", "restart", "resume"
"""The steps of a session that a recording can have."""
MOST_BYTES = 2**30
"""The largest size of a record, so that a damaged length cannot fill the memory."""
REMEDY = "name a file that `understudy run --record FILE.mcap` wrote"


@dataclass(frozen=True, slots=True)
class RecordedPress:
    """A press that takes effect at a tick, counted from 0: a switch to `state`, or a confirmation (None).

    Tables of presses may have other steps of a session too; `does` is the step.
    """

    tick: int
    state: str | None
    does: str = PRESS
    at_s: float | None = None
    """The body's time at the press, in s; None if unknown."""


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
    """A recorded run.

    `times` [T] are the body's times of the ticks, in s, and `values` [T, K, N] the readings. `paths` has the states
    of all levels after each tick, and `presses` the presses, both by agent. `whole` is True if the file was closed,
    not killed. `runs` is the number of runs in the file, of which this is one. `logged_ns` [T] are the times at
    which the ticks were recorded, in ns since 1970, and `duties` has what each agent of a team began, by agent.
    """

    path: Path
    head: RecordingHeader
    times: Column
    keys: tuple[ReadingKey, ...]
    values: NDArray[np.float64]
    paths: Sequence[Sequence[tuple[str, ...]]]
    presses: Sequence[Sequence[RecordedPress]]
    whole: bool
    runs: int = 1
    logged_ns: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    duties: Sequence[Sequence[RecordedDuty]] = ()
    commands: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)
    """The commands by channel, shape [T, N] each; none if the recording has none, as those of earlier versions."""

    @property
    def ticks(self) -> int:
        """The number of ticks, T."""
        return len(self.times)


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
        return Recording(
            path,
            head,
            np.array(self._readings[0].times[:ticks]),
            tuple(key_of[name] for name in names),
            np.stack([np.array(column.values[:ticks]) for column in self._readings], axis=2),
            [each[:ticks] for each in self._paths],
            self._presses,
            whole,
            self.runs,
            np.array(self._readings[0].logged_ns[:ticks], np.int64),
            self._duties,
            self._arrange_commands(self._readings[0].times[:ticks]),
        )

    def _arrange_commands(self, times: Sequence[float]) -> dict[str, NDArray[np.float64]]:
        """Return the commands [T, N] by channel; NaN in ticks that have none, empty if no tick has any."""
        names = next((each.names for each in self._commands if each.times), ())
        tick_of = {time_s: tick for tick, time_s in enumerate(times)}
        table = np.full((len(names), len(times), len(self._commands)), np.nan)
        for agent, column in enumerate(self._commands):
            if column.names != names:
                continue
            for time_s, values in zip(column.times, column.values, strict=True):
                if time_s in tick_of:
                    table[:, tick_of[time_s], agent] = values
        return dict(zip(names, table, strict=True))


def _step(tick: int, text: str) -> RecordedPress:
    """Parse a recorded step with its time, such as "restart 12.5"."""
    does, _, at = text.partition(" ")
    try:
        return RecordedPress(tick, None, does, float(at) if at else None)
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
