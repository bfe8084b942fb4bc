"""Random lessons, as odd as the model allows."""

from __future__ import annotations

from dataclasses import replace
from math import nan
from typing import Any

import numpy as np
from hypothesis import strategies as st

from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.example_source import ExampleSource
from understudy.model.features import (
    AnyFeature,
    BoundFeature,
    CounterFeature,
    Feature,
    FlagFeature,
    TimeInState,
    TimerFeature,
)
from understudy.model.learner_options import LONGEST_REACTION_S, LearnerOptions, TreeOptions
from understudy.model.lesson import Example, ExampleKind, Lesson, ReadingLog
from understudy.model.library import Kit, TrainedAutomaton
from understudy.model.property import Property, PropertyKind, StoredMoment
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import BOOLEAN, Categorical, Continuous, Kind, Toroidal

names = st.one_of(
    st.sampled_from(
        ["stay", "go to", "größe", "状態", "a.b[0]", '"quoted"', "\\", "null", "*", "e\u0301", "\u2028"]
    ),
    st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=12),
)
numbers = st.floats(allow_nan=False, allow_infinity=False)
labels = st.lists(
    st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=6).filter(
        lambda label: "|" not in label and label == label.strip()
    ),
    min_size=1,
    max_size=4,
    unique=True,
).map(tuple)
kinds: st.SearchStrategy[Kind] = st.one_of(
    st.just(Continuous()),
    st.builds(Toroidal, st.floats(1e-3, 1e6)),
    st.builds(Categorical, labels),
)


def values(kind: Kind) -> st.SearchStrategy[float]:
    """Values of a kind, absent ones among them."""
    if isinstance(kind, Categorical):
        inside: st.SearchStrategy[float] = st.integers(0, len(kind.labels) - 1).map(float)
    elif isinstance(kind, Toroidal):
        inside = st.floats(0, kind.period, exclude_max=True)
    else:
        inside = numbers
    return inside | st.just(nan)


@st.composite
def draw_bound_features(draw: Any) -> tuple[BoundFeature, ...]:
    chosen: list[BoundFeature] = []
    for name in draw(st.lists(names, max_size=4, unique=True)):
        kind = draw(kinds)
        feature: AnyFeature = draw(
            st.sampled_from(
                [
                    Feature(name, kind, reading="x", unit="m"),
                    Feature(name, kind, reading="x", of="A"),
                    FlagFeature(name),
                    CounterFeature(name),
                    TimerFeature(name),
                    TimeInState(name),
                ]
            )
        )
        binding = Binding({parameter: draw(names) for parameter in feature.parameters})
        chosen.append(BoundFeature(feature, binding))
    distinct = {str(bound): bound for bound in chosen}
    return tuple(distinct.values())


@st.composite
def trees(draw: Any, features: tuple[BoundFeature, ...], states: int) -> Tree:
    """A tree whose children come after their parents, some of them shared."""
    leaves = draw(st.integers(1, 4))
    tests = draw(st.integers(0, 4)) if features else 0
    size = tests + leaves
    nodes: list[Node] = []
    for index in range(tests):
        child = st.integers(index + 1, size - 1) | st.just(STAY)
        feature = draw(st.integers(0, len(features) - 1))
        kind = features[feature].kind
        yes, no, absent = draw(child), draw(child), draw(child)
        if isinstance(kind, Categorical):
            branches = tuple(draw(child) for _ in kind.labels)
            nodes.append(Node(TestKind.LABEL, feature, absent=absent, branches=branches))
        elif isinstance(kind, Toroidal) and draw(st.booleans()):
            nodes.append(Node(TestKind.ARC, feature, draw(numbers), draw(numbers), yes, no, absent))
        elif draw(st.booleans()):
            nodes.append(Node(TestKind.ABSENT, feature, yes=yes, no=no))
        else:
            nodes.append(Node(TestKind.BELOW, feature, high=draw(numbers), yes=yes, no=no, absent=absent))
    nodes += [make_leaf(draw(st.integers(STAY, states - 1))) for _ in range(leaves)]
    return Tree(tuple(nodes))


@st.composite
def records(draw: Any) -> ReadingLog:
    keys = tuple(draw(st.lists(st.tuples(names, names | st.none()), max_size=3, unique=True)))
    moments = draw(st.integers(0, 5))
    any_number = st.floats(width=64)  # NaN and infinities too: a record is what was read
    rows = [[draw(any_number) for _ in keys] for _ in range(moments)]
    seconds = np.array([draw(numbers) for _ in range(moments)], dtype=np.float64)
    return ReadingLog(keys, np.array(rows, dtype=np.float64).reshape(moments, len(keys)), seconds)


@st.composite
def draw_automaton(draw: Any) -> TrainedAutomaton:
    """An automaton with its lesson, learned (from trees drawn at random)."""
    features = draw(draw_bound_features())
    others = draw(st.lists(names.filter(lambda name: name != "start"), min_size=1, max_size=4, unique=True))
    states = [START]
    for name in others:
        flag = draw(st.none() | names)
        states.append(
            State(name, flag=flag)
            if flag is not None
            else State(
                name, draw(st.none() | names), Binding(draw(st.dictionaries(names, names, max_size=2)))
            )
        )
    parameters = tuple(draw(st.lists(names, max_size=2, unique=True)))
    bare = Automaton(draw(names), tuple(states), features, parameters, draw(st.booleans()))
    record = draw(records())
    promised = tuple(draw(st.lists(properties(), max_size=2)))
    lesson = Lesson(bare, draw(examples(bare, len(record))), draw(options()), record, promised)
    movable = [state.name for state in states if state.flag is None]
    return TrainedAutomaton(
        replace(bare, transitions={name: draw(trees(features, len(states))) for name in movable}), lesson
    )


