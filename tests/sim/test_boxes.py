"""Boxes that robots pull, by numbers that a reader checks by hand: hands, ways, homes."""

from __future__ import annotations

from math import hypot, radians
from typing import Any

import numpy as np
import pytest
from tests.sim.laws import check_state
from tests.sim.pullers import HandPullers

from understudy.sim.scenario.files import load_scenario
from understudy.sim.scenario.schema import (
    CargoSensor,
    Goal,
    GripSensor,
    ObjectClass,
    Obstacle,
    PullRule,
    RobotGroup,
    RobotType,
    Scenario,
    StallSensor,
)
from understudy.sim.world import World

STEP = 0.05
"""How far a robot drives in a tick, m."""
ROVER = RobotType(
    radius=0.2, speed=10 * STEP, turning_deg=90.0, reach=0.6, sensors=(GripSensor(), StallSensor(after_s=0.5))
)
HOME = ObjectClass(name="home", home=True, radius=1.0, at=((9.0, 7.0),))
AROUND = ((4.5, 4.0), (5.5, 4.0), (5.0, 4.5), (5.0, 3.5))
"""Places within reach of a box in the middle."""


def arena(
    *places: tuple[float, ...],
    pull: PullRule,
    at: tuple[tuple[float, float], ...] = ((5.0, 4.0),),
    **more: Any,
) -> World:
    """A world of 10 m x 8 m with robots at these places (x, y, degrees), and boxes."""
    objects = (ObjectClass(name="box", radius=0.2, at=at, pull=pull), HOME, *more.pop("objects", ()))
    given = {"types": {"rover": ROVER}, "robots": (RobotGroup(type="rover", at=places),), **more}
    return World(Scenario(size=(10.0, 8.0), objects=objects, **given), (0,))


def act(world: World, ticks: int = 1, **commands: Any) -> None:
    for _ in range(ticks):
        world.act({name: np.zeros(world.agents) + value for name, value in commands.items()})


def box(world: World, slot: int = 0) -> tuple[float, float]:
    row = world.state.objects[0, slot]
    return float(row["x"]), float(row["y"])


def read(world: World, name: str) -> list[float]:
    column: list[float] = world.sense([(name, None)])[name, None].tolist()
    return column


# hands, it takes so many, whether it moves
HANDS = [(1, 1, True), (3, 1, True), (1, 2, False), (2, 2, True), (2, 3, False), (3, 3, True), (4, 3, True)]


@pytest.mark.parametrize(("hands", "needed", "moves"), HANDS)
def test_a_box_moves_with_hands_enough(hands: int, needed: int, moves: bool) -> None:
    places = [(x, y, 90.0) for x, y in AROUND[:hands]]
    world = arena(*places, (1.0, 1.0, 90.0), pull=PullRule(robots=needed))
    act(world, load=1.0)
    assert read(world, "holding") == [1.0] * hands + [0.0]
    assert read(world, "enough") == [float(moves)] * hands + [0.0]
    act(world, 4, drive=1.0)
    assert box(world) == pytest.approx((5.0, 4.0 + 4 * STEP * moves))
    for (x, y, _), row in zip(places, world.state.robots, strict=False):
        assert (row["x"], row["y"]) == pytest.approx((x, y + 4 * STEP * moves))
    assert world.state.robots["y"][-1] == pytest.approx(1.0 + 4 * STEP)
    assert read(world, "stuck") == [0.0] * (hands + 1)
    act(world, drive=1.0)
    assert read(world, "stuck") == [float(not moves)] * hands + [0.0]


SIDE = STEP / 2
# headings, commands of two robots, the way of the box in a tick
WAYS = [
    ((90.0, 90.0), (1.0, 1.0), (0.0, STEP)),
    ((90.0, 90.0), (1.0, 0.0), (0.0, SIDE)),
    ((90.0, 90.0), (1.0, -1.0), (0.0, 0.0)),
    ((0.0, 90.0), (1.0, 1.0), (SIDE, SIDE)),
    ((0.0, 180.0), (1.0, 1.0), (0.0, 0.0)),
    ((0.0, 90.0), (-1.0, 0.5), (-SIDE, SIDE / 2)),
]


@pytest.mark.parametrize(("headings", "drives", "way"), WAYS)
def test_it_goes_as_the_mean_of_those_who_hold_it(
    headings: tuple[float, float], drives: tuple[float, float], way: tuple[float, float]
) -> None:
    places = [(x, y, heading) for (x, y), heading in zip(AROUND, headings, strict=False)]
    world = arena(*places, pull=PullRule(robots=2))
    act(world, load=1.0)
    act(world, drive=np.array(drives))
    assert box(world) == pytest.approx((5.0 + way[0], 4.0 + way[1]), abs=1e-12)


