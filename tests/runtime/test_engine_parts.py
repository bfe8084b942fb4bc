"""What an engine is made of: functions, classifiers, bodies that go on by themselves, and what it refuses."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from math import inf, nan
from random import Random
from typing import Any

import numpy as np
import pytest
from sklearn.tree import DecisionTreeClassifier
from tests.bodies import RANGE, Scripted, kit
from tests.make.programs import link_program, make_automaton, make_calling_state
from tests.runtime.random_libraries import Played, draw_library, draw_program, play_random_body

from understudy.errors import DefinitionError, KindError, SettingError, UnderstudyError, UnknownName
from understudy.learning.sklearn_adapter import ClassifierTransition
from understudy.model.automaton import START, Automaton, State, Transition
from understudy.model.behaviors import Behavior, Command, StateEffect, behavior, increment, set_counter
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature, Percept, ReadingsView, feature
from understudy.model.library import Kit, Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import BOOLEAN, Column, Continuous
from understudy.runtime.body import FusedPlan
from understudy.runtime.engine import _pulse_kernels, tables
from understudy.runtime.engine.compiler import compile_programs
from understudy.runtime.engine.engine import Engine
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import IDLE_PROGRAM, link
from understudy.runtime.run_loop import Run

BALL = Binding(A="ball")
FAR = Tree((Node(TestKind.BELOW, 0, high=99.0, yes=1, no=2), make_leaf(2), make_leaf(1)))


def go(transition: Transition, *, feature: str = "range_of", does: str = "forward") -> Automaton:
    """From the start to a state, and from there to another, as one transition function says of the ball."""
    states = (START, State("on", does), State("off", "left"))
    features = (BoundFeature(kit.features[feature], BALL),)
    return Automaton("go", states, features, transitions=dict.fromkeys(("start", "on", "off"), transition))


def test_functions_compute_as_in_a_run() -> None:
    """A feature and a behavior that are functions, at different times for each agent."""
    opposite = Tree((Node(TestKind.ARC, 0, 2.8, 3.5, 1, 2), make_leaf(1), make_leaf(2)))
    turning = Automaton(
        "turning",
        (START, State("toward", "toward", BALL), State("left", "left")),
        (BoundFeature(kit.features["opposite"], BALL), BoundFeature(kit.features["range_of"], BALL)),
        transitions={
            "start": opposite,
            "toward": Tree((Node(TestKind.BELOW, 1, high=98.0, yes=1, no=2), make_leaf(2), make_leaf(1))),
            "left": opposite,
        },
    )
    programs = [
        link_program(turning),
        link_program(turning),
        link(Library(kit), "toward", {"A": "goal"}),
        IDLE_PROGRAM,
    ]
    bodies = Scripted(4), Scripted(4)
    engine, run = Engine(bodies[0], programs), Run(bodies[1], [Interpreter(program) for program in programs])
    for _ in range(12):
        engine.tick()
        run.tick()
    assert bodies[0].commanded == bodies[1].commanded
    assert set(engine.keys) == set(run.keys)
    assert engine.plan() is None


@behavior
def flee(robot: ReadingsView) -> dict[str, Column]:
    """In one library."""
    return {"drive": -robot.load}


def test_functions_of_one_name_are_told_apart() -> None:
    def other(robot: ReadingsView) -> dict[str, Column]:
        return {"drive": robot.load + 1.0}

    other.__name__, other.__doc__ = "flee", flee.doc
    same = behavior(other)
    assert same == flee  # as parts of a kit they are alike
    programs = [link(Library(Kit.from_parts(part)), "flee") for part in (flee, same)]
    body = Scripted(2, {**RANGE, ("load", None): lambda tick: 3.0})
    Engine(body, programs).tick()
    assert body.commanded[0]["drive"] == [-3.0, 4.0]


def test_programs_with_parts_in_common_share_them() -> None:
    library = Library.from_automata(kit, go(FAR))
    once = compile_programs([link(library, "go")])
    many = compile_programs([link(library, "go") for _ in range(50)] + [IDLE_PROGRAM])
    assert len(once.places) == len(many.places) == 3
    assert many.roots.tolist() == [0] * 50 + [-1]
    assert (many.depth, many.slots, len(many.basics)) == (1, 0, 3)


def test_slots_are_shared_by_what_never_runs_at_once() -> None:
    """Slots begin after those of whichever automaton around it has most, in any of the programs."""
    counting = make_automaton("counting", ["lap"], features=["laps"])
    clicking = make_automaton("clicking", ["lap", "click"])
    inner = [make_calling_state("one", "counting"), make_calling_state("two", "clicking")]
    plain = make_automaton("plain", inner)
    outer = make_automaton("outer", [*inner, "lap", "click"])
    library = Library.from_automata(kit, counting, clicking, plain, outer)
    compiled = compile_programs([link(library, "plain"), link(library, "outer")])
    assert {str(place): dict(place.memory) for place in compiled.places if place.state == "start"} == {
        "plain/start": {},
        "outer/start": {("counter", "laps"): 0, ("timer", "watch"): 1},
        "counting/start": {("counter", "laps"): 2},
        "clicking/start": {("counter", "laps"): 2, ("timer", "watch"): 3},
    }
    assert compiled.slots == 4


# Transition functions that are no trees.


def classifier() -> ClassifierTransition:
    """On below 99 m, else off."""
    fitted = DecisionTreeClassifier(random_state=0).fit([[0, 90], [0, 98], [0, 99], [0, 110]], [1, 1, 2, 2])
    return ClassifierTransition(fitted, (Continuous(),))


class Alone:
    """The same as a tree does, one at a time."""

    def decide(self, values: Sequence[float], /) -> int:
        return FAR.decide(values)

    def path(self, values: Sequence[float], /) -> Any:
        return FAR.path(values)


def test_classifiers_are_asked_for_all_agents_that_wait() -> None:
    inner = go(classifier())
    outer = make_automaton(
        "outer",
        [State("go", "go"), "left"],
        {"start": lambda seen: "go", "go": lambda seen: "left" if seen else None, "left": lambda seen: "go"},
        features=["seen"],
        library=Library.from_automata(kit, inner),
    )
    trees = go(FAR)
    programs = [
        link_program(inner, outer),
        link_program(inner),
        link_program(trees),
        link_program(go(Alone())),
        IDLE_PROGRAM,
    ]
    bodies = Scripted(5), Scripted(5)
    engine, run = Engine(bodies[0], programs), Run(bodies[1], [Interpreter(program) for program in programs])
    for _ in range(12):
        engine.tick()
        run.tick()
        assert [engine.path(agent) for agent in range(5)] == [each.path for each in run.interpreters]
    assert bodies[0].commanded == bodies[1].commanded
    assert engine.slow == ("go/start", "go/on", "go/off", "outer/start", "outer/go", "outer/left")
    assert engine.plan() is None


class Answering:
    """Answers what it is told to."""

    def __init__(self, answer: int) -> None:
        self.answer = answer

    def decide(self, values: Sequence[float], /) -> int:
        return self.answer

    path = Alone.path


def test_an_answer_that_is_no_state_is_refused() -> None:
    engine = Engine(Scripted(2), [link_program(go(FAR)), link_program(go(Answering(3)))])
    with pytest.raises(DefinitionError, match="its transition function answered 3 for agent 1"):
        engine.tick()
    assert engine.running.min() >= 0  # nobody is left waiting


# Bodies that go on by themselves.


class Advancing(Played):
    """Advances by itself, agent by agent rather than tick by tick as a column."""

    advanced = 0

    def advance(self, plan: FusedPlan, ticks: int, threads: int | None) -> None:
        self.advanced += ticks
        for _ in range(ticks):
            percept = self.sense(plan.keys)
            columns = np.array([percept[key] for key in plan.keys]).reshape(len(plan.keys), self.agents)
            _pulse_kernels.pulse_agents(
                columns, self.time_s, plan.tables, plan.stacks, plan.running, 0, self.agents
            )
            channels = [channel.name for channel in self.channels]
            self.act(dict(zip(channels, plan.commands[plan.running].T, strict=True)))


def test_a_fused_body_advances_as_tick_by_tick() -> None:
    random = Random(3)
    library = draw_library(random)
    programs = [draw_program(random, library) for _ in range(8)]
    plain = play_random_body(random, agents=8, ticks=20)
    fused = Advancing(plain.percepts, plain.ticks_s, plain.time_s)
    engines = Engine(plain, programs), Engine(fused, programs)
    for engine in engines:
        engine.run(30)
    assert (fused.advanced, fused.commanded) == (30, plain.commanded)
    assert engines[0].running.tolist() == engines[1].running.tolist()
    assert [engines[0].levels(agent) for agent in range(8)] == [
        engines[1].levels(agent) for agent in range(8)
    ]


@pytest.mark.parametrize(
    "part",
    [go(FAR, feature="opposite"), go(FAR, does="computed"), go(Alone())],
    ids=["feature", "behavior", "transition"],
)
def test_a_fused_body_ticks_where_python_is_needed(part: Automaton) -> None:
    class Hurried(Scripted):
        def advance(self, plan: FusedPlan, ticks: int, threads: int | None) -> None:
            raise NotImplementedError

    computed = Behavior("computed", function=lambda robot: {"drive": robot.load})
    program = link(Library.from_automata(kit + Kit.from_parts(computed), part), "go")
    body = Hurried(2)
    Engine.from_program(body, program).run(3)
    assert body.tick == 3
    with pytest.raises(NotImplementedError):
        Engine.from_program(body, link_program(go(FAR))).run(3)


# What is refused.

TREES: list[tuple[tuple[Node, ...], str]] = [
    ((make_leaf(3),), "answers state 3 of 3"),
    ((make_leaf(-2),), "answers state -2 of 3"),
    ((Node(TestKind.BELOW, 1, high=1.0, yes=1, no=1), make_leaf(0)), "asks for feature 1 of 1"),
    (
        (Node(TestKind.BELOW, 0, yes=1, no=1), make_leaf(0)),
        r"has a boundary of range_of\(ball\) that is not a number",
    ),
    ((Node(TestKind.LABEL, 0, branches=(1, 1)), make_leaf(0)), "has 2 branches for the 0 labels of range_of"),
]


@pytest.mark.parametrize(("nodes", "says"), TREES)
def test_a_tree_that_does_not_fit_is_refused(nodes: tuple[Node, ...], says: str) -> None:
    with pytest.raises(DefinitionError, match=f"automaton 'go', state 'start': its tree {says}"):
        compile_programs([link_program(go(Tree(nodes)))])


def test_what_does_not_fit_an_engine() -> None:
    body = Scripted(2)
    with pytest.raises(SettingError, match="programs are 1 for 2 agents"):
        Engine(body, [IDLE_PROGRAM])
    engine = Engine.from_program(body, link_program(go(FAR)))
    with pytest.raises(SettingError, match="threads are 0"):
        engine.run(1, threads=0)
    bad = engine.snapshot()
    bad.state[1, 0] = 3
    for snapshot in (bad, Engine.from_program(Scripted(3), link_program(go(FAR))).snapshot()):
        with pytest.raises(SettingError, match="snapshot is of other programs"):
            engine.restore(snapshot)
    with pytest.raises(UnknownName, match="channel 'rise'"):
        Engine.from_program(body, link(Library(Kit.from_parts(Behavior("fly", Command(rise=1.0)))), "fly"))


def of(value: float, agent: int) -> Callable[[ReadingsView], Column]:
    """A function that gives one agent this value, and others 1."""

    def read_value(robot: ReadingsView) -> Column:
        return np.where(np.arange(len(robot.load)) == agent, value, 1.0)

    return read_value


class Odd(Scripted):
    """Senses something that it should not."""

    def __init__(self, column: Column, key: tuple[str, str | None]) -> None:
        super().__init__(3)
        self.column, self.key = column, key

    def sense(self, keys: Sequence[tuple[str, str | None]]) -> Percept:
        return {**super().sense(keys), **({self.key: self.column} if self.key in keys else {})}


SEEN = Tree((Node(TestKind.LABEL, 0, branches=(1, 2)), make_leaf(1), make_leaf(2)))
SENSED: list[tuple[Any, str, tuple[str, str | None], type[UnderstudyError], str]] = [
    ([0, inf, 3], "seen", ("seen", None), KindError, "feature 'seen' of agent 2: 3.0 is not the index of a"),
    ([0, 0.5, 0], "seen", ("seen", None), KindError, "feature 'seen' of agent 1: 0.5 is not the index of a"),
    ([2, nan, 0], "seen", ("seen", None), KindError, "feature 'seen' of agent 0: 2.0 is not the index of a"),
    (
        [1, 1],
        "load",
        ("load", None),
        DefinitionError,
        r"the body's reading 'load' has shape \(2,\); return one",
    ),
]


@pytest.mark.parametrize(("column", "name", "key", "error", "says"), SENSED)
@pytest.mark.parametrize("runs", [Run, Engine])
def test_a_reading_that_makes_no_sense(
    runs: Any, column: Any, name: str, key: tuple[str, str | None], error: type[UnderstudyError], says: str
) -> None:
    tree = SEEN if name == "seen" else FAR
    states = (START, State("on", "forward"), State("off", "left"))
    one = Automaton("one", states, (BoundFeature(kit.features[name]),), transitions={"start": tree})
    with pytest.raises(error, match=says):
        runs.from_program(Odd(np.array(column, np.float64), key), link_program(one)).tick()


@pytest.mark.parametrize("runs", [Run, Engine])
def test_a_function_that_makes_no_sense(runs: Any) -> None:
    odd = behavior(lambda robot: {"drive": of(nan, 2)(robot)})
    sensed = feature(BOOLEAN)(of(4.0, 1))
    library = Library(kit + Kit.from_parts(odd, sensed))
    with pytest.raises(DefinitionError, match="channel 'drive' is not finite for agent 2: it is nan"):
        runs.from_program(Scripted(3), link(library, odd.name)).tick()
    one = Automaton("one", (START,), (BoundFeature(sensed),), transitions={"start": Tree((make_leaf(0),))})
    with pytest.raises(KindError, match=r"feature 'read_value' of agent 1: 4\.0 is not the index"):
        runs.from_program(Scripted(3), link(Library.from_automata(library.kit, one), "one")).tick()


def test_kernels_and_tables_mean_the_same_by_their_numbers() -> None:
    names = ("FLAG", "COUNTER", "TIMER", "TIME", "SET", "ADD", "CLOCK", "ASKED")
    assert [getattr(_pulse_kernels, name) for name in names] == [getattr(tables, name) for name in names]
    assert tables.NODE.itemsize == 32


@pytest.mark.parametrize("value", [nan, inf, -inf, 1e308, -(2.0**53) - 2])
@pytest.mark.parametrize("change", [set_counter, increment])
def test_a_counter_holds_a_number_that_never_becomes_infinite(
    change: Callable[[str, float], StateEffect], value: float
) -> None:
    problem = (
        f"counter 'laps': a behavior changes it by or to {value}; give a number from -9007199254740992 to"
    )
    with pytest.raises(DefinitionError, match=re.escape(problem)):
        change("laps", value)
    assert change("laps", -(2.0**53)).value == -(2.0**53)
