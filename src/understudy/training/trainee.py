"""The trainee: the agent in training, pulsed by the semantics of presses (docs/semantics.md).

A press replaces step 1 of the automaton in training. Without a press, step 1 returns the current state in training
mode, and asks the learned transition functions in testing and in live teaching. This module decides what a press
records, and hands it to the session.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum

from msgspec import UNSET, UnsetType

from understudy.errors import SessionError
from understudy.model.automaton import name_next_state
from understudy.model.features import Percept
from understudy.model.learner_options import LearnerOptions
from understudy.model.lesson import ExampleKind
from understudy.runtime.body import Body
from understudy.runtime.feature_columns import FeatureColumns
from understudy.runtime.interpreter import Interpreter, Row, RunningAutomaton
from understudy.runtime.link import Program
from understudy.training.feature_values import collect_own_values


class Mode(StrEnum):
    """The mode of a session.

    "training": the demonstrator decides. "testing": the learned automaton decides until the next press. "live": the
    learned automaton decides, and learns from every press.
    """

    TRAINING = "training"
    TESTING = "testing"
    LIVE = "live"


def choose_teaching_mode(options: LearnerOptions) -> Mode:
    """Return the mode in which a lesson with these options is taught."""
    return Mode.LIVE if options.live else Mode.TRAINING


def choose_mode_after_press(mode: Mode, options: LearnerOptions) -> Mode:
    """Return the mode after a press, which ends testing."""
    return choose_teaching_mode(options) if mode is Mode.TESTING else mode


@dataclass(frozen=True, slots=True)
class OwnSwitch:
    """A switch that the learned automaton decided: the states before and after it, and the readings that it used."""

    state: str
    next: str
    own: Mapping[str, float]
    seconds: float
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Press:
    """A press that directs to `state`, or confirms the current state (None). It takes effect at the next tick.

    `answers` is the recent switch of the learned automaton that a press in live teaching judges.
    """

    number: int
    state: str | None
    correction: bool = False
    paused: bool = False
    answers: OwnSwitch | UnsetType = UNSET


@dataclass(frozen=True, slots=True)
class FlagEntry:
    """The tick at which the learned automaton raised a flag: the state it left, its own readings, the row."""

    state: str
    own: Mapping[str, float]
    moment: int


@dataclass(frozen=True, slots=True)
class PressExample:
    """One example that a press made, at this tick or at the tick at which a flag was raised."""

    state: str
    next: str
    kind: ExampleKind
    own: Mapping[str, float]
    entry: FlagEntry | None = None  # where it belongs, if not to this tick


@dataclass(slots=True)
class TickResult:
    """The result of one tick of the trainee: states before and after, and the examples of a press.

    `correction` says that the learned automaton decides otherwise than the press. `leaves_directed_flag` says that a
    press in live teaching led out of a flag state to which an earlier press had led.
    """

    state: str
    next: str
    own: Mapping[str, float]
    press: Press | None = None
    examples: list[PressExample] = field(default_factory=list)
    raised: bool = False  # it decided by itself to enter a flag state
    correction: bool = False
    leaves_directed_flag: bool = False


class Trainee(Interpreter):
    """An interpreter whose root automaton is in training."""

    def __init__(self, program: Program, mode: Mode, *, now: float) -> None:
        super().__init__(program, now=now)
        if not isinstance(self.root, RunningAutomaton):
            raise SessionError("only an automaton can be taught, not a basic behavior")
        self.taught: RunningAutomaton = self.root
        self.mode = mode
        self.press: Press | None = None
        self.entry: FlagEntry | None = None
        self.result = TickResult("", "", {})

    def start(self, now: float) -> None:
        """Start the root again."""
        super().start(now)
        self.entry = None

    def keep(self, press: Press | None, entry: FlagEntry | None) -> None:
        """Take over a waiting press and the place where a flag was raised, if their states still exist."""
        automaton = self.taught.automaton
        lasting = [state.name for state in automaton.states if state.flag is None]
        if press is not None and press.state in (None, *automaton.state_names):
            is_gone = isinstance(press.answers, OwnSwitch) and press.answers.state not in lasting
            self.press = replace(press, answers=UNSET) if is_gone else press
        if entry is not None and entry.state in lasting and self.taught.flag is not None:
            self.entry = entry

    def pulse(self, row: Row, now: float) -> int:
        """Run one tick, decided by a press, by the mode, or by the learned automaton; see `result`."""
        machine, states = self.taught, self.taught.automaton.state_names
        before, own = machine.state_name, collect_own_values(machine, now)
        press, self.press = self.press, None
        result = TickResult(before, before, own, press)
        if press is not None:
            result.correction = press.correction or (
                self.mode is Mode.LIVE and self._decides_otherwise(press, row, now)
            )
            self._obey(press, result, now)
            basic = machine.active.pulse(row, now)
        elif self.mode is Mode.TRAINING:
            basic = machine.active.pulse(row, now)
        else:
            basic = machine.pulse(row, now)
            result.next = states[machine.state]
            result.raised = machine.flag is not None and result.next != before
        self.result = result
        return basic

    def list_queries(
        self, percept: Percept, body: Body, agent: int
    ) -> tuple[tuple[RunningAutomaton, Row], ...]:
        """List the running automata, from the one in training down, each with the feature vector of a query now."""
        row = FeatureColumns(self.program.features, body).columns(percept)[:, agent].tolist()
        return tuple((machine, machine.values(row, body.time_s)) for machine in self.active)

    def _decides_otherwise(self, press: Press, row: Row, now: float) -> bool:
        """Return whether the learned automaton decides otherwise than a press; not where nothing was taught."""
        machine = self.taught
        here = machine.state_name
        wanted = press.state if press.state is not None else here
        if isinstance(press.answers, OwnSwitch) or machine.flag is not None:
            return wanted != here and (machine.flag is None or self.entry is not None)
        transition = machine.automaton.transitions.get(here)
        if transition is None:
            return False
        decided = transition.decide(machine.values(row, now))
        return name_next_state(machine.automaton, here, decided) != wanted

    def _obey(self, press: Press, result: TickResult, now: float) -> None:
        machine, automaton = self.taught, self.taught.automaton
        before = machine.state_name
        after = press.state if press.state is not None else before
        result.next = after
        if automaton.state(before).flag is not None:
            self._obey_at_flag(press, after, result, now)
        elif isinstance(press.answers, OwnSwitch):
            self._obey_after_switch(press.answers, after, result, now)
        elif after == before:
            result.examples.append(PressExample(before, before, ExampleKind.CONFIRMATION, result.own))
        else:
            result.examples.append(PressExample(before, after, ExampleKind.DIRECTIVE, result.own))
            self._switch(after, now)
            if automaton.state(after).flag is None:
                result.examples.append(
                    PressExample(after, after, ExampleKind.DEFAULT, collect_own_values(machine, now))
                )

    def _obey_after_switch(self, switch: OwnSwitch, after: str, result: TickResult, now: float) -> None:
        """Record what the learned automaton should have decided when it switched, and go to the wanted state."""
        machine = self.taught
        kind = ExampleKind.CONFIRMATION if after == switch.state else ExampleKind.DIRECTIVE
        result.examples.append(PressExample(switch.state, after, kind, switch.own))
        self._switch(after, now)
        if kind is ExampleKind.DIRECTIVE and machine.flag is None:
            own = collect_own_values(machine, now)
            result.examples.append(PressExample(after, after, ExampleKind.DEFAULT, own))

    def _obey_at_flag(self, press: Press, after: str, result: TickResult, now: float) -> None:
        """Correct a flag, at the tick at which the learned automaton raised it."""
        flagged = self.taught.state_name
        if (press.correction or self.mode is Mode.LIVE) and self.entry is not None:
            state = self.entry.state
            kind = ExampleKind.CONFIRMATION if after == state else ExampleKind.DIRECTIVE
            result.examples.append(PressExample(state, after, kind, self.entry.own, self.entry))
        elif self.mode is Mode.LIVE and after != flagged:
            result.leaves_directed_flag = True
        if after != flagged:
            self._switch(after, now)

    def _switch(self, after: str, now: float) -> None:
        self.taught.switch(self.taught.automaton.index(after), now)
        self.entry = None


@dataclass(frozen=True, slots=True)
class SessionView:
    """One moment of a session as a person sees it.

    `features` has the present value of each chosen feature by its label ("distance_to(A)"); absent is NaN, a
    categorical value is its label's index. `path` is the current state of every level; `flag` is the flag that the
    automaton in training has raised.
    """

    time_s: float
    mode: Mode
    state: str
    path: tuple[str, ...]
    flag: str | None
    features: Mapping[str, float]
    states: tuple[str, ...]
    targets: Mapping[str, str]
    waiting: str | None  # the state of a press that acts at the next tick
    examples: int
    undoable: str | None
    redoable: str | None
