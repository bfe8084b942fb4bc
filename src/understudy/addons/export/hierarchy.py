"""The intermediate form of an export: a ground hierarchy as plain tables, from which every target is written.

All names are resolved and all parameters bound. Readings, computed values, basic behaviors and automata refer to each
other by their index.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from understudy.addons.export.body_interface import ORDER_CHANNELS, BodyInterface
from understudy.addons.export.decisions import TreeRoutines, make_routines
from understudy.addons.export.expressions import Expression, Number, ReadingValue, translate_function
from understudy.errors import DefinitionError, UnknownName
from understudy.model.behaviors import Command, StateEffect
from understudy.model.binding import Binding, format_bound_name
from understudy.model.features import BoundFeature, CounterFeature, Feature, FlagFeature, TimerFeature
from understudy.model.squad import Order
from understudy.model.tree import Tree
from understudy.model.value_kinds import Continuous, Kind
from understudy.runtime.body import Channel, Reading
from understudy.runtime.link import Child, GroundBehavior, Instance, Program, ResetFeature, ValueSource


@dataclass(frozen=True, slots=True)
class ReadingSlot:
    """A reading that the exported behavior takes in every tick, of the body itself or of a target."""

    reading: str
    target: str | None
    kind: Kind
    unit: str = ""
    doc: str = ""

    def __str__(self) -> str:
        return self.reading if self.target is None else f"{self.reading}({self.target})"


@dataclass(frozen=True, slots=True)
class ComputedValue:
    """A value that a Python function computes of readings: a feature, or a channel of a basic behavior.

    `expression` holds `SlotValue`s in place of readings. It is None if the function could not be translated, for the
    reason in `problem`. `slots` are the indices of the readings that the function looks at.
    """

    name: str
    kind: Kind
    slots: tuple[int, ...]
    expression: GroundExpression | None
    problem: str = ""


@dataclass(frozen=True, slots=True)
class SlotValue:
    """A reading in an expression, by its index in `Hierarchy.readings`."""

    slot: int


@dataclass(frozen=True, slots=True)
class GroundOperation:
    """An operation of `expressions.Operation`, on ground expressions."""

    name: str
    operands: tuple[GroundExpression, ...]


GroundExpression: TypeAlias = Number | SlotValue | GroundOperation


@dataclass(frozen=True, slots=True)
class FeatureSource:
    """Where the value of an automaton's feature comes from.

    `sort` says what `index` counts: a reading, a computed value, a flag (of `Hierarchy.flags`), a counter or a timer
    (of the automaton). `fresh` is the value in the tick in which the automaton entered its state, if not None.
    """

    sort: str  # "reading", "computed", "flag", "counter", "timer" or "time in state"
    index: int
    kind: Kind
    name: str
    fresh: float | None = None

    @property
    def can_be_absent(self) -> bool:
        """True if the value can be absent: that of a reading, a function or a timer."""
        return self.sort in ("reading", "computed", "timer")


@dataclass(frozen=True, slots=True)
class ChildRef:
    """What a state runs: an automaton or a basic behavior, by its index."""

    is_automaton: bool
    index: int


@dataclass(frozen=True, slots=True)
class GroundState:
    """A state: what it runs, the flag that it raises (an index of `Hierarchy.flags`), its tree, and its effects."""

    name: str
    child: ChildRef
    flag: int | None
    tree: Tree | None
    effects: tuple[StateEffect, ...]


@dataclass(frozen=True, slots=True)
class GroundAutomaton:
    """An automaton with the targets of its parameters; `name` is unique in the hierarchy, such as "goto(station)"."""

    name: str
    automaton: str
    binding: Binding
    stateless: bool
    states: tuple[GroundState, ...]
    decisions: tuple[TreeRoutines, ...]
    features: tuple[FeatureSource, ...]
    counters: tuple[str, ...]
    timers: tuple[str, ...]

    def find_memory(self, effect: StateEffect) -> int:
        """Find the counter or timer that a state changes when it is entered, by its index."""
        return (self.counters if effect.of == "counter" else self.timers).index(effect.name)


@dataclass(frozen=True, slots=True)
class GroundBasic:
    """A basic behavior: its command, or what its function computes by channel, or its order to a squad.

    `computed` has indices of `Hierarchy.computed` by channel. `problem` says why a function could not be translated.
    """

    name: str
    behavior: str
    binding: Binding
    command: Command
    computed: Mapping[str, int]
    changes: tuple[StateEffect, ...]
    order: Order | None
    slots: tuple[int, ...] = ()
    problem: str = ""

    @property
    def is_function(self) -> bool:
        """True if its command depends on readings."""
        return bool(self.problem or self.computed)


@dataclass(frozen=True, slots=True)
class FunctionToWrite:
    """A function of a feature or behavior that could not be translated, with the readings that it looks at, and why."""

    name: str
    slots: tuple[int, ...]
    readings: tuple[str, ...]
    problem: str

    def refuse(self, remedy: str) -> str:
        """Say that it is missing, and what is to be done about it."""
        read = ", ".join(self.readings) or "unknown readings"
        return f"{self.name} of {read} could not be translated ({self.problem}): {remedy}"


@dataclass(frozen=True, slots=True)
class Hierarchy:
    """Everything that an exported behavior consists of, as plain tables.

    Parameters
    ----------
    name
        Name of the exported automaton.
    binding
        The target of each of its parameters.
    root
        The automaton or basic behavior that is run.
    readings
        The readings that it takes in every tick; what is absent is NaN.
    computed
        The values of Python functions: features of automata, and channels of basic behaviors.
    basics
        The basic behaviors.
    automata
        The automata, each after those that it contains.
    flags
        The flags that automata raise.
    channels
        The command channels; one that a basic behavior does not command is at rest.
    tick_s
        The nominal length of a tick, s.
    features
        For each feature of the program, in order: the index of its reading, or -1 - the index of its computed value.
    """

    name: str
    binding: Binding
    root: ChildRef
    readings: tuple[ReadingSlot, ...]
    computed: tuple[ComputedValue, ...]
    basics: tuple[GroundBasic, ...]
    automata: tuple[GroundAutomaton, ...]
    flags: tuple[str, ...]
    channels: tuple[Channel, ...]
    tick_s: float
    features: tuple[int, ...]

    @property
    def is_coordinator(self) -> bool:
        """True if the basic behaviors are orders to the members of a squad."""
        return any(basic.order is not None for basic in self.basics)

    @property
    def functions_to_write(self) -> tuple[FunctionToWrite, ...]:
        """The functions that cannot be translated."""
        functions: list[tuple[str, ComputedValue | GroundBasic]] = []
        functions += [(f"feature {each.name}", each) for each in self.computed]
        functions += [(f"behavior {each.name}", each) for each in self.basics]
        return tuple(
            FunctionToWrite(
                name, each.slots, tuple(str(self.readings[slot]) for slot in each.slots), each.problem
            )
            for name, each in functions
            if each.problem
        )

    @property
    def feature_functions(self) -> list[int]:
        """The computed values that are features of automata, by their index."""
        sources = [source for each in self.automata for source in each.features]
        return sorted({source.index for source in sources if source.sort == "computed"})

    def find_raising(self, number: int, state: int, flag: int) -> list[tuple[int, int]]:
        """Find the states that raise a flag to a state which runs their automaton.

        Parameters
        ----------
        number
            Index of the automaton of the state.
        state
            Index of the state.
        flag
            Index of the flag.

        Returns
        -------
        list of tuple
            The index of the automaton that the state runs, and that of each state of it that raises the flag.
        """
        child = self.automata[number].states[state].child
        if not child.is_automaton:
            return []
        states = self.automata[child.index].states
        return [(child.index, index) for index, each in enumerate(states) if each.flag == flag]

    @property
    def depth(self) -> int:
        """The largest number of automata that are active at the same time."""
        depths: list[int] = []
        for each in self.automata:
            below = [depths[state.child.index] for state in each.states if state.child.is_automaton]
            depths.append(1 + max(below, default=0))
        return depths[self.root.index] if self.root.is_automaton else 0


def flatten_program(program: Program, *, name: str, binding: Binding, body: BodyInterface) -> Hierarchy:
    """Make the intermediate form of a program for a body.

    UnknownName is raised if the body has not what the program reads or commands, and DefinitionError if a state does
    not decide with a tree.
    """
    return _Flattener(program, body).flatten(name, binding)


class _Flattener:
    def __init__(self, program: Program, body: BodyInterface) -> None:
        self.program, self.body, self.channels = program, body, body.channels
        if any(ground.behavior.order is not None for ground in program.basics):
            self.channels = ORDER_CHANNELS
        self.slots: dict[tuple[str, str | None], ReadingSlot] = {}
        self.computed: list[ComputedValue] = []
        self.automata: dict[int, int] = {}
        self.made: list[GroundAutomaton] = []
        self.flags: dict[str, int] = {}

    def flatten(self, name: str, binding: Binding) -> Hierarchy:
        features = tuple(self.feature(bound) for bound in self.program.features)
        self.features = features
        basics = tuple(self.basic(ground) for ground in self.program.basics)
        root = self.child(self.program.root)
        return Hierarchy(
            name,
            binding,
            root,
            tuple(self.slots.values()),
            tuple(self.computed),
            basics,
            tuple(self.made),
            tuple(self.flags),
            self.channels,
            self.body.tick_s,
            features,
        )

    def slot(self, reading: str, target: str | None) -> int:
        key = (reading, target)
        if key not in self.slots:
            reading_of = {each.name: each for each in self.body.readings}
            own = reading_of.get(reading)
            if own is None and self.body.is_complete:
                raise UnknownName(what="reading", name=reading, where="the body", known=list(reading_of))
            own = own or Reading(reading, Continuous())
            self.slots[key] = ReadingSlot(reading, target, own.kind, own.unit, own.doc)
        return list(self.slots).index(key)

    def feature(self, bound: BoundFeature) -> int:
        feature = bound.feature
        if not isinstance(feature, Feature):
            return 0
        if feature.function is None:
            target = bound.binding[feature.of] if feature.of else None
            return self.slot(feature.reading or "", target)
        translated = translate_function(feature.function, feature.parameters)
        slots = self.look(translated.readings, bound.binding)
        expression, problem = None, translated.problem
        if not problem and set(translated.results) != {""}:
            problem = "it does not return one value"
        if not problem:
            expression = self.ground(translated.results[""], bound.binding)
        self.computed.append(ComputedValue(str(bound), feature.kind, slots, expression, problem))
        return -len(self.computed)

    def look(self, readings: Sequence[tuple[str, str | None]], binding: Binding) -> tuple[int, ...]:
        keys = [(reading, None if owner is None else binding[owner]) for reading, owner in readings]
        return tuple(self.slot(*key) for key in keys if self.has(key[0]))

    def has(self, reading: str) -> bool:
        return not self.body.is_complete or any(each.name == reading for each in self.body.readings)

    def ground(self, expression: Expression, binding: Binding) -> GroundExpression:
        if isinstance(expression, Number):
            return expression
        if isinstance(expression, ReadingValue):
            owner = expression.parameter
            return SlotValue(self.slot(expression.reading, None if owner is None else binding[owner]))
        operands = tuple(self.ground(each, binding) for each in expression.operands)
        return GroundOperation(expression.name, operands)

    def basic(self, ground: GroundBehavior) -> GroundBasic:
        behavior, binding, name = ground.behavior, ground.binding, str(ground)
        channels = [each.name for each in self.channels]
        for channel in behavior.command:
            self.check_channel(channel, name, channels)
        computed: dict[str, int] = {}
        slots: tuple[int, ...] = ()
        problem = ""
        if behavior.function is not None:
            translated = translate_function(behavior.function, behavior.parameters)
            slots, problem = self.look(translated.readings, binding), translated.problem
            for channel, expression in translated.results.items():
                self.check_channel(channel, name, channels)
                computed[channel] = len(self.computed)
                of = self.ground(expression, binding)
                self.computed.append(ComputedValue(f"{channel} of {name}", Continuous(), slots, of))
        order = None if behavior.order is None else behavior.order.substitute(binding)
        return GroundBasic(
            name, behavior.name, binding, behavior.command, computed, behavior.changes, order, slots, problem
        )

    def check_channel(self, channel: str, name: str, channels: Sequence[str]) -> None:
        if channel not in channels:
            raise UnknownName(
                what="channel", name=channel, where=f"the body, for behavior {name},", known=channels
            )

    def child(self, child: Child) -> ChildRef:
        if isinstance(child, int):
            return ChildRef(False, child)
        if id(child) not in self.automata:
            exported = self.automaton(child)
            self.automata[id(child)] = len(self.made)
            self.made.append(exported)
        return ChildRef(True, self.automata[id(child)])

    def automaton(self, instance: Instance) -> GroundAutomaton:
        automaton = instance.automaton
        children = [self.child(child) for child in instance.children]
        effects = [each for changes in instance.changes for each in changes]
        own = [bound.feature for bound in automaton.features]
        counters = list(dict.fromkeys(
            [each.name for each in effects if each.of == "counter"]
            + [each.name for each in own if isinstance(each, CounterFeature)]
        ))  # fmt: skip
        timers = list(dict.fromkeys(
            [each.name for each in effects if each.of == "timer"]
            + [each.name for each in own if isinstance(each, TimerFeature)]
        ))  # fmt: skip
        states = []
        for index, state in enumerate(automaton.states):
            tree = automaton.transitions.get(state.name)
            if tree is not None and not isinstance(tree, Tree):
                raise DefinitionError(
                    what=f"automaton {automaton.name!r}",
                    problem=f"state {state.name!r} decides with a {type(tree).__name__}, which cannot be exported",
                    remedy="learn it with decision trees",
                )
            flag = None if state.flag is None else self.flags.setdefault(state.flag, len(self.flags))
            states.append(GroundState(state.name, children[index], flag, tree, instance.changes[index]))
        features = tuple(
            self.source(source, bound, counters, timers)
            for source, bound in zip(instance.sources, automaton.features, strict=True)
        )
        trees: dict[int, list[int]] = {}  # states may share one
        for index, exported in enumerate(states):
            if exported.tree is not None:
                trees.setdefault(id(exported.tree), []).append(index)
        decisions = [
            TreeRoutines(tuple(of), make_routines(tree, lambda feature: features[feature].can_be_absent))
            for of in trees.values()
            if (tree := states[of[0]].tree) is not None
        ]
        return GroundAutomaton(
            format_bound_name(automaton.name, instance.binding, automaton.parameters),
            automaton.name,
            instance.binding,
            automaton.stateless,
            tuple(states),
            tuple(decisions),
            features,
            tuple(counters),
            tuple(timers),
        )

    def source(
        self, source: ValueSource, bound: BoundFeature, counters: Sequence[str], timers: Sequence[str]
    ) -> FeatureSource:
        name, kind = str(bound), bound.kind
        if isinstance(source, int | ResetFeature):
            position = source if isinstance(source, int) else source.position
            fresh = None if isinstance(source, int) else source.fresh
            at = self.features[position]
            if at >= 0:
                return FeatureSource("reading", at, kind, name, fresh)
            return FeatureSource("computed", -1 - at, kind, name, fresh)
        if isinstance(source, FlagFeature):
            return FeatureSource("flag", self.flags.setdefault(source.name, len(self.flags)), kind, name)
        if isinstance(source, CounterFeature):
            return FeatureSource("counter", counters.index(source.name), kind, name)
        if isinstance(source, TimerFeature):
            return FeatureSource("timer", timers.index(source.name), kind, name)
        return FeatureSource("time in state", 0, kind, name)
