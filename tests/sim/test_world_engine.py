"""The engine on worlds: by ticks, in one go, in threads, sorted, in a grid - as the interpreter, bit for bit."""

from __future__ import annotations

from collections.abc import Callable
from math import tau
from random import Random
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from tests.runtime.random_libraries import draw_tree
from tests.sim.random_scenarios import draw_pulling_world, draw_world
from tests.sim.test_world_laws import states

from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import AnyFeature, BoundFeature, Feature
from understudy.model.library import Kit, Library
from understudy.model.tree import Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Toroidal
from understudy.runtime.engine.engine import Engine
from understudy.runtime.interpreter import Interpreter
from understudy.runtime.link import Program, link
from understudy.runtime.run_loop import Run
from understudy.sim import step as advancing
from understudy.sim.layout import neighbor_grid
from understudy.sim.scenario.schema import (
    Camera,
    ObjectClass,
    RobotGroup,
    RobotType,
    Scenario,
    TargetLocator,
    TargetSpec,
)
from understudy.sim.world import World
from understudy_lab.bench.standard_task import BASE, FULL, make_base_library, make_full_library
from understudy_lab.bench.standard_task import make_full_scenario as full_task

TICKS = 30


def random_library(random: Random, kit: Kit) -> Library:
    """Two automata that look at the kit's readings, the second uses the first."""
    library = Library(kit)
    for name in ("a0", "a1"):
        library = Library.from_automata(
            kit, *map(library.automaton, library.taught), _automaton(random, library, name)
        )
    return library


def _automaton(random: Random, library: Library, name: str) -> Automaton:
    behaviors = [*[each for each in library.kit.behaviors if each != "stand"] * 2, *[*library.taught] * 5]
    states = (
        START,
        *(State(f"s{index}", random.choice(behaviors), Binding({})) for index in range(random.randint(2, 5))),
        *((State("done", flag="done"),) if random.random() < 0.3 else ()),
    )
    readings = [feature for feature in library.kit.features.values() if isinstance(feature, Feature)]
    own = [feature for feature in library.kit.features.values() if not isinstance(feature, Feature)]
    targets = [*library.kit.targets]
    features = {
        str(bound): bound
        for bound in (
            *(bind_feature(random, random.choice(readings), targets) for _ in range(4)),
            bind_feature(random, random.choice(own), targets),
        )
    }
    bound = list(features.values())
    transitions = {
        state.name: fit_cuts(random, draw_tree(random, states, bound, 3), bound)
        for state in states
        if state.flag is None
    }
    return Automaton(name, states, tuple(bound), (), False, transitions)


def bind_feature(random: Random, feature: AnyFeature, targets: list[str]) -> BoundFeature:
    return BoundFeature(feature, Binding({each: random.choice(targets) for each in feature.parameters}))


def fit_cuts(random: Random, tree: Tree, features: list[BoundFeature]) -> Tree:
    """A tree whose cuts are where readings of worlds are: most lengths are within a few m."""
    nodes = []
    for node in tree.nodes:
        if node.test in (TestKind.BELOW, TestKind.ARC) and isinstance(features[node.feature].kind, Toroidal):
            node = node._replace(low=random.uniform(0, tau), high=random.uniform(0, tau))
        nodes.append(node)
    return Tree(tuple(nodes))


def draw_world_and_programs(number: int, *, worlds: int = 1) -> tuple[World, list[Program]]:
    """A random world - every third with boxes to pull, and signals - and a program for each of its robots."""
    make = draw_pulling_world if number % 3 == 0 else draw_world
    random, world = Random(number), make(number, worlds=worlds)
    kit = world.kit
    if not any(isinstance(feature, Feature) and feature.reading for feature in kit.features.values()):
        return draw_world_and_programs(number + 9_999, worlds=worlds)
    libraries = [random_library(random, kit) for _ in range(2)]
    programs = [link(random.choice(libraries), "a1") for _ in range(world.robots)]
    return world, programs * worlds


def outcome(world: World, engine: Engine) -> tuple[dict[str, bytes], list[bytes], bytes]:
    return states(world), [column.tobytes() for column in engine.stacks], engine.running.tobytes()


def again(world: World) -> World:
    """The same worlds at their beginning."""
    return World(world.scenario, world.seeds)


