"""The log of a session, which records its lesson and decides when each change is on disk.

It turns ticks and presses into examples, and keeps the history for undo and the journal for resuming.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import inf
from typing import NamedTuple, TypeAlias

from msgspec import UNSET

from understudy.learning.mislabels import CorrectionDiagnosis
from understudy.model.binding import Binding
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.runtime.interpreter import StackFrame, measure_elapsed
from understudy.training.corrections import SOON_S, CorrectionStep, LastSwitch
from understudy.training.edits import correct_press
from understudy.training.example_index import ExampleIndex
from understudy.training.feature_values import compute_example_values, recompute_example_values
from understudy.training.journal import (
    FlagRaised,
    Journal,
    LessonChanged,
    ModeChanged,
    PressApplied,
    UndoRedo,
    WatchedAccepted,
    WatchingChanged,
)
from understudy.training.journal_replay import HistoryStep, ReplayedSession, diff_lessons
from understudy.training.sample_buffer import Sample, compact_reading_log
from understudy.training.trainee import FlagEntry, Mode, OwnSwitch, Press, TickResult, Trainee
from understudy.training.watched_examples import (
    WatchedBatch,
    WatchedBuffer,
    WatchedTick,
    measure_deciding_time,
)

RunState: TypeAlias = tuple[StackFrame, ...]


class TraineeState(NamedTuple):
    """The run state of the automaton in training, and where the learned automaton raised its flag, if it did."""

    run: RunState
    raised: FlagEntry | None


class LessonLog:
    """The log of one session. `steady` names the readings that a reaction time never shifts.

    `last_switch` is the last switch that the learned automaton decided by itself.
    """

    def __init__(self, past: ReplayedSession, journal: Journal, *, steady: frozenset[str]) -> None:
        self.journal = journal
        self.presses = past.presses
        self._watching = past.watching
        self._history, self._recorder = past.history, past.recorder
        self._steady = steady
        self._watched = WatchedBuffer()
        self._index = ExampleIndex()
        self._counted: tuple[tuple[Example, ...], int] = ((), 0)
        self._last_correction = past.unlearning
        self.last_switch = LastSwitch(past.recorder.keys, steady)

    @property
    def is_watching(self) -> bool:
        """Whether ticks without a press become watched examples, in a lesson that records them."""
        return self._watching

    @is_watching.setter
    def is_watching(self, watching: bool) -> None:
        self._watching = watching
        self.journal.write(WatchingChanged(watching))

    @property
    def lesson(self) -> Lesson:
        """The current lesson, without its record."""
        return self._history.lesson

    @property
    def press_count(self) -> int:
        """The number of examples made by presses, cached because views need it at every tick."""
        examples = self.lesson.examples
        if self._counted[0] is not examples:
            self._counted = examples, sum(example.is_from_press for example in examples)
        return self._counted[1]

    @property
    def complete(self) -> Lesson:
        """The current lesson, with the latest watched examples and the record that its examples need."""
        lesson, record = self.lesson, self._recorder.record
        ticks = self._agreed().ticks
        return compact_reading_log(
            replace(
                lesson,
                examples=(
                    *lesson.examples,
                    *self._numbered(ticks, range(len(record), len(record) + len(ticks))),
                ),
                record=record.with_rows(
                    [each.moment.values for each in ticks], [each.moment.seconds for each in ticks]
                ),
            )
        )

    @property
    def correction_diagnosis(self) -> CorrectionDiagnosis | None:
        """The diagnosis of the last correction; None if there is none, or if the robot had been right."""
        last = self._last_correction
        return last.diagnosis if last is not None and last.is_still_in_lesson(self.lesson) else None

    @property
    def undoable(self) -> str | None:
        """The name of the step that undo would take back."""
        return self._history.undoable

    @property
    def redoable(self) -> str | None:
        """The name of the step that redo would repeat."""
        return self._history.redoable

    # At every tick

    def add_tick(self, moment: Sample, state: str) -> None:
        """Add a tick in this state of the automaton."""
        self._recorder.append(moment)
        self.journal.add_tick(moment, state)

    def log_flag(self, result: TickResult) -> FlagEntry:
        """Note that the learned automaton raised a flag at this tick, and return where a correction of it belongs."""
        entry = FlagEntry(result.state, result.own, self._recorder.keep_last())
        self.log_raised(entry, result.next)
        return entry

    def log_raised(self, entry: FlagEntry, state: str) -> None:
        """Note that the flag of this state is up, and where it was raised."""
        several = sum(each.flag is not None for each in self.lesson.automaton.states) > 1
        rows = self.journal.new_rows(self._recorder.record)
        self.journal.write(FlagRaised(entry, rows, state if several else UNSET))

    def log_silence(self, result: TickResult, moment: Sample, binding: Binding) -> None:
        """Log a tick without a press; if the lesson learns from silence, it may become a watched example."""
        automaton = self.lesson.automaton
        self.last_switch.note_tick(result, moment, binding, first=automaton.states[0].name)
        resting = result.state == result.next == automaton.states[0].name
        if not (self.lesson.options.watched and self.is_watching) or resting:
            return
        if automaton.state(result.state).flag is None:
            kind = ExampleKind.WATCHED
            example = Example(0, result.state, (), result.next, kind, own=result.own, binding=binding)
            self._watched.add_tick(WatchedTick(moment, example))

    def find_answered_switch(
        self, now: Sample, state: str | None, trainee: Trainee, *, paused: bool
    ) -> OwnSwitch | None:
        """Return the recent switch of the learned automaton that a press now judges; None if there is none.

        There is one in live teaching only: the last switch, if the press takes it back within 2 s, or comes so soon
        that the demonstrator began to press before it.
        """
        if trainee.mode is not Mode.LIVE:
            return None
        raised = trainee.taught.active.flag is not None
        late_s = measure_deciding_time(self.lesson.options.reaction_s)
        directed = {
            (example.state, example.next)
            for example in self.lesson.examples
            if example.kind is ExampleKind.DIRECTIVE and not example.quarantined
        }
        switch = self.last_switch.find_answered(
            now.seconds,
            state,
            directed=directed,
            late_s=late_s,
            paused=paused,
            raised=raised,
            appeared=self.last_switch.has_anything_appeared(now.values, self.lesson.automaton.features),
        )
        lasting = {state.name for state in self.lesson.automaton.states if state.flag is None}
        return switch if switch is not None and switch.state in lasting else None

    def record(
        self,
        result: TickResult,
        press: Press,
        binding: Binding,
        *,
        before: TraineeState,
        after: TraineeState,
    ) -> None:
        """Record the examples of a press that took effect at this tick, from `before` to `after`."""
        entry = result.examples[0].entry if result.examples else None
        if entry is not None:
            since_s = float(self._recorder.record.seconds[entry.moment])
        else:
            since_s = press.answers.seconds if isinstance(press.answers, OwnSwitch) else inf
        reaction_s = self.lesson.options.reaction_s
        self._watched.discard_recent(self._recorder.now, reaction_s=reaction_s, since_s=since_s)
        self.accept_watched()
        if not result.examples:
            slip = self._find_directed_flag(result)
            if slip is None:
                self.journal.write(PressApplied(press.number, list(after.run)))
            else:
                lesson, what = correct_press(self.lesson, slip, result.next), f"mend example {slip}"
                self.step(what, lesson, before=before, after=after, press=press.number)
            return
        if entry is not None:
            moment, window = entry.moment, 0
        elif isinstance(press.answers, OwnSwitch):
            moment = self._recorder.keep(Sample(press.answers.seconds, press.answers.values))
            window = 0
        elif press.paused:
            moment, window = self._recorder.keep_last(), 0
        else:
            moment, window = self._recorder.keep_press()
        examples = []
        for number, pressed in enumerate(result.examples, self._next_number()):
            example = Example(
                number,
                pressed.state,
                (),
                pressed.next,
                pressed.kind,
                correction=result.correction,
                moment=moment,
                window=window,
                own=pressed.own,
                binding=binding,
            )
            values = compute_example_values(example, self.lesson, self._recorder.record, steady=self._steady)
            examples.append(replace(example, values=values))
        lesson = replace(self.lesson, examples=self._index.replace_watched(examples))
        what, stay = f"{examples[0].state} → {examples[0].next}", None
        if result.correction:
            stay = self.last_switch.find_undone_stay(examples[0], self.lesson, self._recorder.now)
            self._last_correction = CorrectionStep(self.lesson, lesson, examples[0], stay)
            lesson, what = self._last_correction.step(what)
        self.last_switch.clear()
        self.step(what, lesson, before=before, after=after, press=press.number, stay=stay)

    def _find_directed_flag(self, result: TickResult) -> int | None:
        """Return the number of the latest example if it led to a flag state that a press soon left; otherwise None."""
        last = max(
            (each for each in self.lesson.examples if each.is_from_press),
            key=lambda each: each.number,
            default=None,
        )
        if not result.leaves_directed_flag or last is None or last.moment is None:
            return None
        passed_s = measure_elapsed(self._recorder.now, float(self._recorder.record.seconds[last.moment]))
        return last.number if last.next == result.state and 0.0 <= passed_s <= SOON_S else None

    # Between ticks

    def begin_episode(self) -> None:
        """Note that the robot was moved from outside, so that earlier readings do not belong to later presses."""
        self.accept_watched()
        self._watched.begin_episode()
        self.last_switch.clear()
        self._recorder.begin_episode()
        self.journal.log_moved()

    def accept_watched(self) -> None:
        """Turn the watched ticks that were not corrected into watched examples."""
        agreed = self._agreed()
        self._watched.accept(agreed)
        if agreed.ticks:
            watched = self._numbered(
                agreed.ticks, [self._recorder.keep(each.moment) for each in agreed.ticks]
            )
            self._history.amend(*watched)
            self.journal.write(WatchedAccepted(watched, self.journal.new_rows(self._recorder.record)))

    def _agreed(self) -> WatchedBatch:
        self._index.update(self.lesson.examples)
        return self._watched.extract_batch(
            self.lesson, self._recorder.keys, existing=self._index.keys, steady=self._steady
        )

    def _numbered(self, ticks: Sequence[WatchedTick], rows: Sequence[int]) -> list[Example]:
        """Return watched examples with their numbers and their rows of the record."""
        first = self._next_number()
        return [
            replace(each.example, number=number, moment=row)
            for number, (each, row) in enumerate(zip(ticks, rows, strict=True), first)
        ]

    def _next_number(self) -> int:
        self._index.update(self.lesson.examples)
        return self._index.largest + 1

    def step(
        self,
        what: str,
        lesson: Lesson,
        *,
        before: TraineeState,
        after: TraineeState,
        press: int | None = None,
        stay: Example | None = None,
    ) -> None:
        """Change the lesson. It is on disk when this returns, unless a press caused it, which is on disk already.

        Nothing happens if nothing would change.
        """
        if lesson is self.lesson:
            return
        if self.journal.path is not None:  # comparing lessons takes longer than all else, the longer they are
            design, different, gone = diff_lessons(self.lesson, lesson)
            rows = self.journal.new_rows(self._recorder.record)
            entry = LessonChanged(
                what, press, design, different, gone, rows, list(before.run), list(after.run), stay
            )
            self.journal.write(entry, sync=press is None)
        self._history.step(what, HistoryStep(self.lesson, *before), HistoryStep(lesson, *after))

    def recompute_values(self, lesson: Lesson) -> Lesson:
        """Return a lesson whose features or reaction time changed, with the values of its examples computed again."""
        return recompute_example_values(self.lesson, lesson, self._recorder.record, steady=self._steady)

    def undo(self) -> tuple[str, HistoryStep]:
        """Undo the last step; return its name and the state before it."""
        undone = self._history.undo()
        self._went(back=True)
        return undone

    def count_steps_since(self, is_wanted: Callable[[Lesson], bool]) -> int | None:
        """Count the steps since the newest former lesson that is wanted; None if there is none."""
        return self._history.count_steps_since(is_wanted)

    def redo(self) -> tuple[str, HistoryStep]:
        """Redo the step that was undone last; return its name and the state after it."""
        redone = self._history.redo()
        self._went(back=False)
        return redone

    def _went(self, *, back: bool) -> None:
        self._watched.clear()
        self.journal.write(UndoRedo(back), sync=True)

    def log_mode(self, mode: Mode, run: RunState, targets: Mapping[str, str], waiting: Press | None) -> None:
        """Log a change of mode, run state or targets that no press caused."""
        self.journal.write(ModeChanged(mode, list(run), dict(targets), waiting), sync=True)
