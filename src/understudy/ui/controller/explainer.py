"""Explanations in words: the present decision, and the last switch that the automaton made by itself."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from understudy.judging.explain_run import DecisionReason, LevelExplanation, explain_query
from understudy.judging.explanation_text import (
    describe_intention,
    describe_present,
    describe_switch,
    list_examples,
)
from understudy.judging.tracing import TransitionQuery
from understudy.learning.explain import Explanation, explain
from understudy.learning.fit import learn
from understudy.model.automaton import Transition
from understudy.model.describe import describe_transitions
from understudy.model.lesson import Lesson
from understudy.model.library import TrainedAutomaton
from understudy.model.tree import STAY
from understudy.runtime.interpreter import Interpreter, RunningAutomaton
from understudy.training.session import Session
from understudy.training.trainee import Mode, SessionView

MOST_SWITCHES = 1_000


@dataclass(frozen=True, slots=True)
class SwitchEvent:
    """A switch that a learned automaton made, on any level; `call` is the automaton with its targets."""

    automaton: str
    call: str
    before: str
    after: str
    query: TransitionQuery

    @property
    def time_s(self) -> float:
        """The time of the switch on the world's clock, s."""
        return self.query.time_s


class DecisionExplainer:
    """Explains the decisions of one session; the lesson is learned again only when it changed."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._for: tuple[object, ...] = ()
        self._lesson: Lesson = session.lesson
        self._transitions: dict[str, Transition] = {}
        self._switches: deque[SwitchEvent] = deque(maxlen=MOST_SWITCHES)
        self._followed: Interpreter | None = None

    def observe_next_tick(self) -> None:
        """Record the switches of the next tick, on all levels."""
        trainee = self._session.trainee
        if self._followed is not trainee:  # the lesson changed, or what it stands for
            self._followed = trainee
            trainee.observe_switches(self._see)

    def _see(
        self, machine: RunningAutomaton, state: int, answer: int, values: Sequence[float], now: float
    ) -> None:
        if answer != STAY:
            names = machine.automaton.state_names
            query = TransitionQuery(now, state, answer, tuple(values))
            call = str(machine.instance)
            self._switches.append(
                SwitchEvent(machine.automaton.name, call, names[state], names[answer], query)
            )

    @property
    def last_switch(self) -> SwitchEvent | None:
        """The last switch of the automaton in training."""
        name = self._session.automaton.name
        return next((each for each in reversed(self._switches) if each.automaton == name), None)

    def clear(self) -> None:
        """Forget all switches."""
        self._switches.clear()

    def list_switches_before(self, time_s: float) -> list[SwitchEvent]:
        """List the switches of this run before a time of the world, for `restore_switches` after a rewind."""
        return [each for each in self._switches if each.time_s < time_s]

    def restore_switches(self, switches: Sequence[SwitchEvent]) -> None:
        """Set the switches of this run so far."""
        self._switches = deque(switches, MOST_SWITCHES)

    def learn_lesson(self) -> tuple[Lesson, Mapping[str, Transition]]:
        """Return the current lesson and what is learned from it; both are the same objects until the lesson changes."""
        session = self._session
        key = (session.examples, session.automaton)
        if not self._for or any(new is not old for new, old in zip(key, self._for, strict=True)):
            self._for, self._lesson = key, session.lesson
            self._transitions = dict(learn(self._lesson))
        return self._lesson, self._transitions

    def explain_decision(self, state: str, values: Sequence[float]) -> Explanation:
        """Explain what the current lesson decides in a state for a feature vector."""
        self.learn_lesson()
        return explain(self._lesson, state, values, self._transitions.get(state))

    def describe_rules(self) -> list[tuple[str, str]]:
        """Describe the learned rules: pairs of a state and a condition on which it is left."""
        taught = self._taught(self.learn_lesson()[0].automaton.name)
        rules = describe_transitions(taught.automaton, taught.lesson)
        return [(state, line) for state, lines in rules.items() for line in lines]

    def explain_levels(self) -> tuple[LevelExplanation, ...]:
        """Explain the present decision of every level, from the automaton in training down."""
        session = self._session
        queries = session.trainee.list_queries(session.percept, session.body, session.agent)
        return tuple(self._level(machine, tuple(values)) for machine, values in queries)

    def _level(self, machine: RunningAutomaton, values: tuple[float, ...]) -> LevelExplanation:
        name, call = machine.automaton.name, str(machine.instance)
        decision = None
        if machine.flag is None:
            query = TransitionQuery(self._session.body.time_s, machine.state, machine.state, values)
            decision = explain_query(call, query, self._taught(name))
        return LevelExplanation(call, machine.state_name, machine.entered, decision, None, machine.flag)

    def explain_last_switch(self) -> tuple[SwitchEvent, DecisionReason] | None:
        """Explain the last switch of any level; of several in one tick, that of the highest level."""
        if not self._switches:
            return None
        latest = self._switches[-1].time_s
        switch = next(each for each in self._switches if each.time_s == latest)
        if switch.before not in self._taught(switch.automaton).automaton.state_names:
            return None  # the states were replaced
        return switch, explain_query(switch.call, switch.query, self._taught(switch.automaton))

    def _taught(self, name: str) -> TrainedAutomaton:
        lesson, transitions = self.learn_lesson()
        if name == lesson.automaton.name:
            return TrainedAutomaton(replace(lesson.automaton, transitions=transitions), lesson)
        return self._session.library.taught[name]

    def format_lines(self, view: SessionView) -> list[str]:
        """Format the explanation as sentences."""
        values = tuple(view.features.values())
        now = self.explain_decision(view.state, values) if view.flag is None else None
        if view.mode is Mode.TRAINING:
            lines = ["In training, you decide.", describe_intention(now)]
        else:
            lines = [describe_present(now, view.flag)]
        if self.last_switch is not None:
            was = self.explain_decision(self.last_switch.before, self.last_switch.query.values)
            text = describe_switch(was.state, self.last_switch.after, was, list_examples(was))
            lines.append(f"{view.time_s - self.last_switch.time_s:.1f} s ago it {text}.")
        return lines