@pytest.mark.parametrize("number", range(3000, 3040))
def test_the_engine_runs_as_interpreters_do(number: int) -> None:
    world, programs = draw_world_and_programs(number)
    run = Run(world, [Interpreter(program, now=world.time_s) for program in programs])
    ticked = Engine(again(world), programs)
    fused = Engine(again(world), programs)
    assert fused.plan() is not None
    for _ in range(TICKS):
        run.tick()
        ticked.tick()
        assert states(ticked.body) == states(world)  # type: ignore[arg-type]
        assert [ticked.path(agent) for agent in range(world.agents)] == [
            each.path for each in run.interpreters
        ]
    fused.run(TICKS)
    assert outcome(fused.body, fused) == outcome(ticked.body, ticked)  # type: ignore[arg-type]


def in_threads(threads: int) -> Callable[[Engine], None]:
    return lambda engine: engine.run(TICKS, threads=threads)


def in_chunks(engine: Engine) -> None:
    for ticks in (1, 7, 0, 2, TICKS - 10):
        engine.run(ticks)


def by_ticks_and_in_one_go(engine: Engine) -> None:
    for _ in range(TICKS // 2):
        engine.tick()
    engine.run(TICKS - TICKS // 2)


WAYS = {
    "2 threads": in_threads(2),
    "3 threads": in_threads(3),
    "chunks": in_chunks,
    "both": by_ticks_and_in_one_go,
}


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is for large worlds only happens in small ones: grids, sorting, several threads in one world."""
    monkeypatch.setattr(neighbor_grid, "FEW", 1)
    monkeypatch.setattr(advancing, "SORTED", 2)
    monkeypatch.setattr(advancing, "MOST_TICKS", 7)


@pytest.mark.parametrize("number", range(3030, 3058))
def test_every_way_to_run_is_the_same(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    world, programs = draw_world_and_programs(number)
    plain = Engine(again(world), programs)
    plain.run(TICKS, threads=1)
    expected = outcome(plain.body, plain)  # type: ignore[arg-type]
    for gridded, in_order in ((False, False), (True, False), (True, True), (False, True)):
        with monkeypatch.context() as patch:
            patch.setattr(neighbor_grid, "FEW", 1 if gridded else 10_000)
            patch.setattr(advancing, "SORTED", 2 if in_order else 10_000)
            patch.setattr(advancing, "MOST_TICKS", 7)
            for name, way in WAYS.items():
                engine = Engine(again(world), programs)
                way(engine)
                assert outcome(engine.body, engine) == expected, (gridded, in_order, name)  # type: ignore[arg-type]


@pytest.mark.parametrize("number", range(3050, 3060))
def test_threads_at_work_in_one_world(number: int, small: None) -> None:
    """At least 64 robots a thread: random worlds with many of them."""
    world, _ = draw_world_and_programs(number)
    scenario = replace(
        world.scenario,
        size=(60.0, 60.0),
        robots=(RobotGroup(type=next(iter(world.scenario.types)), count=200),),
    )
    program = link(random_library(Random(number), World(scenario, (0,)).kit), "a1")
    expected = None
    for threads in (1, 2, 3):
        engine = Engine.from_program(World(scenario, (number,)), program)
        engine.run(TICKS, threads=threads)
        found = outcome(engine.body, engine)  # type: ignore[arg-type]
        assert expected in (None, found), threads
        expected = found


@pytest.mark.parametrize("threads", [1, 2, 3])
@pytest.mark.parametrize("number", range(3060, 3070))
def test_worlds_side_by_side_run_as_alone(number: int, threads: int) -> None:
    world, programs = draw_world_and_programs(number, worlds=5)
    engine = Engine(world, programs)
    engine.run(TICKS, threads=threads)
    size = world.robots
    for index, seed in enumerate(world.seeds):
        alone = Engine(World(world.scenario, (seed,)), programs[:size])
        alone.run(TICKS)
        rows = slice(index * size, (index + 1) * size)
        for field in (
            "x",
            "y",
            "heading",
            "speed",
            "spin",
            "stored",
            "delivered",
            "blocked",
            "holding",
            "signal",
        ):
            own = alone.body.state.robots[field]  # type: ignore[attr-defined]
            assert (own == world.state.robots[field][rows]).all()
        for field in ("x", "y", "present", "amount", "due", "hands", "gathered"):
            own = alone.body.state.objects[field][0]  # type: ignore[attr-defined]
            assert (own == world.state.objects[field][index]).all()


@pytest.mark.parametrize("in_order", [2, 1000])
@pytest.mark.parametrize("threads", [1, 2, 5])
def test_worlds_that_have_ended_stay_as_they_are(
    threads: int, in_order: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(advancing, "SORTED", in_order)
    seeds, ended = (1, 2, 3, 4), np.array([False, True, True, False])
    program = link(make_base_library(), BASE)
    world = World(full_task(150), seeds)
    plan = Engine.from_program(world, program).plan()
    assert plan is not None
    world.advance(plan, 10)
    world.advance(plan, 20, threads, ended=ended)
    assert world.state.tick.tolist() == [30, 10, 10, 30]
    for index, seed in enumerate(seeds):
        alone = Engine.from_program(World(full_task(150), (seed,)), program)
        alone.run(10 if ended[index] else 30)
        rows = slice(index * world.robots, (index + 1) * world.robots)
        for field in ("x", "y", "heading", "stored"):
            own = alone.body.state.robots[field]  # type: ignore[attr-defined]
            assert (own == world.state.robots[field][rows]).all(), (seed, field)


@pytest.mark.parametrize("standard", ["base", "full"])
def test_the_standard_programs(standard: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = full_task(150)
    program = link(make_base_library(), BASE) if standard == "base" else link(make_full_library(), FULL)
    run = Run.from_program(World(scenario, (1,)), program)
    for _ in range(60):
        run.tick()
    expected = states(run.body)  # type: ignore[arg-type]
    for few, in_order, threads in ((24, 1000, 1), (1000, 1000, 1), (24, 2, 1), (24, 2, 2), (24, 1000, 2)):
        monkeypatch.setattr(neighbor_grid, "FEW", few)
        monkeypatch.setattr(advancing, "SORTED", in_order)
        engine = Engine.from_program(World(scenario, (1,)), program)
        engine.run(60, threads=threads)
        assert states(engine.body) == expected, (few, in_order, threads)  # type: ignore[arg-type]


@pytest.mark.parametrize("standard", ["base", "full"])
def test_robots_that_stay_sorted_while_they_go(standard: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Sorted in every tick, or so seldom that many have gone to other cells meanwhile: nobody is overlooked."""
    program = link(make_base_library(), BASE) if standard == "base" else link(make_full_library(), FULL)
    outcomes = []
    for drift, most in ((0.0, 1), (2.0, 7), (10.0, 40)):
        monkeypatch.setattr(neighbor_grid, "DRIFT", drift)
        monkeypatch.setattr(neighbor_grid, "MOST_KEPT", most)
        engine = Engine.from_program(World(full_task(200), (2,)), program)
        engine.run(60, threads=1)
        outcomes.append(states(engine.body))  # type: ignore[arg-type]
    assert outcomes[0] == outcomes[1] == outcomes[2]


def lattice(side: int, step: float = 1.0) -> Scenario:
    """Robots at the places of a lattice: each has four nearest ones, and sees two equal blobs."""
    places = tuple(
        (step * (1 + column), step * (1 + line), 0.0) for column in range(side) for line in range(side)
    )
    return Scenario(
        size=(step * (side + 1), step * (side + 1)),
        types={
            "rover": RobotType(
                color="red", team="red", sensors=(TargetLocator(), Camera(view_deg=100.0)),
                behaviors={"ahead": {"drive": 1.0}, "left": {"turn": 1.0}},
            )
        },
        robots=(RobotGroup(type="rover", at=places),),
        objects=(ObjectClass(name="flag", color="red", at=((0.5, 0.5),)),),
        targets={"anyone": TargetSpec(robot="any"), "red": TargetSpec(color="red")},
    )  # fmt: skip


@pytest.mark.parametrize("step", [1.0, 0.7, 1.3, 2.1])
def test_ties_end_the_same_in_any_order(step: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Equal distances and equal blobs: who counts does not depend on grids and sorting."""
    keys = [("range", "anyone"), ("bearing", "anyone"), ("blob_x", "red"), ("blob_size", "red")]
    scenario = lattice(9, step)
    percepts = []
    for few in (1, 10_000):
        monkeypatch.setattr(neighbor_grid, "FEW", few)
        world = World(scenario, (0,))
        percepts.append(world.sense(keys))
    for key in keys:
        assert np.array_equal(percepts[0][key], percepts[1][key], equal_nan=True), key


def test_two_features_of_one_reading() -> None:
    """Both are asked for in one plan, and both hold what was sensed."""
    scenario = lattice(3)
    kit = World(scenario, (0,)).kit + Kit.from_parts(
        Feature("again", kit_feature(scenario, "distance_to").kind, "range", of="A", unit="m"),
    )
    features = [BoundFeature(kit.features[name], Binding(A="anyone")) for name in ("distance_to", "again")]
    decide = Tree(
        (
            Node(TestKind.BELOW, 0, 0.95, 0.95, 1, 2, 1),
            make_leaf(1),
            Node(TestKind.BELOW, 1, 1.05, 1.05, 3, 4, 4),
            make_leaf(2),
            make_leaf(1),
        )
    )
    states_ = (START, State("s", "left", Binding({})), State("t", "ahead", Binding({})))
    automaton = Automaton(
        "both", states_, tuple(features), (), True, dict.fromkeys(("start", "s", "t"), decide)
    )
    program = link(Library.from_automata(kit, automaton), "both")
    run, engine = (
        Run.from_program(World(scenario, (0,)), program),
        Engine.from_program(World(scenario, (0,)), program),
    )
    plan = engine.plan()
    assert plan is not None
    for _ in range(10):
        run.tick()
    engine.run(10)
    assert states(engine.body) == states(run.body)  # type: ignore[arg-type]
    assert (run.body.state.robots["x"] != World(scenario, (0,)).state.robots["x"]).any()  # type: ignore[attr-defined]


def test_an_interrupted_run_leaves_whole_ticks(small: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was put in another order is put back: robots, their automata and the clock are of the same tick."""
    program = link(make_base_library(), BASE)
    engine, other = (Engine.from_program(World(full_task(50), (1,)), program) for _ in range(2))

    def interrupt(*args: Any, **more: Any) -> None:
        run(*args, **more)
        raise KeyboardInterrupt

    run = advancing.run_worlds
    with monkeypatch.context() as patch:
        patch.setattr(advancing, "run_worlds", interrupt)
        with pytest.raises(KeyboardInterrupt):
            engine.run(TICKS, threads=1)
    other.run(int(engine.body.state.tick[0]))  # type: ignore[attr-defined]
    assert outcome(engine.body, engine) == outcome(other.body, other)  # type: ignore[arg-type]


def test_who_is_just_alone_goes_as_far_as_by_ticks() -> None:
    """Robots that head for each other from as far as both can go in a tick, to the last bit of the distance."""
    kind = RobotType(radius=0.03, speed=13.7, sensors=(TargetLocator(),), behaviors={"ahead": {"drive": 1.0}})
    scenario = Scenario(
        size=(9.0, 9.0),
        types={"rover": kind},
        robots=(RobotGroup(type="rover", at=((1.0, 1.0), (3.0, 3.0))),),
        targets={"anyone": TargetSpec(robot="any")},
    )
    kit = World(scenario, (0,)).kit
    distance = BoundFeature(kit.features["distance_to"], Binding(A="anyone"))
    ahead = Tree((Node(TestKind.BELOW, 0, 0.0, 0.0, 1, 2, 2), make_leaf(1), make_leaf(1)))
    states_ = (START, State("s", "ahead", Binding({})))
    automaton = Automaton("go", states_, (distance,), (), True, dict.fromkeys(("start", "s"), ahead))
    program = link(Library.from_automata(kit, automaton), "go")
    ticked, fused = (Engine.from_program(World(scenario, (0,)), program) for _ in range(2))
    apart = 2.0 * (kind.radius + kind.speed * scenario.tick_s)
    for angle in np.linspace(0.0, tau, 1000, endpoint=False):
        for engine in (ticked, fused):
            engine.restart()
            robots = engine.body.state.robots  # type: ignore[attr-defined]
            robots["speed"] = 0.0
            robots["x"], robots["y"] = (4.5, 4.5 + apart * np.cos(angle)), (4.5, 4.5 + apart * np.sin(angle))
            robots["heading"] = (angle, (angle + tau / 2) % tau)
        ticked.tick()
        fused.run(1)
        assert states(fused.body) == states(ticked.body)  # type: ignore[arg-type]


def kit_feature(scenario: Scenario, name: str) -> Feature:
    feature = World(scenario, (0,)).kit.features[name]
    assert isinstance(feature, Feature)
    return feature


def test_kernels_for_less_do_the_same() -> None:
    """Kernels are compiled for what a scenario has; those for everything do the same."""
    scenario = full_task(30)
    program = link(make_full_library(), FULL)
    engines = [
        Engine.from_program(world, program) for world in (World(scenario, (1, 2)), World(scenario, (1, 2)))
    ]
    for engine in engines:
        engine.run(60)
    assert states(engines[0].body) == states(engines[1].body)  # type: ignore[arg-type]