@pytest.mark.parametrize("speed", [0.1, 0.4])
def test_it_goes_no_faster_than_the_slowest(speed: float) -> None:
    slow = RobotType(radius=0.2, speed=speed, reach=0.6)
    robots = (
        RobotGroup(type="rover", at=((4.5, 4.0, 90.0),)),
        RobotGroup(type="slow", at=((5.5, 4.0, 90.0),)),
    )
    world = arena(pull=PullRule(robots=2), types={"rover": ROVER, "slow": slow}, robots=robots)
    act(world, load=1.0)
    act(world, 10, drive=1.0)
    assert box(world) == pytest.approx((5.0, 4.0 + speed))


def test_who_touches_another_that_holds_the_same_box_is_not_in_its_way() -> None:
    world = arena((5.0, 3.8, 90.0), (5.0, 4.2, 90.0), pull=PullRule(robots=2))
    act(world, load=1.0)
    act(world, 10, drive=1.0)
    assert box(world) == pytest.approx((5.0, 4.0 + 10 * STEP))
    assert world.state.robots["y"].tolist() == pytest.approx([3.8 + 10 * STEP, 4.2 + 10 * STEP])


def test_who_holds_a_box_turns_freely() -> None:
    world = arena((4.5, 4.0, 90.0), pull=PullRule())
    act(world, load=1.0)
    act(world, 10, turn=1.0)
    assert world.state.robots["heading"][0] == pytest.approx(radians(180.0))
    assert box(world) == (5.0, 4.0)


@pytest.mark.parametrize("around", [False, True])
def test_all_stop_where_one_of_them_must(around: bool) -> None:
    """The robot ahead comes to an obstacle; or the box itself does, between two robots that would pass it."""
    places = ((4.6, 4.0, 90.0), (5.4, 4.0, 90.0)) if around else ((5.0, 4.5, 90.0), (5.0, 3.5, 90.0))
    world = arena(*places, pull=PullRule(robots=2), obstacles=(Obstacle(radius=0.1, at=((5.0, 6.0),)),))
    act(world, load=1.0)
    act(world, 100, drive=1.0)
    stops = 6.0 - 0.1 - 0.2 - (0.0 if around else 0.5)
    assert box(world) == pytest.approx((5.0, stops), abs=1e-8)
    for (_, y, _), row in zip(places, world.state.robots, strict=True):
        assert row["y"] - stops == pytest.approx(y - 4.0, abs=1e-8)
    assert read(world, "stuck") == [1.0, 1.0]
    check_state(world)


def test_two_boxes_that_meet() -> None:
    """Each with two robots, head on: they come as near as the robots ahead, and no nearer."""
    places = ((2.0, 4.0, 0.0), (2.9, 4.0, 0.0), (7.1, 4.0, 180.0), (8.0, 4.0, 180.0))
    world = arena(*places, pull=PullRule(robots=2), at=((2.5, 4.0), (7.5, 4.0)))
    act(world, load=1.0)
    for _ in range(60):
        act(world, drive=1.0)
        check_state(world)
    x = world.state.robots["x"]
    assert x[2] - x[1] == pytest.approx(0.4, abs=1e-8)
    assert x[1] - x[0] == pytest.approx(0.9)
    assert box(world)[0] - x[0] == pytest.approx(0.5)


# what a robot near two boxes is told, tick by tick, and the box that it holds after each
TOLD = [
    ("it takes hold", [({"load": 1.0}, 1)]),
    ("it does nothing", [({}, 0)]),
    ("it drives", [({"load": 1.0, "drive": 0.1}, 0)]),
    ("it turns", [({"load": 1.0, "turn": 0.1}, 0)]),
    ("it holds on", [({"load": 1.0}, 1), ({}, 1), ({"load": 1.0, "drive": 1.0}, 1), ({"drive": -1.0}, 1)]),
    ("it lets go", [({"load": 1.0}, 1), ({"unload": 1.0}, 0)]),
    ("driving, too", [({"load": 1.0}, 1), ({"unload": 1.0, "drive": 1.0}, 0)]),
    ("both is to load", [({"load": 1.0}, 1), ({"load": 1.0, "unload": 1.0}, 1)]),
    ("and once more", [({"load": 1.0}, 1), ({"unload": 1.0}, 0), ({"load": 1.0}, 1)]),
]


@pytest.mark.parametrize(("told", "ticks"), TOLD, ids=lambda each: each if isinstance(each, str) else "")
def test_taking_hold_and_letting_go(told: str, ticks: list[tuple[dict[str, Any], int]]) -> None:
    """Box 0 is 0.55 m away, box 1 0.5 m: the nearest within its reach of 0.6 m counts, here slot 1."""
    world = arena((5.0, 4.0, 90.0), pull=PullRule(robots=5), at=((5.55, 4.0), (4.5, 4.0)), robots=FIVE)
    for commands, holds in ticks:
        act(world, 1, **commands)
        assert world.view().robots.holding[0] == (holds if holds else -1), told
        assert world.state.objects["hands"][0, :2].tolist() == [0, int(holds > 0)]


