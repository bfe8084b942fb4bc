"""The interpreter: the meaning of a pulse for one agent, in plain Python (docs/semantics.md, paper section 3.1).

Every other engine and every export must agree with this file, which is the definition. Real robots and sessions run
it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import floor, nan
from operator import itemgetter
from typing import TypeAlias

from understudy.model.automaton import Automaton
from understudy.model.drawing import format_repr
from understudy.model.features import CounterFeature, FlagFeature, OwnFeature, TimerFeature
from understudy.model.tree import STAY
from understudy.model.value_kinds import NO, YES
from understudy.runtime.link import Child, Instance, Program, ResetFeature, ValueSource

Row: TypeAlias = Sequence[float]
"""One agent's values of `Program.features`, in one snapshot."""

SwitchObserver: TypeAlias = "Callable[[RunningAutomaton, int, int, Sequence[float], float], None]"
"""Called when a transition function answers another state or STAY: machine, state, answer, values, time."""

DecideState: TypeAlias = Callable[[Sequence[float]], int]
QueryObserver: TypeAlias = "Callable[[RunningAutomaton, int, int, Sequence[float]], None]"
"""Called at every query: machine, state, answer, values."""


def measure_elapsed(now: float, since: float) -> float:
    """Return the seconds from one time to another, rounded so that equally many ticks always give the same number.

    Rounding is plain arithmetic that every engine and export can repeat bit for bit: to 1e-9 s, and to 1e-6 s from
    2**22 s on, where floats are too far apart for that, as on a clock that counts from 1970.
    """
    steps = 1e9 if now < 4194304.0 else 1e6
    return floor((now - since) * steps + 0.5) / steps


class RunningBehavior:
    """A running basic behavior: it raises no flags, and a pulse of it issues its command."""

    __slots__ = ("index",)
    flag: str | None = None

    def __init__(self, index: int) -> None:
        self.index = index

    def start(self, now: float) -> None:
        """Do nothing: counters and timers that its start changes belong to the automaton of the state."""

    def stop(self) -> None:
        """Do nothing: the next command replaces this one."""

    def pulse(self, row: Row, now: float) -> int:
        """Return the position of the basic behavior in `Program.basics`."""
        return self.index


class RunningAutomaton:
    """A running automaton: a ground instance with its current state, flag, counters and timers."""

    __slots__ = (
        "_children",
        "_decides",
        "_own",
        "_pick",
        "active",
        "counters",
        "entered",
        "flag",
        "instance",
        "state",
        "switch_observer",
        "timers",
    )

    def __init__(self, instance: Instance, machines: dict[Child, Running]) -> None:
        self.instance = instance
        self._children = [get_running(child, machines) for child in instance.children]
        transitions = instance.automaton.transitions
        self._decides = [
            transitions[state.name].decide if state.name in transitions else None
            for state in self.automaton.states
        ]
        self._pick = _picker(instance.sources)
        self._own = [
            (index, source.name if isinstance(source, FlagFeature) else None, source)
            for index, source in enumerate(instance.sources)
            if not isinstance(source, int)
        ]
        self.switch_observer: SwitchObserver | None = None
        self.counters: dict[str, float] = {}
        self.timers: dict[str, float] = {}
        self.start(0.0)

    def start(self, now: float) -> None:
        """Begin in the start state, with flags, counters and timers cleared."""
        self.state = 0
        self.active = self._children[0]
        self.entered = now
        self.flag: str | None = None
        self.counters.clear()
        self.timers.clear()

    def stop(self) -> None:
        """Stop the running behaviors, innermost first."""
        self.active.stop()
        self.active = self._children[0]

    def pulse(self, row: Row, now: float) -> int:
        """Run one tick: query, switch, pulse. Return the position in `Program.basics` of the basic behavior to run."""
        decide = self._decides[self.state]
        if decide is not None:
            values = self._pick(row) if not self._own else self.values(row, now)
            following = decide(values)
            if following != self.state:
                if self.switch_observer is not None:
                    self.switch_observer(self, self.state, following, values, now)
                if following != STAY:
                    self.switch(following, now)
        return self.active.pulse(row, now)

    def switch(self, following: int, now: float) -> None:
        """Stop the current state's behavior, then start the next one's. Entering a flag state raises its flag."""
        self.active.stop()
        self.state = following
        self.entered = now
        self.flag = self.automaton.states[following].flag
        self.active = self._children[following]
        self.active.start(now)
        for change in self.instance.changes[following]:
            memory = self.counters if change.of == "counter" else self.timers
            if change.action == "reset":
                memory.pop(change.name, None)
            elif change.action == "increment":
                memory[change.name] = memory.get(change.name, 0.0) + change.value
            else:
                memory[change.name] = change.value if change.of == "counter" else now

    def values(self, row: Row, now: float) -> Sequence[float]:
        """Return the feature vector: body readings from the snapshot, the automaton's own features as they are now."""
        values = list(self._pick(row))
        for index, flag, feature in self._own:  # flags first: most are, and a pulse must be quick
            if flag is None:
                values[index] = self.read_own_feature(feature, row, now)
            else:
                values[index] = YES if self.active.flag == flag else NO
        return values

    def read_own_feature(self, feature: ResetFeature | OwnFeature, row: Row, now: float) -> float:
        """Read a flag, a counter, a timer, the time in state, or a feature that a switch in this tick has reset."""
        if isinstance(feature, ResetFeature):
            return feature.fresh if self.entered == now else row[feature.position]
        if isinstance(feature, FlagFeature):
            return YES if self.active.flag == feature.name else NO
        if isinstance(feature, CounterFeature):
            return self.counters.get(feature.name, 0.0)
        if isinstance(feature, TimerFeature):
            return measure_elapsed(now, self.timers[feature.name]) if feature.name in self.timers else nan
        return measure_elapsed(now, self.entered)

    def observe_queries(self, observer: QueryObserver) -> None:
        """Call `observer` at every query from now on. Without an observer, queries cost no time for this."""
        self._decides = [
            None if decide is None else self._observe(state, decide, observer)
            for state, decide in enumerate(self._decides)
        ]

    def _observe(self, state: int, decide: DecideState, observer: QueryObserver) -> DecideState:
        def decided(values: Sequence[float]) -> int:
            following = decide(values)
            observer(self, state, following, values)
            return following

        return decided

    @property
    def automaton(self) -> Automaton:
        """The automaton that runs."""
        return self.instance.automaton

    @property
    def state_name(self) -> str:
        """The name of the current state."""
        return self.automaton.states[self.state].name


