"""Reader of recordings, which returns every complete tick even if the run was killed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.errors import FileError, SettingError, UnderstudyError
from understudy.extras import ExtraMissing
from understudy.model.features import ReadingKey
from understudy.model.kinds import Column
from understudy.robots.recording.header import METADATA, RecordingHeader, decode_header
from understudy.robots.recording.message_types import (
    READINGS,
    STATES,
    TEXT,
    ReadingsEncoder,
    decode_reading_names,
    decode_states,
    format_reading_label,
    register_message_types,
)
from understudy.robots.recording.recorder import PRESSES, STEPS, TOPICS
from understudy.robots.ros.messages import MessageRefused, decode_message
from understudy.robots.ros.state_topic import resolve_topic_name

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
class Recording:
    """A recorded run.

    `times` [T] are the body's times of the ticks, in s, and `values` [T, K, N] the readings. `paths` has the states
    of all levels after each tick, and `presses` the presses, both by agent. `whole` is True if the file was closed,
    not killed. `runs` is the number of runs in the file, of which this is one.
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

    @property
    def ticks(self) -> int:
        """The number of ticks, T."""
        return len(self.times)


def read_recording(path: Path | str, *, run: int | None = None) -> Recording:
    """Read a run up to its last complete tick; raise FileError if the file is no recording or has no decisions.

    If the file has several runs, such as an afternoon's lessons, `run` is the number of the one to read, from 1; the
    last by default. SettingError is raised if there is no such run.
    """
    path = Path(path)
    register_message_types()
    kept = _FileReader(run)
    whole = kept.read(path)
    if kept.runs and run is not None and not 1 <= run <= kept.runs:
        remedy = f"count from 1 to {kept.runs}"
        raise SettingError(where=str(path), setting="its run", problem=f"is {run}", remedy=remedy)
    if isinstance(kept.head, str):
        raise _no_recording(path, kept.head)
    return kept.recording(path, kept.head, whole=whole)


class _FileReader:
    """The contents of a file as far as it has been read."""

    def __init__(self, run: int | None) -> None:
        self._run, self.runs = run, 0
        self.head: RecordingHeader | str = "it does not say which behavior ran"
        self._channels: dict[int, tuple[str, str]] = {}
        self._wanted: dict[tuple[str, str], tuple[str, int]] = {}
        self._schemas: dict[int, str] = {}
        self._readings: list[_ReadingColumn] = []
        self._paths: list[list[tuple[str, ...]]] = []
        self._presses: list[list[RecordedPress]] = []

    def read(self, path: Path) -> bool:
        """Read a file; return whether it ends properly."""
        begun = False
        try:
            for record in _records(path):
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
        except Exception as error:  # whatever a reader does with bytes that end too early or are damaged
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
                    self._keep(*what, record.data)
                except MessageRefused as error:
                    raise _no_recording(path, str(error)) from None
        elif isinstance(record, Schema):
            self._schemas[record.id] = record.name
        elif isinstance(record, Channel):
            self._channels[record.id] = record.topic, self._schemas.get(record.schema_id, "")
        elif isinstance(record, Metadata) and record.name == METADATA:
            self.runs += 1
            if self.runs == (self._run or self.runs):
                self.head = decode_header(record.metadata)
                self._begin(self.head.names if isinstance(self.head, RecordingHeader) else ())
            elif self.runs > (self._run or self.runs):
                self._wanted = {}  # that run is over

    def _begin(self, names: Sequence[str]) -> None:
        """Begin another run, and discard those before."""
        topics = {READINGS: TOPICS[READINGS], STATES: TOPICS[STATES]}
        self._wanted = {
            (resolve_topic_name(name, topic), type): (topic, agent)
            for agent, name in enumerate(names)
            for type, topic in (*topics.items(), (TEXT, PRESSES), (TEXT, STEPS))
        }
        self._readings = [_ReadingColumn() for _ in names]
        self._paths = [[] for _ in names]
        self._presses = [[] for _ in names]

    def _keep(self, topic: str, agent: int, data: bytes) -> None:
        if topic == TOPICS[READINGS]:
            self._readings[agent].add(data)
        elif topic == TOPICS[STATES]:
            self._paths[agent].append(decode_states(data)[1])
        else:
            said, tick = decode_message(TEXT, data).data, len(self._paths[agent])
            self._presses[agent].append(
                _step(tick, said) if topic == STEPS else RecordedPress(tick, said or None)
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
        known = {format_reading_label(key): key for key in _keys(head)}
        if any(column.names != names for column in self._readings) or not known.keys() >= set(names):
            raise _no_recording(path, "its readings are not those of its head")
        return Recording(
            path,
            head,
            np.array(self._readings[0].times[:ticks]),
            tuple(known[name] for name in names),
            np.stack([np.array(column.values[:ticks]) for column in self._readings], axis=2),
            [each[:ticks] for each in self._paths],
            self._presses,
            whole,
            self.runs,
        )


def _step(tick: int, said: str) -> RecordedPress:
    """Parse a recorded step with its time, such as "restart 12.5"."""
    does, _, at = said.partition(" ")
    try:
        return RecordedPress(tick, None, does, float(at) if at else None)
    except ValueError:
        raise MessageRefused(type=TEXT, problem=f"{said!r:.60} is not a step of a session") from None


class _ReadingColumn:
    """The readings of one agent, tick by tick."""

    def __init__(self) -> None:
        self.names: tuple[str, ...] = ()
        self.times: list[float] = []
        self.values: list[Column] = []
        self._reader = ReadingsEncoder(())

    def add(self, data: bytes) -> None:
        found = self._reader.decode(data)
        if found is None:
            names = decode_reading_names(data)
            if self.times and names != self.names:
                raise MessageRefused(type=READINGS, problem="other readings than in the ticks before")
            self.names, self._reader = names, ReadingsEncoder(names)
            found = self._reader.decode(data)
        if found is None:
            raise MessageRefused(type=READINGS, problem="not as Understudy writes them")
        self.times.append(found[0])
        self.values.append(found[1])


def _records(path: Path) -> Iterator[Any]:
    try:
        from mcap.stream_reader import StreamReader
    except ImportError:
        raise ExtraMissing(what="a recording", extra="ros2") from None
    with path.open("rb") as file:
        yield from StreamReader(file, record_size_limit=MOST_BYTES, validate_crcs=True).records


def _keys(head: RecordingHeader) -> list[ReadingKey]:
    return [
        (reading.name, target)
        for reading in head.readings
        for target in (head.targets if reading.of_targets else (None,))
    ]


def _no_recording(path: Path, problem: str) -> FileError:
    return FileError(path=path, place="", problem=problem, remedy=REMEDY)
