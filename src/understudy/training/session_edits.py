"""Changes of a session's lesson: undo and redo, edits of examples, another design (paper section 3.2)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Unpack

from understudy.errors import DefinitionError, UnderstudyError
from understudy.learning.fit import learn_automaton
from understudy.learning.lesson_change import LessonStep
from understudy.model.automaton import Automaton
from understudy.model.binding import Binding
from understudy.model.change_summary import ChangeSummary
from understudy.model.drawing import call_markup, format_number_of, format_repr
from understudy.model.lesson import Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.runtime.body import Body, is_rewindable
from understudy.runtime.link import link
from understudy.runtime.run_loop import Run
from understudy.training.edits import (
    DesignChange,
    ExampleChange,
    change_design,
    correct_press,
    delete_examples,
    describe_edit,
    edit_example,
    set_quarantine,
)
from understudy.training.journal_replay import HistoryStep
from understudy.training.lesson_design import check_parameter_targets
from understudy.training.lesson_log import LessonLog, TraineeState
from understudy.training.trainee import Mode, Press, TickResult, Trainee, choose_teaching_mode


class SessionDisplay:
    """The part of a session that represents it."""

    body: Body
    trainee: Trainee
    _log: LessonLog

    def __repr__(self) -> str:
        lesson, taught = self._log.lesson, self.trainee.taught
        examples = format_number_of(len(lesson.examples), "example")
        facts = [f"{self.trainee.mode} mode", f"in state {taught.state_name}", examples]
        return format_repr(self, f"of {lesson.name!r}", *facts, f"at {self.body.time_s:.1f} s")

    def _repr_html_(self) -> str:
        return call_markup("html_cards:write_session_html", self)


class EditableSession(SessionDisplay, ABC):
    """The part of a session that changes its lesson. After each change another trainee continues where the last was."""

    library: Library
    _run: Run
    _targets: dict[str, str]
    _last_step: LessonStep | None

    @abstractmethod
    def _new_run(self) -> Run:
        """Make the run of the trainee and of the other agents."""

    @property
    def last_change(self) -> ChangeSummary | None:
        """What the automaton decides otherwise since the last press or edit, apart from what that itself says.

        None if there is nothing to say, as after an undo, or after a press that recorded nothing or mended a slip.
        Only decision trees are compared.
        """
        return None if self._last_step is None else self._last_step.summary

    def _record_press(self, result: TickResult, press: Press, binding: Binding, before: TraineeState) -> None:
        """Record the examples of a press, and learn from them in live teaching."""
        lesson, automaton = self._log.lesson, self.trainee.taught.automaton
        self._last_step = None
        self._log.record(result, press, binding, before=before, after=self._trainee_state())
        live = self.trainee.mode is Mode.LIVE
        if live:
            self._relink(self._try_trainee(Mode.LIVE))
        if result.examples:
            self._last_step = LessonStep(
                lesson,
                self._log.lesson,
                former=automaton if live else None,
                learned=self.trainee.taught.automaton if live else None,
            )

    def undo(self) -> str:
        """Undo a press that still waits for its tick, or else the last change of the lesson. The world stays as it is.

        Returns
        -------
        str
            What was undone, in words.

        Raises
        ------
        SessionError
            If there is nothing to undo.
        """
        self._last_step = None
        waiting = self.trainee.press
        if waiting is None:
            return self._went(self._log.lesson, *self._log.undo())
        what, self.trainee.press = self._describe_press(waiting), None
        self._relink(self._try_trainee(Mode.TESTING if waiting.correction else self.trainee.mode))
        self._turned()
        return what

    def count_steps_since(self, is_wanted: Callable[[Lesson], bool]) -> int | None:
        """Count how often to undo to get a former lesson back, if nothing waits for its tick.

        Parameters
        ----------
        is_wanted
            Returns whether a lesson, without its record, is the wanted one.

        Returns
        -------
        int | None
            The number of steps since the newest such lesson; None if undo does not lead to one.
        """
        return self._log.count_steps_since(is_wanted)

    def redo(self) -> str:
        """Redo the change that was undone last.

        Returns
        -------
        str
            What was redone, in words.

        Raises
        ------
        SessionError
            If there is nothing to redo.
        """
        self._last_step = None
        return self._went(self._log.lesson, *self._log.redo())

    def _went(self, former: Lesson, what: str, there: HistoryStep) -> str:
        mode, self.trainee.press = self.trainee.mode, None
        self._relink(self._try_trainee(self._choose_mode(former, self._log.lesson)))
        self.trainee.restore(there.run, now=self.body.time_s)
        self.trainee.keep(None, there.raised)
        if self.trainee.mode is not mode:
            self._turned()
        return what

    def _try_trainee(self, mode: Mode) -> Trainee:
        try:
            return self._new_trainee(self._log.lesson, mode)
        except DefinitionError:  # what is left is too little for its classifier: nothing to test
            lesson, mode = self._log.lesson, Mode.LIVE if mode is Mode.LIVE else Mode.TRAINING
            return self._link_trainee(lesson.automaton, mode)

    def _describe_press(self, press: Press) -> str:
        state = self.trainee.taught.state_name
        return f"{state} → {press.state or state}"

    def delete(self, *numbers: int) -> None:
        """Delete examples.

        Parameters
        ----------
        *numbers
            Numbers of the examples.
        """
        self._change(describe_edit("delete", len(numbers)), delete_examples(self._log.lesson, numbers))

    def quarantine(self, reasons: Mapping[int, str]) -> None:
        """Put examples into quarantine, where they do not teach, or take them out.

        Parameters
        ----------
        reasons
            A reason for each number of an example; "" takes it out.
        """
        what = describe_edit("quarantine" if any(reasons.values()) else "release", len(reasons))
        self._change(what, set_quarantine(self._log.lesson, reasons))

    def edit(self, number: int, **change: Unpack[ExampleChange]) -> None:
        """Edit an example.

        Parameters
        ----------
        number
            Number of the example.
        **change
            Its new `state`, `next`, or `values` by feature label.
        """
        self._change(f"edit example {number}", edit_example(self._log.lesson, number, **change))

    def correct_slip(self, number: int, next: str) -> None:
        """Correct a press that was a slip.

        Parameters
        ----------
        number
            Number of its example.
        next
            The state that was meant.
        """
        self._change(f"mend example {number}", correct_press(self._log.lesson, number, next))

    def change_design(
        self, *, targets: Mapping[str, str] | None = None, **choice: Unpack[DesignChange]
    ) -> None:
        """Change states, flags, features, parameters, statelessness or options; what is not given stays.

        Examples stay and get values of new features from the record. Examples of states that are gone are dropped.

        Parameters
        ----------
        targets
            A target for each new parameter.
        **choice
            What changes, as for `new_lesson`.
        """
        self._log.accept_watched()
        stand_for = {**self._targets, **(targets or {})}
        lesson = change_design(self._log.lesson, self.library, choice, stand_for)
        check_parameter_targets(lesson.automaton, targets or {}, self.body.targets)
        self._change(f"choose {' and '.join(choice)}", self._log.recompute_values(lesson), targets)

    def _change(self, what: str, lesson: Lesson, targets: Mapping[str, str] | None = None) -> None:
        former, self._targets = self._targets, {**self._targets, **(targets or {})}
        try:
            trainee = self._new_trainee(lesson, self._choose_mode(self._log.lesson, lesson))
        except UnderstudyError:
            self._targets = former
            raise
        here = self._trainee_state()
        if targets:
            self._log.begin_episode()  # what was sensed and decided before has no reading of new targets
            self._turned()
        self._last_step = LessonStep(self._log.lesson, lesson)
        self._log.step(what, lesson, before=here, after=here)
        mode = self.trainee.mode
        self._relink(trainee)
        if trainee.mode is not mode:
            self._turned()

    def _choose_mode(self, former: Lesson, lesson: Lesson) -> Mode:
        """Return the mode in which the session goes on, another one if the lesson is taught in another way now."""
        now = self.trainee.mode
        if now is Mode.TESTING or lesson.options.live == former.options.live:
            return now
        return choose_teaching_mode(lesson.options)

    def make_trained_automaton(self) -> TrainedAutomaton:
        """Learn from the lesson, and return the automaton together with the lesson.

        Returns
        -------
        TrainedAutomaton
            What `save_automaton` stores in a library.
        """
        lesson = self._log.complete
        return TrainedAutomaton(learn_automaton(lesson), lesson)

    def _trainee_state(self) -> TraineeState:
        return TraineeState(self.trainee.snapshot(self.body.time_s), self.trainee.entry)

    def _keep_snapshot(self) -> None:
        body, now = self.body, self.body.time_s
        if self._log.journal.path is not None and is_rewindable(body):
            run, mode = self.trainee.snapshot(now), self.trainee.mode
            switch = self._log.last_switch.switch if mode is Mode.LIVE else None
            self._log.journal.snapshot(body.snapshot(), run, mode, switch)

    def _turned(self) -> None:
        self._log.log_mode(
            self.trainee.mode, self.trainee.snapshot(self.body.time_s), self._targets, self.trainee.press
        )

    def _relink(self, trainee: Trainee) -> None:
        """Let another trainee continue where the present one is."""
        old, self.trainee = self.trainee, trainee
        trainee.restore(old.snapshot(self.body.time_s), now=self.body.time_s)
        trainee.keep(old.press, old.entry)
        self._run = self._new_run()
        if trainee.press is not old.press:
            self._turned()  # its state is gone

    def _new_trainee(self, lesson: Lesson, mode: Mode) -> Trainee:
        automaton = lesson.automaton if mode is Mode.TRAINING else learn_automaton(lesson)
        return self._link_trainee(automaton, mode)

    def _link_trainee(self, automaton: Automaton, mode: Mode) -> Trainee:
        library = self.library.with_automaton(TrainedAutomaton(automaton))
        bound = {name: target for name, target in self._targets.items() if name in automaton.parameters}
        return Trainee(link(library, automaton.name, bound), mode, now=self.body.time_s)
