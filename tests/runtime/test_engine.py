"""The engine equals the interpreter, tick by tick, whatever it runs."""

from __future__ import annotations

from math import inf
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.bodies import Scripted
from tests.bodies import kit as scripted_kit
from tests.make.programs import link_program, make_calling_state
from tests.runtime.random_libraries import Played, draw_library, draw_program, play_random_body, pulse_each

from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.runtime.engine.engine import Engine
from understudy.runtime.engine.tables import flatten_tree
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import Program

CASES = st.builds(Random, st.integers(0, 2**32))


def draw_programs(random: Random, *, agents: int, automata: int, depth: int) -> tuple[Played, list[Program]]:
    """A body, and programs for its agents: of two libraries, most of them of the first."""
    libraries = [draw_library(random, automata=automata, depth=depth) for _ in range(2)]
    programs = [draw_program(random, random.choice(libraries[:1] * 3 + libraries[1:])) for _ in range(agents)]
    return play_random_body(random, agents=agents, ticks=30), programs


@settings(max_examples=200)
@given(CASES, st.integers(1, 5), st.integers(1, 4), st.integers(0, 4))
def test_the_engine_equals_the_interpreter(random: Random, agents: int, automata: int, depth: int) -> None:
    body, programs = draw_programs(random, agents=agents, automata=automata, depth=depth)
    engine = Engine(body, programs)
    interpreters = [Interpreter(program, now=body.time_s) for program in programs]
    for _ in range(45):
        if random.random() < 0.03:
            again = random.sample(range(agents), random.randint(1, agents))
            engine.restart(again)
            for agent in again:
                interpreters[agent].start(body.time_s)
        percept = body.sense(list(body.percepts[0]))
        commands = engine.decide(percept)
        expected = pulse_each(interpreters, percept, body.time_s)
        assert [engine.compiled.basics[index] for index in engine.running.tolist()] == expected
        for agent, interpreter in enumerate(interpreters):
            assert engine.path(agent) == interpreter.path
            assert engine.levels(agent) == interpreter.snapshot(body.time_s)
            assert commands["drive"][agent] == expected[agent].behavior.command.get("drive", 0.0)
        body.act(commands)


def pack_state(engine: Engine) -> list[bytes]:
    """All of an engine's run state."""
    root, state, entered, memory = engine.stacks
    return [array.tobytes() for array in (root, state, entered, memory, engine.running)]


@settings(max_examples=20)
@given(CASES, st.integers(1, 30), st.integers(2, 5))
def test_threads_change_nothing(random: Random, agents: int, threads: int) -> None:
    body, programs = draw_programs(random, agents=agents, automata=4, depth=3)
    other = Played(body.percepts, body.ticks_s, body.time_s)
    serial, split = Engine(body, programs), Engine(other, programs)
    serial.run(40)
    split.run(40, threads=threads)
    assert body.commanded == other.commanded
    assert pack_state(serial) == pack_state(split)


@settings(max_examples=20)
@given(CASES)
def test_a_snapshot_goes_on_as_before(random: Random) -> None:
    body, programs = draw_programs(random, agents=4, automata=4, depth=3)
    engine = Engine(body, programs)
    engine.run(17)
    kept, tick, now = engine.snapshot(), body.tick, body.time_s
    engine.run(20)
    after, paths = pack_state(engine), [engine.path(agent) for agent in range(4)]
    body.tick, body.time_s = tick, now
    engine.restore(kept)
    engine.run(20)
    assert [engine.path(agent) for agent in range(4)] == paths
    assert pack_state(engine) == after


def test_random_libraries_have_what_there_is_to_get_wrong() -> None:
    """Else the tests above would say little."""
    random, levels, kept, plain = Random(0), 0, set(), 0
    for _ in range(60):
        body, programs = draw_programs(random, agents=4, automata=4, depth=3)
        engine = Engine(body, programs)
        for _ in range(20):
            engine.tick()
            for agent in range(4):
                found = engine.levels(agent)
                levels = max(levels, len(found))
                plain += not found
                kept |= {name for level in found for name in (*level.counters, *level.timers)}
    assert levels == 4
    assert plain > 0
    assert kept == {"laps", "falls", "unread", "watch", "bell"}


