"""How robots move, against closed forms: arcs, contacts, pushes - by numbers that a reader checks by hand."""

from __future__ import annotations

from math import cos, hypot, pi, radians, sin, tau
from typing import Any

import numpy as np
import pytest

from understudy.sim.scenario.schema import (
    ArenaRegion,
    ObjectClass,
    Obstacle,
    RandomWalk,
    RobotGroup,
    RobotType,
    Scenario,
    Wall,
)
from understudy.sim.world import World

RADIUS, STEP = 0.2, 0.05
"""Of a robot, m; and how far it drives in a tick of 0.1 s."""
GAP = 1e-8
"""At most so much is left between a robot and what stops it, m."""
SQUARE = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))


def arena(*places: tuple[float, ...], kind: RobotType | None = None, **more: Any) -> World:
    """A world of 10 m x 8 m with robots at these places: x, y, degrees."""
    scenario = Scenario(
        size=(10.0, 8.0),
        types={"rover": kind or RobotType(radius=RADIUS, speed=10 * STEP, turning_deg=90.0)},
        robots=(RobotGroup(type="rover", at=places),),
        **more,
    )
    return World(scenario, (0,))


def drive(world: World, ticks: int, *, drive: Any = 1.0, turn: Any = 0.0) -> None:
    for _ in range(ticks):
        world.act({"drive": np.zeros(world.agents) + drive, "turn": np.zeros(world.agents) + turn})


def robot(world: World, index: int = 0) -> tuple[float, float, float]:
    row = world.state.robots[index]
    return float(row["x"]), float(row["y"]), float(row["heading"])


def locate_object(world: World, slot: int = 0) -> tuple[float, float]:
    row = world.state.objects[0, slot]
    return float(row["x"]), float(row["y"])


@pytest.mark.parametrize(("ahead", "turn"), [(1.0, 1.0), (1.0, -0.5), (-0.7, 0.3), (0.4, -1.0)])
def test_an_arc(ahead: float, turn: float) -> None:
    """Drive and turn make a circle of radius speed / turning, and every tick ends on it."""
    world = arena((5.0, 4.0, 30.0))
    speed, spin = ahead * 0.5, turn * pi / 2
    around = speed / spin
    heading = radians(30.0)
    center_x, center_y = 5.0 - around * sin(heading), 4.0 + around * cos(heading)
    for tick in range(1, 200):
        drive(world, 1, drive=ahead, turn=turn)
        angle = heading + spin * 0.1 * tick
        x, y, looks = robot(world)
        assert (x, y) == pytest.approx(
            (center_x + around * sin(angle), center_y - around * cos(angle)), abs=1e-12 * tick
        )
        assert (looks - angle + pi) % tau - pi == pytest.approx(0.0, abs=1e-12 * tick)
        assert 0.0 <= looks < tau


def test_straight_ahead_and_back() -> None:
    world = arena((5.0, 4.0, 90.0))
    drive(world, 10)
    assert robot(world)[:2] == pytest.approx((5.0, 4.5))
    drive(world, 10, drive=-1.0)
    assert robot(world)[:2] == pytest.approx((5.0, 4.0))
    drive(world, 10, drive=7.0)  # as fast as it can
    assert robot(world)[:2] == pytest.approx((5.0, 4.5))


def test_on_the_spot() -> None:
    world = arena((5.0, 4.0, 0.0))
    drive(world, 10, drive=0.0, turn=1.0)
    assert robot(world)[:2] == (5.0, 4.0)
    assert robot(world)[2] == pytest.approx(pi / 2)
    drive(world, 40, drive=0.0, turn=-1.0)
    assert robot(world)[2] == pytest.approx(pi / 2)


def test_accelerations() -> None:
    """0.2 m/s per s: after k ticks 0.02 k m/s, and the way is the sum; to stop takes as long."""
    kind = RobotType(
        radius=RADIUS, speed=0.1, acceleration=0.2, turning_deg=90.0, turning_acceleration_deg=100.0
    )
    world = arena((5.0, 4.0, 0.0), kind=kind)
    drive(world, 3)
    assert robot(world)[0] - 5.0 == pytest.approx(0.002 + 0.004 + 0.006)
    drive(world, 4)
    assert robot(world)[0] - 5.0 == pytest.approx(0.002 + 0.004 + 0.006 + 0.008 + 3 * 0.01)
    drive(world, 1, drive=0.0)
    assert world.state.robots["speed"][0] == pytest.approx(0.008)
    drive(world, 20, drive=0.0)
    assert world.state.robots["speed"][0] == 0.0
    drive(world, 2, drive=0.0, turn=1.0)
    assert robot(world)[2] == pytest.approx(radians(1.0 + 2.0))


