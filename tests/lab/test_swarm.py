"""The swarm: what is written by hand pulls boxes together, and robots can practice where they are taught."""

from __future__ import annotations

import pytest

from understudy_lab.swarm.practice import SPECS, make_swarm_team, robots_world
from understudy_lab.swarm.study import (
    ALONE,
    FAILS_TICK,
    WAYS,
    measure_gathered,
    schedule_failures,
)
from understudy_lab.tasks.swarm_world import make_expert_libraries
from understudy_lab.teams import FAILING


@pytest.mark.retrains
def test_coordinators_bring_more_home_than_robots_by_themselves() -> None:
    known = make_expert_libraries()
    together, apart = (
        measure_gathered(team, 1500)
        for team in (make_swarm_team(known, [3]), make_swarm_team(known, [3], way=WAYS[ALONE]))
    )
    assert together["loads"] > 1.3 * apart["loads"] > 0
    assert together["loads"] == pytest.approx(together["crates"] + 10 * together["containers"], abs=2.0)


def test_a_third_of_each_world_fails_at_some_time() -> None:
    found = schedule_failures([5, 6])
    assert all(FAILS_TICK[0] <= tick < FAILS_TICK[1] for tick in found)
    rows = [robot for robots in found.values() for robot in robots]
    assert len(rows) == len(set(rows)) == 2 * (200 // FAILING)
    assert sum(row < 200 for row in rows) == 200 // FAILING


@pytest.mark.parametrize("practice", sorted(SPECS))
def test_robots_can_practice(practice: str) -> None:
    world = robots_world(practice, 5)
    world.act({})
    holds = float(world.sense([("holding", None)])["holding", None][0])
    assert bool(holds) == SPECS[practice].held
