"""Automata: states, features and transition functions (paper section 3.1).

A state may run another automaton just as it runs a basic behavior, so automata nest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Protocol

from understudy.errors import DefinitionError, UnknownName
from understudy.model.binding import NOTHING_BOUND, Binding, format_bound_name
from understudy.model.drawing import Axes, call_markup, call_plot, format_number_of, format_repr
from understudy.model.features import BoundFeature
from understudy.model.tree import STAY, PathStep


class Transition(Protocol):
    """The interface of a state's transition function, such as `Tree`."""

    def decide(self, values: Sequence[float], /) -> int:
        """Return the index of the next state for a feature vector, or STAY to keep the current state.

        `values` holds one number per feature of the automaton, NaN where absent.
        """
        ...

    def path(self, values: Sequence[float], /) -> tuple[tuple[PathStep, ...], int]:
        """Return the tests passed for a feature vector, and the index of the leaf that was reached.

        The steps are empty where the function has no tests to report.
        """
        ...


@dataclass(frozen=True, slots=True)
class State:
    """A state of an automaton: it runs a behavior, idles, or raises a flag and ends there.

    Several states may run the same behavior. A flag state idles and is never left.

    Parameters
    ----------
    name
        Name of the state, unique within its automaton.
    behavior
        Name of the basic behavior or automaton of the library that runs in this state. None: idle.
    binding
        For each parameter of the behavior, the name of a target or of a parameter of the automaton.
    flag
        Name of the flag that this state raises. None: not a flag state.

    Raises
    ------
    DefinitionError
        If both `behavior` and `flag` are given.
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
"""The start state of automata, which idles."""
USUAL_FLAGS = ("done", "failed")
"""The flags that a behavior usually raises when it has succeeded, and when it has given up."""


@dataclass(frozen=True, slots=True)
class Automaton:
    """An automaton: states, features, parameters, and a transition function for each state (paper section 3.1).

    A state without a transition function is never left (paper section 3.2), so an automaton without any idles in its
    start state.

    Parameters
    ----------
    name
        Name of the automaton, by which other automata can run it as a behavior.
    states
        The states. The first one is the start state; it must idle and raise no flag.
    features
        The features that transition functions decide on, in the order of their feature vectors.
    parameters
        Names of the automaton's parameters, which are bound to targets where it is used.
    stateless
        True if all states that raise no flag share one transition function.
    transitions
        Transition function by state name. Flag states have none.

    Raises
    ------
    DefinitionError
        If the first state does not idle, a name occurs twice, or a flag state has a transition function.
    UnknownName
        If `transitions` names a state that does not exist.
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

    def __repr__(self) -> str:
        called = format_bound_name(self.name, {name: name for name in self.parameters})
        states, features = len(self.states), len(self.features)
        facts = [format_number_of(states, "state"), format_number_of(features, "feature")]
        return format_repr(
            self, repr(called), *facts, *(["stateless"] if self.stateless else []), *self._lacks()
        )

    def _lacks(self) -> list[str]:
        return [] if self.transitions else ["no transition functions"]

    def _wrong(self, problem: str, remedy: str) -> DefinitionError:
        return DefinitionError(what=f"automaton {self.name!r}", problem=problem, remedy=remedy)

    @property
    def state_names(self) -> tuple[str, ...]:
        """The names of the states in declared order; transition functions return positions in this tuple."""
        return tuple(state.name for state in self.states)

    @property
    def flags(self) -> tuple[str, ...]:
        """The names of the flags that the states raise, in declared order and each once."""
        return tuple(dict.fromkeys(state.flag for state in self.states if state.flag is not None))

    def state(self, name: str) -> State:
        """Return the state with the given name.

        Parameters
        ----------
        name
            Name of the state.

        Returns
        -------
        State
            The state.

        Raises
        ------
        UnknownName
            If the automaton has no state with this name.
        """
        return self.states[self.index(name)]

    def index(self, name: str) -> int:
        """Return the position of the state with the given name.

        Parameters
        ----------
        name
            Name of the state.

        Returns
        -------
        int
            The position in `states`, from 0.

        Raises
        ------
        UnknownName
            If the automaton has no state with this name.
        """
        for index, state in enumerate(self.states):
            if state.name == name:
                return index
        raise UnknownName(what="state", name=name, where=f"automaton {self.name!r}", known=self.state_names)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Plot the states as a graph with numbered transitions, and their conditions in words below.

        `TrainedAutomaton.plot` rounds thresholds with a view to the examples of the lesson.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw into. None: in a new figure.

        Returns
        -------
        Axes
            The axes; `plot().figure.savefig("NAME.pdf")` writes a vector file.
        """
        return call_plot("automaton_plot:plot_automaton", self, ax)

    def _repr_svg_(self) -> str:
        return call_markup("html_cards:draw_automaton", self)


def name_next_state(automaton: Automaton, state: str, outcome: int) -> str:
    """Return the name of the next state for an outcome of a state's transition function; `state` itself for STAY."""
    return state if outcome == STAY else automaton.states[outcome].name


def query_next_state(automaton: Automaton, state: str, values: Sequence[float]) -> str:
    """Return the next state that an automaton chooses in a state for a feature vector."""
    function = automaton.transitions.get(state)
    return state if function is None else name_next_state(automaton, state, function.decide(values))
