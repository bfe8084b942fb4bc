"""Random libraries, programs and percepts, for whatever has to agree with the interpreter.

All is drawn from a `random.Random`: a seed says which library it was. Cuts and readings come from the same few
numbers, so that readings often lie on a boundary.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import nan, tau
from random import Random

import numpy as np

from understudy.model.automaton import START, Automaton, State, Transition
from understudy.model.behaviors import (
    Behavior,
    Command,
    increment,
    reset_counter,
    reset_timer,
    set_counter,
    set_timer,
)
from understudy.model.binding import Binding, Target
from understudy.model.features import (
    BoundFeature,
    CounterFeature,
    Feature,
    FlagFeature,
    Percept,
    ReadingKey,
    TimeInState,
    TimerFeature,
)
from understudy.model.library import Kit, Library
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import BOOLEAN, Categorical, Column, Continuous, Toroidal
from understudy.runtime.body import Channel, Commands, Reading, list_reading_keys
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import IDLE_PROGRAM, GroundBehavior, Program, link

NUMBERS = (0.0, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 3.0, 6.0)
COLORS = Categorical(("red", "green", "blue", "gray", "black"))
FLAGS = ("done", "failed")
TICKS_S = (0.1, 0.1, 0.1, 0.03, 0.25, 1 / 3)

kit = Kit.from_parts(
    Feature("range_of", Continuous(), "range", of="A"),
    Feature("bearing_of", Toroidal(), "bearing", of="A"),
    Feature("color_of", COLORS, "color", of="A"),
    Feature("load", Continuous(), "load"),
    Feature("seen", BOOLEAN, "seen"),
    *(FlagFeature(flag) for flag in FLAGS),
    *(CounterFeature(name) for name in ("laps", "falls")),
    *(TimerFeature(name) for name in ("watch", "bell")),
    TimeInState(),
    Behavior("forward", Command(drive=1.0)),
    Behavior("left", Command(turn=1.0)),
    Behavior("toward", Command(drive=0.5, turn=0.25), parameters=("A",)),
    Behavior("lap", Command(drive=0.5), (increment("laps"),)),
    Behavior("slip", changes=(increment("falls", -0.1), increment("laps", 0.1), set_timer("bell"))),
    Behavior("three_laps", changes=(set_counter("laps", 3.0), reset_counter("falls"))),
    Behavior("no_laps", changes=(reset_counter("laps"), reset_timer("bell"))),
    Behavior("click", Command(turn=-1.0), (set_timer("watch"),)),
    Behavior("unclick", changes=(reset_timer("watch"), increment("unread"))),
    Target("ball"),
    Target("goal"),
)
OWN = (*FLAGS, "laps", "falls", "watch", "bell", "time_in_state")


class Played:
    """N agents that sense the percepts given and obey anything; after the last percept comes the first again."""

    targets = ("ball", "goal")
    channels = (Channel("drive"), Channel("turn", rest=0.5))
    readings = (
        Reading("range", Continuous(), of_targets=True),
        Reading("bearing", Toroidal(), of_targets=True),
        Reading("color", COLORS, of_targets=True),
        Reading("load", Continuous()),
        Reading("seen", BOOLEAN),
    )
    tick_s = TICKS_S[0]

    def __init__(self, percepts: Sequence[Percept], ticks_s: Sequence[float], begin_s: float = 0.0) -> None:
        self.agents = len(next(iter(percepts[0].values())))
        self.percepts, self.ticks_s = percepts, ticks_s
        self.tick, self.time_s = 0, begin_s
        self.commanded: list[dict[str, list[float]]] = []

    def sense(self, keys: Sequence[ReadingKey]) -> Percept:
        percept = self.percepts[self.tick % len(self.percepts)]
        return {key: percept[key] for key in keys}

    def act(self, commands: Commands) -> None:
        self.commanded.append({channel: column.tolist() for channel, column in commands.items()})
        self.time_s += self.ticks_s[self.tick % len(self.ticks_s)]
        self.tick += 1


def play_random_body(random: Random, *, agents: int, ticks: int) -> Played:
    """A body with percepts of its own for that many ticks; its clock began at some time, and jitters."""
    ticks_s = [random.choice(TICKS_S) for _ in range(ticks)]
    blank = Played([{("load", None): np.zeros(agents)}], ticks_s)
    kinds = {reading.name: reading.kind for reading in blank.readings}
    drawn = {Continuous(): NUMBERS, Toroidal(): tuple(x for x in NUMBERS if x < tau)}

    def column(key: ReadingKey) -> Column:
        kind = kinds[key[0]]
        values = range(len(kind.labels)) if isinstance(kind, Categorical) else drawn[kind]
        return np.array(random.choices((*values, nan), k=agents), np.float64)

    percepts = [{key: column(key) for key in list_reading_keys(blank)} for _ in range(ticks)]
    return Played(percepts, ticks_s, random.choice((0.0, 1e5 / 3, -2.5)))


def draw_library(
    random: Random, *, automata: int = 4, depth: int = 4, kit: Kit = kit, name: str = "a"
) -> Library:
    """A library of that many automata, a0 and on, each of which may use those before it; trees this deep at most.

    The last one uses the one before it, and so down to the first.
    """
    library = Library(kit)
    for number in range(automata):
        made = _automaton(random, library, depth, f"{name}{number}")
        library = Library.from_automata(kit, *map(library.automaton, library.taught), made)
    return library


def draw_program(random: Random, library: Library) -> Program:
    """An automaton of the library, most likely the last, or a basic behavior, or idling; its parameters bound."""
    if random.random() < 0.05:
        return IDLE_PROGRAM
    names = list(library.taught)
    name = random.choice([*names, *names[-1:] * 4 * len(names), "forward", "toward"])
    return link(library, name, {each: random.choice(Played.targets) for each in library.parameters(name)})


def _automaton(random: Random, library: Library, depth: int, name: str) -> Automaton:
    parameters = random.choice(((), ("A",), ("B", "A")))
    bindable = (*parameters, *Played.targets)
    states = [START]
    behaviors = [*library.kit.behaviors, *list(library.taught) * 4]
    for index in range(random.randint(1, 5)):
        behavior = list(library.taught)[-1] if library.taught and not index else random.choice(behaviors)
        binding = {each: random.choice(bindable) for each in library.parameters(behavior)}
        states.append(State(f"s{index}", random.choice((behavior,) * 9 + (None,)), Binding(binding)))
        if states[-1].behavior is None:
            states[-1] = State(f"s{index}")
    states.extend(State(flag, flag=flag) for flag in random.sample(FLAGS, random.randint(0, 2)))
    features = list(
        dict.fromkeys(_feature(random, library.kit, bindable) for _ in range(random.randint(0, 6)))
    )
    stateless = random.random() < 0.2
    return Automaton(
        name,
        tuple(states),
        tuple(features),
        parameters,
        stateless,
        _transitions(random, states, features, depth, stateless=stateless),
    )


def _feature(random: Random, kit: Kit, bindable: Sequence[str]) -> BoundFeature:
    name = random.choice([*kit.features, *(own for own in OWN if own in kit.features)])
    feature = kit.features[name]
    return BoundFeature(feature, Binding({each: random.choice(bindable) for each in feature.parameters}))


def _transitions(
    random: Random, states: Sequence[State], features: Sequence[BoundFeature], depth: int, *, stateless: bool
) -> Mapping[str, Transition]:
    """A tree for most states that raise no flag; one for all in a stateless automaton."""
    lasting = [state.name for state in states if state.flag is None]
    if stateless:
        return dict.fromkeys(lasting, draw_tree(random, states, features, depth))
    return {
        name: draw_tree(random, states, features, depth)
        for name in lasting
        if name == "start" or random.random() < 0.9
    }


def draw_tree(random: Random, states: Sequence[State], features: Sequence[BoundFeature], depth: int) -> Tree:
    """A tree over the features with every sort of node, which flags seldom end."""
    nodes: list[Node] = []
    lasting = [index for index, state in enumerate(states) if state.flag is None]
    outcomes = [STAY, *range(len(states)), *lasting, *[1] * 4]

    def add(left: int) -> int:
        """The index of a node with `left` levels below it, or STAY: nothing was ever shown there."""
        if random.random() < 0.05 and nodes:
            return STAY
        at = len(nodes)
        nodes.append(make_leaf(random.choice(outcomes)))
        if left and features and random.random() < 0.85:
            nodes[at] = _node(random, features, lambda: add(left - 1))
        return at

    add(depth)
    return Tree(tuple(nodes))


def _node(random: Random, features: Sequence[BoundFeature], below: Callable[[], int]) -> Node:
    position = random.randrange(len(features))
    kind = features[position].kind
    if random.random() < 0.15:
        return Node(TestKind.ABSENT, position, yes=below(), no=below())
    if isinstance(kind, Categorical):
        branches = tuple(below() for _ in kind.labels)
        return Node(TestKind.LABEL, position, absent=random.choice((*branches, STAY)), branches=branches)
    sort = random.choice((TestKind.BELOW, TestKind.ARC))
    low, high = random.choice(NUMBERS), random.choice(NUMBERS)
    yes, no = below(), below()
    return Node(sort, position, low, high, yes, no, random.choice((yes, no, STAY)))


def row(program: Program, percept: Percept, agent: int) -> list[float]:
    """One agent's values of a program's features, all of them readings."""
    found = []
    for bound in program.features:
        reading = bound.feature.reading if isinstance(bound.feature, Feature) else None
        found.append(float(percept[str(reading), bound.binding.get("A")][agent]))
    return found


def pulse_each(interpreters: Sequence[Interpreter], percept: Percept, now: float) -> list[GroundBehavior]:
    """What each agent's interpreter runs on a percept."""
    return [
        each.program.basics[each.pulse(row(each.program, percept, agent), now)]
        for agent, each in enumerate(interpreters)
    ]
