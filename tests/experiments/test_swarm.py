"""The swarm: what is written by hand pulls boxes together, and many platoons are like a few."""

from __future__ import annotations

import pytest

from understudy.experiments.swarm.measuring import gathered, hand_coded
from understudy.experiments.swarm.practice import (
    SPECS,
    alone,
    coordinated,
    of_platoons,
    robots_world,
    scenario,
)


def test_coordinators_bring_more_home_than_robots_by_themselves() -> None:
    known = hand_coded()
    together, apart = (gathered(made(known, [3]), 1500) for made in (coordinated, alone))
    assert together["hands"] > 1.3 * apart["hands"] > 0


def test_eight_platoons_are_the_swarm_that_ships() -> None:
    made, ships = of_platoons(8), scenario()
    assert [each.count for each in made.robots] == [each.count for each in ships.robots] == [25] * 8
    assert [each.count for each in made.objects[1:]] == [each.count for each in ships.objects[1:]]


@pytest.mark.parametrize("practice", sorted(SPECS))
def test_robots_can_practice(practice: str) -> None:
    world = robots_world(practice, 5)
    world.act({})
    holds = float(world.sense([("holding", None)])["holding", None][0])
    assert bool(holds) == SPECS[practice].held
