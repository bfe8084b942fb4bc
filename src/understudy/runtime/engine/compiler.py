"""The compiler: from the programs of agents to the tables that kernels run (docs/architecture.md).

The hierarchy under each root is laid out as ground instances. Parts that programs share are stored once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.automaton import Automaton, Transition
from understudy.model.behaviors import StateEffect
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, CounterFeature, Feature, FlagFeature, TimerFeature
from understudy.model.tree import STAY, Tree
from understudy.runtime.engine.tables import (
    ADD,
    ASKED,
    CHANGE,
    CLOCK,
    COUNTER,
    FALLEN,
    FLAG,
    INSTANCE,
    NODE,
    OWN_SOURCES,
    RISEN,
    SET,
    STATE,
    TIME,
    TIMER,
    NodeRow,
    Stacks,
    Tables,
    check_tree,
    flatten_tree,
)
from understudy.runtime.link import (
    IDLE_PROGRAM,
    Child,
    GroundBehavior,
    Program,
    ResetFeature,
    ValueSource,
)

Kept: TypeAlias = tuple[str, str]
"""A counter or timer: "counter" or "timer", and its name."""


@dataclass(frozen=True, slots=True)
class StateSlot:
    """The state that a number in compiled tables stands for, by names.

    `binding` has the target of each parameter of the automaton. `memory` has the place of each counter and timer of the
    automaton in the memory of an agent, and `sources` says where the value of each of its features is found.
    """

    automaton: str
    state: str
    binding: Binding
    memory: Mapping[Kept, int]
    sources: NDArray[np.int32] = field(compare=False)

    def __str__(self) -> str:
        return f"{self.automaton}/{self.state}"


@dataclass(frozen=True, slots=True)
class PythonTransition:
    """A transition function that is not a tree: Python calls it with the values of these sources.

    Its result is one of `states` states, the first of which has the number `first`.
    """

    transition: Transition
    sources: NDArray[np.int32]
    first: int
    states: int


@dataclass(frozen=True, slots=True)
class Compiled:
    """Programs as tables, and the meaning of the numbers in them.

    `features` are the columns of feature vectors; `basics` are the results of pulses (the first one idles); `places`
    are the states by number; `python_transitions` are the transition functions that are not trees, by state. `roots`
    has the value of `Stacks.root` for each program, `flags` the number of each flag. Run states have `depth` levels and
    `slots` remembered values.
    """

    tables: Tables
    features: tuple[BoundFeature, ...]
    basics: tuple[GroundBehavior, ...]
    places: tuple[StateSlot, ...]
    python_transitions: Mapping[int, PythonTransition]
    roots: NDArray[np.int32]
    flags: Mapping[str, int]
    depth: int
    slots: int

    def stacks(self, agents: int | None = None) -> Stacks:
        """Make initial run states: of one agent for each compiled program, or for the first `agents` programs only."""
        agents = len(self.roots) if agents is None else agents
        return Stacks(
            self.roots[:agents].copy(),
            np.zeros((agents, self.depth), np.int32),
            np.full((agents, self.depth), -np.inf),
            np.full((agents, self.slots), np.nan),
        )


def compile_programs(programs: Sequence[Program]) -> Compiled:
    """Compile the programs of agents to tables, in which equal parts are shared.

    DefinitionError for a tree that tests a feature or leads to a state that its automaton does not have.
    """
    merging = _InstanceMerger()
    merged = {id(program): merging.child(program, program.root) for program in programs}
    laying = _TableWriter(merging)
    return Compiled(
        laying.tables(),
        tuple(bound for bound, _ in merging.features),
        tuple(ground for ground, _ in merging.basics),
        tuple(laying.places),
        laying.python_transitions,
        np.array([merged[id(program)] for program in programs], np.int32),
        laying.flags,
        laying.depth,
        laying.slots,
    )


@dataclass(frozen=True)
class _GroundInstance:
    """An instance with its numbers in the tables; a child is an instance, or -1 minus a basic behavior's number."""

    identity: int
    binding: Binding
    sources: tuple[ValueSource, ...]
    children: tuple[int, ...]
    changes: tuple[tuple[StateEffect, ...], ...]


class _InstanceMerger:
    """A numbering of the parts of programs; functions are distinguished by identity, not by name."""

    def __init__(self) -> None:
        self.features: dict[tuple[BoundFeature, Callable[..., Any] | None], int] = {}
        self.basics: dict[tuple[GroundBehavior, Callable[..., Any] | None], int] = {}
        self.instances: dict[_GroundInstance, int] = {}
        self.automata: list[Automaton] = []
        self.met: dict[tuple[int, int], int] = {}
        self.child(IDLE_PROGRAM, IDLE_PROGRAM.root)

    def child(self, program: Program, child: Child) -> int:
        """Return the number of an instance, after those under it, or -1 minus that of a basic behavior."""
        if isinstance(child, int):
            ground = program.basics[child]
            return -1 - self.basics.setdefault((ground, ground.behavior.function), len(self.basics))
        key = id(program), id(child)
        if key not in self.met:
            children = tuple(self.child(program, below) for below in child.children)
            sources = tuple(self.source(program, source) for source in child.sources)
            identity = id(child.automaton)
            merged = _GroundInstance(identity, child.binding, sources, children, child.changes)
            if merged not in self.instances:
                self.instances[merged] = len(self.automata)
                self.automata.append(child.automaton)
            self.met[key] = self.instances[merged]
        return self.met[key]

    def source(self, program: Program, source: ValueSource) -> ValueSource:
        if isinstance(source, ResetFeature):
            return ResetFeature(self.column(program, source.position), source.fresh)
        return self.column(program, source) if isinstance(source, int) else source

    def column(self, program: Program, source: int) -> int:
        bound = program.features[source]
        function = bound.feature.function if isinstance(bound.feature, Feature) else None
        return self.features.setdefault((bound, function), len(self.features))