def noisy(count: int, **noise: Any) -> World:
    """Robots side by side, far from each other."""
    scenario = Scenario(
        size=(10.0, 2.0 * count),
        types={"rover": RobotType(radius=RADIUS, speed=10 * STEP, turning_deg=90.0, **noise)},
        robots=(RobotGroup(type="rover", at=tuple((5.0, 1.0 + 2.0 * index, 0.0) for index in range(count))),),
    )
    return World(scenario, (0,))


def test_noise_of_driving() -> None:
    """Its mean is 1, its spread as given."""
    world = noisy(500, noise_drive=0.1)
    steps = []
    for tick in range(40):
        before = world.state.robots["x"].copy()
        drive(world, 1, drive=1.0 if tick % 2 else -1.0)
        steps.append(np.abs(world.state.robots["x"] - before))
    share = np.array(steps) / STEP
    assert share.mean() == pytest.approx(1.0, abs=5 * 0.1 / share.size**0.5)
    assert share.std() == pytest.approx(0.1, rel=0.03)
    correlation = np.corrcoef(share[:-1].ravel(), share[1:].ravel())[0, 1]
    assert abs(correlation) < 0.03  # each tick anew


def test_noise_is_capped() -> None:
    world = noisy(500, noise_drive=3.0)
    drive(world, 1)
    share = (world.state.robots["x"] - 5.0) / STEP
    assert share.min() == 0.0
    assert share.max() == pytest.approx(2.0)
    assert share.mean() == pytest.approx(1.0, abs=0.2)


def test_noise_of_turning() -> None:
    world = noisy(500, noise_turn=0.2)
    turns = []
    for _ in range(20):
        before = world.state.robots["heading"].copy()
        drive(world, 1, drive=0.0, turn=1.0)
        turns.append((world.state.robots["heading"] - before) % tau)
    share = np.array(turns) / radians(9.0)
    assert share.mean() == pytest.approx(1.0, abs=0.01)
    assert share.std() == pytest.approx(0.2, rel=0.05)
    assert (world.state.robots["x"] == 5.0).all()


def test_noise_without_a_command_is_none() -> None:
    world = noisy(5, noise_drive=0.5, noise_turn=0.5)
    before = world.state.robots.copy()
    drive(world, 20, drive=0.0)
    for field in ("x", "y", "heading", "speed", "spin"):
        assert (world.state.robots[field] == before[field]).all()


PILLAR = ObjectClass(name="pillar", solid=True, radius=0.5, at=((7.0, 4.0),))
CASES: list[
    tuple[str, dict[str, Any], float, float]
] = [  # what is in the way; degrees it drives in; where x, y ends
    ("the outer wall", {}, 0.0, 10.0 - RADIUS),
    ("a wall", {"walls": (Wall(points=((7.0, 1.0), (7.0, 7.0))),)}, 0.0, 7.0 - RADIUS),
    ("the end of a wall", {"walls": (Wall(points=((7.0, 4.0), (9.0, 4.0))),)}, 0.0, 7.0 - RADIUS),
    ("a disc", {"obstacles": (Obstacle(radius=0.5, at=((7.0, 4.0),)),)}, 0.0, 6.5 - RADIUS),
    ("a polygon's edge", {"obstacles": (Obstacle(points=SQUARE, at=((7.0, 4.0),)),)}, 0.0, 6.5 - RADIUS),
    (
        "a polygon's corner",
        {"obstacles": (Obstacle(points=SQUARE, at=((7.0, 4.0, 45.0),)),)},
        0.0,
        7.0 - 0.5**0.5 - RADIUS,
    ),
    ("a solid object", {"objects": (PILLAR,)}, 0.0, 6.5 - RADIUS),
]


@pytest.mark.parametrize("fast", [1.0, 7.0, 1000.0], ids=["slow", "step > radius", "step > arena"])
@pytest.mark.parametrize(("what", "more", "degrees", "ends"), CASES, ids=[case[0] for case in CASES])
def test_it_stops_at_contact_and_can_leave(
    what: str, more: dict[str, Any], degrees: float, ends: float, fast: float
) -> None:
    kind = RobotType(radius=RADIUS, speed=10 * STEP * fast, turning_deg=90.0)
    world = arena((3.0, 4.0, degrees), kind=kind, **more)
    drive(world, 200)
    assert ends - GAP <= robot(world)[0] <= ends
    assert robot(world)[1] == 4.0
    stopped = robot(world)
    drive(world, 3)
    assert robot(world) == pytest.approx(stopped, abs=GAP)
    drive(world, 20, drive=0.0, turn=1.0)  # turns around
    assert robot(world)[:2] == pytest.approx(stopped[:2], abs=GAP)
    drive(world, 1)
    assert robot(world)[0] < ends - 0.04


