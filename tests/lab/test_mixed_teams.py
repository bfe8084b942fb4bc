"""Scouts and carriers: worlds to practice in, who fails, and a taught team that brings something home."""

from __future__ import annotations

import pytest

from understudy.sim.world import World
from understudy_lab.mixed_teams.study import (
    CARRIER,
    FAILS_TICK,
    SQUAD,
    make_coordinated_team,
    make_single_type_scenario,
    make_single_type_team,
    measure_delivered,
    practices,
    robots_world,
    scenario,
    schedule_failures,
    squad_practices,
    teach,
)
from understudy_lab.teams import make_team_libraries


@pytest.mark.parametrize("name", [*practices(), *squad_practices()])
def test_practices_can_be(name: str) -> None:
    world = World(squad_practices()[name], [1]) if name in squad_practices() else robots_world(name, 1)
    kind = world.names.types[int(world.state.robots["type"][0])]
    assert name in squad_practices() or kind in name


def test_a_third_of_each_world_fails_each_at_a_time_of_its_own() -> None:
    found = schedule_failures(range(50))
    rows = sorted(row for each in found.values() for row in each)
    assert [sum(row // 12 == world for row in rows) for world in range(50)] == [4] * 50
    assert len(set(rows)) == 200
    assert min(found) >= FAILS_TICK[0]
    assert max(found) < FAILS_TICK[1]
    assert len(found) > 150


def test_a_team_of_one_type_has_as_many() -> None:
    assert (
        World(make_single_type_scenario(CARRIER), [0]).robots
        == World(squad_practices()["wrecks with little in them"], [0]).robots
    )


def test_the_coordinator_orders_what_its_roles_know() -> None:
    library = make_team_libraries(scenario())[SQUAD]
    assert {"some_found", "all_found", "finding", "load_carried"} <= set(library.kit.features)
    assert {"seek", "share", "work", "load", "wait"} <= set(library.kit.behaviors)


@pytest.mark.retrains
def test_a_taught_mixed_team_outdoes_carriers() -> None:
    libraries, seeds = teach(18).libraries, range(4)
    together = measure_delivered(make_coordinated_team(libraries, seeds), 4000)
    carriers = measure_delivered(make_single_type_team(CARRIER, libraries, seeds, "gather"), 4000)
    assert together["rate"] > 1.5 * carriers["rate"] > 0
    assert carriers["total"] == together["total"] > 400