class _TableWriter:
    """A writer that lays out merged instances as records."""

    def __init__(self, merging: _InstanceMerger) -> None:
        self.grounds = list(merging.instances)
        self.automata = merging.automata
        self.flags: dict[str, int] = {}
        self.nodes: list[NodeRow] = []
        self.states: list[tuple[int, ...]] = []
        self.changes: list[tuple[int, int, float]] = []
        self.instances: list[tuple[int, int, int]] = []
        self.places: list[StateSlot] = []
        self.python_transitions: dict[int, PythonTransition] = {}
        self.depth, self.slots, self.memories = _memories(self.grounds)
        for number in range(len(self.grounds)):
            self.append_instance(number)

    def tables(self) -> Tables:
        return Tables(
            np.array(self.nodes, NODE),
            np.array(self.states, STATE),
            np.array(self.instances, INSTANCE),
            np.array(self.changes, CHANGE),
        )

    def append_instance(self, number: int) -> None:
        """Append the rows of one instance, an automaton with its targets as one state of the hierarchy runs it."""
        ground, automaton, memory = self.grounds[number], self.automata[number], self.memories[number]
        first = len(self.states)
        sources = [self.source(source, memory) for source in ground.sources]
        codes = np.array(sources, np.int32)
        trees: dict[int, int] = {}  # states may share one
        for state, child, changes in zip(automaton.states, ground.children, ground.changes, strict=True):
            transition = automaton.transitions.get(state.name)
            asks = STAY
            if isinstance(transition, Tree):
                if id(transition) not in trees:
                    check_tree(transition, automaton, state.name)
                    asks, rows = flatten_tree(transition, sources=sources, first=first, at=len(self.nodes))
                    self.nodes.extend(rows)
                    trees[id(transition)] = asks
                asks = trees[id(transition)]
            elif transition is not None:
                self.python_transitions[len(self.states)] = PythonTransition(
                    transition, codes, first, len(automaton.states)
                )
                asks = ASKED
            flag = -1 if state.flag is None else self.flag(state.flag)
            begun = len(self.changes)
            self.changes.extend(_change(change, memory) for change in changes)
            self.states.append((asks, max(child, -1), max(-1 - child, -1), flag, begun, len(self.changes)))
            self.places.append(StateSlot(automaton.name, state.name, ground.binding, memory, codes))
        slots = memory.values()
        self.instances.append((first, min(slots, default=0), max(slots, default=-1) + 1))

    def source(self, source: ValueSource, memory: Mapping[Kept, int]) -> int:
        """Return where a node finds the value of a feature."""
        if isinstance(source, int):
            return source
        if isinstance(source, ResetFeature):
            own_source, which = RISEN if source.fresh else FALLEN, source.position
        elif isinstance(source, FlagFeature):
            own_source, which = FLAG, self.flag(source.name)
        elif isinstance(source, CounterFeature):
            own_source, which = COUNTER, memory["counter", source.name]
        elif isinstance(source, TimerFeature):
            own_source, which = TIMER, memory["timer", source.name]
        else:
            own_source, which = TIME, 0
        return -1 - (own_source + OWN_SOURCES * which)

    def flag(self, name: str) -> int:
        return self.flags.setdefault(name, len(self.flags))


def _memories(grounds: Sequence[_GroundInstance]) -> tuple[int, int, list[dict[Kept, int]]]:
    """Compute the depth of run states, the number of their slots, and the slots of each instance.

    Slots come after those of the instances above, so that only instances that never run at once share slots.
    """
    depths, begins = [1] * len(grounds), [0] * len(grounds)
    memories: list[dict[Kept, int]] = [{} for _ in grounds]
    slots = 0
    for number in reversed(range(len(grounds))):  # parents come after their children
        ground = grounds[number]
        variables: dict[Kept, None] = {}
        for change in (change for changes in ground.changes for change in changes):
            variables[change.of, change.name] = None
        for source in ground.sources:
            if isinstance(source, CounterFeature | TimerFeature):
                variables["counter" if isinstance(source, CounterFeature) else "timer", source.name] = None
        begin = begins[number]
        memories[number] = {each: begin + position for position, each in enumerate(variables)}
        slots = max(slots, begin + len(variables))
        for child in ground.children:
            if child >= 0:
                depths[child] = max(depths[child], depths[number] + 1)
                begins[child] = max(begins[child], begin + len(variables))
    return max(depths, default=1), slots, memories


def _change(change: StateEffect, memory: Mapping[Kept, int]) -> tuple[int, int, float]:
    slot = memory[change.of, change.name]
    if change.action == "reset":
        return SET, slot, np.nan
    if change.action == "increment":
        return ADD, slot, change.value
    return (SET, slot, change.value) if change.of == "counter" else (CLOCK, slot, 0.0)