FIVE = (RobotGroup(type="rover", at=((5.0, 4.0, 90.0), *((x, 1.0, 90.0) for x in (1.0, 2.0, 3.0, 4.0)))),)


def test_out_of_reach() -> None:
    world = arena((4.399, 4.0, 90.0), (5.6, 4.0, 90.0), pull=PullRule())
    act(world, load=1.0)
    assert read(world, "holding") == [0.0, 1.0]


def test_who_fails_lets_go() -> None:
    world = arena(*((x, y, 90.0) for x, y in AROUND[:2]), pull=PullRule(robots=2))
    act(world, load=1.0)
    world.freeze(1)
    act(world, drive=1.0)
    assert box(world) == (5.0, 4.0)
    assert read(world, "enough")[0] == 0.0


def test_a_box_is_gathered_once_its_center_is_in_a_home() -> None:
    """The home's rim is 0.52 m above the box, so in the eleventh tick of 0.05 m it is gathered, and is gone."""
    world = arena((9.5, 5.48, 90.0), pull=PullRule(), at=((9.0, 5.48),), goal=Goal(gathered=1))
    act(world, load=1.0)
    act(world, 10, drive=1.0)
    assert world.gathered.tolist() == [0]
    act(world, drive=1.0)
    assert world.gathered.tolist() == [1]
    assert world.view().gathered == 1
    assert read(world, "holding") == [0.0]
    assert world.finished_s[0] == pytest.approx(1.2)
    assert world.view().objects.kind.tolist() == [1]
    act(world, drive=-1.0)
    assert world.state.robots["y"][0] == pytest.approx(5.48 + 10 * STEP)
    act(world, 50, load=1.0)
    assert world.gathered.tolist() == [1]


def test_a_box_appears_again() -> None:
    """Each time somewhere else, free of all, for another seed elsewhere; and it can be pulled again."""
    places = set()
    for _ in range(2):
        world = arena(
            (9.5, 5.98, 90.0), pull=PullRule(respawn=True), at=((9.0, 5.98),), goal=Goal(gathered=3)
        )
        act(world, load=1.0)
        act(world, drive=1.0)
        assert world.gathered.tolist() == [1]
        x, y = box(world)
        places.add((x, y))
        assert hypot(x - 9.0, y - 7.0) >= 1.2
        assert world.state.objects["present"][0, 0] == 1
        assert read(world, "holding") == [0.0]
        world.move_object(0, 9.0, 5.99)
        act(world, load=1.0)
        act(world, drive=1.0)
        assert world.gathered.tolist() == [2]
        assert box(world) not in places
    assert len(places) == 1


def test_hands_that_hold_a_box_load_no_food() -> None:
    both = RobotType(reach=0.6, capacity=2, load_s=0.1, unload_s=0.1, sensors=(CargoSensor(), GripSensor()))
    food = ObjectClass(name="food", amount=5, at=((5.0, 4.0),))
    world = arena(
        (4.5, 4.0, 90.0), (1.0, 1.0, 0.0), pull=PullRule(robots=2), types={"rover": both}, objects=(food,)
    )
    act(world, 3, load=1.0)
    assert read(world, "holding") == [1.0, 0.0]
    assert read(world, "food_stored") == [0.0, 0.0]


def move_the_box(world: World) -> None:
    world.move_object(0, 2.0, 2.0)


def move_the_robot(world: World) -> None:
    world.place(0, 4.6, 4.0, 0.0)


def remove_the_box(world: World) -> None:
    world.remove_object(0)


@pytest.mark.parametrize("edit", [move_the_box, move_the_robot, remove_the_box])
def test_what_a_person_moves_is_held_no_more(edit: Any) -> None:
    world = arena((4.5, 4.0, 90.0), pull=PullRule())
    act(world, load=1.0)
    edit(world)
    assert read(world, "holding") == [0.0]
    assert world.state.objects["hands"][0, 0] == 0
    act(world, drive=1.0)
    assert world.state.objects["hands"][0, 0] == 0


def test_a_gathered_box_counts_where_another_takes_its_place() -> None:
    world = arena((9.5, 5.98, 90.0), pull=PullRule(), at=((9.0, 5.98),), spare_objects=0)
    act(world, load=1.0)
    act(world, drive=1.0)
    assert world.add_object("box", 2.0, 2.0) == 0
    assert world.gathered.tolist() == [1]


def test_the_boxes_world_can_be_solved() -> None:
    """By robots written by hand, in each of ten worlds: boxes that one can pull, and crates that three must."""
    scenario = load_scenario("boxes")
    world = World(scenario, range(10))
    hand = HandPullers(world)
    helped = 0
    while np.isnan(world.finished_s).any() and world.time_s < scenario.limit_s:
        world.act(hand.decide(world.sense(hand.keys)))
        helped = max(helped, int(world.state.objects["hands"].max()))
    assert (world.finished_s <= scenario.limit_s).all(), world.gathered
    assert world.gathered.tolist() == [12] * 10
    assert helped >= 3
