"""The notebook of a session: what is written down of its lesson, and when it is on disk.

It turns what happened at a tick into examples, keeps the history for undo, and the journal for a kill.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import inf

from understudy.model.binding import Binding
from understudy.model.example import Example, ExampleKind
from understudy.model.lesson import Lesson
from understudy.runtime.interpreter import Level
from understudy.training.journal import Accepted, Acted, Journal, Pressed, Raised, Stepped, Turned, Went
from understudy.training.past import Past, difference
from understudy.training.recorder import Moment, compact
from understudy.training.trainee import Entry, Mode, Outcome, Press
from understudy.training.values import valued, values_of
from understudy.training.watching import Seen, Watching

Run = tuple[Level, ...]


class Notebook:
    """Writes down one session. `steady` names the readings that a reaction time never shifts."""

    def __init__(self, past: Past, journal: Journal, *, steady: frozenset[str]) -> None:
        self.journal = journal
        self.presses = past.presses
        self.watching = True
        self._history, self._recorder = past.history, past.recorder
        self._steady = steady
        self._watched = Watching()

    @property
    def lesson(self) -> Lesson:
        """The lesson as it stands, without its record."""
        return self._history.lesson

    @property
    def complete(self) -> Lesson:
        """The lesson as it stands, with the record its examples need."""
        return compact(replace(self.lesson, record=self._recorder.record))

    @property
    def undoable(self) -> str | None:
        """What undo would take back."""
        return self._history.undoable

    @property
    def redoable(self) -> str | None:
        """What redo would do again."""
        return self._history.redoable

    # At every tick

    def remember(self, moment: Moment, state: str) -> None:
        """A tick was sensed in this state of the automaton."""
        self._recorder.remember(moment)
        self.journal.remember(moment, state)

    def press(self, press: Press) -> None:
        """A press was made: on disk when this returns."""
        self.journal.flush()
        self.journal.write(Pressed(press), sync=True)
        self.presses = press.number

    def raised(self, outcome: Outcome) -> Entry:
        """What was learned raised a flag at this tick: where a correction of it belongs."""
        row = self._recorder.keep_press(paused=False)
        entry = Entry(outcome.state, outcome.own, *row, self._recorder.now)
        self.journal.write(Raised(entry, self.journal.new_rows(self._recorder.record)))
        return entry

    def see(self, outcome: Outcome, moment: Moment, binding: Binding) -> None:
        """A tick passed without a press: watched, if the lesson wants it and somebody watches."""
        automaton = self.lesson.automaton
        resting = outcome.state == outcome.next == automaton.states[0].name
        if not (self.lesson.options.watched and self.watching) or resting:
            return
        if automaton.state(outcome.state).flag is None:
            kind = ExampleKind.WATCHED
            example = Example(0, outcome.state, (), outcome.next, kind, own=outcome.own, binding=binding)
            self._watched.see(Seen(moment, example))

    def record(self, outcome: Outcome, press: Press, binding: Binding, *, before: Run, after: Run) -> None:
        """A press acted at this tick: write down what it showed, from run state `before` to `after`."""
        flagged = min((shown.entry.seconds for shown in outcome.shown if shown.entry), default=inf)
        reaction_s = self.lesson.options.reaction_s
        self._watched.doubt(self._recorder.now, reaction_s=reaction_s, flagged=flagged)
        self.accept_watched()
        if not outcome.shown:
            self.journal.write(Acted(press.number, list(after)))
            return
        row = self._recorder.keep_press(paused=press.paused)
        number = max((example.number for example in self.lesson.examples), default=0)
        made = []
        for shown in outcome.shown:
            number += 1
            moment, window = row if shown.entry is None else (shown.entry.moment, shown.entry.window)
            example = Example(
                number,
                shown.state,
                (),
                shown.next,
                shown.kind,
                correction=press.correction,
                moment=moment,
                window=window,
                own=shown.own,
                binding=binding,
            )
            values = values_of(example, self.lesson, self._recorder.record, steady=self._steady)
            made.append(replace(example, values=values))
        what = f"{made[0].state} → {made[0].next}"
        lesson = replace(self.lesson, examples=(*self.lesson.examples, *made))
        self.step(what, lesson, before=before, after=after, press=press.number)

    # Between ticks

    def begin_episode(self) -> None:
        """The robot did not get by itself to where it is now."""
        self.accept_watched()
        self._watched.begin_episode()
        self._recorder.begin_episode()

    def accept_watched(self) -> None:
        """What was seen and not objected to becomes watched examples."""
        watched = self._watched.accept(self.lesson, self._recorder, steady=self._steady)
        if watched:
            self._history.amend(*watched)
            self.journal.write(Accepted(list(watched), self.journal.new_rows(self._recorder.record)))

    def step(self, what: str, lesson: Lesson, *, before: Run, after: Run, press: int | None = None) -> None:
        """Change the lesson: on disk when this returns, unless a press did it, which is there already."""
        design, different, gone = difference(self.lesson, lesson)
        rows = self.journal.new_rows(self._recorder.record)
        entry = Stepped(what, press, design, different, gone, rows, list(before), list(after))
        self.journal.write(entry, sync=press is None)
        self._history.step(what, lesson, before=before, after=after)

    def valued(self, lesson: Lesson) -> Lesson:
        """A lesson whose features or reaction time changed, with its examples' values computed again."""
        return valued(lesson, self._recorder.record, steady=self._steady)

    def undo(self) -> tuple[str, Run]:
        """Take the last step back: what it was, and the run state before it."""
        undone = self._history.undo()
        self._went(back=True)
        return undone

    def redo(self) -> tuple[str, Run]:
        """Do the last undone step again: what it was, and the run state after it."""
        redone = self._history.redo()
        self._went(back=False)
        return redone

    def _went(self, *, back: bool) -> None:
        self._watched.forget()
        self.journal.write(Went(back), sync=True)

    def turned(self, mode: Mode, run: Run, targets: Mapping[str, str]) -> None:
        """The mode, the run state or what parameters stand for changed otherwise than by a press."""
        self.journal.write(Turned(mode, list(run), dict(targets)), sync=True)
