"""Teams of scenarios: what everybody knows, who runs what, and a patrol that goes as ordered."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest
from tests.sim.patrollers import ROBOTS, SCENARIO

from understudy.errors import SettingError
from understudy.runtime.team.squad_body import SquadBody
from understudy.sim.scenario.squad_schema import CommsSpec
from understudy.sim.team.libraries import collect_libraries, find_behavior_sort, make_team
from understudy.sim.world import World
from understudy_lab.bench.patrol import make_libraries


def test_a_coordinator_knows_the_statistics_and_its_members_behaviors() -> None:
    kit = collect_libraries(SCENARIO, ROBOTS)["patrol"].kit
    assert {"someone_sees", "all_done", "present", "done", "time_in_state"} <= set(kit.features)
    assert {*ROBOTS.kit.behaviors, *ROBOTS.taught} == set(kit.behaviors)
    assert kit.behaviors["servo"].parameters == ("A",)
    assert list(kit.targets) == list(ROBOTS.kit.targets)


def test_whose_behavior_it_is() -> None:
    libraries = make_libraries()
    assert [find_behavior_sort(libraries, name) for name in ("lead", "wander", "forwards", "patrol/lead", None)] == [
        "patrol", "pioneer", "pioneer", "patrol", "patrol",
    ]  # fmt: skip
    twice = {**libraries, "other": libraries["patrol"]}
    with pytest.raises(SettingError, match="patrol/lead"):
        find_behavior_sort(twice, "lead")


def orders(team) -> SquadBody:  # type: ignore[no-untyped-def]
    squads = team.layer("patrol").body
    assert isinstance(squads, SquadBody)
    return squads


def test_all_are_ordered_in_the_tick_of_a_sighting() -> None:
    """And a robot that nobody ordered about runs nothing."""
    team = make_team(SCENARIO, range(20), make_libraries(), {"patrol": ("lead", {})})
    attacked = 0
    states = ["start"] * 20
    for _ in range(900):
        before = np.array(states)
        team.tick()
        sees = team.layer("patrol").percept["someone_sees", "intruder"] == 1.0
        states = [team.layer("patrol").runner.path(world)[0] for world in range(20)]
        assert {states[world] for world in np.flatnonzero(sees & (before == "out"))} <= {"attack"}
        for world in np.flatnonzero(np.array(states) == "attack").tolist():
            assert {path[0] for path in team.paths[4 * world : 4 * world + 4]} == {"servo(intruder)"}
            attacked += 1
    assert attacked > 0


def test_robots_alone_have_no_coordinator() -> None:
    team = make_team(SCENARIO, [3], make_libraries(), {"pioneer": ("wander", {})})
    team.run(20)
    assert len(team.layers) == 1
    assert all(path for path in team.paths)


def test_delayed_orders_come_later_and_lost_ones_are_made_up_for() -> None:
    """What is answered is told by when it was ordered: nobody takes an old report for a new one."""
    slow = msgspec.structs.replace(SCENARIO, radio=CommsSpec(delay_s=0.2, loss=0.3))
    team = make_team(slow, [7], make_libraries(), {"patrol": ("lead", {})})
    team.tick()
    squads = orders(team)
    assert squads.ordering.issued.tolist() == [0.0]
    assert np.isnan(squads.ordering.answering).all()
    for _ in range(30):
        team.tick()
    assert squads.ordering.answering.tolist() == [0.0] * 4
    assert all(duty is not None and duty.behavior == "wander" for duty in squads.ordering.duty)


def test_what_travels_is_counted() -> None:
    """Four orders of 12 bytes; four reports of 10, a reading (8) and a flag (1) in each: they grow with the members."""
    team = make_team(SCENARIO, [7, 8], make_libraries(), {"patrol": ("lead", {})})
    found = orders(team).traffic
    assert (found.messages, found.bytes) == (2 * 8, 8 * (12 + 10 + 8 + 1))


def test_who_has_failed_is_counted_no_more() -> None:
    team = make_team(SCENARIO, [7], make_libraries(), {"patrol": ("lead", {})})
    world = team.ground
    assert isinstance(world, World)
    squads = orders(team)

    def list_present() -> list[float]:
        team.tick()
        return list(squads.sense([("present", None)])["present", None])

    assert list_present() == [4.0]
    world.freeze(1)
    world.freeze(3)
    assert list_present() == [2.0]
    world.freeze(0)
    world.freeze(2)
    assert list_present() == [0.0]
    assert squads.failed.tolist() == [True]


def test_a_team_side_by_side_is_as_alone() -> None:
    slow = msgspec.structs.replace(SCENARIO, radio=CommsSpec(delay_s=0.1, loss=0.1))
    together = make_team(slow, [5, 6, 7], make_libraries(), {"patrol": ("lead", {})})
    alone = make_team(slow, [6], make_libraries(), {"patrol": ("lead", {})})
    for _ in range(400):
        together.tick()
        alone.tick()
    assert together.paths[4:8] == alone.paths
    ours, theirs = together.ground, alone.ground
    assert isinstance(ours, World)
    assert isinstance(theirs, World)
    assert ours.state.robots["x"][4:8].tolist() == theirs.state.robots["x"].tolist()


def test_many_ticks_in_one_go_are_as_tick_by_tick() -> None:
    """Also where a robot fails, and in whatever portions."""
    slow, fast = (make_team(SCENARIO, range(6), make_libraries(), {"patrol": ("lead", {})}) for _ in range(2))
    for portion in (1, 250, 3, 400):
        for team in (slow, fast):
            assert isinstance(team.ground, World)
            team.ground.freeze(portion % 24)
        for _ in range(portion):
            slow.tick()
        fast.run(portion)
        assert slow.paths == fast.paths
        assert slow.ground.snapshot() == fast.ground.snapshot()  # type: ignore[attr-defined]
    assert repr(orders(slow).capture_state()) == repr(orders(fast).capture_state())
