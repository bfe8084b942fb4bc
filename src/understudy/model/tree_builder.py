"""Automata written down by hand: trees as nested questions with the names of states for leaves."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from math import pi, tau

from understudy.model.automaton import Automaton, State
from understudy.model.binding import NOTHING_BOUND, Binding
from understudy.model.features import BoundFeature, Flag
from understudy.model.tree import Node, Test, Tree, leaf


@dataclass(frozen=True)
class Ask:
    """A test with what follows it: another test, or the name of the next state. Absent counts as no."""

    feature: str
    yes: Question
    no: Question
    below: float | None = None
    arc: tuple[float, float] | None = None
    absent: bool = False


Question = Ask | str


def below(feature: str, value: float, yes: Question, no: Question) -> Ask:
    """Is it less than `value`?"""
    return Ask(feature, yes, no, below=value)


def within(feature: str, half: float, yes: Question, no: Question) -> Ask:
    """Is this angle at most `half` to either side of straight ahead?"""
    return Ask(feature, yes, no, arc=(tau - half, half))


def on_the_left(feature: str, yes: Question, no: Question) -> Ask:
    """Is this angle between straight ahead and straight back, to the left?"""
    return Ask(feature, yes, no, arc=(0.0, pi))


def seen(feature: str, yes: Question, no: Question) -> Ask:
    """Is this reading there?"""
    return Ask(feature, yes, no, absent=True)


def raised(flag: str, yes: Question, no: Question) -> Ask:
    """Is this flag up in the automaton below?"""
    return Ask(flag, yes, no)


def automaton(
    name: str,
    asks: Mapping[str, Question],
    *,
    readings: Mapping[str, BoundFeature],
    runs: Mapping[str, str] | None = None,
    flags: tuple[str, ...] = (),
    basics: Collection[str] = (),
    bindings: Mapping[str, Binding] | None = None,
    parameters: tuple[str, ...] = (),
) -> Automaton:
    """An automaton of one state per tree and per flag; a state named after one of `basics` runs it.

    A name in a test that is none of `readings` is a flag of the automaton below.
    """
    below_it = {**{state: state for state in basics}, **(runs or {})}
    states = (
        *(State(state, below_it.get(state), (bindings or {}).get(state, NOTHING_BOUND)) for state in asks),
        *(State(flag, flag=flag) for flag in flags),
    )
    names = [state.name for state in states]
    features = list(dict.fromkeys(feature for ask in asks.values() for feature in _features(ask)))
    bound = tuple(readings.get(feature) or BoundFeature(Flag(feature)) for feature in features)
    trees = {state: _tree(ask, features, names) for state, ask in asks.items()}
    return Automaton(name, states, bound, parameters, transitions=trees)


def _features(ask: Question) -> list[str]:
    return [] if isinstance(ask, str) else [ask.feature, *_features(ask.yes), *_features(ask.no)]


def _tree(ask: Question, features: list[str], states: list[str]) -> Tree:
    nodes: list[Node] = []

    def grow(ask: Question) -> int:
        """The index of the first node of what grows here; children come after their parents."""
        index = len(nodes)
        if isinstance(ask, str):
            nodes.append(leaf(states.index(ask)))
            return index
        nodes.append(leaf(0))
        yes, no = grow(ask.yes), grow(ask.no)
        feature = features.index(ask.feature)
        if ask.arc:
            nodes[index] = Node(Test.ARC, feature, *ask.arc, yes, no, no)
        elif ask.absent:
            nodes[index] = Node(Test.ABSENT, feature, yes=no, no=yes)
        elif ask.below is not None:
            nodes[index] = Node(Test.BELOW, feature, high=ask.below, yes=yes, no=no, absent=no)
        else:
            nodes[index] = Node(Test.LABEL, feature, absent=no, branches=(no, yes))
        return index

    grow(ask)
    return Tree(tuple(nodes))
