"""Sessions: a person, or a program in place of one, trains an automaton (paper section 3.2).

session = Session(body, library, lesson, targets={"A": "station"})
session.direct("rotate_left")
session.test()
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import isfinite, isinf
from numbers import Real
from pathlib import Path
from typing import Self

from msgspec import UNSET

from understudy.errors import SessionError, SettingError, UnknownName
from understudy.learning.mislabels import CorrectionDiagnosis
from understudy.model.automaton import Automaton
from understudy.model.binding import Binding
from understudy.model.features import Percept
from understudy.model.lesson import Example, Lesson
from understudy.model.library import Library
from understudy.model.value_kinds import ABSENT
from understudy.runtime.body import Body, Resettable, list_reading_keys
from understudy.runtime.interpreter import Interpreter, StackFrame
from understudy.runtime.link import link
from understudy.runtime.run_loop import Run
from understudy.storage.append_log import JournalLock
from understudy.training.feature_values import (
    collect_own_values,
    compute_feature_values,
    list_steady_readings,
)
from understudy.training.journal import Journal, SessionStarted
from understudy.training.journal_replay import ReplayedSession, encode_journal_lesson
from understudy.training.lesson_design import check_binding_names, check_parameter_targets
from understudy.training.lesson_log import LessonLog, TraineeState
from understudy.training.other_agents import NO_SIMULATION, OtherAgents, SessionSnapshot, require_rewindable
from understudy.training.sample_buffer import Sample
from understudy.training.session_edits import EditableSession
from understudy.training.trainee import Mode, Press, SessionView, TickResult, choose_mode_after_press


class Session(EditableSession):
    """A training session of one automaton on one agent of a body; the other agents idle or run behaviors.

    Parameters
    ----------
    body
        The body whose agent is trained.
    library
        The behaviors that the automaton may use.
    lesson
        The lesson to begin or to continue; see `new_lesson`.
    targets
        The target of each parameter of the automaton while it is trained.
    agent
        Index of the agent that is trained.
    clock
        The demonstrator's time, s. None: the body's clock.
    journal
        Path of a new file to which every press is written before `direct` or `confirm` returns, from which
        `Session.resume` continues the session after any end. None: no journal.
    about
        What `Session.resume` finds again in the journal, such as the seed of the world.
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
        if journal is not None:  # encoding a long lesson takes longer than all else here
            encoded = encode_journal_lesson(lesson)
            began = SessionStarted.from_body(body, encoded, agent, self._targets, about or {})
            self._log.journal = Journal.create(journal, began, rows=len(lesson.record))

    @classmethod
    def resume(
        cls, journal: Path | str, body: Body, library: Library, *, clock: Callable[[], float] | None = None
    ) -> Self:
        """Resume a session from its journal, however it ended.

        No acknowledged press is lost. The lesson is as it was. Body and automaton are as at the last snapshot, if the
        body can be rewound and is one of the same world.

        Parameters
        ----------
        journal
            Path of the journal, which is continued.
        body
            A body like that of the session.
        library
            The behaviors that the automaton may use.
        clock
            The demonstrator's time, s. None: the body's clock.

        Returns
        -------
        Session
            The session, ready for the next tick.

        Raises
        ------
        FileError
            If the file is not a journal, or another session is writing it.
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
        goes_on = past.restore_body(body) and past.body_tick == past.ticks
        session = cls.__new__(cls)
        session._begin(body, library, past, clock)
        rows = len(past.recorder.record)
        session._log.journal = Journal.resume(journal, ticks=past.ticks, rows=rows, lock=lock)
        if goes_on:
            session._log.last_switch.restore(past.switch, Binding(past.targets))
        else:
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
        self._run, self._last_step = self._new_run(), None

    # What there is to see

    @property
    def lesson(self) -> Lesson:
        """The current lesson, with its record."""
        return self._log.complete

    @property
    def automaton(self) -> Automaton:
        """The automaton in training, without transition functions."""
        return self._log.lesson.automaton

    @property
    def examples(self) -> tuple[Example, ...]:
        """The examples of the lesson, oldest first."""
        return self._log.lesson.examples

    @property
    def mode(self) -> Mode:
        """The mode: who decides without a press, and whether a press teaches at once."""
        return self.trainee.mode

    @property
    def run_state(self) -> tuple[StackFrame, ...]:
        """The run state of the automaton in training and of those below it."""
        return self.trainee.snapshot(self.body.time_s)

    @property
    def percept(self) -> Percept:
        """The snapshot on display: all readings, sensed once per tick."""
        if self._percept is None:
            self._percept = self.body.sense(self._keys)
        return self._percept

    @property
    def correction_diagnosis(self) -> CorrectionDiagnosis | None:
        """The diagnosis of the last correction: which examples caused the wrong decision. None if there is none."""
        return self._log.correction_diagnosis

    @property
    def is_watching(self) -> bool:
        """Whether ticks without a press become watched examples, in a lesson that records them."""
        return self._log.is_watching

    @is_watching.setter
    def is_watching(self, watching: bool) -> None:
        self._log.is_watching = watching

    def view(self) -> SessionView:
        """Return what a person sees now.

        Returns
        -------
        SessionView
            Mode, state and path, values of the chosen features, targets, and what can be undone.
        """
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
        """Direct the robot to a state from the next tick on. In testing this is a correction. Ends driving.

        Parameters
        ----------
        state
            Name of the state.

        Returns
        -------
        int
            Number of the press.

        Raises
        ------
        UnknownState
            If the automaton has no such state.
        """
        self.automaton.index(state)
        return self._press(state)

    def confirm(self) -> int:
        """Confirm the current state, from the next tick on.

        Returns
        -------
        int
            Number of the press.
        """
        return self._press(None)

    def _press(self, state: str | None) -> int:
        if self._driving is not None:
            self.drive(None)
        waiting = self.trainee.press
        correction = self.mode is Mode.TESTING or (waiting is not None and waiting.correction)
        answers = self._log.find_answered_switch(self._sample(), state, self.trainee, paused=self.paused)
        press = Press(self._log.presses + 1, state, correction, self.paused, answers or UNSET)
        self._keep_snapshot()
        self._log.presses = self._log.journal.press(press)
        self.trainee.press = press
        self.trainee.mode = choose_mode_after_press(self.mode, self._log.lesson.options)
        return press.number

    def _sample(self) -> Sample:
        """Take the readings of the agent, as a lesson keeps them: what is infinite is absent."""
        values = (float(self.percept[key][self.agent]) for key in self._keys)
        return Sample(self._clock(), tuple(ABSENT if isinf(value) else value for value in values))

    def tick(self) -> None:
        """Run one tick: sense, decide, act, and record the examples of a press."""
        percept, trainee, moment = self.percept, self.trainee, self._sample()
        if self._log.journal.wants_snapshot(self.body.tick_s):
            self._keep_snapshot()
        self._log.add_tick(moment, trainee.taught.state_name)
        before = self._trainee_state() if trainee.press else None
        commands = self._run.decide(percept)
        if self._driving is None:
            self._write_down(trainee.result, moment, before)
        self.body.act(commands)
        self._percept = None

    def _write_down(self, result: TickResult, moment: Sample, before: TraineeState | None) -> None:
        binding = Binding(self._targets)
        if result.press is not None and before is not None:
            self._record_press(result, result.press, binding, before)
            return
        if result.raised:
            self.trainee.entry = self._log.log_flag(result)
        self._log.log_silence(result, moment, binding)

    def run_for(self, seconds: float) -> None:
        """Run for some time.

        Parameters
        ----------
        seconds
            The body's time to run, s; finite and at least 0. It is rounded to whole ticks.

        Raises
        ------
        SettingError
            If `seconds` is negative or not finite.
        """
        if not (isinstance(seconds, Real) and isfinite(seconds) and seconds >= 0):
            where, problem = f"session of {self.automaton.name!r}", f"are {seconds!r:.60}"
            remedy = "give a finite number, 0 or more"
            raise SettingError(where=where, setting="seconds", problem=problem, remedy=remedy)
        until = self.body.time_s + seconds - self.body.tick_s / 2
        while self.body.time_s < until:
            self.tick()

    # Modes

    def test(self, *, afresh: bool = True) -> None:
        """Switch to testing: learn from the lesson, and let the automaton decide, until the next press.

        Parameters
        ----------
        afresh
            Whether the automaton restarts. False: it continues in its current state.
        """
        self._log.accept_watched()
        self._relink(self._new_trainee(self._log.lesson, Mode.TESTING))
        (self.restart if afresh else self._turned)()

    def teach(self) -> None:
        """Switch to live teaching: the learned automaton decides, and learns at once from every press."""
        self._log.accept_watched()
        self._relink(self._try_trainee(Mode.LIVE))
        self._turned()

    def train(self) -> None:
        """Switch to training: the robot stays in its current state until it is directed."""
        self.trainee.mode = Mode.TRAINING
        self._turned()

    def restart(self) -> None:
        """Restart the automaton in training, and record nothing."""
        self._log.begin_episode()
        self.trainee.press = None
        self.trainee.start(self.body.time_s)
        self._turned()

    def reset(self, seed: int) -> None:
        """Begin the world of another seed and restart the automaton; record nothing.

        Parameters
        ----------
        seed
            Seed of the world, at least 0.
        """
        if not isinstance(self.body, Resettable):
            raise SessionError(f"this body cannot be reset: {NO_SIMULATION}")
        self.body.reset([seed])
        self._percept = None
        self.other_agents.start()
        self.restart()

    def capture(self) -> SessionSnapshot:
        """Capture the present moment of the run.

        Returns
        -------
        SessionSnapshot
            The moment, to be passed to `rewind`.

        Raises
        ------
        SessionError
            If the body cannot be rewound.
        """
        return SessionSnapshot(
            require_rewindable(self.body).snapshot(),
            self.run_state,
            self.mode,
            self.other_agents.snapshot(),
            self.trainee.entry,
        )

    def rewind(self, instant: SessionSnapshot) -> None:
        """Go back to a moment of this session: the world and all automata. The lesson stays as it is.

        Parameters
        ----------
        instant
            What `capture` returned.
        """
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
        """Drive the robot into position with a basic behavior, and record nothing.

        Parameters
        ----------
        behavior
            Name of the behavior. None ends driving.
        binding
            A target for each parameter of the behavior.
        """
        if behavior is not None and behavior not in (behaviors := self.library.kit.behaviors):
            raise UnknownName(what="basic behavior", name=behavior, where="the kit", known=list(behaviors))
        self._driving = None
        if behavior is not None:
            self._driving = Interpreter(link(self.library, behavior, binding or {}), now=self.body.time_s)
        self._log.begin_episode()
        self.trainee.press = None
        self._turned()
        self._run = self._new_run()

    def note_moved(self) -> None:
        """Note that the robot or the world was moved by hand, so that no press refers to what was sensed before."""
        self._percept = None
        self._log.begin_episode()

    def refresh_percept(self) -> None:
        """Sense again, after something changed between two ticks."""
        self._percept = None

    def bind_targets(self, **targets: str) -> None:
        """Bind parameters of the automaton to other targets from now on.

        Parameters
        ----------
        **targets
            The target of each parameter that changes.
        """
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
        """Set what the other agents do during training.

        Parameters
        ----------
        behavior
            Name of the behavior that they run. None: they idle.
        binding
            A target for each parameter of the behavior.
        library
            Library of the behavior. None: that of the session.
        """
        self.other_agents.set_behavior(behavior, binding, library=library)
        self._run = self._new_run()
        self._log.journal.write(self.other_agents.behavior_call)

    def close(self) -> None:
        """Write everything to disk, and release the journal."""
        self._log.journal.close()

    def _new_run(self) -> Run:
        return self.other_agents.run(self.agent, self._driving or self.trainee)
