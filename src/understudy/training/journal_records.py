"""Records of the journal of a session: one from each restart or move of the robot to the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.errors import FileError
from understudy.model.lesson import Example
from understudy.model.value_kinds import Continuous, parse_kind
from understudy.records.record import Episode, Record, RecordedPress, select_episode
from understudy.runtime.body import Reading
from understudy.runtime.interpreter import StackFrame
from understudy.training.journal import (
    AnyEntry,
    LessonChanged,
    PressApplied,
    PressReceived,
    RobotMoved,
    SessionStarted,
    TicksLogged,
    read_journal,
    unpack_rows,
)
from understudy.training.trainee import Press


@dataclass
class _Contents:
    """The ticks and presses of a journal as far as it has been read."""

    width: int
    rows: list[NDArray[np.float64]] = field(default_factory=list)
    states: list[str] = field(default_factory=list)
    cuts: list[int] = field(default_factory=list)
    """The ticks before which the robot was moved, or the automaton restarted."""
    waiting: dict[int, tuple[int, Press]] = field(default_factory=dict)
    presses: list[RecordedPress] = field(default_factory=list)
    reached: dict[int, str] = field(default_factory=dict)
    """The state after a tick in which a press took effect."""

    def add(self, entry: AnyEntry) -> None:
        match entry:
            case TicksLogged():
                self.rows.append(unpack_rows(entry.rows, self.width))
                self.states += entry.states
            case RobotMoved():
                self.cuts.append(len(self.states))
            case PressReceived():
                self.waiting[entry.press.number] = len(self.states), entry.press
            case LessonChanged():
                self._apply(entry.press, entry.changed, entry.after)
            case PressApplied():
                self._apply(entry.press, (), entry.run)

    def _apply(self, number: int | None, changed: Sequence[Example], run: Sequence[StackFrame]) -> None:
        if number not in self.waiting:
            return
        tick, press = self.waiting.pop(number)
        pressed = max((each for each in changed if each.is_shown), key=lambda each: each.number, default=None)
        correction = press.correction if pressed is None else pressed.correction
        kind = None if pressed is None else pressed.kind
        self.presses.append(RecordedPress(tick, press.state, correction, kind))
        if run:
            self.reached[tick] = run[0].state


def read_journal_records(path: Path | str) -> list[Record]:
    """Read the records of a journal.

    Journals have all readings of the body in each tick, and only the state of the automaton in training; they have no
    commands. They log the state before each tick; that after the last tick of a record is the one before it, unless a
    press took effect there.
    """
    entries = read_journal(path)
    began = next(entries, None)
    if not isinstance(began, SessionStarted):
        remedy = "name the journal of a session"
        raise FileError(path=path, place="its first entry", problem="no session begins there", remedy=remedy)
    contents = _Contents(len(began.keys) + 1)
    for entry in entries:
        contents.add(entry)
    if not contents.rows:
        remedy = "name the journal of a session that ran"
        raise FileError(path=path, place="", problem="its session has no tick", remedy=remedy)
    values = np.concatenate(contents.rows)
    ends = sorted({cut for cut in contents.cuts if 0 < cut < len(values)} | {0, len(values)})
    whole = _make_record(Path(path), began, values, contents)
    parts = [Episode(whole.episodes[0].source, start, end) for start, end in pairwise(ends)]
    return [
        replace(select_episode(whole, part), states=_list_states(contents, part.first, part.end))
        for part in parts
    ]


def _make_record(
    path: Path, began: SessionStarted, values: NDArray[np.float64], contents: _Contents
) -> Record:
    keys = [(name, target) for name, target in began.keys]
    kinds = [*began.kinds, *[""] * (len(keys) - len(began.kinds))]  # old journals do not have them
    readings = {
        name: Reading(
            name, parse_kind(kind, where=name) if kind else Continuous(), of_targets=target is not None
        )
        for (name, target), kind in zip(keys, kinds, strict=True)
    }
    unknown = f"{path}: it does not say kinds of readings; numbers were taken as distances, not as angles"
    seed = began.about.get("seed")
    return Record(
        times=values[:, -1],
        values={key: values[:, column] for column, key in enumerate(keys)},
        commands=np.zeros((len(values), 0)),
        channels=(),
        readings=tuple(readings.values()),
        targets=tuple(dict.fromkeys(target for _, target in keys if target is not None)),
        tick_s=began.tick_s,
        episodes=(Episode(path.name, 0, len(values)),),
        omissions=() if len(began.kinds) == len(keys) else (unknown,),
        presses=tuple(contents.presses),
        agent=f"agent {began.agent}",
        source=str(path),
        seed=seed if isinstance(seed, int) else None,
        behavior=_read_name(began.lesson),
        kinds_known=len(began.kinds) == len(keys),
    )


def _list_states(contents: _Contents, start: int, end: int) -> tuple[tuple[str, ...], ...]:
    """List the state after each tick, which the journal has before the next one."""
    before = contents.states
    after = [
        contents.reached.get(tick, before[tick + 1] if tick + 1 < end else before[tick])
        for tick in range(start, end)
    ]
    return tuple((state,) for state in after)


class _NamedDoc(msgspec.Struct):
    name: str


class _LessonDoc(msgspec.Struct):
    automaton: _NamedDoc


def _read_name(lesson: bytes) -> str:
    """Return the name of the automaton of a lesson's document."""
    return msgspec.json.decode(lesson, type=_LessonDoc).automaton.name
