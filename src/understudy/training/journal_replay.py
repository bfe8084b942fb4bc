"""The past of a session: its history, its record, and its last state, replayed from its journal."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self

from understudy.errors import FileError, SessionError
from understudy.model.features import ReadingKey
from understudy.model.lesson import Example, Lesson, ReadingLog
from understudy.model.library import Library, TrainedAutomaton
from understudy.runtime.body import Body, is_rewindable
from understudy.runtime.interpreter import StackFrame
from understudy.storage.document import decode_document, encode_document
from understudy.training.corrections import CorrectionStep
from understudy.training.journal import (
    AnyEntry,
    FlagRaised,
    LessonChanged,
    ModeChanged,
    OthersChanged,
    PressApplied,
    PressReceived,
    ReadingRows,
    RobotMoved,
    SessionStarted,
    SnapshotTaken,
    TicksLogged,
    UndoRedo,
    WatchedAccepted,
    WatchingChanged,
    read_journal,
    unpack_rows,
)
from understudy.training.sample_buffer import Sample, SampleBuffer
from understudy.training.trainee import (
    FlagEntry,
    Mode,
    OwnSwitch,
    Press,
    choose_mode_after_press,
    choose_teaching_mode,
)


@dataclass(frozen=True, slots=True)
class HistoryStep:
    """The lesson at a step, the run state of its automaton, and where its flag was raised, if it was."""

    lesson: Lesson
    run: tuple[StackFrame, ...] = ()
    raised: FlagEntry | None = None


class History:
    """The current lesson, the steps behind it, and the undone ones ahead."""

    def __init__(self, lesson: Lesson) -> None:
        self.lesson = lesson
        self._done: list[tuple[str, HistoryStep, HistoryStep]] = []
        self._undone: list[tuple[str, HistoryStep, HistoryStep]] = []

    def step(self, what: str, before: HistoryStep, after: HistoryStep) -> None:
        """Add a step; `what` names the change of the lesson."""
        self._done.append((what, before, after))
        self._undone.clear()
        self.lesson = after.lesson

    def amend(self, *watched: Example) -> None:
        """Add watched examples to the current lesson, which is not a step."""
        self.lesson = replace(self.lesson, examples=(*self.lesson.examples, *watched))

    def undo(self) -> tuple[str, HistoryStep]:
        """Go back one step; return its name and the state before it."""
        if not self._done:
            raise SessionError("there is nothing to undo: no step has changed this lesson yet")
        step = self._done.pop()
        self._undone.append((step[0], step[1], replace(step[2], lesson=self.lesson)))
        self.lesson = step[1].lesson
        return step[:2]

    def redo(self) -> tuple[str, HistoryStep]:
        """Redo the step that was undone last; return its name and the state after it."""
        if not self._undone:
            raise SessionError("there is nothing to redo: nothing was undone since the last step")
        step = self._undone.pop()
        self._done.append((step[0], replace(step[1], lesson=self.lesson), step[2]))
        self.lesson = step[2].lesson
        return step[0], step[2]

    def count_steps_since(self, is_wanted: Callable[[Lesson], bool]) -> int | None:
        """Count the steps since the newest former lesson that is wanted; None if there is none."""
        for steps, (_, before, _) in enumerate(reversed(self._done), 1):
            if is_wanted(before.lesson):
                return steps
        return None

    @property
    def undoable(self) -> str | None:
        """The name of the step that undo would take back."""
        return self._done[-1][0] if self._done else None

    @property
    def redoable(self) -> str | None:
        """The name of the step that redo would repeat."""
        return self._undone[-1][0] if self._undone else None


@dataclass(slots=True)
class ReplayedSession:
    """History, record and last state of a session; those of a new session are empty."""

    history: History
    recorder: SampleBuffer
    targets: dict[str, str] = field(default_factory=dict)
    agent: int = 0
    mode: Mode = Mode.TRAINING
    presses: int = 0
    waiting: Press | None = None
    raised: FlagEntry | None = None
    flag_state: str | None = None  # the one that `raised` led to
    run: tuple[StackFrame, ...] = ()
    body: bytes | None = None
    ticks: int = 0
    body_tick: int | None = None
    switch: OwnSwitch | None = None
    about: Mapping[str, str | int | float | bool] = field(default_factory=dict)
    others: OthersChanged | None = None
    watching: bool = True
    unlearning: CorrectionStep | None = None

    @classmethod
    def from_lesson(
        cls, lesson: Lesson, keys: Sequence[ReadingKey], targets: Mapping[str, str], agent: int
    ) -> Self:
        """Make the past of a session that begins with a lesson."""
        return cls(
            History(replace(lesson, record=ReadingLog())),
            SampleBuffer(keys, lesson.record),
            dict(targets),
            agent,
            choose_teaching_mode(lesson.options),
        )

    def restore_body(self, body: Body) -> bool:
        """Restore the last snapshot of the body; return False if there is none that fits this body.

        A snapshot fits if the body can be rewound and has the same world, which a failing world is not.
        """
        if self.body is None or not is_rewindable(body):
            return False
        try:
            body.restore(self.body)
        except FileError:
            return False
        return True

    @classmethod
    def from_journal(
        cls, path: Path | str, library: Library | None, keys: Sequence[ReadingKey] | None = None
    ) -> Self:
        """Replay a journal; FileError if it has no session, or one with other readings.

        Without a library, features are as the journal has them, which is enough to read the lesson.
        """
        entries = read_journal(path)
        began = next(entries, None)
        if not isinstance(began, SessionStarted):
            raise FileError(
                path=path,
                place="its first entry",
                problem="no session begins there",
                remedy="begin a new session",
            )
        if keys is not None and tuple(began.keys) != tuple(keys):
            raise FileError(
                path=path,
                place="its first entry",
                problem="the session was with a body that has other readings",
                remedy="resume it with the body it was with",
            )
        lesson = decode_journal_lesson(began.lesson, library, path)
        past = cls.from_lesson(lesson, began.keys, began.targets, began.agent)
        past.about = began.about
        for entry in entries:
            past.apply_entry(entry, library, path)
        return past

    def apply_entry(self, entry: AnyEntry, library: Library | None, path: Path | str) -> None:
        """Repeat the change that an entry of the journal records."""
        match entry:
            case TicksLogged():
                self.ticks = entry.first + entry.rows.count
                for moment in self._moments(entry.rows):
                    self.recorder.append(moment)
            case SnapshotTaken():
                self.body, self.body_tick = zlib.decompress(entry.body), entry.tick
                self.run, self.mode = tuple(entry.run), entry.mode
                self.switch = entry.switch or None
            case PressReceived():
                self.waiting, self.presses = entry.press, entry.press.number
                self.mode = choose_mode_after_press(self.mode, self.history.lesson.options)
            case PressApplied():
                self.waiting, self.run = None, tuple(entry.run)
                self._drop_flag_unless_up()
            case LessonChanged():
                self._keep(entry.rows)
                before = self.history.lesson
                after = apply_lesson_step(before, entry, library, path)
                self.run = tuple(entry.before)
                self._drop_flag_unless_up()
                former = HistoryStep(before, self.run, self.raised)
                self.run, self.history.lesson = tuple(entry.after), after
                self._drop_flag_unless_up()
                self.history.step(entry.what, former, HistoryStep(after, self.run, self.raised))
                if entry.press is not None:
                    self.waiting = None
                    self.unlearning = (
                        CorrectionStep.from_lessons(before, after, entry.stay) or self.unlearning
                    )
            case WatchedAccepted():
                self._keep(entry.rows)
                self.history.amend(*entry.examples)
            case FlagRaised():
                self._keep(entry.rows)
                flags = [
                    state.name for state in self.history.lesson.automaton.states if state.flag is not None
                ]
                self.raised, self.flag_state = entry.entry, entry.state or flags[0]
            case UndoRedo():
                _, there = self.history.undo() if entry.back else self.history.redo()
                self.run, self.raised, self.waiting = there.run, there.raised, None
                self.flag_state = there.run[0].state if there.run else None
                self._drop_flag_unless_up()
            case ModeChanged():
                self.mode, self.run, self.targets = entry.mode, tuple(entry.run), dict(entry.targets)
                self.waiting = entry.waiting
                self._drop_flag_unless_up()
            case OthersChanged():
                self.others = entry
            case WatchingChanged():
                self.watching = entry.watching
            case RobotMoved():
                self.switch = None
                self.recorder.begin_episode()
            case SessionStarted():
                raise FileError(
                    path=path,
                    place="",
                    problem="two sessions are in one journal",
                    remedy="keep one per session",
                )

    def _drop_flag_unless_up(self) -> None:
        """Drop the place where a flag was raised once its state is left, or the state before it is gone."""
        states = {state.name: state.flag for state in self.history.lesson.automaton.states}
        is_up = bool(self.run) and self.run[0].state == self.flag_state and bool(states.get(self.flag_state))
        if self.raised is not None and not (is_up and states.get(self.raised.state, "gone") is None):
            self.raised = None

    def _keep(self, rows: ReadingRows) -> None:
        for moment in self._moments(rows):
            self.recorder.keep(moment)

    def _moments(self, rows: ReadingRows) -> list[Sample]:
        width = len(self.recorder.keys) + 1
        return [Sample(seconds, tuple(values)) for *values, seconds in unpack_rows(rows, width).tolist()]


def encode_journal_lesson(lesson: Lesson) -> bytes:
    """Encode a lesson for the journal: its document without trees."""
    return encode_document(TrainedAutomaton(lesson.automaton, lesson))


def decode_journal_lesson(data: bytes, library: Library | None, path: Path | str) -> Lesson:
    """Decode a lesson from the journal."""
    kit = None if library is None else library.kit
    opened = decode_document(data, kit, path=path, learn=lambda lesson: {})
    if opened.taught.lesson is None:
        raise FileError(path=path, place="", problem="an entry holds no lesson", remedy="begin a new session")
    return opened.taught.lesson


def diff_lessons(before: Lesson, after: Lesson) -> tuple[bytes | None, list[Example], list[int]]:
    """Compare two lessons: the new design if it changed, new or changed examples, and numbers of deleted ones."""
    design = None
    designs = [(each.automaton, each.options, each.properties, each.goal) for each in (before, after)]
    if designs[0] != designs[1]:
        design = encode_journal_lesson(replace(after, examples=(), record=ReadingLog()))
    old = {example.number: example for example in before.examples}
    new = {example.number for example in after.examples}
    different = [example for example in after.examples if old.get(example.number) is not example]
    return design, different, [number for number in old if number not in new]


def apply_lesson_step(
    lesson: Lesson, step: LessonChanged, library: Library | None, path: Path | str
) -> Lesson:
    """Return the lesson after a step of a journal."""
    base = lesson
    if step.design is not None:
        base = decode_journal_lesson(step.design, library, path)
    new = {example.number: example for example in step.changed}
    examples = [new.pop(e.number, e) for e in lesson.examples if e.number not in step.removed]
    return replace(base, examples=(*examples, *new.values()), record=ReadingLog())
