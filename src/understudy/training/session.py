"""The session: one training of one automaton, by whoever presses (paper section 3.2).

session = Session(body, library, lesson, targets={"A": "station"})
session.direct("rotate_left")
session.test()
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import isfinite
from numbers import Real
from pathlib import Path
from typing import Self, Unpack

from understudy.errors import DefinitionError, SessionError, SettingError, UnderstudyError, UnknownName
from understudy.learning.correction_diagnosis import CorrectionDiagnosis
from understudy.learning.fit import learn_automaton
from understudy.model.automaton import Automaton
from understudy.model.binding import Binding
from understudy.model.features import Percept
from understudy.model.lesson import Example, Lesson
from understudy.model.library import Library, TrainedAutomaton
from understudy.runtime.body import Body, Resettable, is_rewindable, list_reading_keys
from understudy.runtime.interpreter import Interpreter, StackFrame
from understudy.runtime.program import link
from understudy.runtime.run_loop import Run
from understudy.storage.append_log import JournalLock
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
from understudy.training.feature_values import (
    collect_own_values,
    compute_feature_values,
    list_steady_readings,
)
from understudy.training.journal import Journal, SessionStarted
from understudy.training.journal_replay import HistoryStep, ReplayedSession, encode_journal_lesson
from understudy.training.lesson_design import check_binding_names, check_parameter_targets
from understudy.training.lesson_log import LessonLog, TraineeState
from understudy.training.other_agents import NO_SIMULATION, OtherAgents, SessionSnapshot, require_rewindable
from understudy.training.sample_buffer import Sample
from understudy.training.session_view import SessionView
from understudy.training.trainee import Mode, Press, TickResult, Trainee


class Session:
    """One agent of a body being taught one automaton; the others idle, or run behaviors of the library.

    `targets` says what the automaton's parameters stand for while it is taught. `clock` is the demonstrator's
    time, s (the body's where there is none). With a `journal` (a new file), every press is on disk before `direct` or
    `confirm` returns, and `Session.resume` goes on after any end; `about` is kept there for whoever resumes.
    """

    def __init__(
        self,
        body: Body,
        library: Library,
        lesson: Lesson,
        *,
        targets: Mapping[str, str] | None = None,
        agent: int = 0,
        clock: Callable[[], float] | None = None,
        journal: Path | str | None = None,
        about: Mapping[str, str | int | float | bool] | None = None,
    ) -> None:
        if not 0 <= agent < body.agents:
            problem, remedy = f"is {agent} of {body.agents} agents", "count from 0"
            raise SettingError(where="session", setting="agent", problem=problem, remedy=remedy)
        keys = list_reading_keys(body)
        check_parameter_targets(lesson.automaton, targets or {}, body.targets)
        self._begin(body, library, ReplayedSession.from_lesson(lesson, keys, targets or {}, agent), clock)
        began = SessionStarted(
            encode_journal_lesson(lesson), agent, list(keys), body.tick_s, self._targets, dict(about or {})
        )
        self._log.journal = Journal.create(journal, began, rows=len(lesson.record))

    @classmethod
    def resume(
        cls, journal: Path | str, body: Body, library: Library, *, clock: Callable[[], float] | None = None
    ) -> Self:
        """Go on with a session that ended, however it ended: nothing acknowledged is lost.

        The lesson is as it was; body and automaton are as at the last snapshot, if the body can be rewound. FileError
        where another session is writing the journal.
        """
        journal = Path(journal)
        lock = JournalLock.acquire(journal)  # before it is read: another session may be adding to it
        try:
            return cls._resume(journal, body, library, clock, lock)
        except BaseException:
            lock.release()
            raise

    @classmethod
    def _resume(
        cls,
        journal: Path,
        body: Body,
        library: Library,
        clock: Callable[[], float] | None,
        lock: JournalLock,
    ) -> Self:
        past = ReplayedSession.from_journal(journal, library, list_reading_keys(body))
        goes_on = False
        if past.body is not None and is_rewindable(body):
            body.restore(past.body)
            goes_on = past.body_tick == past.ticks
        session = cls.__new__(cls)
        session._begin(body, library, past, clock)
        rows = len(past.recorder.record)
        session._log.journal = Journal.resume(journal, ticks=past.ticks, rows=rows, lock=lock)
        if not goes_on:
            session._log.begin_episode()
        return session

    def _begin(
        self, body: Body, library: Library, past: ReplayedSession, clock: Callable[[], float] | None
    ) -> None:
        self.body, self.library, self.agent = body, library, past.agent
        self.paused, self._targets = False, past.targets
        self._clock = clock or (lambda: body.time_s)
        self._keys = list_reading_keys(body)
        self._log = LessonLog(past, Journal(), steady=list_steady_readings(body))
        self.other_agents = OtherAgents(body, library, past.others)
        self._driving: Interpreter | None = None
        self._percept: Percept | None = None
        check_binding_names(library, self.automaton)
        self.trainee = self._new_trainee(self._log.lesson, past.mode)  # another one after each change
        self.trainee.restore(past.run, now=body.time_s)
        self.trainee.keep(past.waiting, past.raised)
        self._run = self._new_run()

    # What there is to see

    @property
    def lesson(self) -> Lesson:
        """The lesson as it stands, with its record."""
        return self._log.complete

    @property
    def automaton(self) -> Automaton:
        """What was chosen for the automaton under training, without transition functions."""
        return self._log.lesson.automaton

    @property
    def examples(self) -> tuple[Example, ...]:
        """The lesson's examples, oldest first."""
        return self._log.lesson.examples

    @property
    def mode(self) -> Mode:
        """Training: the demonstrator decides. Testing: what was learned decides."""
        return self.trainee.mode

    @property
    def run_state(self) -> tuple[StackFrame, ...]:
        """The run state of the automaton under training and of those below."""
        return self.trainee.snapshot(self.body.time_s)

    @property
    def percept(self) -> Percept:
        """The snapshot on display: all readings, sensed once per tick."""
        if self._percept is None:
            self._percept = self.body.sense(self._keys)
        return self._percept

    @property
    def correction_diagnosis(self) -> CorrectionDiagnosis | None:
        """What the last correction of a wrong decision came to: who is to blame for it; None if there is none."""
        return self._log.correction_diagnosis

    @property
    def is_watching(self) -> bool:
        """Whether silence counts as consent, in a lesson with watched examples; False: I am not watching."""
        return self._log.is_watching

    @is_watching.setter
    def is_watching(self, watching: bool) -> None:
        self._log.is_watching = watching

    def view(self) -> SessionView:
        """What a person sees now."""
        machine, press = self.trainee.taught, self.trainee.press
        own = collect_own_values(machine, self.body.time_s)
        return SessionView(
            time_s=self.body.time_s,
            mode=self.mode,
            state=machine.state_name,
            path=self.trainee.path,
            flag=machine.flag,
            features=compute_feature_values(
                self.automaton.features, own, self._targets, self.percept, self.body, self.agent
            ),
            states=self.automaton.state_names,
            targets=dict(self._targets),
            waiting=None if press is None else press.state or machine.state_name,
            examples=self._log.press_count,
            undoable=self._log.undoable if press is None else self._describe_press(press),
            redoable=self._log.redoable,
        )

    # Pressing

    def direct(self, state: str) -> int:
        """Direct the robot to a state from the next tick on; a correction in testing. The press's number."""
        self.automaton.index(state)
        return self._press(state)

    def confirm(self) -> int:
        """Keep doing this: acts at the next tick. The press's number."""
        return self._press(None)

    def _press(self, state: str | None) -> int:
        if self._driving is not None:
            self.drive(None)
        waiting = self.trainee.press
        correction = self.mode is Mode.TESTING or (waiting is not None and waiting.correction)
        press = Press(self._log.presses + 1, state, correction, self.paused)
        self._keep_snapshot()
        self._log.presses = self._log.journal.press(press)
        self.trainee.press, self.trainee.mode = press, Mode.TRAINING
        return press.number

    def tick(self) -> None:
        """One tick: sense, decide, act, and write down what a press showed."""
        percept, trainee, log = self.percept, self.trainee, self._log
        if log.journal.wants_snapshot(self.body.tick_s):
            self._keep_snapshot()
        readings = tuple(float(percept[key][self.agent]) for key in self._keys)
        moment = Sample(self._clock(), readings)
        log.add_tick(moment, trainee.taught.state_name)
        before = self._trainee_state() if trainee.press else None
        commands = self._run.decide(percept)
        if self._driving is None:
            self._write_down(trainee.outcome, moment, before)
        self.body.act(commands)
        self._percept = None

    def _write_down(self, outcome: TickResult, moment: Sample, before: TraineeState | None) -> None:
        binding = Binding(self._targets)
        if outcome.press is not None and before is not None:
            self._log.record(outcome, outcome.press, binding, before=before, after=self._trainee_state())
            return
        if outcome.raised:
            self.trainee.entry = self._log.log_flag(outcome)
        self._log.log_silence(outcome, moment, binding)

    def run_for(self, seconds: float) -> None:
        """Tick for so long of the body's time; SettingError where that is no finite number from 0 up."""
        if not (isinstance(seconds, Real) and isfinite(seconds) and seconds >= 0):
            where, problem = f"session of {self.automaton.name!r}", f"are {seconds!r:.60}"
            remedy = "give a finite number, 0 or more"
            raise SettingError(where=where, setting="seconds", problem=problem, remedy=remedy)
        until = self.body.time_s + seconds - self.body.tick_s / 2
        while self.body.time_s < until:
            self.tick()

    # Modes

    def test(self, *, afresh: bool = True) -> None:
        """Switch to testing: learn from the lesson and restart the automaton, or let it go on where it is."""
        self._log.accept_watched()
        self._relink(self._new_trainee(self._log.lesson, Mode.TESTING))
        (self.restart if afresh else self._turned)()

    def train(self) -> None:
        """Switch to training: the robot goes on with what it is doing until directed."""
        self.trainee.mode = Mode.TRAINING
        self._turned()

    def restart(self) -> None:
        """Start the automaton under training afresh; records nothing."""
        self._log.begin_episode()
        self.trainee.press = None
        self.trainee.start(self.body.time_s)
        self._turned()

    def reset(self, seed: int) -> None:
        """Begin anew in the world of another seed, with the automaton restarted; records nothing."""
        if not isinstance(self.body, Resettable):
            raise SessionError(f"this body cannot be reset: {NO_SIMULATION}")
        self.body.reset([seed])
        self._percept = None
        self.other_agents.start()
        self.restart()

    def capture(self) -> SessionSnapshot:
        """This moment of the run, to come back to with `rewind`; SessionError where the body cannot be rewound."""
        return SessionSnapshot(
            require_rewindable(self.body).snapshot(),
            self.run_state,
            self.mode,
            self.other_agents.snapshot(),
            self.trainee.entry,
        )

    def rewind(self, instant: SessionSnapshot) -> None:
        """Go back to a moment of this session, world and automata both; the lesson stays, and nothing is recorded."""
        require_rewindable(self.body).restore(instant.body)
        self.other_agents.restore(instant.others)
        self.note_moved()
        self.trainee.press, self.trainee.mode = None, instant.mode
        if self.trainee.entry is not None:  # the journal says that this flag is no longer up
            self.trainee.start(self.body.time_s)
            self._turned()
        self.trainee.restore(instant.run, now=self.body.time_s)
        self.trainee.keep(None, instant.raised)
        self._turned()
        if self.trainee.entry is not None:
            self._log.log_raised(self.trainee.entry, self.trainee.taught.state_name)
        self._keep_snapshot()

    def drive(self, behavior: str | None, binding: Mapping[str, str] | None = None) -> None:
        """Drive the robot into position with a basic behavior, recording nothing; None ends it."""
        if behavior is not None and behavior not in (known := self.library.kit.behaviors):
            raise UnknownName(what="basic behavior", name=behavior, where="the kit", known=list(known))
        self._driving = None
        if behavior is not None:
            self._driving = Interpreter(link(self.library, behavior, binding or {}), now=self.body.time_s)
        self._log.begin_episode()
        self.trainee.press = None
        self._turned()
        self._run = self._new_run()

    def note_moved(self) -> None:
        """The robot or the world was moved by hand: what came before says nothing about now."""
        self._percept = None
        self._log.begin_episode()

    def refresh_percept(self) -> None:
        """Sense anew: what is on display may have changed between two ticks."""
        self._percept = None

    def bind_targets(self, **targets: str) -> None:
        """Let parameters stand for other targets from now on."""
        check_parameter_targets(self.automaton, targets, self.body.targets)
        self._log.begin_episode()
        self._targets |= targets
        self._relink(self._new_trainee(self._log.lesson, self.mode))
        self._turned()

    def set_other_agents(
        self,
        behavior: str | None,
        binding: Mapping[str, str] | None = None,
        *,
        library: Library | None = None,
    ) -> None:
        """What the other agents do meanwhile: idle (None), or a behavior of the library, or of a newer one."""
        self.other_agents.set_behavior(behavior, binding, library=library)
        self._run = self._new_run()
        self._log.journal.write(self.other_agents.behavior_call)

    # Changing the lesson

    def undo(self) -> str:
        """Take back a press that still waits, or else the last step that changed the lesson; the world stays.

        What it was.
        """
        waiting = self.trainee.press
        if waiting is None:
            return self._went(*self._log.undo())
        what, self.trainee.press = self._describe_press(waiting), None
        self._relink(self._try_trainee(Mode.TESTING if waiting.correction else self.mode))
        self._turned()
        return what

    def redo(self) -> str:
        """Do the last undone step again. What it was."""
        return self._went(*self._log.redo())

    def _went(self, what: str, there: HistoryStep) -> str:
        mode, self.trainee.press = self.mode, None
        self._relink(self._try_trainee(mode))
        self.trainee.restore(there.run, now=self.body.time_s)
        self.trainee.keep(None, there.raised)
        if self.mode is not mode:
            self._turned()
        return what

    def _try_trainee(self, mode: Mode) -> Trainee:
        try:
            return self._new_trainee(self._log.lesson, mode)
        except DefinitionError:  # what is left is too little for its classifier: nothing to test
            return self._new_trainee(self._log.lesson, Mode.TRAINING)

    def _describe_press(self, press: Press) -> str:
        state = self.trainee.taught.state_name
        return f"{state} → {press.state or state}"

    def delete(self, *numbers: int) -> None:
        """Delete examples by number."""
        self._change(describe_edit("delete", len(numbers)), delete_examples(self._log.lesson, numbers))

    def quarantine(self, reasons: Mapping[int, str]) -> None:
        """Let examples teach nothing for now, by number, each for a reason; "" lets one teach again."""
        what = describe_edit("quarantine" if any(reasons.values()) else "release", len(reasons))
        self._change(what, set_quarantine(self._log.lesson, reasons))

    def edit(self, number: int, **change: Unpack[ExampleChange]) -> None:
        """Edit an example: its state, its next state, or its values by feature label."""
        self._change(f"edit example {number}", edit_example(self._log.lesson, number, **change))

    def correct_slip(self, number: int, next: str) -> None:
        """Say what a press was meant for, by its example's number: it slipped."""
        self._change(f"mend example {number}", correct_press(self._log.lesson, number, next))

    def change_design(
        self, *, targets: Mapping[str, str] | None = None, **choice: Unpack[DesignChange]
    ) -> None:
        """Choose states, flags, features, parameters, statelessness or options anew; what is not given stays.

        Examples stay, valued from the record; those of states that are gone are dropped. `targets`: for parameters.
        """
        self._log.accept_watched()
        stand_for = {**self._targets, **(targets or {})}
        lesson = change_design(self._log.lesson, self.library, choice, stand_for)
        check_parameter_targets(lesson.automaton, targets or {}, self.body.targets)
        self._change(f"choose {' and '.join(choice)}", self._log.recompute_values(lesson), targets)

    def _change(self, what: str, lesson: Lesson, targets: Mapping[str, str] | None = None) -> None:
        former, self._targets = self._targets, {**self._targets, **(targets or {})}
        try:
            trainee = self._new_trainee(lesson, self.mode)
        except UnderstudyError:
            self._targets = former
            raise
        here = self._trainee_state()
        if targets:
            self._turned()
        self._log.step(what, lesson, before=here, after=here)
        self._relink(trainee)

    def make_trained_automaton(self) -> TrainedAutomaton:
        """The automaton as learned from the lesson now, with the lesson: what a library keeps."""
        lesson = self._log.complete
        return TrainedAutomaton(learn_automaton(lesson), lesson)

    def close(self) -> None:
        """Put everything on disk, and let go of the journal."""
        self._log.journal.close()

    def _trainee_state(self) -> TraineeState:
        return TraineeState(self.run_state, self.trainee.entry)

    def _turned(self) -> None:
        self._log.log_mode(self.mode, self.run_state, self._targets, self.trainee.press)

    def _keep_snapshot(self) -> None:
        if self._log.journal.path is not None and is_rewindable(self.body):
            self._log.journal.snapshot(self.body.snapshot(), self.run_state, self.mode)

    def _relink(self, trainee: Trainee) -> None:
        """Another trainee goes on where the one before is."""
        old, self.trainee = self.trainee, trainee
        trainee.restore(old.snapshot(self.body.time_s), now=self.body.time_s)
        trainee.keep(old.press, old.entry)
        self._run = self._new_run()
        if trainee.press is not old.press:
            self._turned()  # its state is gone

    def _new_trainee(self, lesson: Lesson, mode: Mode) -> Trainee:
        automaton = learn_automaton(lesson) if mode is Mode.TESTING else lesson.automaton
        library = self.library.with_automaton(TrainedAutomaton(automaton))
        bound = {name: target for name, target in self._targets.items() if name in automaton.parameters}
        return Trainee(link(library, automaton.name, bound), mode, now=self.body.time_s)

    def _new_run(self) -> Run:
        return self.other_agents.run(self.agent, self._driving or self.trainee)
