"""A world that was edited by hand becomes a scenario in which everything is where it was, whatever the seed."""

from __future__ import annotations

import numpy as np
import pytest

from understudy.sim.catalog import find_scenario
from understudy.sim.scenario.files import MARKER, format_scenario, list_builtin_scenarios, parse_scenario
from understudy.sim.scenario.schema import MOUSE, Scenario
from understudy.sim.scenario_snapshot import make_scenario_snapshot
from understudy.sim.view import WorldView
from understudy.sim.world import World


def save_and_load(world: World) -> Scenario:
    """The scenario of a world as it stands, written to a file and read again."""
    made = make_scenario_snapshot(world.scenario, world.view(), name="mine")
    return parse_scenario(format_scenario(made))


def list_places(view: WorldView, scenario: Scenario) -> dict[str, list[tuple[float, ...]]]:
    """Where things are, by what they are; without what comes and goes."""
    passing = {thing.name for thing in scenario.objects if thing.presence is not None} | {MOUSE}
    found: dict[str, list[tuple[float, ...]]] = {}
    for index, kind in enumerate(view.objects.kind.tolist()):
        if (name := view.names.classes[kind]) not in passing:
            found.setdefault(name, []).append((view.objects.x[index], view.objects.y[index]))
    for index in range(len(view.robots)):
        heading = view.robots.heading[index]
        place = (view.robots.x[index], view.robots.y[index], np.cos(heading), np.sin(heading))
        found.setdefault(f"robot {view.names.types[view.robots.type[index]]}", []).append(place)
    discs = np.column_stack([view.discs.x, view.discs.y, view.discs.radius])
    found["discs"] = [tuple(row) for row in sorted(discs.tolist())]
    found["corners"] = [tuple(row) for row in sorted(view.edges.round(4).tolist())]
    return found


@pytest.mark.parametrize("name", list_builtin_scenarios())
def test_all_is_where_it_was(name: str) -> None:
    world = World(find_scenario(name), [3])
    before = list_places(world.view(), world.scenario)
    again = World(save_and_load(world), [11])
    after = list_places(again.view(), world.scenario)
    assert after.keys() == before.keys()
    for what, places in before.items():
        assert np.allclose(after[what], places, atol=1e-5), what


def test_what_was_edited_is_kept() -> None:
    world = World(find_scenario("forage"), [3])
    world.place(0, 6.0, 6.0, 1.0)
    world.add_obstacle(3.0, 9.0, 0.4)
    world.add_object(MARKER, 2.0, 2.0)
    food = world.view().names.classes.index("food")
    for slot in world.view().objects.slot[world.view().objects.kind == food].tolist():
        world.remove_object(slot)
    world.add_object("food", 9.0, 3.0, amount=10)
    made = save_and_load(world)
    view = World(made, [0]).view()
    assert (view.robots.x[0], view.robots.y[0]) == (6.0, 6.0)
    assert view.robots.heading[0] == pytest.approx(1.0, abs=1e-5)
    assert view.discs.radius.tolist() == [0.4]
    names = [view.names.classes[kind] for kind in view.objects.kind.tolist()]
    assert sorted(names) == ["food", MARKER, "station"]
    assert view.objects.amount.max() == 10
    assert made.goal == world.scenario.goal


def test_a_world_without_markers_declares_none() -> None:
    made = save_and_load(World(find_scenario("forage"), [3]))
    assert all(thing.name != MARKER for thing in made.objects)
    assert made.name == "mine"


def test_sources_that_differ_are_drawn_between() -> None:
    world = World(find_scenario("forage"), [0])
    amounts = [each for each in world.view().objects.at_first.tolist() if each]
    made = save_and_load(world)
    (food,) = (thing for thing in made.objects if thing.name == "food")
    assert food.amount == (min(amounts), max(amounts))