Running: TypeAlias = RunningAutomaton | RunningBehavior


def get_running(child: Child, machines: dict[Child, Running]) -> Running:
    """Get the running instance or basic behavior of a child; one object serves all its activations, one at a time."""
    if child not in machines:
        machines[child] = (
            RunningBehavior(child) if isinstance(child, int) else RunningAutomaton(child, machines)
        )
    return machines[child]


def _picker(sources: Sequence[ValueSource]) -> Callable[[Row], Sequence[float]]:
    """Make a function that picks the sources that are body readings from a row; others get an arbitrary value."""
    if not any(isinstance(source, int) for source in sources):
        blank = [nan] * len(sources)
        return lambda row: blank
    slots = [source if isinstance(source, int) else 0 for source in sources]
    return itemgetter(*slots) if len(slots) > 1 else itemgetter(slice(slots[0], slots[0] + 1))


@dataclass(frozen=True, slots=True)
class StackFrame:
    """One automaton of a run state: its current state and its memory.

    Times are stored as seconds ago, so that a run state can be restored at another reading of the body's clock.
    """

    automaton: str
    state: str
    time_in_state: float
    counters: dict[str, float] = field(default_factory=dict)
    timers: dict[str, float] = field(default_factory=dict)


class Interpreter:
    """One agent that runs a program.

    Parameters
    ----------
    program
        The program, as `link` makes it.
    now
        The body's time at the start, s.
    """

    def __init__(self, program: Program, *, now: float = 0.0) -> None:
        self.program = program
        self._machines: dict[Child, Running] = {}
        self.root = get_running(program.root, self._machines)
        self.start(now)

    def __repr__(self) -> str:
        return format_repr(self, f"in {' > '.join(self.path) or 'a basic behavior'}")

    def start(self, now: float) -> None:
        """Start the root again from its beginning.

        Parameters
        ----------
        now
            The body's time, s.
        """
        self.root.stop()
        self.root.start(now)
        self._started = now

    def pulse(self, row: Row, now: float) -> int:
        """Run one tick.

        Parameters
        ----------
        row
            Values of `program.features`, NaN where absent.
        now
            The body's time, s.

        Returns
        -------
        int
            Position in `Program.basics` of the basic behavior to run.
        """
        return self.root.pulse(row, now)

    def observe_switches(self, switch_observer: SwitchObserver | None) -> None:
        """Call a function before every switch of any level.

        Parameters
        ----------
        switch_observer
            The function; it gets the running automaton and the index of the next state. None: call nothing.
        """
        for machine in self._machines.values():
            if isinstance(machine, RunningAutomaton):
                machine.switch_observer = switch_observer

    def observe_queries(self, observer: QueryObserver) -> None:
        """Call a function at every query of any level from now on.

        Parameters
        ----------
        observer
            The function; it gets the running automaton, its feature vector and the decision.
        """
        for machine in self._machines.values():
            if isinstance(machine, RunningAutomaton):
                machine.observe_queries(observer)

    @property
    def active(self) -> tuple[RunningAutomaton, ...]:
        """The running automata, from the root down."""
        machines = []
        machine = self.root
        while isinstance(machine, RunningAutomaton):
            machines.append(machine)
            machine = machine.active
        return tuple(machines)

    @property
    def behavior_start_s(self) -> float:
        """The body's time at which the running basic behavior was started, s."""
        active = self.active
        return active[-1].entered if active else self._started

    @property
    def path(self) -> tuple[str, ...]:
        """The current state of every level, from the root down."""
        return tuple(machine.state_name for machine in self.active)

    def snapshot(self, now: float) -> tuple[StackFrame, ...]:
        """Return the run state of every active level, as plain values.

        Parameters
        ----------
        now
            The body's time, s.

        Returns
        -------
        tuple
            A `StackFrame` per level, from the root down.
        """
        return tuple(
            StackFrame(
                machine.automaton.name,
                machine.state_name,
                measure_elapsed(now, machine.entered),
                dict(machine.counters),
                {timer: measure_elapsed(now, since) for timer, since in machine.timers.items()},
            )
            for machine in self.active
        )

    def restore(self, levels: Sequence[StackFrame], *, now: float, entered: float | None = None) -> None:
        """Go back to a run state, as far down as its states still exist, and start what lies below.

        Parameters
        ----------
        levels
            What `snapshot` returned.
        now
            The body's time, s.
        entered
            When a root that is a basic behavior was started, s. None: now.
        """
        self.start(now)
        self._started = now if entered is None else entered
        machine = self.root
        for level in levels:
            if not isinstance(machine, RunningAutomaton) or machine.automaton.name != level.automaton:
                return
            if level.state not in machine.automaton.state_names:
                return
            machine.switch(machine.automaton.index(level.state), now)
            machine.entered = now - level.time_in_state
            machine.counters = dict(level.counters)
            machine.timers = {timer: now - seconds for timer, seconds in level.timers.items()}
            machine = machine.active
