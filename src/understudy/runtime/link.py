"""Programs: a behavior of a library, made ready to run, with every name resolved and every parameter bound.

`link` expands the hierarchy under a root into instances: automata with the targets of their parameters. Since
automata never contain themselves, an agent has at most one activation of each instance at a time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from understudy.errors import DefinitionError, UnboundParameter, UnknownName
from understudy.model.automaton import Automaton, State
from understudy.model.behaviors import Behavior, StateEffect
from understudy.model.binding import NOTHING_BOUND, Binding, format_bound_name
from understudy.model.features import BoundFeature, Feature, OwnFeature
from understudy.model.library import Library

IDLING = 0
"""The position in `Program.basics` of doing nothing."""


@dataclass(frozen=True, slots=True)
class GroundBehavior:
    """A basic behavior with the targets of its parameters."""

    behavior: Behavior
    binding: Binding = NOTHING_BOUND

    def __str__(self) -> str:
        return format_bound_name(self.behavior.name, self.binding, self.behavior.parameters)


@dataclass(frozen=True, slots=True)
class ResetFeature:
    """A position in `Program.features` that reads `fresh` in the tick in which the automaton entered its state."""

    position: int
    fresh: float


ValueSource: TypeAlias = int | ResetFeature | OwnFeature
"""Where the value of an automaton's feature comes from."""


@dataclass(frozen=True, slots=True, eq=False)
class Instance:
    """An automaton with the targets of its parameters.

    `sources` has, for each feature, its position in `Program.features`, or the automaton's own feature, or a
    `ResetFeature`. `children` has, for each state, the instance that it runs, or a position in `Program.basics`.
    `changes` has, for each state, the changes that its start makes to counters and timers.
    """

    automaton: Automaton
    binding: Binding
    sources: tuple[ValueSource, ...]
    children: tuple[Child, ...]
    changes: tuple[tuple[StateEffect, ...], ...]

    def __str__(self) -> str:
        return format_bound_name(self.automaton.name, self.binding, self.automaton.parameters)


Child: TypeAlias = Instance | int


@dataclass(frozen=True, slots=True)
class Program:
    """A runnable program: the root instance or basic behavior, and the ground features and behaviors under it."""

    root: Child
    features: tuple[BoundFeature, ...]
    basics: tuple[GroundBehavior, ...]


IDLE_PROGRAM = Program(IDLING, (), (GroundBehavior(Behavior("idle")),))
"""The program of an agent that is to do nothing."""


def link(library: Library, name: str, binding: Mapping[str, str] = NOTHING_BOUND) -> Program:
    """Resolve a behavior of a library, with its parameters bound to targets.

    Parameters
    ----------
    library
        The library, which has all behaviors and features under the root.
    name
        Name of the behavior at the root.
    binding
        A target for each parameter of the root.

    Returns
    -------
    Program
        The program, ready for an `Interpreter`, a `Run` or an `Engine`.

    Raises
    ------
    UnknownName
        If a behavior or a target does not exist.
    UnboundParameter
        If a parameter is not bound.
    DefinitionError
        If a feature or an automaton is defined inconsistently.
    RecursionRefused
        If an automaton contains itself.
    """
    library.refuse_recursion(name)
    linker = _Linker(library)
    root = linker.child(name, Binding(binding))
    return Program(root, tuple(linker.features), tuple(linker.basics))


class _Linker:
    def __init__(self, library: Library) -> None:
        self.library = library
        self.features: dict[BoundFeature, int] = {}
        self.basics: dict[GroundBehavior, int] = dict.fromkeys(IDLE_PROGRAM.basics, IDLING)
        self.instances: dict[tuple[str, Binding], Instance] = {}

    def child(self, name: str, binding: Binding) -> Child:
        behavior = self.library.behavior(name)
        self.check_ground(name, behavior.parameters, binding)
        if isinstance(behavior, Behavior):
            ground = GroundBehavior(behavior, binding)
            return self.basics.setdefault(ground, len(self.basics))
        key = (name, binding)
        if key not in self.instances:
            self.instances[key] = self.instance(behavior, binding)
        return self.instances[key]

    def instance(self, automaton: Automaton, binding: Binding) -> Instance:
        children: list[Child] = []
        changes: list[tuple[StateEffect, ...]] = []
        for state in automaton.states:
            changes.append(self.changes(state))
            if state.behavior is None:
                children.append(IDLING)
            else:
                children.append(self.child(state.behavior, state.binding.substitute(binding)))
        sources = tuple(self.source(bound, binding, automaton) for bound in automaton.features)
        return Instance(automaton, binding, sources, tuple(children), tuple(changes))

    def changes(self, state: State) -> tuple[StateEffect, ...]:
        behavior = self.library.kit.behaviors.get(state.behavior or "")
        return behavior.changes if behavior else ()

    def source(self, bound: BoundFeature, binding: Binding, automaton: Automaton) -> ValueSource:
        if not isinstance(bound.feature, Feature):
            return bound.feature
        ground = BoundFeature(bound.feature, bound.binding.substitute(binding))
        self.check_targets(automaton.name, ground.binding)
        position = self.features.setdefault(ground, len(self.features))
        fresh = bound.feature.fresh
        return position if fresh is None else ResetFeature(position, fresh)

    def check_ground(self, name: str, parameters: tuple[str, ...], binding: Binding) -> None:
        targets = self.library.kit.targets
        for parameter in parameters:
            if parameter in targets:
                raise DefinitionError(
                    what=f"behavior {name!r}",
                    problem=f"its parameter {parameter!r} has the name of a target",
                    remedy="rename the parameter",
                )
            if parameter not in binding:
                raise UnboundParameter(behavior=name, parameter=parameter, targets=list(targets))
        for parameter in binding:
            if parameter not in parameters:
                raise UnknownName(
                    what="parameter", name=parameter, where=f"behavior {name!r}", known=parameters
                )
        self.check_targets(name, binding)

    def check_targets(self, name: str, binding: Binding) -> None:
        targets = list(self.library.kit.targets)
        for target in binding.values():
            if target not in targets:
                raise UnknownName(what="target", name=target, where=f"the kit, for {name!r},", known=targets)
