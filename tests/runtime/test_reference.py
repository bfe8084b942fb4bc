"""The interpreter equals a reference written differently, on random automata and random readings."""

from __future__ import annotations

from math import nan
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from tests.bodies import TICK_S, kit
from tests.runtime.reference import begin, pulse

from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature
from understudy.model.library import Library
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import link

BASICS = ("forward", "lap", "three_laps", "no_laps", "click", "unclick")
TARGETS = ("ball", "goal")
FEATURES: dict[str, tuple[tuple[str, ...], int]] = {  # how the reference reads it, number of labels (0: none)
    "load": (("reading", "load", ""), 0),
    "seen": (("reading", "seen", ""), 2),
    "range_of": (("reading", "range", "A"), 0),
    "bearing_of": (("reading", "bearing", "A"), 0),
    "done": (("flag", "done"), 2),
    "failed": (("flag", "failed"), 2),
    "laps": (("counter", "laps"), 0),
    "watch": (("timer", "watch"), 0),
    "time_in_state": (("time",), 0),
}
CUTS = st.sampled_from([0.0, 0.1, 0.2, 0.3, 1.0, 2.0, 4.0])
NUMBERS = st.sampled_from([0.0, 0.1, 0.3, 1.0, 1.5, 3.0, 5.0, nan])


@st.composite
def trees(draw: st.DrawFn, features: list[Any], states: list[str], depth: int = 3) -> Any:
    """A tree over the features, possibly None: nothing was ever shown here."""
    if draw(st.integers(0, 9)) == 0:
        return None
    if depth == 0 or not features or draw(st.integers(0, 3)) == 0:
        return ("leaf", draw(st.sampled_from([None, *states, *states])))
    feature = draw(st.integers(0, len(features) - 1))
    below = trees(features, states, depth - 1)
    labels = features[feature][2]
    test = draw(st.sampled_from(["absent", "label"] if labels else ["absent", "below", "below", "arc"]))
    if test == "absent":
        return ("absent", feature, draw(below), draw(below))
    if test == "label":
        return ("label", feature, [draw(below) for _ in range(labels)], draw(below))
    return (test, feature, draw(CUTS), draw(CUTS), draw(below), draw(below), draw(below))


@st.composite
def automata(draw: st.DrawFn) -> dict[str, Any]:
    """Up to four automata, each free to use those before it; the last is the root."""
    made: dict[str, Any] = {}
    for name in ("a", "b", "c", "d")[: draw(st.integers(1, 4))]:
        parameters = draw(st.sampled_from([[], ["A"], ["B", "A"]]))
        bindable = st.sampled_from([*parameters, *TARGETS])
        states: dict[str, Any] = {"start": {}}
        for index in range(draw(st.integers(1, 3))):
            behavior = draw(st.sampled_from([*BASICS, "toward", *made, *made]))
            needed = (
                ["A"] if behavior == "toward" else made[behavior]["parameters"] if behavior in made else []
            )
            binding = {parameter: draw(bindable) for parameter in needed}
            states[f"s{index}"] = {"behavior": behavior, "binding": binding}
        for flag in draw(st.sampled_from([[], ["done"], ["failed"], ["done", "failed"]])):
            states[flag] = {"flag": flag}
        features: list[Any] = []
        for label in draw(st.lists(st.sampled_from(list(FEATURES)), max_size=4)):
            read, labels = FEATURES[label]
            of = draw(bindable) if read[-1] == "A" else None
            feature = (label, (*read[:-1], of) if of else read, labels, of)
            if feature not in features:
                features.append(feature)
        inner = [state for state in states if "flag" not in states[state]]
        transitions = {
            state: draw(trees(features, list(states))) or ("leaf", None)
            for state in inner
            if state == "start" or draw(st.integers(0, 4))
        }
        made[name] = {
            "parameters": parameters,
            "states": states,
            "drawn": features,
            "features": [feature[1] for feature in features],
            "transitions": transitions,
        }
    return made


def build_automaton(name: str, me: dict[str, Any]) -> Automaton:
    names = list(me["states"])
    return Automaton(
        name,
        (
            START,
            *(
                State(state, flag=what["flag"])
                if "flag" in what
                else State(state, what["behavior"], Binding(what["binding"]))
                for state, what in list(me["states"].items())[1:]
            ),
        ),
        tuple(
            BoundFeature(kit.features[label], Binding({"A": of} if of else {}))
            for label, _, _, of in me["drawn"]
        ),
        tuple(me["parameters"]),
        transitions={state: flat(tree, names) for state, tree in me["transitions"].items()},
    )


def flat(tree: Any, names: list[str]) -> Tree:
    """The same tree as nodes."""
    nodes: list[Node] = []

    def add(tree: Any) -> int:
        if tree is None:
            return STAY
        at = len(nodes)
        nodes.append(make_leaf(STAY))
        test, feature, *rest = tree if tree[0] != "leaf" else ("leaf", 0, tree[1])
        if test == "leaf":
            nodes[at] = make_leaf(STAY if rest[0] is None else names.index(rest[0]))
        elif test == "absent":
            nodes[at] = Node(TestKind.ABSENT, feature, yes=add(rest[0]), no=add(rest[1]))
        elif test == "label":
            branches = tuple(add(branch) for branch in rest[0])
            nodes[at] = Node(TestKind.LABEL, feature, absent=add(rest[1]), branches=branches)
        else:
            low, high, inside, outside, away = rest
            sort = TestKind.BELOW if test == "below" else TestKind.ARC
            nodes[at] = Node(sort, feature, low, high, add(inside), add(outside), add(away))
        return at

    add(tree)
    return Tree(tuple(nodes))


PERCEPTS = st.fixed_dictionaries(
    {
        ("load", ""): NUMBERS,
        ("seen", ""): st.sampled_from([0.0, 1.0, nan]),
        **{(reading, target): NUMBERS for reading in ("range", "bearing") for target in TARGETS},
    }
)


@settings(max_examples=200)
@given(data=st.data(), first=st.integers(0, 40))
def test_the_interpreter_equals_the_reference(data: st.DataObject, first: int) -> None:
    made = data.draw(automata())
    *_, root = made
    bound = {parameter: data.draw(st.sampled_from(TARGETS)) for parameter in made[root]["parameters"]}
    program = link(
        Library.from_automata(kit, *(build_automaton(name, me) for name, me in made.items())), root, bound
    )
    interpreter = Interpreter(program, now=first * TICK_S)
    memory = begin(made, root, first)
    for tick, percept in enumerate(data.draw(st.lists(PERCEPTS, min_size=1, max_size=25)), first):
        row = [
            percept[str(feature.feature.reading), next(iter(feature.binding.values()), "")]  # type: ignore[union-attr]
            for feature in program.features
        ]
        if data.draw(st.integers(0, 7)) == 0:  # going back to where one is changes nothing
            interpreter.restore(interpreter.snapshot(tick * TICK_S), now=tick * TICK_S)
        answered = program.basics[interpreter.pulse(row, tick * TICK_S)]
        expected = pulse(made, root, memory, bound, percept, tick)
        assert (answered.behavior.name, dict(answered.binding)) == expected
        assert list(interpreter.path) == path(memory)


def path(memory: dict[str, Any] | None) -> list[str]:
    return [] if memory is None else [memory["state"], *path(memory["child"])]