def test_robots_head_on() -> None:
    world = arena((3.0, 4.0, 0.0), (7.0, 4.0, 180.0))
    drive(world, 100)
    assert robot(world, 1)[0] - robot(world)[0] == pytest.approx(2 * RADIUS, abs=2 * GAP)
    assert robot(world)[0] == pytest.approx(5.0 - RADIUS, abs=GAP)
    assert robot(world, 1)[0] - robot(world)[0] >= 2 * RADIUS
    drive(world, 10, drive=np.array([0.0, -1.0]))
    assert robot(world, 1)[0] == pytest.approx(5.5 + RADIUS, abs=GAP)


def test_a_robot_that_drives_off_lets_the_next_follow() -> None:
    """A column of robots, rim to rim: all go on, none overtakes."""
    world = arena(*((2.0 + 2.0 * RADIUS * index, 4.0, 0.0) for index in range(5)))
    drive(world, 60)
    gaps = np.diff(world.state.robots["x"])
    assert (gaps >= 2 * RADIUS).all()
    assert world.state.robots["x"][4] == pytest.approx(3.6 + 60 * STEP)
    assert world.state.robots["x"][0] > 2.0 + 50 * STEP


@pytest.mark.parametrize("step", [0.05, 0.6, 3.0, 500.0])
def test_nothing_tunnels_however_fast(step: float) -> None:
    """Many robots, each in a cell of thin walls: all are where they were."""
    walls = tuple(Wall(points=((0.0, y), (10.0, y))) for y in (2.0, 4.0, 6.0))
    walls += tuple(Wall(points=((x, 0.0), (x, 8.0))) for x in (2.0, 4.0, 6.0, 8.0))
    places = tuple((1.0 + 2.0 * (index % 5), 1.0 + 2.0 * (index // 5), 37.0 * index) for index in range(20))
    kind = RobotType(radius=RADIUS, speed=10 * step, turning_deg=1700.0, noise_drive=0.5)
    world = arena(*places, kind=kind, walls=walls)
    draw = np.random.default_rng(0)
    for _ in range(300):
        drive(world, 1, drive=draw.uniform(-1, 1, 20), turn=draw.uniform(-1, 1, 20))
    robots = world.state.robots
    assert (np.floor(robots["x"] / 2.0) == np.arange(20) % 5).all()
    assert (np.floor(robots["y"] / 2.0) == np.arange(20) // 5).all()
    inside = np.stack([robots["x"] % 2.0, robots["y"] % 2.0])
    assert (np.abs(inside - 1.0) <= 1.0 - RADIUS).all()
    assert np.abs(robots["x"] % 2.0 - 1.0).max() > 0.7


def test_blocked_robots_know_it_and_forget_it() -> None:
    world = arena((9.8, 4.0, 0.0))
    drive(world, 5)
    assert world.state.robots["blocked"][0] == 5
    drive(world, 1, drive=0.0)
    assert world.state.robots["blocked"][0] == 0
    drive(world, 3)
    drive(world, 1, drive=-1.0)
    assert world.state.robots["blocked"][0] == 0


BOX = ObjectClass(name="box", pushable=True, radius=0.3, at=((4.0, 4.0),))


def test_a_box_goes_as_far_as_it_is_driven() -> None:
    world = arena((3.0, 4.0, 0.0), objects=(BOX,))
    drive(world, 60)
    assert robot(world)[0] == pytest.approx(3.0 + 60 * STEP, abs=1e-6)
    assert locate_object(world)[0] == pytest.approx(6.0 + RADIUS + 0.3, abs=1e-6)
    assert locate_object(world)[1] == 4.0
    assert locate_object(world)[0] - robot(world)[0] >= RADIUS + 0.3
    drive(world, 10, drive=-1.0)
    assert locate_object(world)[0] == pytest.approx(6.0 + RADIUS + 0.3, abs=1e-6)  # not pulled


def test_some_boxes_take_two() -> None:
    heavy = ObjectClass(name="box", pushable=True, pushers=2, radius=0.5, at=((5.0, 4.0),))
    alone = arena((3.0, 4.0, 0.0), objects=(heavy,))
    drive(alone, 100)
    assert locate_object(alone) == (5.0, 4.0)
    assert robot(alone)[0] == pytest.approx(4.5 - RADIUS, abs=GAP)
    both = arena((3.0, 3.7, 0.0), (3.0, 4.3, 0.0), objects=(heavy,))
    drive(both, 40)
    assert locate_object(both)[0] > 5.1
    assert locate_object(both)[1] == pytest.approx(4.0, abs=1e-9)
    against = arena((3.0, 4.0, 0.0), (7.0, 4.0, 180.0), objects=(heavy,))
    drive(against, 100)
    assert locate_object(against) == pytest.approx((5.0, 4.0), abs=1e-6)


def test_a_box_at_a_wall_stops_the_robot() -> None:
    world = arena((3.0, 4.0, 0.0), objects=(BOX,))
    drive(world, 300)
    assert locate_object(world)[0] == pytest.approx(10.0 - 0.3, abs=1e-6)
    assert locate_object(world)[0] <= 10.0 - 0.3
    assert robot(world)[0] == pytest.approx(10.0 - 0.6 - RADIUS, abs=1e-6)
    assert world.state.robots["blocked"][0] > 50


def test_a_box_pushes_no_box() -> None:
    boxes = ObjectClass(name="box", pushable=True, radius=0.3, at=((4.0, 4.0), (6.0, 4.0)))
    world = arena((3.0, 4.0, 0.0), objects=(boxes,))
    drive(world, 200)
    assert locate_object(world, 1) == (6.0, 4.0)
    assert locate_object(world)[0] == pytest.approx(5.4, abs=1e-6)
    assert robot(world)[0] == pytest.approx(5.4 - 0.3 - RADIUS, abs=1e-6)


def test_a_box_pushes_no_robot() -> None:
    world = arena((3.0, 4.0, 0.0), (6.0, 4.0, 90.0), objects=(BOX,))
    drive(world, 200, drive=np.array([1.0, 0.0]))
    assert robot(world, 1)[:2] == (6.0, 4.0)
    assert locate_object(world)[0] == pytest.approx(6.0 - RADIUS - 0.3, abs=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_boxes_in_a_crowd_hardly_overlap(seed: int) -> None:
    """A box gives way by as much as 1 % of its radius, and no more."""
    scenario = Scenario(
        size=(4.0, 4.0),
        types={"rover": RobotType(radius=0.15, speed=1.0, turning_deg=300.0)},
        robots=(RobotGroup(type="rover", count=12),),
        objects=(ObjectClass(name="box", pushable=True, radius=0.2, count=12),),
    )
    world = World(scenario, (seed,))
    draw = np.random.default_rng(seed)
    moved = 0
    for _ in range(200):
        before = world.state.objects["x"].copy()
        drive(world, 1, drive=draw.uniform(-0.2, 1, 12), turn=draw.uniform(-1, 1, 12))
        moved += int((world.state.objects["x"] != before).sum())
        boxes = world.state.objects[0]
        boxes = boxes[boxes["present"] != 0]
        x = np.concatenate([world.state.robots["x"], boxes["x"]])
        y = np.concatenate([world.state.robots["y"], boxes["y"]])
        radius = np.repeat([0.15, 0.2], 12)
        apart = np.hypot(x[:, None] - x, y[:, None] - y) - radius - radius[:, None] + 9 * np.eye(24)
        assert apart.min() >= -0.01 * 0.2
        assert apart[:12, :12].min() >= 0
        assert np.minimum(x, y).min() >= 0.15
        assert np.maximum(x - 4 + radius, y - 4 + radius).max() <= 0.002
    assert moved > 50


@pytest.mark.parametrize("degrees", [90.0, 180.0, 270.0])
def test_the_world_turned_is_the_same_world(degrees: float) -> None:
    """A square arena with a robot, a box and a disc, turned by quarters: all ends turned likewise."""

    def rotate(x: float, y: float, by: float) -> tuple[float, float]:
        c, s = round(cos(radians(by))), round(sin(radians(by)))
        return 4.0 + c * (x - 4.0) - s * (y - 4.0), 4.0 + s * (x - 4.0) + c * (y - 4.0)

    def world(by: float) -> World:
        scenario = Scenario(
            size=(8.0, 8.0),
            types={"rover": RobotType(radius=RADIUS, speed=0.5, turning_deg=90.0)},
            robots=(
                RobotGroup(
                    type="rover", at=((*rotate(2.0, 3.9, by), by), (*rotate(5.0, 5.0, by), by + 200.0))
                ),
            ),
            obstacles=(Obstacle(radius=0.5, at=(rotate(6.5, 4.4, by),)),),
            objects=(ObjectClass(name="box", pushable=True, radius=0.3, at=(rotate(3.0, 4.0, by),)),),
        )
        return World(scenario, (0,))

    one, other = world(0.0), world(degrees)
    for tick in range(100):
        for each in (one, other):
            drive(each, 1, drive=1.0, turn=0.1 * (tick % 3 - 1))
        for index in range(2):
            x, y, heading = robot(one, index)
            assert robot(other, index)[:2] == pytest.approx(rotate(x, y, degrees), abs=1e-7)
            assert (robot(other, index)[2] - heading - radians(degrees) + pi) % tau - pi == pytest.approx(
                0, abs=1e-9
            )
        assert locate_object(other) == pytest.approx(rotate(*locate_object(one), degrees), abs=1e-7)
    assert hypot(locate_object(one)[0] - 3.0, locate_object(one)[1] - 4.0) > 0.1


def test_robots_that_do_not_collide_go_through_each_other_only() -> None:
    kind = RobotType(radius=RADIUS, speed=10 * STEP, turning_deg=90.0, collides=False)
    world = arena((3.0, 4.0, 0.0), (4.0, 4.0, 180.0), kind=kind, objects=(PILLAR,))
    drive(world, 100)
    assert robot(world)[0] == pytest.approx(6.5 - RADIUS, abs=GAP)
    assert robot(world, 1)[0] == pytest.approx(RADIUS, abs=GAP)


def test_overlapping_things_can_part() -> None:
    """Whatever brought them there: they never come nearer, and may go away."""
    world = arena((3.0, 4.0, 0.0), (7.0, 4.0, 180.0))
    world.state.robots["x"][1] = 3.1
    drive(world, 5)
    assert (robot(world)[0], robot(world, 1)[0]) == (3.0, 3.1)
    drive(world, 20, drive=-1.0)
    assert robot(world)[0] == pytest.approx(2.0)
    assert robot(world, 1)[0] == pytest.approx(4.1)


def make_walk_world(**more: Any) -> World:
    return arena((1.0, 1.0, 0.0), **more)


def walker(speed: float, *, solid: bool = True) -> ObjectClass:
    return ObjectClass(name="dog", solid=solid, radius=0.3, count=3, walk=RandomWalk(speed=speed, turn_s=1.0))


@pytest.mark.parametrize("solid", [True, False])
@pytest.mark.parametrize("speed", [0.5, 8.0, 200.0])
def test_what_walks_goes_through_no_wall(speed: float, solid: bool) -> None:
    wall = Wall(points=((5.0, 0.0), (5.0, 8.0)))
    dogs = walker(speed, solid=solid)
    world = make_walk_world(objects=(dogs,), walls=(wall,))
    side, moved = world.state.objects["x"][0, :3] > 5.0, False
    for _ in range(300):
        before = world.state.objects["x"][0, :3].copy()
        drive(world, 1, drive=0.0)
        now = world.state.objects["x"][0, :3]
        assert ((now > 5.0) == side).all()
        assert (np.abs(now - 5.0) >= 0.3).all()
        assert ((now >= 0.3) & (now <= 9.7)).all()
        moved |= bool((before != now).any())
    assert moved


def test_a_large_robot_is_not_walked_over() -> None:
    kind = RobotType(radius=1.5, speed=0.0)
    world = arena((5.0, 4.0, 0.0), kind=kind, objects=(walker(5.0),))
    for _ in range(300):
        drive(world, 1)
        dogs = world.state.objects[0, :3]
        assert (np.hypot(dogs["x"] - 5.0, dogs["y"] - 4.0) >= 1.8).all()


def test_what_walks_keeps_to_its_region_and_comes_back_to_it() -> None:
    dog = ObjectClass(name="dog", radius=0.3, walk=RandomWalk(speed=1.0, turn_s=0.5), within="yard")
    narrow = ArenaRegion(box=(2.0, 2.0, 4.0, 2.2))  # narrower than the dog
    world = make_walk_world(objects=(dog,), regions={"yard": narrow})
    places = []
    for _ in range(300):
        drive(world, 1, drive=0.0)
        places.append(locate_object(world))
        assert 2.0 <= places[-1][0] <= 4.0
        assert 2.0 <= places[-1][1] <= 2.2
    assert max(x for x, _ in places) - min(x for x, _ in places) > 0.5
    world.move_object(0, 7.0, 7.0)
    for _ in range(3000):
        drive(world, 1, drive=0.0)
    assert 2.0 <= locate_object(world)[0] <= 4.0
