"""Episodes of the journal of a session: one from each restart or move of the robot to the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from understudy.errors import FileError
from understudy.judging.episodes.episode import Episode, EpisodePress
from understudy.model.features import format_reading_label
from understudy.model.lesson import Example
from understudy.model.value_kinds import parse_kind
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
    presses: list[EpisodePress] = field(default_factory=list)
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
        self.presses.append(EpisodePress(tick, press.state, correction, kind))
        if run:
            self.reached[tick] = run[0].state


def read_journal_episodes(path: Path | str) -> list[Episode]:
    """Read the episodes of a journal.

    Journals have all readings of the body in each tick, and only the state of the automaton in training. They log it
    before each tick; the state after the last tick of an episode is that before it, unless a press took effect there.
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
    labels = [format_reading_label((name, target)) for name, target in began.keys]
    kinds = {label: parse_kind(kind, where=label) for label, kind in zip(labels, began.kinds, strict=False)}
    values = np.concatenate(contents.rows)
    ends = sorted({cut for cut in contents.cuts if 0 < cut < len(values)} | {0, len(values)})
    seed = began.about.get("seed")
    return [
        Episode(
            agent=f"agent {began.agent}",
            tick_s=began.tick_s,
            times=values[start:end, -1],
            states=_list_states(contents, start, end),
            readings={label: values[start:end, column] for column, label in enumerate(labels)},
            kinds=kinds,
            presses=tuple(
                replace(press, tick=press.tick - start) for press in contents.presses if start <= press.tick < end
            ),
            source=str(path),
            seed=seed if isinstance(seed, int) else None,
            behavior=_read_name(began.lesson),
        )
        for start, end in pairwise(ends)
    ]  # fmt: skip


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
