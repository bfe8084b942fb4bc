"""The session: one training of one automaton, by whoever presses (paper section 3.2).

    session = Session(body, library, lesson, targets={"A": "station"})
    session.direct("rotate_left")
    session.run_for(1.2)
    session.direct("forward")
    ...
    session.test()
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Self, Unpack

from understudy.errors import FileError, UnknownName
from understudy.learning.transitions import learned
from understudy.model.automaton import Automaton
from understudy.model.binding import Binding
from understudy.model.example import Example, ExampleKind
from understudy.model.feature import BoundFeature, Percept
from understudy.model.kinds import Categorical
from understudy.model.lesson import Lesson, Options
from understudy.model.library import Library, Taught
from understudy.runtime.body import Body, Rewindable, every_key
from understudy.runtime.interpreter import Interpreter, Level
from understudy.runtime.program import IDLE_PROGRAM, Program, link
from understudy.runtime.run import Run
from understudy.runtime.sensing import feature_column
from understudy.training.design import check_names
from understudy.training.edits import Choice, deleted, edited, rechosen
from understudy.training.journal import Accepted, Acted, Began, Journal, Pressed, Raised, Stepped, Turned, Went
from understudy.training.past import Past, difference, lesson_bytes
from understudy.training.recorder import Moment, compact
from understudy.training.screen import Screen
from understudy.training.trainee import Entry, Mode, Outcome, Press, Trainee
from understudy.training.values import own_readings, own_value, valued, values_of
from understudy.training.watching import Seen, Watching

Clock = Callable[[], float]


class Session:
    """One agent of a body being taught one automaton; the others idle, or run behaviors of the library.

    `targets` says what the automaton's parameters stand for while it is taught. `clock` is the demonstrator's time
    (the body's where there is none). Every step is on disk in the `journal` before it is acknowledged.
    """

    def __init__(
        self,
        body: Body,
        library: Library,
        lesson: Lesson,
        *,
        targets: Mapping[str, str] | None = None,
        agent: int = 0,
        clock: Clock | None = None,
        journal: Path | None = None,
        about: Mapping[str, str | int | float | bool] | None = None,
    ) -> None:
        past = Past.none(lesson, every_key(body), targets or {}, agent)
        self._begin(body, library, past, clock, Journal(journal))
        design = lesson_bytes(lesson)
        began = Began(design, agent, list(self._keys), body.tick_s, self._targets, dict(about or {}))
        self._journal.begin(began, rows=len(lesson.record))

    @classmethod
    def resume(cls, journal: Path, body: Body, library: Library, *, clock: Clock | None = None) -> Self:
        """Go on with a session that ended, however it ended: nothing acknowledged is lost.

        The lesson is as it was; body and automaton are as at the last snapshot, if the body can be rewound.
        """
        past = Past.replayed(journal, library)
        if past.recorder.keys != every_key(body):
            raise FileError(
                path=journal,
                place="its first entry",
                problem="the session was with a body that has other readings",
                remedy="resume it with the body it was with",
            )
        if past.body is not None and isinstance(body, Rewindable):
            body.restore(past.body)
        session = cls.__new__(cls)
        session._begin(body, library, past, clock, Journal.resumed(journal, ticks=past.ticks, rows=len(past.recorder.record)))
        return session

    def _begin(self, body: Body, library: Library, past: Past, clock: Clock | None, journal: Journal) -> None:
        self.body, self.library, self.agent = body, library, past.agent
        self.watching = True
        self.paused = False
        self._clock = clock or (lambda: body.time_s)
        self._keys = every_key(body)
        self._steady = frozenset(
            reading.name for reading in body.readings if isinstance(reading.kind, Categorical)
        )
        self._history, self._recorder, self._targets = past.history, past.recorder, past.targets
        self._presses, self._journal = past.presses, journal
        self._others: dict[int, Program] = {}
        self._driving: Program | None = None
        self._watched = Watching()
        self._percept: Percept | None = None
        check_names(library, self.automaton)
        self._trainee = self._new_trainee(learned_too=past.mode is Mode.TESTING)
        self._trainee.restore(past.run, now=body.time_s)
        self._trainee.mode, self._trainee.press = past.mode, past.waiting
        if past.raised is not None and self._trainee.taught.flag is not None:
            self._trainee.entry = past.raised.entry
        self._run = self._new_run()

    # What there is to see

    @property
    def lesson(self) -> Lesson:
        """The lesson as it stands, with its record."""
        return replace(self._plain, record=self._recorder.record)

    @property
    def _plain(self) -> Lesson:
        return self._history.lesson

    @property
    def automaton(self) -> Automaton:
        """What was chosen for the automaton under training, without transition functions."""
        return self._plain.automaton

    @property
    def mode(self) -> Mode:
        """Training: the demonstrator decides. Testing: what was learned decides."""
        return self._trainee.mode

    @property
    def examples(self) -> tuple[Example, ...]:
        """The lesson's examples, oldest first."""
        return self._plain.examples

    @property
    def path(self) -> tuple[str, ...]:
        """The current state of every level, from the automaton under training down."""
        return self._trainee.path

    @property
    def run_state(self) -> tuple[Level, ...]:
        """The run state of the automaton under training and those below."""
        return self._trainee.snapshot()

    @property
    def percept(self) -> Percept:
        """The snapshot on display: all readings, sensed once per tick."""
        if self._percept is None:
            self._percept = self.body.sense(self._keys)
        return self._percept

    def screen(self) -> Screen:
        """What a person sees now."""
        machine = self._trainee.taught
        own = own_readings(machine, self.body.time_s)
        features = {
            str(bound): own_value(bound.feature, own) if bound.own else self._sensed(bound)
            for bound in self.automaton.features
        }
        press = self._trainee.press
        return Screen(
            time_s=self.body.time_s,
            mode=self.mode,
            state=machine.state_name,
            path=self.path,
            flag=machine.flag,
            features=features,
            states=self.automaton.state_names,
            targets=dict(self._targets),
            waiting=None if press is None else press.state or machine.state_name,
            examples=sum(example.pressed for example in self.examples),
            undoable=self._history.undoable,
            redoable=self._history.redoable,
        )

    def _sensed(self, bound: BoundFeature) -> float:
        ground = BoundFeature(bound.feature, bound.binding.within(self._targets))
        return float(feature_column(ground, self.percept, agents=self.body.agents)[self.agent])

    # Pressing

    def direct(self, state: str) -> int:
        """Direct the robot to a state: acts at the next tick. In testing mode, a correction. The press's number."""
        self.automaton.index(state)
        return self._press(state)

    def confirm(self) -> int:
        """Keep doing this: acts at the next tick. The press's number."""
        return self._press(None)

    def _press(self, state: str | None) -> int:
        waiting = self._trainee.press
        correction = self.mode is Mode.TESTING or (waiting is not None and waiting.correction)
        press = Press(self._presses + 1, state, correction, self.paused)
        self._keep_snapshot()
        self._journal.flush()
        self._journal.write(Pressed(press), sync=True)
        self._presses += 1
        self._trainee.press = press
        self._trainee.mode = Mode.TRAINING
        return press.number

    def tick(self) -> None:
        """One tick: sense, decide, act, and record what a press showed."""
        percept = self.percept
        machine = self._trainee.taught
        moment = Moment(self._clock(), tuple(float(percept[key][self.agent]) for key in self._keys))
        self._recorder.remember(moment)
        if self._journal.wants_snapshot(self.body.tick_s):
            self._keep_snapshot()
        self._journal.remember(moment, machine.state_name)
        before = self._trainee.snapshot() if self._trainee.press else ()
        commands = self._run.decide(percept)
        if self._driving is None:
            self._record(self._trainee.outcome, moment, before)
        self.body.act(commands)
        self._percept = None

    def run_for(self, seconds: float) -> None:
        """Tick for so long of the body's time."""
        until = self.body.time_s + seconds - self.body.tick_s / 2
        while self.body.time_s < until:
            self.tick()

    def _record(self, outcome: Outcome, moment: Moment, before: tuple[Level, ...]) -> None:
        if outcome.raised:
            entry = Entry(outcome.state, outcome.own, *self._recorder.keep_press(paused=False))
            self._trainee.entry = entry
            self._journal.write(Raised(entry, self._journal.new_rows(self._recorder.record)))
        if outcome.press is None:
            self._see(outcome, moment)
            return
        options = self._plain.options
        self._watched.doubt(moment.seconds, reaction_s=options.reaction_s)
        self._accept_watched()
        if not outcome.shown:
            self._journal.write(Acted(outcome.press.number, list(self.run_state)))
            return
        row = self._recorder.keep_press(paused=outcome.press.paused)
        number = max((example.number for example in self.examples), default=0)
        made = []
        for shown in outcome.shown:
            number += 1
            at, window = row if shown.entry is None else (shown.entry.moment, shown.entry.window)
            made.append(
                self._example(
                    Example(
                        number,
                        shown.state,
                        (),
                        shown.next,
                        shown.kind,
                        correction=outcome.press.correction,
                        moment=at,
                        window=window,
                        own=shown.own,
                        binding=Binding(self._targets),
                    )
                )
            )
        lesson = self._plain
        what = f"{made[0].state} → {made[0].next}"
        after = replace(lesson, examples=(*lesson.examples, *made))
        self._step(what, after, before=before, press=outcome.press.number)

    def _example(self, example: Example) -> Example:
        values = values_of(example, self._plain, self._recorder.record, steady=self._steady)
        return replace(example, values=values)

    def _see(self, outcome: Outcome, moment: Moment) -> None:
        options, automaton = self._plain.options, self.automaton
        resting = outcome.state == outcome.next == automaton.states[0].name
        if not (options.watched and self.watching) or resting or automaton.state(outcome.state).flag is not None:
            return
        example = Example(
            0,
            outcome.state,
            (),
            outcome.next,
            ExampleKind.WATCHED,
            own=outcome.own,
            binding=Binding(self._targets),
        )
        self._watched.see(Seen(moment, example))

    def _accept_watched(self) -> None:
        watched = self._watched.accept(self._plain, self._recorder, steady=self._steady)
        if watched:
            self._history.amend(*watched)
            self._journal.write(Accepted(list(watched), self._journal.new_rows(self._recorder.record)))

    # Modes

    def test(self) -> None:
        """Switch to testing: learn from the lesson and restart the automaton."""
        self._accept_watched()
        self._relink(learned_too=True)
        self._trainee.mode = Mode.TESTING
        self.restart()

    def train(self) -> None:
        """Switch to training: the robot goes on with what it is doing until directed."""
        self._trainee.mode = Mode.TRAINING
        self._turned()

    def restart(self) -> None:
        """Start the automaton under training afresh; records nothing."""
        self._begin_episode()
        self._trainee.press = None
        self._trainee.start(self.body.time_s)
        self._turned()

    def drive(self, behavior: str | None, binding: Mapping[str, str] | None = None) -> None:
        """Drive the robot into position with a basic behavior, recording nothing; None ends it."""
        if behavior is not None and behavior not in self.library.kit.behaviors:
            raise UnknownName(
                what="basic behavior", name=behavior, where="the kit", known=list(self.library.kit.behaviors)
            )
        self._driving = None if behavior is None else link(self.library, behavior, binding or {})
        self._begin_episode()
        self._trainee.press = None
        self._run = self._new_run()

    def moved(self) -> None:
        """The robot or the world was put elsewhere by hand: what came before says nothing about now."""
        self._percept = None
        self._begin_episode()

    def _begin_episode(self) -> None:
        self._accept_watched()
        self._watched.begin_episode()
        self._recorder.begin_episode()

    def _turned(self) -> None:
        self._journal.write(Turned(self.mode, list(self.run_state), dict(self._targets)), sync=True)

    def _keep_snapshot(self) -> None:
        if isinstance(self.body, Rewindable):
            self._journal.snapshot(self.body.snapshot(), self.run_state, self.mode)

    # Changing the lesson

    def undo(self) -> str:
        """Take back the last step that changed the lesson; the world stays. What the step was."""
        return self._went(*self._history.undo(), back=True)

    def redo(self) -> str:
        """Do the last undone step again. What it was."""
        return self._went(*self._history.redo(), back=False)

    def _went(self, what: str, run: Sequence[Level], *, back: bool) -> str:
        self._journal.write(Went(back), sync=True)
        self._watched.forget()
        self._trainee.press = None
        self._relink(learned_too=self.mode is Mode.TESTING)
        self._trainee.restore(run, now=self.body.time_s)
        self._percept = None
        return what

    def delete(self, *numbers: int) -> None:
        """Delete examples by number."""
        self._change(f"delete {len(numbers)} example{'s' * (len(numbers) != 1)}", deleted(self._plain, numbers))

    def edit(
        self,
        number: int,
        *,
        state: str | None = None,
        next: str | None = None,
        values: Mapping[str, float] | None = None,
    ) -> None:
        """Edit an example: its state, its next state, or its values by feature label."""
        lesson = edited(self._plain, number, state=state, next=next, values=values or {})
        self._change(f"edit example {number}", lesson)

    def choose(self, **chosen: Unpack[Choice]) -> None:
        """Choose states, flags, features, parameters, statelessness or options anew; what is not given stays.

        Examples stay, with values computed again from the record; those of states that are gone are dropped.
        """
        lesson = rechosen(self._plain, self.library, chosen)
        self._change(f"choose {' and '.join(chosen)}", valued(lesson, self._recorder.record, steady=self._steady))

    def stand_for(self, **targets: str) -> None:
        """Let parameters stand for other targets from now on."""
        for parameter, target in targets.items():
            if parameter not in self.automaton.parameters:
                raise UnknownName(
                    what="parameter",
                    name=parameter,
                    where=f"automaton {self.automaton.name!r}",
                    known=self.automaton.parameters,
                )
            if target not in self.body.targets:
                raise UnknownName(what="target", name=target, where="the body", known=list(self.body.targets))
        self._begin_episode()
        self._targets |= targets
        self._relink(learned_too=self.mode is Mode.TESTING)
        self._turned()

    def others(self, behavior: str | None, binding: Mapping[str, str] | None = None) -> None:
        """What the other agents do meanwhile: idle (None), or a behavior of the library."""
        program = None if behavior is None else link(self.library, behavior, binding or {})
        self._others = {
            agent: program for agent in range(self.body.agents) if agent != self.agent and program is not None
        }
        self._run = self._new_run()

    def taught(self) -> Taught:
        """The automaton as learned from the lesson now, with the lesson: what a library keeps."""
        self._accept_watched()
        lesson = compact(self.lesson)
        return Taught(learned(lesson), lesson)

    def _change(self, what: str, lesson: Lesson) -> None:
        run = self._trainee.snapshot()
        self._step(what, lesson, before=run)
        self._relink(learned_too=self.mode is Mode.TESTING)

    def _step(self, what: str, lesson: Lesson, *, before: tuple[Level, ...], press: int | None = None) -> None:
        after = self._trainee.snapshot()
        design, different, gone = difference(self._plain, lesson)
        rows = self._journal.new_rows(self._recorder.record)
        self._journal.write(
            Stepped(what, press, design, different, gone, rows, list(before), list(after)), sync=press is None
        )
        self._history.step(what, lesson, before=before, after=after)

    # Running

    def _relink(self, *, learned_too: bool) -> None:
        old = self._trainee
        self._trainee = self._new_trainee(learned_too=learned_too)
        self._trainee.restore(old.snapshot(), now=self.body.time_s)
        self._trainee.mode, self._trainee.press, self._trainee.entry = old.mode, old.press, old.entry
        self._run = self._new_run()

    def _new_trainee(self, *, learned_too: bool) -> Trainee:
        lesson = self._plain
        automaton = learned(lesson) if learned_too else lesson.automaton
        library = self.library.with_taught(Taught(automaton))
        bound = {name: target for name, target in self._targets.items() if name in automaton.parameters}
        return Trainee(link(library, automaton.name, bound), now=self.body.time_s)

    def _new_run(self) -> Run:
        now = self.body.time_s
        interpreters = [
            Interpreter(self._others.get(agent, IDLE_PROGRAM), now=now) for agent in range(self.body.agents)
        ]
        interpreters[self.agent] = self._trainee if self._driving is None else Interpreter(self._driving, now=now)
        return Run(self.body, interpreters)

