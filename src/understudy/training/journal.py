"""The journal of a session: everything needed to go on after a kill, replay a lesson, and look back.

Every press is on disk before it is acknowledged, every change of the lesson when it is made, all readings of
every tick in chunks (a press flushes its chunk), and a snapshot of body and automaton every few seconds and
at presses.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Sequence
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
from understudy.runtime.interpreter import StackFrame
from understudy.storage.append_log import AppendLog, JournalLock, read_log
from understudy.storage.json_text import convert_decode_errors
from understudy.training.sample_buffer import Sample
from understudy.training.trainee import FlagEntry, Mode, Press

MAGIC = b"understudy journal 1\n"
CHUNK_TICKS = 50
SNAPSHOT_S = 5.0


class ReadingRows(msgspec.Struct, frozen=True):
    """Rows of readings: float64, little-endian, compressed; the last column is the demonstrator's time."""

    count: int
    packed: bytes


# The tags of entries are part of the format: they stay, whatever the classes are called.


class SessionStarted(msgspec.Struct, frozen=True, tag="Began"):
    """The session as it began."""

    lesson: bytes
    agent: int
    keys: list[ReadingKey]
    tick_s: float
    targets: dict[str, str]
    about: dict[str, str | int | float | bool]


class TicksLogged(msgspec.Struct, frozen=True, tag="Ticks"):
    """All readings of consecutive ticks, and the state of the taught automaton at each."""

    first: int
    rows: ReadingRows
    states: list[str]


class SnapshotTaken(msgspec.Struct, frozen=True, tag="Snapshot"):
    """Body and automaton before a tick."""

    tick: int
    body: bytes
    run: list[StackFrame]
    mode: Mode


class PressReceived(msgspec.Struct, frozen=True, tag="Pressed"):
    """A press, acknowledged once this is on disk."""

    press: Press


class LessonChanged(msgspec.Struct, frozen=True, tag="Stepped"):
    """A step that changed the lesson; `press` is the press that made it, `design` the lesson without
    examples. Where it is a correction that takes back a switch, `stay` is what should have been decided then.
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
    """A press that acted and showed nothing."""

    press: int
    run: list[StackFrame]


class WatchedAccepted(msgspec.Struct, frozen=True, tag="Accepted"):
    """Watched examples: no step of their own."""

    examples: list[Example]
    rows: ReadingRows


class FlagRaised(msgspec.Struct, frozen=True, tag="Raised"):
    """What was learned raised a flag: where a correction of the flag would be recorded. `state` is the flag state, of
    an automaton that has several.
    """

    entry: FlagEntry
    rows: ReadingRows
    state: str | UnsetType = UNSET


class UndoRedo(msgspec.Struct, frozen=True, tag="Went"):
    """An undo, or a redo."""

    back: bool


class ModeChanged(msgspec.Struct, frozen=True, tag="Turned"):
    """A change of mode, a restart, or other targets: what is not a step of the lesson."""

    mode: Mode
    run: list[StackFrame]
    targets: dict[str, str]
    waiting: Press | None


class OthersChanged(msgspec.Struct, frozen=True, tag="Occupied"):
    """What the agents do from here on that are not being taught: idle (None), or a behavior."""

    behavior: str | None
    targets: dict[str, str]


class WatchingChanged(msgspec.Struct, frozen=True, tag="Attended"):
    """Whether somebody watches from here on."""

    watching: bool


class RobotMoved(msgspec.Struct, frozen=True, tag="Placed"):
    """The robot did not get by itself to where it is from here on."""


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
    """A session's journal; without a path it keeps nothing."""

    def __init__(self, path: Path | str | None = None) -> None:
        self.path = None if path is None else Path(path)
        self._log: AppendLog | None = None
        self._ticks: list[tuple[Sample, str]] = []
        self._first = 0
        self._kept_rows = 0
        self._snapshot_tick: int | None = None  # none since the robot was placed elsewhere

    @classmethod
    def create(cls, path: Path | str | None, entry: SessionStarted, *, rows: int) -> Self:
        """A new journal for a session whose lesson has a record of so many rows; FileError if the file
        exists.
        """
        journal = cls(path)
        if path is not None:
            journal._log = AppendLog.create(path, MAGIC)
            journal._kept_rows = rows
            journal.write(entry, sync=True)
        return journal

    @classmethod
    def resume(cls, path: Path | str, *, ticks: int, rows: int, lock: JournalLock) -> Self:
        """Go on with a journal that holds `ticks` ticks and `rows` rows of the lesson's record; `lock` is its lock."""
        journal = cls(path)
        journal._log = AppendLog.append(path, MAGIC, lock=lock)
        journal._first, journal._kept_rows = ticks, rows
        return journal

    @property
    def tick(self) -> int:
        """Ticks so far."""
        return self._first + len(self._ticks)

    def write(self, entry: AnyEntry, *, sync: bool = False) -> None:
        """Append an entry."""
        if self._log is not None:
            self._log.write(_encode(entry), sync=sync)

    def add_tick(self, moment: Sample, state: str) -> None:
        """A tick has been sensed."""
        if self._log is None:
            return
        self._ticks.append((moment, state))
        if len(self._ticks) >= CHUNK_TICKS:
            self.flush()

    def flush(self) -> None:
        """Write the ticks of the running chunk."""
        if not self._ticks or self._log is None:
            return
        rows = np.array([(*moment.values, moment.seconds) for moment, _ in self._ticks])
        self.write(TicksLogged(self._first, pack_rows(rows), [state for _, state in self._ticks]))
        self._first += len(self._ticks)
        self._ticks.clear()

    def press(self, press: Press) -> int:
        """A press was made: on disk when this returns its number."""
        self.flush()
        self.write(PressReceived(press), sync=True)
        return press.number

    def wants_snapshot(self, tick_s: float) -> bool:
        """Whether the last snapshot is a few seconds old, or of another place."""
        if self._log is None or self._snapshot_tick is None:
            return self._log is not None
        return (self.tick - self._snapshot_tick) * tick_s >= SNAPSHOT_S - 1e-9

    def snapshot(self, body: bytes, run: Sequence[StackFrame], mode: Mode) -> None:
        """Keep body and automaton as they are before the next tick, once per tick."""
        if self._log is not None and self._snapshot_tick != self.tick:
            self._snapshot_tick = self.tick
            self.write(SnapshotTaken(self.tick, zlib.compress(body, 1), list(run), mode))

    def log_moved(self) -> None:
        """The robot was moved after the last tick."""
        self.flush()
        self.write(RobotMoved())
        self._snapshot_tick = None

    def new_rows(self, record: ReadingLog) -> ReadingRows:
        """The rows of a record that no entry holds yet."""
        if self._log is None:
            return ReadingRows(0, b"")
        new = np.column_stack([record.values, record.seconds])[self._kept_rows :]
        self._kept_rows = len(record)
        return pack_rows(new)

    def close(self) -> None:
        """Put everything on disk."""
        if self._log is not None:
            self.flush()
            self._log.close()


def read_journal(path: Path | str) -> Iterator[AnyEntry]:
    """The entries of a journal, oldest first; FileError where it is none."""
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
    """Rows [M, K + 1] packed."""
    return ReadingRows(len(rows), zlib.compress(np.ascontiguousarray(rows, dtype="<f8").tobytes(), 1))


def unpack_rows(rows: ReadingRows, width: int) -> NDArray[np.float64]:
    """Rows [M, width]."""
    return np.frombuffer(zlib.decompress(rows.packed), dtype="<f8").reshape(rows.count, width)
