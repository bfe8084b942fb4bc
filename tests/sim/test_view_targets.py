"""Where targets are, as seen from outside: the same as the locators of the robots say."""

from __future__ import annotations

from math import atan2, hypot, pi, tau

import pytest

from understudy.sim.catalog import find_scenario
from understudy.sim.scenario.schema import (
    ObjectClass,
    RobotGroup,
    RobotType,
    Scenario,
    TargetLocator,
    TargetSpec,
)
from understudy.sim.target_lookup import find_target_place
from understudy.sim.world import World

RANGED = RobotType(sensors=(TargetLocator(),), capacity=3)
SCENARIO = Scenario(
    size=(10.0, 8.0),
    types={"scout": RANGED, "guard": RANGED},
    robots=(RobotGroup(type="scout", count=3), RobotGroup(type="guard", count=2)),
    objects=(
        ObjectClass(name="food", count=4, amount=(0, 3)),
        ObjectClass(name="post", count=3, color="red"),
    ),
    targets={
        "food": TargetSpec(nearest="food"),
        "post": TargetSpec(nearest="post"),
        "second": TargetSpec(object="post", index=1),
        "friend": TargetSpec(robot="teammate"),
        "foe": TargetSpec(robot="opponent"),
        "anyone": TargetSpec(robot="any"),
        "guard": TargetSpec(team="guard"),
        "red": TargetSpec(color="red"),
    },
)


@pytest.mark.parametrize("target", ["food", "post", "second", "friend", "foe", "anyone", "guard"])
def test_places_are_where_locators_say(target: str) -> None:
    world = World(SCENARIO, range(5))
    percept = world.sense([("range", target), ("bearing", target)])
    for agent in range(world.agents):
        robot, place = world.state.robots[agent], find_target_place(world, target, agent)
        if place is None:
            assert percept["range", target][agent] != percept["range", target][agent]
            continue
        dx, dy = place[0] - robot["x"], place[1] - robot["y"]
        assert percept["range", target][agent] == pytest.approx(hypot(dx, dy))
        off = percept["bearing", target][agent] - (atan2(dy, dx) - robot["heading"])
        assert abs((off + pi) % tau - pi) < 1e-9


def test_what_is_not_there_is_nowhere() -> None:
    world = World(SCENARIO, [1])
    assert find_target_place(world, "red") is None
    world.state.objects["amount"] = 0
    assert find_target_place(world, "food") is None
    world.remove_object(int(world.view().objects.slot[world.view().objects.kind == 1][1]))
    assert find_target_place(world, "second") is None
    assert find_target_place(world, "post") is not None


def test_food_is_counted_in_each_world() -> None:
    world = World(find_scenario("forage-team"), range(4))
    before = world.total
    assert before.tolist() == [int(world.view(row).objects.amount.sum()) for row in range(4)]
    world.state.robots["stored"][:4] = 2
    assert (world.total - before).tolist() == [8, 0, 0, 0]
