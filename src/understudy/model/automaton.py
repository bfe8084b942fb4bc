"""Automata: states, features, transition functions; themselves behaviors, so that they nest (paper section 3.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Protocol

from understudy.errors import DefinitionError, UnknownName
from understudy.model.binding import NOTHING_BOUND, Binding, format_bound_name
from understudy.model.features import BoundFeature
from understudy.model.tree import PathStep


class Transition(Protocol):
    """A transition function of one state."""

    def decide(self, values: Sequence[float], /) -> int:
        """The next state's index for a feature vector, or STAY."""
        ...

    def path(self, values: Sequence[float], /) -> tuple[tuple[PathStep, ...], int]:
        """The tests passed on the way, and the leaf reached; nothing where the function cannot say."""
        ...


@dataclass(frozen=True, slots=True)
class State:
    """A name, a behavior and a binding; or a flag state, which raises `flag`, idles and is never left.

    `behavior` names a basic behavior or an automaton of the library; None idles. Several states may share one.
    """

    name: str
    behavior: str | None = None
    binding: Binding = NOTHING_BOUND
    flag: str | None = None

    def __post_init__(self) -> None:
        if self.flag is not None and self.behavior is not None:
            raise DefinitionError(
                what=f"state {self.name!r}",
                problem=f"it raises flag {self.flag!r} and runs {self.behavior!r}",
                remedy="a flag state idles: leave out one of the two",
            )

    def __str__(self) -> str:
        if self.flag is not None:
            return f"{self.name} (raises {self.flag})"
        if self.behavior is None:
            return f"{self.name} (idles)"
        runs = format_bound_name(self.behavior, self.binding)
        return runs if self.behavior == self.name else f"{self.name}: {runs}"


START = State("start")


@dataclass(frozen=True, slots=True)
class Automaton:
    """States, features, parameters and transition functions by state; `states[0]` is the start state.

    A state without a transition function keeps itself (paper section 3.2), so an automaton that was taught nothing
    yet idles in its start state. A stateless one has the same function for every state that raises no flag.
    """

    name: str
    states: tuple[State, ...] = (START,)
    features: tuple[BoundFeature, ...] = ()
    parameters: tuple[str, ...] = ()
    stateless: bool = False
    transitions: Mapping[str, Transition] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        if not self.states or self.states[0].behavior is not None or self.states[0].flag is not None:
            raise self._wrong("its first state does not idle", "begin with the start state")
        for group, names in (
            ("state", [state.name for state in self.states]),
            ("feature", [str(bound) for bound in self.features]),
            ("parameter", list(self.parameters)),
        ):
            twice = sorted({name for name in names if names.count(name) > 1})
            if twice:
                raise self._wrong(f"it has {group} {twice[0]!r} twice", "rename or remove one of the two")
        for name in self.transitions:
            if self.state(name).flag is not None:
                raise self._wrong(
                    f"flag state {name!r} has a transition function", "a flag state is never left"
                )

    def _wrong(self, problem: str, remedy: str) -> DefinitionError:
        return DefinitionError(what=f"automaton {self.name!r}", problem=problem, remedy=remedy)

    @property
    def state_names(self) -> tuple[str, ...]:
        """The states' names in declared order; their positions are what transition functions answer."""
        return tuple(state.name for state in self.states)

    @property
    def flags(self) -> tuple[str, ...]:
        """The flags that its states raise, in declared order."""
        return tuple(dict.fromkeys(state.flag for state in self.states if state.flag is not None))

    def state(self, name: str) -> State:
        """The state of this name; UnknownName where there is none."""
        return self.states[self.index(name)]

    def index(self, name: str) -> int:
        """The position of the state of this name; UnknownName where there is none."""
        for index, state in enumerate(self.states):
            if state.name == name:
                return index
        raise UnknownName(what="state", name=name, where=f"automaton {self.name!r}", known=self.state_names)
