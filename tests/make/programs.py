"""Automata written small: states by what they run, transition functions as plain Python."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from tests.bodies import kit

from understudy.model.automaton import START, Automaton, State, Transition
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature
from understudy.model.library import Library
from understudy.model.tree import STAY, PathStep
from understudy.runtime.link import Program, link
from understudy.training.lesson_design import parse_feature, parse_state

DESIGN = Library(kit)


@dataclass(frozen=True)
class Rule:
    """A transition function from features to a state's name; None stays, and so does what is no name."""

    names: tuple[str, ...]
    answer: Callable[..., str | None]

    def decide(self, values: Sequence[float], /) -> int:
        following = self.answer(*values)
        return self.names.index(following) if following in self.names else STAY

    def path(self, values: Sequence[float], /) -> tuple[tuple[PathStep, ...], int]:
        return (), 0


def make_automaton(
    name: str,
    states: Sequence[str | State] = (),
    rules: Mapping[str, Callable[..., str | None]] | None = None,
    *,
    flags: Sequence[str] = (),
    features: Sequence[str | BoundFeature] = (),
    parameters: Sequence[str] = (),
    library: Library = DESIGN,
    stateless: bool = False,
) -> Automaton:
    """Start, these states ("turn=left" names one), a state per flag; rules are functions of the features."""
    all_states = (
        START,
        *(parse_state(library, state) for state in states),
        *(State(flag, flag=flag) for flag in flags),
    )
    names = tuple(state.name for state in all_states)
    transitions: dict[str, Transition] = {state: Rule(names, rule) for state, rule in (rules or {}).items()}
    return Automaton(
        name,
        all_states,
        tuple(parse_feature(library, feature) for feature in features),
        tuple(parameters),
        stateless,
        transitions,
    )


def make_calling_state(name: str, behavior: str, **binding: str) -> State:
    """A state that runs a behavior the design library does not hold."""
    return State(name, behavior, Binding(binding))


def link_program(*automata: Automaton, **binding: str) -> Program:
    """The last of these automata as a program; the others are there for it to use."""
    return link(Library.from_automata(kit, *automata), automata[-1].name, binding)


def name_running(program: Program, index: int) -> str:
    """What `Interpreter.pulse` answered, as a name."""
    return str(program.basics[index])