@st.composite
def examples(draw: Any, automaton: Automaton, moments: int) -> tuple[Example, ...]:
    made = []
    states = st.sampled_from(automaton.state_names)
    for number in sorted(draw(st.sets(st.integers(0, 2**40), max_size=6))):
        moment = draw(st.none() | st.integers(0, moments - 1)) if moments else None
        kind = draw(st.sampled_from(list(ExampleKind)))
        made.append(
            Example(
                number,
                draw(states),
                tuple(draw(values(bound.kind)) for bound in automaton.features),
                draw(states),
                kind,
                draw(st.booleans()),
                draw(st.booleans()),
                moment,
                0 if moment is None else draw(st.integers(0, moment)),
                draw(st.dictionaries(names, numbers | st.just(nan), max_size=2)),
                Binding(draw(st.dictionaries(names, names, max_size=2))),
                reaction_s=None
                if kind is ExampleKind.WATCHED
                else draw(st.none() | st.floats(0.0, LONGEST_REACTION_S)),
                source=draw(st.none() | sources),
            )
        )
    return tuple(made)


sources = st.builds(
    ExampleSource,
    st.sampled_from(["a.csv", "b.csv"]),
    st.floats(-1e6, 1e6),
    st.sampled_from(["", "anna", "ben"]),
    st.floats(0.0, 1.0),
)


@st.composite
def properties(draw: st.DrawFn) -> Property:
    text = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
    limits = st.none() | st.floats(1.0, 1e4)
    moments = st.builds(StoredMoment, text, text, st.binary(max_size=40), st.integers(0, 9), text, limits)
    kind = draw(st.sampled_from(PropertyKind))
    what = draw(names.map(lambda flag: f"{flag} is raised") | text)
    return Property(
        kind=kind,
        what=what,
        seconds=None if kind is PropertyKind.NEVER else draw(st.floats(1e-3, 1e4)),
        start=draw(moments),
        targets=Binding(draw(st.dictionaries(names, names, max_size=2))),
    )


def options() -> st.SearchStrategy[LearnerOptions]:
    return st.builds(
        LearnerOptions,
        st.floats(0, LONGEST_REACTION_S),
        st.booleans(),
        st.builds(
            TreeOptions,
            st.sampled_from(["default keeps the gap", "midpoint"]),
            st.booleans(),
            st.floats(0, 100),
        ),
    )


def make_kit(automaton: Automaton) -> Kit:
    """A kit with the features that an automaton uses."""
    return Kit({bound.feature.name: bound.feature for bound in automaton.features}, {}, {})


DISTANCE = Feature("distance_to", Continuous(), reading="range", of="A", unit="m")
ANGLE = Feature("angle_to", Toroidal(), reading="bearing", of="A", unit="rad")
READY = Feature("ready", BOOLEAN, reading="ready")
TO_A = Binding(A="A")


def make_goto(name: str = "goto") -> TrainedAutomaton:
    """A small automaton with a lesson, whose every part a test can spoil."""
    bare = Automaton(
        name,
        (START, State("forward", "forward"), State("done", flag="done")),
        (
            BoundFeature(DISTANCE, TO_A),
            BoundFeature(ANGLE, TO_A),
            BoundFeature(READY),
            BoundFeature(FlagFeature("bump")),
        ),
        ("A",),
    )
    tree = Tree(
        (
            Node(TestKind.BELOW, 0, high=0.4, yes=1, no=2),
            make_leaf(2),
            Node(TestKind.ARC, 1, low=6.0, high=0.3, yes=3, no=4),
            make_leaf(1),
            Node(TestKind.LABEL, 2, branches=(5, STAY)),
            make_leaf(STAY),
        )
    )
    directive, watched = ExampleKind.DIRECTIVE, ExampleKind.WATCHED
    shown = (
        Example(
            1, "start", (5.5, 0.25, 1.0, 0.0), "forward", directive, moment=2, window=2, own={"bump": 0.0}
        ),
        Example(
            2,
            "forward",
            (5.5, nan, 1.0, 0.0),
            "forward",
            ExampleKind.DEFAULT,
            moment=2,
            binding=Binding(A="home"),
        ),
        Example(3, "forward", (4.0, 0.5, 1.0, 0.0), "forward", watched, moment=3),
        Example(4, "forward", (3.0, 0.5, nan, 0.0), "forward", watched, moment=4),
    )
    record = ReadingLog(
        (("range", "home"), ("ready", None)), np.arange(10.0).reshape(5, 2) / 3, np.arange(5.0)
    )
    lesson = Lesson(bare, shown, LearnerOptions(0.2, True), record)
    return TrainedAutomaton(replace(bare, transitions={"start": tree, "forward": tree}), lesson)
