"""Free space around robots, and covered ground: a table that can be checked by hand, and the bumper as a witness."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec import structs

from understudy.judging.properties.free_space import CELL_M, find_space, make_clearance, make_covered
from understudy.sim.catalog import find_scenario
from understudy.sim.kernels.dtypes import TOUCH
from understudy.sim.scenario.schema import Obstacle, RobotGroup, Scenario, Wall
from understudy.sim.world import World

ARENA = find_scenario("arena")  # 12 by 10 m; its rover has a radius of 0.2 m
PLACES = [  # x, y of the robot -> the free space around it, m
    (6.0, 5.0, 1.8),  # a wall 2 m above it
    (0.5, 5.0, 0.3),  # the edge of the arena
    (11.0, 2.0, 0.3),  # a post with a radius of 0.5 m, 1 m to the left
    (3.0, 2.0, 0.3),  # the side of a square, 0.5 m to the left
]


def make_room(x: float, y: float) -> Scenario:
    return structs.replace(
        ARENA,
        walls=(Wall(points=((5.0, 7.0), (8.0, 7.0))),),
        obstacles=(
            Obstacle(radius=0.5, at=((10.0, 2.0),)),
            Obstacle(points=((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)), at=((2.0, 2.0, 0.0),)),
        ),
        robots=(RobotGroup(type="rover", at=((x, y, 0.0),)),),
    )


@pytest.mark.parametrize(("x", "y", "free"), PLACES)
def test_clearance_is_measured_from_the_rim(x: float, y: float, free: float) -> None:
    assert make_clearance(World(make_room(x, y), [0]))()[0, 0] == pytest.approx(free)


def test_other_robots_are_in_the_way_and_a_robot_is_not_in_its_own() -> None:
    group = RobotGroup(type="rover", at=((6.0, 5.0, 0.0), (6.0, 6.0, 0.0)))
    world = World(structs.replace(make_room(0.0, 0.0), robots=(group,)), [0])
    assert make_clearance(world)()[0] == pytest.approx([0.6, 0.6])


def test_only_the_robots_that_count_are_measured() -> None:
    """The third of three, with another 1 m above it, and the first at the edge of the arena."""
    group = RobotGroup(type="rover", at=((0.2, 1.0, 0.0), (6.0, 6.0, 0.0), (6.0, 5.0, 0.0)))
    world = World(structs.replace(make_room(0.0, 0.0), robots=(group,)), [0, 1])
    third = np.array([False, False, True])
    assert make_clearance(world, third)() == pytest.approx(np.full((2, 1), 0.6))
    covered = make_covered(world, third)
    for _ in range(10):  # the others drive away
        world.act({"drive": np.tile([1.0, 1.0, 0.0], 2), "turn": np.zeros(6)})
        assert covered() == pytest.approx(np.full((2, 1), CELL_M**2))


def test_it_touches_where_its_bumper_says_so() -> None:
    """Forty robots drive until they run into something, in forty worlds."""
    world = World(ARENA, range(40))
    clearance, touched = make_clearance(world), np.zeros(40, np.bool_)
    for _ in range(300):
        world.act({"drive": np.ones(40), "turn": np.zeros(40)})
        pressed = world.sense([("bumper", None)])[("bumper", None)] == 1.0
        assert ((clearance()[:, 0] < TOUCH) == pressed).all()
        touched |= pressed
    assert touched.all()


def test_ground_is_covered_square_by_square() -> None:
    """A meter to the right in cells of half a meter: two more; turning on the spot adds none."""
    world = World(make_room(6.1, 5.1), [0])
    covered = make_covered(world)
    assert covered()[0, 0] == pytest.approx(CELL_M**2)
    for drive, turn, cells in ((0.0, 1.0, 1), (1.0, 0.0, 3), (0.0, 1.0, 3)):
        for _ in range(20 if drive else 180):
            world.act({"drive": np.full(1, drive), "turn": np.full(1, turn)})
            covered()
        assert covered()[0, 0] == pytest.approx(cells * CELL_M**2)


def test_ground_counts_only_for_a_time() -> None:
    """Half a meter a second to the right from the start of a square: one more each second; after that, none."""
    world = World(make_room(6.01, 5.1), [0])
    found = find_space("covered(2 s)", world, None)
    assert found is not None
    covered, unit = found
    assert unit == "m²"
    cells = [covered()[0, 0] / CELL_M**2]
    for second in range(6):
        for _ in range(10):
            world.act({"drive": np.full(1, float(second < 3)), "turn": np.zeros(1)})
            covered()
        cells.append(covered()[0, 0] / CELL_M**2)
    assert cells == [1, 2, 3, 3, 2, 1, 1]


@pytest.mark.parametrize("subject", ["covered(2)", "covered(x s)", "covered(2 s", "sonar"])
def test_what_is_no_space_is_another_reading(subject: str) -> None:
    assert find_space(subject, World(ARENA, [0]), None) is None
