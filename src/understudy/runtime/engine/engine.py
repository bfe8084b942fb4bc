"""The engine: N agents that run compiled programs, exactly as interpreters would (docs/semantics.md)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any, Protocol, Self, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError, SettingError
from understudy.model.drawing import format_number_of, format_repr
from understudy.model.features import Percept
from understudy.model.value_kinds import Column
from understudy.runtime.body import ORDER, SKILL, Body, Fused, FusedPlan
from understudy.runtime.command_columns import CommandColumns
from understudy.runtime.engine import _pulse_kernels
from understudy.runtime.engine.compiler import PythonTransition, StateSlot, compile_programs
from understudy.runtime.engine.tables import Stacks
from understudy.runtime.feature_columns import FeatureColumns, get_body_feature, get_feature_key
from understudy.runtime.interpreter import StackFrame, measure_elapsed
from understudy.runtime.link import IDLING, Program

Ints = NDArray[np.int32]


@runtime_checkable
class BatchTransition(Protocol):
    """A transition function that decides for many agents at once, for each as it would alone."""

    def decide_all(self, values: NDArray[np.float64], /) -> Sequence[int] | NDArray[Any]:
        """Return the index of the next state, or STAY, for each of n feature vectors [n, F]."""
        ...


def query_python_transition(
    query: PythonTransition, values: NDArray[np.float64], *, place: StateSlot, agents: Ints
) -> Ints:
    """Call a transition function, and return the number of the next state (or STAY) for each feature vector [n, F]."""
    transition = query.transition
    if isinstance(transition, BatchTransition):
        answered = np.asarray(transition.decide_all(values))
    else:
        answered = np.array([transition.decide(row) for row in values.tolist()])
    valid = np.arange(-1, query.states)
    wrong = np.flatnonzero(~np.isin(answered, valid))
    if answered.shape != agents.shape or len(wrong):
        answer = (
            f"{answered[wrong[0]]} for agent {agents[wrong[0]]}"
            if len(wrong)
            else f"{answered.shape} answers"
        )
        raise DefinitionError(
            what=f"automaton {place.automaton!r}, state {place.state!r}",
            problem=f"its transition function answered {answer}",
            remedy=f"it has to answer a state, from 0 to {query.states - 1}, or -1 to stay",
        )
    return np.where(answered < 0, -1, answered + query.first).astype(np.int32)


Each: TypeAlias = Callable[[Callable[[tuple[int, int]], Any], Iterable[tuple[int, int]]], Iterable[Any]]
"""A function like `map`, possibly with threads, that calls a function for each range of agents, `first` to `stop`."""


class Engine:
    """A body whose agents each run a program: the compiled counterpart of `Run`.

    `running` [N] is the position in `compiled.basics` of the basic behavior of each agent at the last tick. `slow`
    names the states, as automaton/state, whose transition functions are not trees and are called in Python.

    Parameters
    ----------
    body
        The body.
    programs
        The program of each agent.
    others
        Further programs, which agents may `begin` later.
    """

    def __init__(self, body: Body, programs: Sequence[Program], others: Sequence[Program] = ()) -> None:
        if len(programs) != body.agents:
            raise _wrong("programs", f"are {len(programs)} for {body.agents} agents", "give one per agent")
        self.body = body
        self.compiled = compile_programs([*programs, *others])
        self._roots = dict(zip(map(id, [*programs, *others]), self.compiled.roots.tolist(), strict=True))
        self._programs = [*programs, *others]  # kept, so that no other gets their identity
        self.stacks = self.compiled.stacks(body.agents)
        self.running = np.full(body.agents, IDLING, np.int32)
        self.slow = tuple(
            dict.fromkeys(str(self.compiled.places[state]) for state in self.compiled.python_transitions)
        )
        self._sensing = FeatureColumns(self.compiled.features, body)
        self._acting = CommandColumns(self.compiled.basics, body)
        self.keys = tuple(dict.fromkeys((*self._sensing.keys, *self._acting.keys)))
        self._channels = tuple(channel.name for channel in body.channels)
        self.restart()

    def __repr__(self) -> str:
        agents, body = format_number_of(self.body.agents, "agent"), type(self.body).__name__
        return format_repr(self, f"of {agents}", f"on a {body}", f"at {self.body.time_s:.1f} s")

    @classmethod
    def from_program(cls, body: Body, program: Program) -> Self:
        """Make an engine in which every agent runs the same program.

        Parameters
        ----------
        body
            The body.
        program
            The program, as `link` makes it.

        Returns
        -------
        Engine
            The engine, before its first tick.
        """
        return cls(body, [program] * body.agents)

    def restart(self, agents: Sequence[int] | NDArray[np.intp] | None = None) -> None:
        """Start the roots of agents again from their beginning.

        Parameters
        ----------
        agents
            Indices of the agents. None: all.
        """
        chosen = np.zeros(self.body.agents, np.bool_)
        chosen[slice(None) if agents is None else list(agents)] = True
        _pulse_kernels.start_agents(chosen, float(self.body.time_s), self.compiled.tables, self.stacks)
        self.running[chosen] = IDLING

    def begin(self, agents: Sequence[int] | NDArray[np.intp], program: Program) -> None:
        """Let agents begin a program.

        Parameters
        ----------
        agents
            Indices of the agents.
        program
            One of the programs that the engine was made with.
        """
        if id(program) not in self._roots:
            raise _wrong("program", "is not a behavior of the engine", "make the engine with it")
        self.stacks.root[agents] = self._roots[id(program)]
        self.restart(agents)

    def root_of(self, program: Program) -> int:
        """Return the value of `Stacks.root` for a program.

        Parameters
        ----------
        program
            One of the programs that the engine was made with.

        Returns
        -------
        int
            The number of the root instance, or -1 minus that of the basic behavior.
        """
        return int(self._roots[id(program)])

    @property
    def orders(self) -> NDArray[np.int64]:
        """The number of the order that each basic behavior of a coordinator gives [B]."""
        return self._acting.table[:, self._acting.channels.index(ORDER)].astype(np.int64)

    def find_raised(self, flag: str) -> NDArray[np.bool_]:
        """Find the agents whose root has raised a flag.

        Parameters
        ----------
        flag
            Name of the flag.

        Returns
        -------
        array
            True for each such agent [N].
        """
        raised = np.zeros(self.body.agents, np.bool_)
        runs = self.stacks.root >= 0
        number = self.compiled.flags.get(flag, -2)
        raised[runs] = self.compiled.tables.states["flag"][self.stacks.state[runs, 0]] == number
        return raised

    def _entered(self) -> Column:
        """Return when each agent started its basic behavior: lower levels are entered later than those above."""
        entered: Column = self.stacks.entered.max(axis=1)
        return entered

    def run(self, ticks: int, *, threads: int | None = None) -> None:
        """Run ticks: all at once if the body can and the programs are data, otherwise one by one.

        The result is the same with any number of threads.

        Parameters
        ----------
        ticks
            The number of ticks.
        threads
            The largest number of threads. None: the body chooses.
        """
        if threads is not None and threads < 1:
            raise _wrong("threads", f"are {threads}", "give at least 1, or None")
        plan = self.plan()
        if plan is not None and isinstance(self.body, Fused):
            self.body.advance(plan, ticks, threads)
        elif threads is None or threads == 1:
            for _ in range(ticks):
                self.tick()
        else:
            with ThreadPoolExecutor(threads) as pool:
                for _ in range(ticks):
                    self._tick(pool.map, parts=threads)

    def plan(self) -> FusedPlan | None:
        """Make what a body needs to run many ticks by itself.

        Returns
        -------
        FusedPlan
            The plan. None if some part of the programs is a Python function.
        """
        features = [get_body_feature(bound) for bound in self.compiled.features]
        by_itself = SKILL not in self._channels  # skills are carried out in Python
        if not by_itself or self.slow or self._acting.computed or any(each.function for each in features):
            return None
        keys = tuple(get_feature_key(bound) for bound in self.compiled.features)
        return FusedPlan(self.compiled.tables, self.stacks, keys, self._acting.table, self.running)

    def tick(self) -> None:
        """Sense, decide and act once."""
        self._tick(map, parts=1)

    def decide(self, percept: Percept) -> dict[str, Column]:
        """Pulse every agent on one snapshot.

        Parameters
        ----------
        percept
            A column [N] for each key that the programs read.

        Returns
        -------
        dict
            A column [N] of commands for each channel.
        """
        return self._decide(percept, map, parts=1)

    def _tick(self, each: Each, *, parts: int) -> None:
        self.body.act(self._decide(self.body.sense(self.keys), each, parts=parts))

    def _decide(self, percept: Percept, each: Each, *, parts: int) -> dict[str, Column]:
        columns, now = self._sensing.columns(percept), float(self.body.time_s)
        cuts = np.linspace(0, self.body.agents, parts + 1).astype(int).tolist()

        def pulse(part: tuple[int, int]) -> None:
            _pulse_kernels.pulse_agents(columns, now, self.compiled.tables, self.stacks, self.running, *part)

        list(each(pulse, pairwise(cuts)))
        if self.slow:
            self._ask(columns, now)
        return dict(
            zip(self._channels, self._acting.commands(self.running, percept, self._entered), strict=True)
        )

    def _ask(self, columns: NDArray[np.float64], now: float) -> None:
        """Call the transition functions that agents wait for, state by state, and resume these agents."""
        tables, stacks, running = self.compiled.tables, self.stacks, self.running
        while len(waiting := np.flatnonzero(running < 0).astype(np.int32)):
            states = stacks.state[waiting, -1 - running[waiting]]
            for state in np.unique(states).tolist():
                query, agents = self.compiled.python_transitions[state], waiting[states == state]
                values = np.empty((len(agents), len(query.sources)))
                _pulse_kernels.gather_feature_vectors(
                    agents, running, query.sources, columns, now, tables, stacks, values
                )
                try:
                    following = query_python_transition(
                        query, values, place=self.compiled.places[state], agents=agents
                    )
                except BaseException:
                    running[running < 0] = IDLING  # they wait no longer
                    raise
                _pulse_kernels.resume_agents(agents, following, columns, now, tables, stacks, running)

    def read_decisions(self, agents: Sequence[int]) -> list[tuple[StateSlot, tuple[float, ...]]]:
        """Read what the automata at the roots of agents decide on in the next tick.

        Parameters
        ----------
        agents
            Indices of the agents, whose roots are automata.

        Returns
        -------
        list
            The state of each, and its present feature vector; NaN where absent.
        """
        columns, now = self._sensing.columns(self.body.sense(self.keys)), float(self.body.time_s)
        at_root = np.full(self.body.agents, -1, np.int32)
        decisions = []
        for agent in agents:
            place = self.compiled.places[self.stacks.state[agent, 0]]
            values, rows = np.empty((1, len(place.sources))), np.array([agent], np.int32)
            _pulse_kernels.gather_feature_vectors(
                rows, at_root, place.sources, columns, now, self.compiled.tables, self.stacks, values
            )
            decisions.append((place, tuple(values[0].tolist())))
        return decisions

    def path(self, agent: int) -> tuple[str, ...]:
        """Return what an agent is doing.

        Parameters
        ----------
        agent
            Index of the agent.

        Returns
        -------
        tuple
            The current state of every level, from the root down.
        """
        return tuple(place.state for place, _ in self._active(agent))

    def levels(self, agent: int) -> tuple[StackFrame, ...]:
        """Return the run state of every active level of an agent, as plain values.

        Parameters
        ----------
        agent
            Index of the agent.

        Returns
        -------
        tuple
            A `StackFrame` per level, from the root down.
        """
        now, memory = self.body.time_s, self.stacks.memory[agent].tolist()
        levels = []
        for place, entered in self._active(agent):
            variables = [(of, name, memory[slot]) for (of, name), slot in place.memory.items()]
            variables = [each for each in variables if each[2] == each[2]]
            counters = {name: value for of, name, value in variables if of == "counter"}
            timers = {name: measure_elapsed(now, value) for of, name, value in variables if of == "timer"}
            levels.append(
                StackFrame(place.automaton, place.state, measure_elapsed(now, entered), counters, timers)
            )
        return tuple(levels)

    def _active(self, agent: int) -> list[tuple[StateSlot, float]]:
        """List the states of an agent and when they were entered, level by level."""
        child = int(self.stacks.root[agent])
        states, times = self.stacks.state[agent].tolist(), self.stacks.entered[agent].tolist()
        active: list[tuple[StateSlot, float]] = []
        while child >= 0:
            state = states[len(active)]
            child = int(self.compiled.tables.states["child"][state])
            active.append((self.compiled.places[state], times[len(active)]))
        return active

    def snapshot(self) -> Stacks:
        """Return the run states of all agents, with times of the body's clock.

        Returns
        -------
        Stacks
            The run states, to be passed to `restore`.
        """
        return self.stacks.copy()

    def restore(self, snapshot: Stacks) -> None:
        """Go back to a snapshot.

        Parameters
        ----------
        snapshot
            What `snapshot` of an engine with the same programs returned.

        Raises
        ------
        SettingError
            If it does not fit the programs.
        """
        pairs: list[tuple[NDArray[Any], NDArray[Any]]] = list(zip(self.stacks, snapshot, strict=True))
        alike = all(ours.shape == theirs.shape and ours.dtype == theirs.dtype for ours, theirs in pairs)
        if not alike or not self._fits(snapshot):
            raise _wrong("snapshot", "is of other programs", "give one of an engine with the same programs")
        for ours, theirs in pairs:
            np.copyto(ours, theirs)

    def _fits(self, snapshot: Stacks) -> bool:
        """Return whether every level is in a state of the instance that the level above it runs."""
        tables, runs = self.compiled.tables, snapshot.root
        if not np.array_equal(runs, self.stacks.root):
            return False
        for state in snapshot.state.T:
            active = runs >= 0
            places = state[active]
            if not np.all((places >= 0) & (places < len(tables.states))):
                return False
            owners = np.searchsorted(tables.instances["start"], places, side="right") - 1
            if not np.array_equal(owners, runs[active]):
                return False
            runs = np.full(len(runs), -1, np.int32)
            runs[active] = tables.states["child"][places]
        return True


def _wrong(setting: str, problem: str, remedy: str) -> SettingError:
    return SettingError(where="engine", setting=setting, problem=problem, remedy=remedy)
