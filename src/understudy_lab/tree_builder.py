"""A builder for hand-written automata: trees as nested tests, with names of states as leaves."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from math import pi, tau

from understudy.model.automaton import Automaton, State
from understudy.model.binding import NOTHING_BOUND, Binding
from understudy.model.features import BoundFeature, FlagFeature
from understudy.model.tree import Node, TestKind, Tree, make_leaf


@dataclass(frozen=True)
class TreeTest:
    """A test of one feature, and what follows on yes and on no: another test, or the name of the next state.

    Give one of: `below`, yes if the value is less; `arc`, yes if an angle in radians lies on the way from the first
    one counterclockwise to the second; `absent=True`, yes if there is a value. Without any of them the feature is a
    flag, and yes means that it is raised. A missing value counts as no.
    """

    feature: str
    yes: TreeBranch
    no: TreeBranch
    below: float | None = None
    arc: tuple[float, float] | None = None
    absent: bool = False


TreeBranch = TreeTest | str


def split_below(feature: str, value: float, yes: TreeBranch, no: TreeBranch) -> TreeTest:
    """Test whether a feature is less than `value`, in the feature's unit."""
    return TreeTest(feature, yes, no, below=value)


def split_within(feature: str, half: float, yes: TreeBranch, no: TreeBranch) -> TreeTest:
    """Test whether an angle is at most `half` radians to either side of straight ahead."""
    return TreeTest(feature, yes, no, arc=(tau - half, half))


def split_on_left(feature: str, yes: TreeBranch, no: TreeBranch) -> TreeTest:
    """Test whether an angle in radians points to the left, between straight ahead (0) and straight back (π)."""
    return TreeTest(feature, yes, no, arc=(0.0, pi))


def split_on_presence(feature: str, yes: TreeBranch, no: TreeBranch) -> TreeTest:
    """Test whether a feature is present, not NaN."""
    return TreeTest(feature, yes, no, absent=True)


def split_on_flag(flag: str, yes: TreeBranch, no: TreeBranch) -> TreeTest:
    """Test whether the automaton that the current state runs has raised a flag."""
    return TreeTest(flag, yes, no)


def build_automaton(
    name: str,
    asks: Mapping[str, TreeBranch],
    *,
    readings: Mapping[str, BoundFeature],
    runs: Mapping[str, str] | None = None,
    flags: tuple[str, ...] = (),
    basics: Collection[str] = (),
    bindings: Mapping[str, Binding] | None = None,
    parameters: tuple[str, ...] = (),
) -> Automaton:
    """Build an automaton with one state per tree in `asks` and one flag state per name in `flags`.

    `runs` gives the behavior of states by name; a state named in `basics` runs the behavior of its own name.
    `bindings` gives the bindings of those behaviors by state. A name in a test that is not in `readings` is
    taken for a flag.
    """
    below_it = {**{state: state for state in basics}, **(runs or {})}
    states = (
        *(State(state, below_it.get(state), (bindings or {}).get(state, NOTHING_BOUND)) for state in asks),
        *(State(flag, flag=flag) for flag in flags),
    )
    names = [state.name for state in states]
    features = list(dict.fromkeys(feature for ask in asks.values() for feature in _features(ask)))
    bound = tuple(readings.get(feature) or BoundFeature(FlagFeature(feature)) for feature in features)
    trees = {state: _tree(ask, features, names) for state, ask in asks.items()}
    return Automaton(name, states, bound, parameters, transitions=trees)


def _features(ask: TreeBranch) -> list[str]:
    return [] if isinstance(ask, str) else [ask.feature, *_features(ask.yes), *_features(ask.no)]


def _tree(ask: TreeBranch, features: list[str], states: list[str]) -> Tree:
    nodes: list[Node] = []

    def grow(ask: TreeBranch) -> int:
        """Add the nodes of a test and of what follows it, parents before children; return the index of the first."""
        index = len(nodes)
        if isinstance(ask, str):
            nodes.append(make_leaf(states.index(ask)))
            return index
        nodes.append(make_leaf(0))
        yes, no = grow(ask.yes), grow(ask.no)
        feature = features.index(ask.feature)
        if ask.arc:
            nodes[index] = Node(TestKind.ARC, feature, *ask.arc, yes, no, no)
        elif ask.absent:
            nodes[index] = Node(TestKind.ABSENT, feature, yes=no, no=yes)
        elif ask.below is not None:
            nodes[index] = Node(TestKind.BELOW, feature, high=ask.below, yes=yes, no=no, absent=no)
        else:
            nodes[index] = Node(TestKind.LABEL, feature, absent=no, branches=(no, yes))
        return index

    grow(ask)
    return Tree(tuple(nodes))
