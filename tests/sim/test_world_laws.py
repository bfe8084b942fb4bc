"""Laws that hold in any world: random scenarios, random commands, tick after tick."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from msgspec.structs import replace
from tests.sim.laws import Kept, check_percept, check_state, check_tick, copy_state
from tests.sim.random_scenarios import draw_commands, draw_pulling_world, draw_world

from understudy.runtime.body import Commands, list_reading_keys
from understudy.sim.scenario.schema import (
    ObjectClass,
    Obstacle,
    PullRule,
    RobotGroup,
    RobotType,
    Scenario,
    Wall,
)
from understudy.sim.world import World

TICKS = 40
AT_HAND = ("aim", "cosine", "sine")
"""What is kept for speed and is no part of the state."""


def states(world: World) -> dict[str, bytes]:
    """All that changes, in plain bytes."""
    return {
        f"{name}.{field}": np.ascontiguousarray(array[field] if field else array).tobytes()
        for name, array in world.state._asdict().items()
        for field in (array.dtype.names or ("",))
        if field not in AT_HAND
    }


def check_scene(number: int, *, ticks: int = TICKS) -> None:
    """Every law in one random world."""
    check_world(draw_world(number), number, ticks=ticks)


def check_world(world: World, number: int, *, ticks: int = TICKS) -> None:
    """Every law in a world."""
    draw, keys = np.random.default_rng(number), list_reading_keys(world)
    check_state(world)
    commands = draw_commands(draw, world)
    for tick in range(ticks):
        if tick == ticks // 2:
            world.freeze(int(draw.integers(world.agents)))
            world.place_pointer(*draw.uniform(0, 1, 2) * world.scenario.size)
        if tick % 8 == 0:
            check_percept(world, world.sense(keys))
        if tick % 6 == 0:
            commands = draw_commands(draw, world)
        before = copy_state(world)
        world.act(commands)
        check_tick(world, before, commands)
        check_state(world)


@pytest.mark.parametrize("first", range(0, 200, 25))
def test_laws(first: int) -> None:
    for number in range(first, first + 25):
        try:
            check_scene(number)
        except Exception as error:
            raise AssertionError(f"scene {number}: {error!r}") from error


@pytest.mark.long
def test_laws_of_boxes_and_signals() -> None:
    """The same where robots pull boxes, and all of it happens: they hold, go, gather, and boxes appear again."""
    happened = np.zeros(4, np.int64)
    for number in range(2000, 2050):
        world = draw_pulling_world(number)
        at_first = copy_state(world).objects
        try:
            check_world(world, number)
        except Exception as error:
            raise AssertionError(f"scene {number}: {error!r}") from error
        boxes, pull = world.state.objects, world.rules.classes["pull"][world.rules.class_of] > 0
        moved = (boxes["x"] != at_first["x"]) & pull & (boxes["gathered"] == 0)
        held, again = boxes["hands"] > 0, (boxes["appeared"] > 0) & pull
        happened += [held.any(), moved.any(), world.gathered[0] > 0, again.any()]
    assert (happened >= 3).all(), happened


@pytest.mark.soak
@pytest.mark.parametrize("first", range(0, 10_000, 250))
def test_laws_of_ten_thousand_scenes(first: int) -> None:
    for number in range(first, first + 250):
        try:
            check_scene(number, ticks=60)
            check_world(draw_pulling_world(number), number, ticks=60)
        except Exception as error:
            raise AssertionError(f"scene {number}: {error!r}") from error


def any_world(number: int, *, worlds: int) -> World:
    """Every third is one with boxes to pull, and signals."""
    return (draw_pulling_world if number % 3 == 0 else draw_world)(number, worlds=worlds)


@pytest.mark.parametrize("number", range(1000, 1050))
def test_a_snapshot_goes_on_bit_for_bit(number: int) -> None:
    world = any_world(number, worlds=2)
    keys, draw = list_reading_keys(world), np.random.default_rng(number)
    drawn = [draw_commands(draw, world) for _ in range(4)]
    commands = [each for each in drawn for _ in range(5)]
    for each in commands:
        world.act(each)
    there = world.snapshot()
    before = world.sense(keys)
    for each in commands:
        world.act(each)
    after = states(world)
    for other in (world, World(world.scenario, world.seeds[::-1])):
        other.restore(there)
        assert other.snapshot() == there
        again = other.sense(keys)
        assert all(np.array_equal(again[key], before[key], equal_nan=True) for key in keys)
        for each in commands:
            other.act(each)
        assert states(other) == after


@pytest.mark.parametrize("number", range(1040, 1090))
def test_a_world_runs_alone_as_among_others_and_again_by_its_seed(number: int) -> None:
    among = any_world(number, worlds=3)
    again = World(among.scenario, among.seeds)
    alone = World(among.scenario, among.seeds[1:2])
    draw, keys = np.random.default_rng(number), list_reading_keys(among)
    own = slice(among.robots, 2 * among.robots)
    for _ in range(25):
        commands = draw_commands(draw, among)
        percepts = [each.sense(keys) for each in (among, again, alone)]
        for key in keys:
            assert np.array_equal(percepts[0][key], percepts[1][key], equal_nan=True)
            assert np.array_equal(percepts[0][key][own], percepts[2][key], equal_nan=True)
        among.act(commands)
        again.act(commands)
        alone.act({name: column[own] for name, column in commands.items()})
    assert states(among) == states(again)
    for field in (field for field in alone.state.robots.dtype.names or () if field not in AT_HAND):
        assert among.state.robots[field][own].tobytes() == alone.state.robots[field].tobytes()
    assert among.state.memory[own].tobytes() == alone.state.memory.tobytes()
    for field in (
        "x",
        "y",
        "heading",
        "present",
        "amount",
        "appeared",
        "due",
        "captured",
        "hands",
        "gathered",
    ):
        assert (among.state.objects[field][1] == alone.state.objects[field][0]).all()


@pytest.mark.parametrize("number", range(1080, 1110))
def test_some_readings_are_as_among_all(number: int) -> None:
    """Draws are keyed by what they are for, so that it does not matter what else is sensed."""
    world = any_world(number, worlds=1)
    keys, draw = list_reading_keys(world), np.random.default_rng(number)
    for _ in range(12):
        whole = world.sense(keys)
        for some in ([keys[draw.integers(len(keys))]], draw.permutation(len(keys))[: len(keys) // 2 + 1]):
            chosen = [keys[int(each)] if not isinstance(each, tuple) else each for each in some]
            found = world.sense(chosen)
            for key in chosen:
                assert np.array_equal(found[key], whole[key], equal_nan=True), key
        world.act(draw_commands(draw, world))


def test_other_seeds_other_worlds() -> None:
    world = draw_world(3, worlds=2)
    scenario = replace(world.scenario, name="other")
    assert states(World(scenario, (1,))) != states(World(scenario, (2,)))


def onto_another(world: World) -> None:
    world.state.robots["x"][0] = world.state.robots["x"][1] + 2 * 0.2 - 1e-6
    world.state.robots["y"][0] = world.state.robots["y"][1]


def change(field: str, index: int, value: float, *, objects: bool = False) -> Callable[[World], None]:
    def apply(world: World) -> None:
        (world.state.objects[0] if objects else world.state.robots)[field][index] = value

    return apply


LIARS: dict[str, Callable[[World], None]] = {
    "a robot overlaps another": onto_another,
    "a robot is partly outside": change("x", 0, 0.2 - 1e-6),
    "a robot is nowhere": change("y", 0, np.nan),
    "a robot turned around without a command": change("heading", 1, 3.0),
    "a robot without a command moved": change("x", 1, 5.0 + 1e-6),
    "a robot went through a wall": change("x", 0, 2.5),
    "a robot went too far": change("y", 0, 1.5),
    "a robot is in an obstacle": change("y", 1, 4.5),
    "a robot is in a box": change("x", 1, 5.7),
    "food was made": change("amount", 0, 4, objects=True),
    "food was lost": change("amount", 0, 2, objects=True),
    "a robot carries too much": change("stored", 0, 9),
    "what stays has moved": change("x", 0, 9.0, objects=True),
    "a box to pull has moved by itself": change("x", 2, 2.0, objects=True),
    "somebody holds what nobody may": change("holding", 1, 1),
    "a robot holds what is out of reach": change("holding", 1, 3),
    "hands are counted wrong": change("hands", 2, 1, objects=True),
}


def check_both(world: World, before: Kept, commands: Commands) -> None:
    check_tick(world, before, commands)
    check_state(world)


@pytest.mark.parametrize("what", LIARS)
def test_the_laws_catch_what_breaks_them(what: str) -> None:
    scenario = Scenario(
        size=(10.0, 8.0),
        types={"rover": RobotType(radius=0.2, capacity=2)},
        robots=(RobotGroup(type="rover", at=((1.0, 1.0, 0.0), (5.0, 4.0, 0.0))),),
        walls=(Wall(points=((2.0, 0.0), (2.0, 4.0))),),
        obstacles=(Obstacle(radius=0.5, at=((5.0, 5.0),)),),
        objects=(
            ObjectClass(name="food", amount=3, at=((7.0, 1.0),)),
            ObjectClass(name="box", pushable=True, radius=0.3, at=((6.0, 4.0),)),
            ObjectClass(name="crate", pull=PullRule(robots=2), at=((1.0, 7.0),)),
        ),
        spare_objects=0,
    )
    world = World(scenario, (0,))
    commands = {"drive": np.array([1.0, 0.0]), "turn": np.zeros(2)}
    before = copy_state(world)
    world.act(commands)
    check_tick(world, before, commands)
    check_state(world)
    LIARS[what](world)
    with pytest.raises(AssertionError):
        check_both(world, before, commands)
