"""Markers: every world has room for some, and they change nothing where none is placed."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace
from tests.sim import golden

from understudy.errors import UnderstudyError
from understudy.runtime.engine.engine import Engine
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import (
    MARKER,
    TARGET,
    add_markers,
    list_builtin_scenarios,
    load_scenario,
    remove_markers,
)
from understudy.sim.scenario.schema import ObjectClass, Scenario, TargetLocator, TargetSpec
from understudy.sim.target_lookup import find_target_place
from understudy.sim.world import World

NAMES = list_builtin_scenarios()


def of_marker(world: World) -> list[tuple[str, str]]:
    return [(reading.name, TARGET) for reading in world.readings if reading.of_targets]


@pytest.mark.parametrize("name", NAMES)
def test_a_marker_is_absent_until_it_is_placed_and_once_it_is_removed(name: str) -> None:
    scenario = find_scenario(name)
    world = World(scenario, [3])
    assert TARGET in make_scenario_kit(scenario).targets
    keys = of_marker(world)
    assert keys
    assert all(np.isnan(column).all() for column in world.sense(keys).values())
    assert find_target_place(world, TARGET) is None
    robot = world.state.robots[0]
    x, y, heading = float(robot["x"]), float(robot["y"]), float(robot["heading"])
    ahead = (x + 0.5 * np.cos(heading), y + 0.5 * np.sin(heading))
    slot = world.add_object(MARKER, *ahead)
    assert find_target_place(world, TARGET) == pytest.approx(ahead)
    sensed = world.sense(keys)
    sensors = scenario.types[world.names.types[int(robot["type"])]].sensors
    locators = [sensor for sensor in sensors if isinstance(sensor, TargetLocator)]
    if any(
        each.targets is None or TARGET in each.targets for each in locators
    ):  # else they are for other things
        assert sensed["range", TARGET][0] == pytest.approx(0.5)
        assert np.cos(sensed["bearing", TARGET][0]) == pytest.approx(1.0)
    if ("blob_x", TARGET) in keys:
        assert sensed["blob_x", TARGET][0] == pytest.approx(80.0, abs=6.0), (
            "ahead is the middle of the picture"
        )
    world.remove_object(slot)
    assert all(np.isnan(column).all() for column in world.sense(keys).values())


def test_a_robot_may_stand_on_it() -> None:
    world = World(find_scenario("forage"), [0])
    robot = world.state.robots[0]
    world.add_object(MARKER, float(robot["x"]), float(robot["y"]))


def test_the_nearest_of_several() -> None:
    world = World(find_scenario("forage"), [0])
    world.place(0, 6.0, 6.0, 0.0)
    far = world.add_object(MARKER, 9.0, 6.0)
    world.add_object(MARKER, 6.0, 8.0)
    assert world.sense([("range", TARGET)])["range", TARGET][0] == pytest.approx(2.0)
    world.move_object(far, 7.0, 6.0)
    assert world.sense([("range", TARGET)])["range", TARGET][0] == pytest.approx(1.0)


def test_a_world_has_room_for_as_many_as_its_spare_objects() -> None:
    world = World(add_markers(replace(load_scenario("forage"), spare_objects=1)), [0])
    world.add_object(MARKER, 1.0, 1.0)
    with pytest.raises(UnderstudyError, match="spare_objects"):
        world.add_object(MARKER, 2.0, 2.0)
    none = World(add_markers(replace(load_scenario("forage"), spare_objects=0)), [0])
    with pytest.raises(UnderstudyError, match="spare_objects"):
        none.add_object(MARKER, 1.0, 1.0)
    assert np.isnan(none.sense([("range", TARGET)])["range", TARGET][0])


def course(scenario: Scenario) -> list[list[float]]:
    """Where everything is after some time of each basic behavior."""
    world = World(scenario, [7])
    Engine.from_program(world, golden.each_in_turn(world)).run(100)
    view = world.view()
    return [
        column.tolist() for column in (view.robots.x, view.robots.heading, view.objects.x, view.objects.y)
    ]


@pytest.mark.parametrize("name", NAMES)
def test_nothing_else_changes(name: str) -> None:
    plain, marked = load_scenario(name), find_scenario(name)
    assert remove_markers(marked) == plain
    assert add_markers(marked) == marked
    assert course(plain) == course(marked)


OWN = ObjectClass(name=MARKER, radius=0.4, color="red", count=2)


@pytest.mark.parametrize(
    "scenario",
    [
        replace(load_scenario("forage"), objects=(*load_scenario("forage").objects, OWN)),
        replace(load_scenario("forage"), targets={TARGET: TargetSpec(object="station")}),
    ],
)
def test_a_world_keeps_its_own(scenario: Scenario) -> None:
    marked = add_markers(scenario)
    assert marked.objects[: len(scenario.objects)] == scenario.objects
    assert marked.targets.items() >= scenario.targets.items()
    assert [thing.name for thing in marked.objects].count(MARKER) == 1
    World(marked, [0])


def test_cameras_do_not_take_it_for_anything_else() -> None:
    forage = load_scenario("forage")
    station, food = forage.objects
    colored = replace(forage, objects=(replace(station, color="magenta"), food))
    assert add_markers(colored).objects[-1].color == "orange"
