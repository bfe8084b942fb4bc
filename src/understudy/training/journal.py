"""The journal of a session, from which it can be resumed after a kill, replayed, and analyzed.

Every press is on disk before it is acknowledged, every change of the lesson when it is made, the readings of all ticks
in chunks (a press flushes its chunk), and a snapshot of body and automaton every few seconds and at presses.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Self, TypeAlias

import msgspec
import numpy as np
from msgspec import UNSET, UnsetType
from numpy.typing import NDArray

from understudy.errors import FileError
from understudy.model.binding import Binding
from understudy.model.features import ReadingKey
from understudy.model.lesson import Example, ReadingLog
from understudy.runtime.body import Body, list_reading_keys
from understudy.runtime.interpreter import StackFrame
from understudy.storage.append_log import AppendLog, JournalLock, read_log
from understudy.storage.json_text import convert_decode_errors
from understudy.training.sample_buffer import Sample
from understudy.training.trainee import FlagEntry, Mode, OwnSwitch, Press

MAGIC = b"understudy journal 1\n"
CHUNK_TICKS = 50
SNAPSHOT_S = 5.0


class ReadingRows(msgspec.Struct, frozen=True):
    """Rows of readings: compressed little-endian float64; the last column is the demonstrator's time."""

    count: int
    packed: bytes


# The tags of entries are part of the format: they stay even if classes are renamed.


class SessionStarted(msgspec.Struct, frozen=True, tag="Began"):
    """The session at its start; `kinds` has the kind of the reading of each key, and is empty in old journals."""

    lesson: bytes
    agent: int
    keys: list[ReadingKey]
    tick_s: float
    targets: dict[str, str]
    about: dict[str, str | int | float | bool]
    kinds: list[str] = []

    @classmethod
    def from_body(
        cls,
        body: Body,
        lesson: bytes,
        agent: int,
        targets: Mapping[str, str],
        about: Mapping[str, str | int | float | bool],
    ) -> Self:
        """Make the entry of a session that begins now with a body."""
        keys = list_reading_keys(body)
        kinds_by_name = {reading.name: str(reading.kind) for reading in body.readings}
        kinds = [kinds_by_name[name] for name, _ in keys]
        return cls(lesson, agent, list(keys), body.tick_s, dict(targets), dict(about), kinds)


class TicksLogged(msgspec.Struct, frozen=True, tag="Ticks"):
    """All readings of consecutive ticks, and the state of the trained automaton at each."""

    first: int
    rows: ReadingRows
    states: list[str]


class SnapshotTaken(msgspec.Struct, frozen=True, tag="Snapshot"):
    """Body and automaton before a tick; in live teaching, also the last switch that the learned automaton decided."""

    tick: int
    body: bytes
    run: list[StackFrame]
    mode: Mode
    switch: OwnSwitch | UnsetType = UNSET


class PressReceived(msgspec.Struct, frozen=True, tag="Pressed"):
    """The record of a press. The press is acknowledged to the person when this record is on disk."""

    press: Press


class LessonChanged(msgspec.Struct, frozen=True, tag="Stepped"):
    """A change of the lesson.

    `press` is the press that caused it, `design` the lesson without examples if that changed. For a correction that
    takes back a switch, `stay` is what should have been decided then.
    """

    what: str
    press: int | None
    design: bytes | None
    changed: list[Example]
    removed: list[int]
    rows: ReadingRows
    before: list[StackFrame]
    after: list[StackFrame]
    stay: Example | None = None


class PressApplied(msgspec.Struct, frozen=True, tag="Acted"):
    """A press that took effect without an example."""

    press: int
    run: list[StackFrame]


class WatchedAccepted(msgspec.Struct, frozen=True, tag="Accepted"):
    """Watched examples, which are not a step of the history."""

    examples: list[Example]
    rows: ReadingRows


class FlagRaised(msgspec.Struct, frozen=True, tag="Raised"):
    """A flag that the learned automaton raised, to which a correction of it refers.

    `state` is the flag state, of an automaton that has several.
    """

    entry: FlagEntry
    rows: ReadingRows
    state: str | UnsetType = UNSET


class UndoRedo(msgspec.Struct, frozen=True, tag="Went"):
    """An undo or a redo."""

    back: bool


class ModeChanged(msgspec.Struct, frozen=True, tag="Turned"):
    """A change of mode or targets, or a restart, which are not steps of the lesson."""

    mode: Mode
    run: list[StackFrame]
    targets: dict[str, str]
    waiting: Press | None


class OthersChanged(msgspec.Struct, frozen=True, tag="Occupied"):
    """A change of the other agents' task from this entry on: idle (None), or a behavior."""

    behavior: str | None
    targets: dict[str, str]


class WatchingChanged(msgspec.Struct, frozen=True, tag="Attended"):
    """Whether ticks without a press are recorded from here on."""

    watching: bool


class RobotMoved(msgspec.Struct, frozen=True, tag="Placed"):
    """A move of the robot from outside, such as by hand."""


