"""Libraries: the named parts at hand - a kit's, and the automata taught so far."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Self, TypeVar

from understudy.errors import DefinitionError, RecursionRefused, UnknownName
from understudy.model.automaton import Automaton
from understudy.model.behaviors import Behavior
from understudy.model.binding import Target, format_bound_name
from understudy.model.features import AnyFeature, FlagFeature
from understudy.model.lesson import Lesson

KitPart = TypeVar("KitPart", AnyFeature, Behavior, Target)


@dataclass(frozen=True)
class Kit:
    """Features, basic behaviors and targets by name."""

    features: Mapping[str, AnyFeature]
    behaviors: Mapping[str, Behavior]
    targets: Mapping[str, Target]

    @classmethod
    def from_parts(cls, *parts: AnyFeature | Behavior | Target) -> Self:
        """A kit of these parts, in this order; two of one sort and name are refused."""
        features: dict[str, AnyFeature] = {}
        behaviors: dict[str, Behavior] = {}
        targets: dict[str, Target] = {}
        for part in parts:
            if isinstance(part, Behavior):
                _add(behaviors, part, "behaviors")
            elif isinstance(part, Target):
                _add(targets, part, "targets")
            elif isinstance(part, AnyFeature):
                _add(features, part, "features")
            else:
                remedy = "give features, behaviors and targets, one by one"
                raise DefinitionError(what="kit", problem=f"{part!r:.60} is no part of it", remedy=remedy)
        return cls(MappingProxyType(features), MappingProxyType(behaviors), MappingProxyType(targets))

    def __add__(self, other: Kit) -> Kit:
        """Both kits' parts; a name that both have is refused."""
        return Kit.from_parts(*self.parts, *other.parts)

    @property
    def parts(self) -> tuple[AnyFeature | Behavior | Target, ...]:
        """Everything in the kit: features, basic behaviors, targets."""
        return (*self.features.values(), *self.behaviors.values(), *self.targets.values())


def _add(parts: dict[str, KitPart], part: KitPart, sort: str) -> None:
    if part.name in parts:
        raise DefinitionError(
            what="kit", problem=f"two {sort} are called {part.name!r}", remedy="rename one of the two"
        )
    parts[part.name] = part


@dataclass(frozen=True)
class TrainedAutomaton:
    """An automaton of the library with the lesson it was learned from (None if it was written by hand)."""

    automaton: Automaton
    lesson: Lesson | None = None


def check_trained_automaton(given: object) -> None:
    """Refuse what is no trained automaton: a lesson teaches nothing until it is learned from."""
    if isinstance(given, TrainedAutomaton):
        return
    what, remedy = f"{given!r:.60}", "give a TrainedAutomaton"
    if isinstance(given, Lesson):
        what, remedy = f"lesson {given.name!r}", "give TrainedAutomaton(learn_automaton(lesson), lesson)"
    if isinstance(given, Automaton):
        what, remedy = f"automaton {given.name!r}", "give TrainedAutomaton(automaton)"
    raise DefinitionError(what=what, problem="it is no trained automaton", remedy=remedy)


@dataclass(frozen=True)
class Library:
    """A kit and the automata taught with it, by name. Frozen: `with_automaton` gives a new one."""

    kit: Kit
    taught: Mapping[str, TrainedAutomaton] = field(default_factory=lambda: MappingProxyType({}))

    @classmethod
    def from_automata(cls, kit: Kit, *automata: Automaton) -> Self:
        """A library of a kit and automata that have no lessons."""
        library = cls(kit)
        for automaton in automata:
            library = library.with_automaton(TrainedAutomaton(automaton))
        return library

    def with_automaton(self, taught: TrainedAutomaton) -> Self:
        """This library with an automaton added or replaced; refused if it would contain itself."""
        check_trained_automaton(taught)
        name = taught.automaton.name
        if name in self.kit.behaviors:
            raise DefinitionError(
                what=f"automaton {name!r}",
                problem="a basic behavior has this name already",
                remedy="rename the automaton",
            )
        library = type(self)(self.kit, MappingProxyType({**self.taught, name: taught}))
        library.refuse_recursion(name)
        return library

    @property
    def features(self) -> Mapping[str, AnyFeature]:
        """What an automaton may look at, by name: the kit's features, and each flag that an automaton here raises."""
        flags = (flag for taught in self.taught.values() for flag in taught.automaton.flags)
        return {**{flag: FlagFeature(flag) for flag in flags}, **self.kit.features}

    def behavior(self, name: str) -> Behavior | Automaton:
        """The basic behavior or automaton of this name; UnknownName where there is none."""
        if name in self.taught:
            return self.taught[name].automaton
        if name in self.kit.behaviors:
            return self.kit.behaviors[name]
        known = [*self.kit.behaviors, *self.taught]
        raise UnknownName(what="behavior", name=name, where="the library", known=known)

    def automaton(self, name: str) -> Automaton:
        """The automaton of this name; UnknownName where there is none."""
        if name not in self.taught:
            raise UnknownName(what="automaton", name=name, where="the library", known=list(self.taught))
        return self.taught[name].automaton

    def parameters(self, name: str) -> tuple[str, ...]:
        """The parameters of the behavior of this name."""
        return self.behavior(name).parameters

    def format_call(self, name: str, binding: Mapping[str, str]) -> str:
        """A behavior with its arguments in the order that a lesson gives them in: goto(station). One that this library
        does not have, with them by alphabet of its parameters.
        """
        known = name in self.taught or name in self.kit.behaviors
        return format_bound_name(name, binding, self.parameters(name) if known else ())

    def find_users(self, name: str) -> tuple[str, ...]:
        """The automata with a state that runs this behavior."""
        return tuple(
            key
            for key, taught in self.taught.items()
            if any(state.behavior == name for state in taught.automaton.states)
        )

    def refuse_recursion(self, name: str, above: tuple[str, ...] = ()) -> None:
        """RecursionRefused, naming the cycle, if the automaton of this name contains itself (paper section 3.1)."""
        if name in above:
            raise RecursionRefused(cycle=(*above[above.index(name) :], name))
        if name in self.taught:
            for state in self.taught[name].automaton.states:
                if state.behavior is not None:
                    self.refuse_recursion(state.behavior, (*above, name))