# One automaton in another, by hand: near is closer than 98.5 m, and the ball is 100 - tick m away.

APPROACH = Automaton(
    "approach",
    (START, State("forward", "forward"), State("done", flag="done")),
    (BoundFeature(scripted_kit.features["range_of"], Binding(A="A")),),
    ("A",),
    transitions={
        "start": Tree((make_leaf(1),)),
        "forward": Tree((Node(TestKind.BELOW, 0, high=98.5, yes=1, no=2), make_leaf(2), make_leaf(1))),
    },
)
OUTER = Automaton(
    "outer",
    (START, make_calling_state("fetch", "approach", A="ball"), State("lap", "lap")),
    (BoundFeature(scripted_kit.features["done"]), BoundFeature(scripted_kit.features["time_in_state"])),
    transitions={
        "start": Tree((make_leaf(1),)),
        "fetch": Tree((Node(TestKind.LABEL, 0, branches=(1, 2)), make_leaf(-1), make_leaf(2))),
        "lap": Tree((Node(TestKind.BELOW, 1, high=0.2, yes=1, no=2), make_leaf(2), make_leaf(1))),
    },
)
TICKS: list[tuple[tuple[str, ...], str]] = [
    (("fetch", "forward"), "forward"),  # 100 m: both levels leave their start state at once
    (("fetch", "forward"), "forward"),  # 99 m
    (("fetch", "done"), "idle"),  # 98 m: the flag goes up, and the automaton idles
    (("lap",), "lap"),  # the parent sees the flag a tick after it went up
    (("lap",), "lap"),  # 0.1 s in the state
    (("fetch", "forward"), "forward"),  # 0.2 s: started afresh, its flag down again
    (("fetch", "done"), "idle"),
]


def test_ticks_by_hand() -> None:
    engine = Engine.from_program(Scripted(), link_program(APPROACH, OUTER))
    for path, basic in TICKS:
        engine.tick()
        assert engine.path(0) == path
        assert engine.compiled.basics[engine.running[0]].behavior.name == basic


NODES: list[tuple[Node, list[tuple[float, float, int, int, int]]]] = [  # low, high, inside, outside, absent
    (Node(TestKind.BELOW, 0, high=2.0, yes=1, no=2, absent=-1), [(-inf, 2.0, -12, -13, -1)]),
    (Node(TestKind.ARC, 0, 1.0, 2.0, 1, 2, 2), [(1.0, 2.0, -12, -13, -13)]),
    (Node(TestKind.ARC, 0, 6.0, 2.0, 1, 2, 1), [(2.0, 6.0, -13, -12, -12)]),  # across the seam: not between
    (Node(TestKind.ABSENT, 0, yes=1, no=2), [(inf, -inf, -13, -13, -12)]),  # nothing is between
    (Node(TestKind.LABEL, 0, absent=2, branches=(1, 2)), [(-inf, 1, -12, -13, -13)]),
    (
        Node(TestKind.LABEL, 0, absent=-1, branches=(1, 2, 2, 1, 1)),
        [(-inf, 2, 6, 7, -1), (-inf, 1, -12, -13, -1), (-inf, 3, -13, 8, -1), (-inf, 4, -12, -12, -1)],
    ),
]


@pytest.mark.parametrize(("node", "rows"), NODES)
def test_every_test_is_between_two_numbers(
    node: Node, rows: list[tuple[float, float, int, int, int]]
) -> None:
    """The first state has index 10, so leaves answer -2 - 10 and -2 - 11; the first node is put at 5."""
    begins, found = flatten_tree(Tree((node, make_leaf(0), make_leaf(1))), sources=[3], first=10, at=5)
    assert begins == 5
    assert [(low, high, inside, outside, absent) for low, high, _, inside, outside, absent in found] == rows
    assert {each.source for each in found} == {3}