AnyEntry: TypeAlias = (
    SessionStarted
    | TicksLogged
    | SnapshotTaken
    | PressReceived
    | LessonChanged
    | PressApplied
    | WatchedAccepted
    | FlagRaised
    | UndoRedo
    | ModeChanged
    | OthersChanged
    | WatchingChanged
    | RobotMoved
)

_encode = msgspec.msgpack.Encoder(enc_hook=dict).encode  # a Binding is written as a plain mapping
_decode = msgspec.msgpack.Decoder(AnyEntry, dec_hook=lambda kind, value: Binding(value)).decode


class Journal:
    """The journal of a session; without a path it stores nothing."""

    def __init__(self, path: Path | str | None = None) -> None:
        self.path = None if path is None else Path(path)
        self._log: AppendLog | None = None
        self._ticks: list[tuple[Sample, str]] = []
        self._first = 0
        self._kept_rows = 0
        self._snapshot_tick: int | None = None  # none since the robot was placed elsewhere

    @classmethod
    def create(cls, path: Path | str | None, entry: SessionStarted, *, rows: int) -> Self:
        """Create the journal of a session whose lesson's record has `rows` rows; FileError if the file exists."""
        journal = cls(path)
        if path is not None:
            journal._log = AppendLog.create(path, MAGIC)
            journal._kept_rows = rows
            journal.write(entry, sync=True)
        return journal

    @classmethod
    def resume(cls, path: Path | str, *, ticks: int, rows: int, lock: JournalLock) -> Self:
        """Continue a journal that has `ticks` ticks and `rows` rows of the lesson's record, under its `lock`."""
        journal = cls(path)
        journal._log = AppendLog.append(path, MAGIC, lock=lock)
        journal._first, journal._kept_rows = ticks, rows
        return journal

    @property
    def tick(self) -> int:
        """The number of ticks so far."""
        return self._first + len(self._ticks)

    def write(self, entry: AnyEntry, *, sync: bool = False) -> None:
        """Append an entry."""
        if self._log is not None:
            self._log.write(_encode(entry), sync=sync)

    def add_tick(self, moment: Sample, state: str) -> None:
        """Add the readings of a tick."""
        if self._log is None:
            return
        self._ticks.append((moment, state))
        if len(self._ticks) >= CHUNK_TICKS:
            self.flush()

    def flush(self) -> None:
        """Write the ticks of the present chunk."""
        if not self._ticks or self._log is None:
            return
        rows = np.array([(*moment.values, moment.seconds) for moment, _ in self._ticks])
        self.write(TicksLogged(self._first, pack_rows(rows), [state for _, state in self._ticks]))
        self._first += len(self._ticks)
        self._ticks.clear()

    def press(self, press: Press) -> int:
        """Write a press to disk, and return its number."""
        self.flush()
        self.write(PressReceived(press), sync=True)
        return press.number

    def wants_snapshot(self, tick_s: float) -> bool:
        """Return whether a snapshot is due: the last one is a few seconds old, or from before a move."""
        if self._log is None or self._snapshot_tick is None:
            return self._log is not None
        return (self.tick - self._snapshot_tick) * tick_s >= SNAPSHOT_S - 1e-9

    def snapshot(
        self, body: bytes, run: Sequence[StackFrame], mode: Mode, switch: OwnSwitch | None = None
    ) -> None:
        """Write body and automaton as they are before the next tick, at most once per tick."""
        if self._log is not None and self._snapshot_tick != self.tick:
            self._snapshot_tick = self.tick
            self.write(SnapshotTaken(self.tick, zlib.compress(body, 1), list(run), mode, switch or UNSET))

    def log_moved(self) -> None:
        """Note that the robot was moved after the last tick."""
        self.flush()
        self.write(RobotMoved())
        self._snapshot_tick = None

    def new_rows(self, record: ReadingLog) -> ReadingRows:
        """Return the rows of a record that no entry has yet."""
        if self._log is None:
            return ReadingRows(0, b"")
        new = np.column_stack([record.values, record.seconds])[self._kept_rows :]
        self._kept_rows = len(record)
        return pack_rows(new)

    def close(self) -> None:
        """Write everything to disk."""
        if self._log is not None:
            self.flush()
            self._log.close()


def read_journal(path: Path | str) -> Iterator[AnyEntry]:
    """Read the entries of a journal, oldest first; FileError if the file is not a journal."""
    for index, payload in enumerate(read_log(path, MAGIC)):
        try:
            with convert_decode_errors():
                entry = _decode(payload)
        except msgspec.MsgspecError as error:
            raise FileError(
                path=path,
                place=f"entry {index + 1}",
                problem=f"it cannot be understood ({error})",
                remedy="use the version of Understudy that wrote this journal",
            ) from None
        yield entry


def pack_rows(rows: NDArray[np.float64]) -> ReadingRows:
    """Pack rows [M, K + 1]."""
    return ReadingRows(len(rows), zlib.compress(np.ascontiguousarray(rows, dtype="<f8").tobytes(), 1))


def unpack_rows(rows: ReadingRows, width: int) -> NDArray[np.float64]:
    """Unpack rows [M, width]."""
    return np.frombuffer(zlib.decompress(rows.packed), dtype="<f8").reshape(rows.count, width)
