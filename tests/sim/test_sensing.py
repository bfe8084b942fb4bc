"""What robots sense, against plain references: each sensor with its own range, noise, rate and dropout."""

from __future__ import annotations

from math import atan2, hypot, isnan, nan, pi, tan, tau
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray
from tests.sim.laws import pieces
from tests.sim.random_scenarios import draw_commands, draw_world
from tests.sim.test_collisions import drive

from understudy.errors import SettingError, UnknownName
from understudy.model.features import ReadingKey
from understudy.runtime.body import list_reading_keys
from understudy.sim.kernel_context import KernelContext
from understudy.sim.scenario.schema import (
    Bumper,
    Camera,
    CargoSensor,
    ElapsedSensor,
    ObjectClass,
    Obstacle,
    PoseSensor,
    RandomSensor,
    RobotGroup,
    RobotType,
    Scenario,
    Sensor,
    Sonar,
    StallSensor,
    TargetLocator,
    TargetSpec,
    Wall,
)
from understudy.sim.step import sense_worlds
from understudy.sim.world import World

Floats = NDArray[np.float64]

FLAGS = ObjectClass(name="flag", color="red", radius=0.1, at=((6.0, 4.0), (2.0, 7.0)))
TARGETS = {
    "flag": TargetSpec(nearest="flag"),
    "second flag": TargetSpec(object="flag", index=1),
    "anyone": TargetSpec(robot="any"),
    "mate": TargetSpec(robot="teammate"),
    "opponent": TargetSpec(robot="opponent"),
    "blues": TargetSpec(team="blue"),
    "pointer": TargetSpec(object="mouse"),
}


def world_of(
    *sensors: Sensor, at: tuple[tuple[float, ...], ...] = ((5.0, 4.0, 0.0),), seed: int = 0, **more: Any
) -> World:
    """A world of 10 m x 8 m: robots of the team red with these sensors, and two blue ones without any."""
    scenario = Scenario(
        size=(10.0, 8.0),
        types={
            "scout": RobotType(
                radius=0.2, speed=0.5, turning_deg=90.0, team="red", color="red", sensors=sensors
            ),
            "blind": RobotType(radius=0.3, team="blue", color="blue"),
        },
        robots=(
            RobotGroup(type="scout", at=at),
            RobotGroup(type="blind", at=((1.0, 1.0, 0.0), (9.0, 1.0, 0.0))),
        ),
        targets=more.pop("targets", TARGETS),
        objects=more.pop("objects", (FLAGS,)),
        **more,
    )
    return World(scenario, (seed,))


def read(world: World, name: str, target: str | None = None) -> float:
    """What the first robot reads."""
    return float(world.sense([(name, target)])[name, target][0])


# Against references in random worlds, without noise.


QUIET = ("dropout", "noise", "noise_deg", "noise_range", "noise_x", "noise_size", "misses", "ghosts")


def quiet(sensor: Sensor) -> Sensor:
    """A sensor that measures every tick, without noise."""
    changes: dict[str, Any] = {name: 0.0 for name in QUIET if hasattr(sensor, name)}
    return replace(sensor, rate_hz=None, **changes)


def noiseless(number: int) -> World:
    """A random world whose sensors have no noise and always answer; a few ticks on."""
    noisy = draw_world(number)
    types = {
        name: replace(kind, sensors=tuple(map(quiet, kind.sensors)))
        for name, kind in noisy.scenario.types.items()
    }
    world = World(replace(noisy.scenario, types=types), noisy.seeds)
    draw = np.random.default_rng(number)
    world.place_pointer(*draw.uniform(0, 1, 2) * world.scenario.size)
    for _ in range(int(draw.integers(8))):
        world.act(draw_commands(draw, world))
    return world


def candidates(world: World, agent: int, target: TargetSpec) -> list[tuple[float, float]]:
    """Where all is that a target may be, in order of slots and ids."""
    names, rules, objects = world.names, world.rules, world.state.objects[0]
    if target.nearest is not None or target.object is not None:
        kind = rules.classes[names.classes.index(target.nearest or target.object or "")]
        slots = list(range(kind["first"], kind["end"]))
        if target.object is not None:
            slots = slots[target.index : target.index + 1]
        return [
            (float(objects["x"][slot]), float(objects["y"][slot]))
            for slot in slots
            if objects["present"][slot]
            and (target.object is not None or not kind["food"] or objects["amount"][slot] > 0)
        ]
    if target.color is not None:
        return []
    teams = rules.types["team"][world.state.robots["type"]]
    found = []
    for other, row in enumerate(world.state.robots):
        wanted = {
            "any": True,
            "teammate": teams[other] == teams[agent],
            "opponent": teams[other] != teams[agent],
            None: target.team is not None and names.teams[teams[other]] == target.team,
        }[target.robot]
        if other != agent and wanted:
            found.append((float(row["x"]), float(row["y"])))
    return found


@pytest.mark.parametrize("number", range(60))
def test_locators(number: int) -> None:
    world = noiseless(number)
    percept = world.sense(list_reading_keys(world))
    for agent, row in enumerate(world.state.robots):
        if world.failed[agent]:
            assert all(isnan(column[agent]) for column in percept.values())
            continue
        kind = world.scenario.types[world.names.types[row["type"]]]
        locators = [sensor for sensor in kind.sensors if isinstance(sensor, TargetLocator)]
        named = {target for sensor in locators for target in sensor.targets or ()}
        for sensor in locators:
            for name in sensor.targets or [name for name in world.targets if name not in named]:
                places = candidates(world, agent, world.scenario.targets[name])
                distances = [hypot(x - row["x"], y - row["y"]) for x, y in places]
                seen = percept["range", name][agent], percept["bearing", name][agent]
                if not places or min(distances) > (sensor.range or np.inf):
                    assert all(map(isnan, seen))
                    continue
                x, y = places[distances.index(min(distances))]
                assert seen[0] == pytest.approx(min(distances), abs=1e-12)
                off = (seen[1] - atan2(y - row["y"], x - row["x"]) + row["heading"] + pi) % tau - pi
                assert off == pytest.approx(0.0, abs=1e-9)


def rays(world: World, agent: int, sensor: Sonar, angles: Floats) -> Floats:
    """How far rays from a robot's center reach, each intersected with each thing on its own."""
    row = world.state.robots[agent]
    x, y = float(row["x"]), float(row["y"])
    ray_x, ray_y = np.cos(angles + row["heading"]), np.sin(angles + row["heading"])
    best = np.full(len(angles), np.inf)
    segments = pieces(world, 0)
    is_wall = world.state.segments[0]["wall"][~np.isnan(world.state.segments[0]["x0"])] != 0
    lines = [
        line
        for line, wall in zip(segments, is_wall, strict=True)
        if ("walls" if wall else "obstacles") in sensor.sees
    ]
    width, height = world.scenario.size
    if "walls" in sensor.sees:
        corners = ((0.0, 0.0), (width, 0.0), (width, height), (0.0, height))
        lines += [
            np.array([*one, *other]) for one, other in zip(corners, (*corners[1:], corners[0]), strict=True)
        ]
    for x0, y0, x1, y1 in lines:
        across = (x1 - x0) * ray_y - (y1 - y0) * ray_x
        with np.errstate(divide="ignore", invalid="ignore"):
            along = ((x1 - x0) * (y0 - y) - (y1 - y0) * (x0 - x)) / across
            share = (ray_x * (y0 - y) - ray_y * (x0 - x)) / across
        hit = (along >= 0) & (share >= 0) & (share <= 1)
        best = np.where(hit & (along < best), along, best)
    discs: list[tuple[float, float, float]] = []
    if "obstacles" in sensor.sees:
        discs += [(d["x"], d["y"], d["radius"]) for d in world.state.discs[0] if d["radius"] > 0]
        kinds = world.rules.classes[world.rules.class_of]
        for kind, thing in zip(kinds, world.state.objects[0], strict=True):
            if thing["present"] and kind["solid"]:
                discs.append((thing["x"], thing["y"], kind["radius"]))
    if "robots" in sensor.sees:
        for other, them in enumerate(world.state.robots):
            if other != agent:
                discs.append((them["x"], them["y"], world.rules.types["radius"][them["type"]]))
    for center_x, center_y, radius in discs:
        middle = (center_x - x) * ray_x + (center_y - y) * ray_y
        aside = (center_x - x) ** 2 + (center_y - y) ** 2 - middle**2
        with np.errstate(invalid="ignore"):
            along = middle - np.sqrt(radius**2 - aside)
        inside = hypot(center_x - x, center_y - y) < radius
        along = np.zeros(len(angles)) if inside else along
        best = np.where((along >= 0) & (along < best), along, best)
    return best


@pytest.mark.parametrize("number", range(60, 110))
def test_sonars_and_bumpers(number: int) -> None:
    world = noiseless(number)
    percept = world.sense(list_reading_keys(world))
    for agent in np.flatnonzero(~world.failed)[:6].tolist():
        index = world.state.robots["type"][agent]
        kind = world.scenario.types[world.names.types[index]]
        for sensor in kind.sensors:
            if isinstance(sensor, Sonar):
                for name, (low, high) in sensor.sectors.items():
                    angles = np.radians(np.linspace(low, high, 1 if low == high else 2000))
                    reach = rays(world, agent, sensor, angles).min() - kind.radius
                    measured = percept[name, None][agent]
                    expected = min(sensor.range, max(0.0, reach))
                    if low == high:
                        assert measured == pytest.approx(expected, abs=1e-9)
                    else:  # a ray may miss by a little what is nearest, or the end of a wall
                        assert measured <= expected + 1e-9
                        assert measured >= min(expected, _nearest(world, agent, sensor) - kind.radius) - 1e-9
            elif isinstance(sensor, Bumper):
                everything = Sonar(sectors={})
                for name, (low, high) in sensor.sectors.items():
                    angles = np.radians(np.linspace(low, high, 4000))
                    touching = rays(world, agent, everything, angles).min() < kind.radius + 0.005
                    if touching:
                        assert percept[name, None][agent] == 1.0


def _nearest(world: World, agent: int, sensor: Sonar) -> float:
    """How far what is nearest is in all directions."""
    return float(rays(world, agent, sensor, np.linspace(0, tau, 20_000)).min()) * 0.999


# By hand.


def test_ranges_and_bearings() -> None:
    world = world_of(TargetLocator(), at=((3.0, 4.0, 90.0), (3.0, 3.0, 0.0)))
    percept = world.sense(list_reading_keys(world))
    assert percept["range", "flag"][:2] == pytest.approx([3.0, 10**0.5])
    assert percept["bearing", "flag"][0] == pytest.approx(3 * pi / 2)  # to the right
    assert percept["range", "second flag"][0] == pytest.approx(10**0.5)
    assert percept["range", "mate"][:2] == pytest.approx([1.0, 1.0])
    assert percept["bearing", "mate"][:2] == pytest.approx([pi, pi / 2])
    assert percept["range", "opponent"][0] == percept["range", "blues"][0] == pytest.approx(13**0.5)
    assert np.isnan(percept["range", "pointer"]).all()
    assert np.isnan(percept["range", "flag"][2:]).all()  # no such sensor
    world.place_pointer(3.0, 6.0)
    assert read(world, "range", "pointer") == 2.0
    world.place_pointer(None)
    assert isnan(read(world, "range", "pointer"))


def test_as_far_as_the_range_and_no_farther() -> None:
    for limit, there in ((1.0, True), (0.999, False)):
        world = world_of(TargetLocator(range=limit))
        assert isnan(read(world, "range", "flag")) is not there
        assert isnan(read(world, "bearing", "flag")) is not there


def test_of_robots_equally_near_the_one_with_the_lowest_id() -> None:
    """Ahead is robot 1; behind, as near, is robot 2."""
    for places in (((5.0, 4.0, 0.0), (6.0, 4.0), (4.0, 4.0)), ((5.0, 4.0, 180.0), (4.0, 4.0), (6.0, 4.0))):
        world = world_of(TargetLocator(), at=places)
        assert read(world, "range", "anyone") == 1.0
        assert (read(world, "bearing", "anyone") + 1e-9) % tau == pytest.approx(0.0, abs=1e-6)


def test_food_that_is_gone_is_not_nearest() -> None:
    food = ObjectClass(name="flag", amount=3, at=((6.0, 4.0), (8.0, 4.0)))
    world = world_of(TargetLocator(), objects=(food,))
    assert read(world, "range", "flag") == 1.0
    world.state.objects["amount"][0, 0] = 0
    assert read(world, "range", "flag") == 3.0
    world.state.objects["amount"][0, 1] = 0
    assert isnan(read(world, "range", "flag"))


def test_several_locators_share_the_targets() -> None:
    world = world_of(TargetLocator(targets=("flag",), range=0.5), TargetLocator())
    assert isnan(read(world, "range", "flag"))
    assert read(world, "range", "second flag") == pytest.approx(18**0.5)


def test_one_reading_behind_two_keys_of_a_plan() -> None:
    """Two features may be of one reading: both columns hold it, with the same noise."""
    sensors = (
        TargetLocator(noise_range=0.1),
        Sonar(sectors={"ahead": (-10, 10)}, noise=0.1),
        Camera(noise_x=1.0),
    )
    world = world_of(*sensors, RandomSensor(), ElapsedSensor(name="unseen", of="blob_x"))
    keys: list[ReadingKey] = [("range", "flag"), ("bearing", "flag"), ("ahead", None), ("blob_x", "flag"),
                              ("random", None), ("unseen", "flag")]  # fmt: skip
    plan = world._planner.plan((*keys, *keys[::-1]))
    out = np.zeros((world.agents, 2 * len(keys)))
    sense_worlds(KernelContext(world._kernel_worlds, plan, world._room), 1, out)
    assert np.array_equal(out[:, : len(keys)], out[:, : len(keys) - 1 : -1], equal_nan=True)
    assert np.array_equal(out[0, : len(keys)], [world.sense(keys)[key][0] for key in keys])
    assert world.sense(keys * 2).keys() == world.sense(keys).keys()


CAMERAS = [  # where, of which color and how wide a flag is; x and size in a frame of 100 x 100 px and 90 degrees
    ((7.0, 4.0), 0.1, 50.0, 2 * 50 / 399**0.5 * 50 * 0.2 / 2),
    ((3.0, 4.0), 0.1, nan, nan),
]


@pytest.mark.parametrize(("place", "radius", "x", "size"), CAMERAS)
def test_a_camera(place: tuple[float, float], radius: float, x: float, size: float) -> None:
    flag = ObjectClass(name="flag", color="red", radius=radius, at=(place,))
    world = world_of(Camera(view_deg=90.0, width_px=100, height_px=100, least_px=0.0), objects=(flag,))
    assert read(world, "blob_x", "flag") == pytest.approx(x, nan_ok=True)
    assert read(world, "blob_size", "flag") == pytest.approx(size, rel=1e-6, nan_ok=True)


def test_a_camera_sees_colors_and_their_range() -> None:
    camera = Camera(view_deg=90.0, width_px=100, height_px=100, range=3.0, least_px=0.0)
    targets = {**TARGETS, "blue": TargetSpec(color="blue"), "red": TargetSpec(color="red")}
    world = world_of(camera, at=((6.04, 1.0, 0.0),), targets=targets, objects=(FLAGS,))
    assert read(world, "blob_x", "blue") == 50.0
    assert read(world, "blob_x", "blues") == 50.0
    assert isnan(read(world, "blob_x", "red"))  # itself it does not see
    assert isnan(read(world, "blob_x", "anyone"))  # no color in particular
    drive(world, 1, drive=np.array([-1.0, 0.0, 0.0]))
    assert isnan(read(world, "blob_x", "blue"))  # 3.01 m


def test_half_hidden_behind_a_pillar() -> None:
    """The right half of the blob is behind a wall that ends on the line of sight."""
    camera = Camera(view_deg=90.0, width_px=100, height_px=100, least_px=0.0)
    flag = ObjectClass(name="flag", color="red", radius=0.6, height=1.0, at=((7.0, 4.0),))
    free = world_of(camera, objects=(flag,))
    half = world_of(camera, objects=(flag,), walls=(Wall(points=((6.0, 4.0), (6.0, 1.0))),))
    assert read(half, "blob_size", "flag") == pytest.approx(read(free, "blob_size", "flag") / 2)
    assert read(half, "blob_x", "flag") < 50.0
    tangent = 0.6 / (4.0 - 0.36) ** 0.5
    assert read(half, "blob_x", "flag") == pytest.approx(50 - 25 * tangent / tan(pi / 4))


def test_a_beam_against_a_circle() -> None:
    """3 m ahead, 0.3 m aside, radius 0.5 m: the beam meets it 0.4 m before its center."""
    world = world_of(
        Sonar(sectors={"beam": (0.0, 0.0)}, range=5.0), obstacles=(Obstacle(radius=0.5, at=((8.0, 4.3),)),)
    )
    assert read(world, "beam") == pytest.approx(3.0 - 0.4 - 0.2)


def test_pose() -> None:
    world = world_of(PoseSensor())
    drive(world, 1, drive=0.5, turn=1.0)
    names = ("x", "y", "heading", "speed", "turning")
    row = world.state.robots[0]
    assert [read(world, name) for name in names] == pytest.approx(
        [row["x"], row["y"], row["heading"], 0.25, pi / 2]
    )
    drive(world, 1, drive=-1.0)
    assert read(world, "speed") == pytest.approx(-0.5)


def test_bumpers_and_stuck() -> None:
    sectors = {"front": (-90.0, 90.0), "rear": (90.0, 270.0)}
    world = world_of(Bumper(sectors=sectors), StallSensor(after_s=0.5), at=((9.5, 4.0, 0.0),))
    assert (read(world, "front"), read(world, "rear"), read(world, "stuck")) == (0.0, 0.0, 0.0)
    drive(world, 6)
    assert (read(world, "front"), read(world, "rear"), read(world, "stuck")) == (1.0, 0.0, 0.0)
    drive(world, 5)
    assert read(world, "stuck") == 1.0
    drive(world, 1, drive=-1.0)
    assert (read(world, "front"), read(world, "stuck")) == (0.0, 0.0)


@pytest.mark.parametrize("gap", [0.0001, 0.003, 0.0049])
def test_a_bumper_feels_all_that_is_near(gap: float) -> None:
    """Of slow robots among many obstacles too: what is within touch is listed for where they are."""
    scenario = Scenario(
        size=(3.0, 3.0),
        types={"snail": RobotType(radius=0.05, speed=0.001, sensors=(Bumper(),))},
        robots=(RobotGroup(type="snail"),),
        obstacles=(Obstacle(radius=0.1, count=20, apart=0.1),),
    )
    world = World(scenario, (0,))
    robot = world.state.robots[0]
    for disc in world.state.discs[0]:
        for angle in np.linspace(0.0, tau, 50):
            robot["x"] = disc["x"] + (0.15 + gap) * np.cos(angle)
            robot["y"] = disc["y"] + (0.15 + gap) * np.sin(angle)
            assert read(world, "bumper") == 1.0


def make_carrying_world(**more: Any) -> World:
    scenario = Scenario(
        size=(10.0, 8.0),
        types={"ant": RobotType(capacity=2, reach=0.5, load_s=0.3, unload_s=0.2, sensors=(CargoSensor(),))},
        robots=(RobotGroup(type="ant", at=((5.0, 4.0), (5.4, 4.6))),),
        objects=(
            ObjectClass(name="food", amount=3, at=((5.0, 4.4),)),
            ObjectClass(name="home", home=True, at=((5.0, 3.6),)),
        ),
        **more,
    )
    return World(scenario, (0,))


def test_cargo() -> None:
    world = make_carrying_world()
    names = ("food_stored", "food_here", "food_left", "station_here")
    assert [read(world, name) for name in names] == [0.0, 3.0, 1.0, 1.0]
    two = {"load": np.ones(2)}
    for _ in range(3):
        assert read(world, "food_stored") == 0.0
        world.act(two)
    assert [read(world, name) for name in names] == [1.0, 1.0, 1.0, 1.0]
    for _ in range(3):
        world.act(two)
    assert world.state.robots["stored"].tolist() == [2, 1]  # the last unit is for the lowest id
    assert [read(world, name) for name in names] == [2.0, 0.0, 0.0, 1.0]
    world.act({"unload": np.ones(2)})
    world.act({"unload": np.ones(2), "drive": np.full(2, 0.01)})  # broken off
    world.act({"unload": np.ones(2)})
    assert world.state.robots["stored"].tolist() == [2, 1]
    world.act({"unload": np.ones(2)})
    assert world.state.robots["stored"].tolist() == [1, 1]  # the other one is too far from home
    assert world.delivered.tolist() == [1]


# What comes and goes.


def test_since() -> None:
    sensors = (
        TargetLocator(targets=("pointer",), range=2.0),
        Bumper(),
        ElapsedSensor(name="lost", of="range"),
        ElapsedSensor(name="free", of="bumper"),
    )
    world = world_of(*sensors, at=((9.0, 4.0, 0.0),), targets={"pointer": TARGETS["pointer"]})
    assert isnan(read(world, "lost", "pointer"))
    assert isnan(read(world, "free"))
    world.place_pointer(9.0, 5.0)
    assert read(world, "lost", "pointer") == 0.0
    drive(world, 2, drive=0.0)
    world.place_pointer(None)
    assert read(world, "lost", "pointer") == pytest.approx(0.1)  # there at the tick before
    drive(world, 2, drive=0.0)
    assert read(world, "lost", "pointer") == pytest.approx(0.3)
    assert isnan(read(world, "free"))
    drive(world, 30)
    assert read(world, "free") == 0.0
    drive(world, 1, drive=-1.0)
    assert read(world, "free") == pytest.approx(0.1)
    world.place(0, 5.0, 4.0, 0.0)
    drive(world, 9, drive=0.0)
    assert read(world, "free") == pytest.approx(1.0)


def test_since_has_a_rate_and_drops_out_like_any_sensor() -> None:
    sensors = (
        TargetLocator(),
        ElapsedSensor(name="lost", of="range", rate_hz=2.5, dropout=0.0),
        ElapsedSensor(name="fresh", of="range", dropout=0.3),
    )
    world = world_of(*sensors, targets={"pointer": TARGETS["pointer"]})
    world.place_pointer(9.0, 5.0)
    drive(world, 2, drive=0.0)
    world.place_pointer(None)
    lost = read_repeatedly(world, "lost", 11, "pointer")  # from tick 2 on; measured at 0, 4, 8 and 12
    assert lost.tolist() == pytest.approx([0.0] * 2 + [0.3] * 4 + [0.7] * 4 + [1.1])
    fresh = read_repeatedly(world, "fresh", 2000, "pointer")
    assert np.isnan(fresh).mean() == pytest.approx(0.3, abs=0.04)
    there = ~np.isnan(fresh)
    assert fresh[there] == pytest.approx(1.2 + 0.1 * np.arange(2000)[there])


def test_a_rate_holds_the_last_answer() -> None:
    """At 2.5 Hz and 0.1 s a tick every fourth tick measures, whether anyone asks or not."""
    world = world_of(PoseSensor(rate_hz=2.5), TargetLocator(rate_hz=5.0, noise_range=0.1))
    x, ranges = [], []
    for tick in range(13):
        if tick % 3 != 1:  # asked now and then only
            x.append((tick, read(world, "x")))
            ranges.append((tick, read(world, "range", "flag")))
        drive(world, 1)
    assert dict(x) == {tick: pytest.approx(5.0 + 0.05 * (tick // 4 * 4)) for tick, _ in x}
    held = dict(ranges)
    assert all(held[tick] == held[tick + 1] for tick in (2, 8))
    assert held[3] != held[5]


def read_repeatedly(world: World, name: str, ticks: int, target: str | None = None) -> Floats:
    """What the first robot reads in so many ticks, standing still."""
    found = []
    for _ in range(ticks):
        found.append(read(world, name, target))
        world.act({})
    return np.array(found)


def test_dropout() -> None:
    world = world_of(PoseSensor(dropout=0.3), TargetLocator(dropout=1.0))
    absent = np.isnan(read_repeatedly(world, "x", 3000))
    assert absent.mean() == pytest.approx(0.3, abs=0.03)
    assert (absent[1:] & absent[:-1]).mean() == pytest.approx(0.09, abs=0.02)  # each time anew
    assert isnan(read(world, "range", "flag"))


NOISES: list[tuple[Sensor, str, str | None, float, float]] = [
    (PoseSensor(noise=0.2), "x", None, 5.0, 0.2),
    (PoseSensor(noise_deg=3.0), "turning", None, 0.0, 3.0 * pi / 180),
    (TargetLocator(noise_range=0.1), "range", "flag", 1.0, 0.1),
    (TargetLocator(noise_deg=4.0), "bearing", "second flag", 3 * pi / 4, 4 * pi / 180),
    (Sonar(sectors={"ahead": (0, 0)}, range=8.0, noise=0.05), "ahead", None, 4.8, 0.05),
    (Camera(noise_x=2.0, noise_size=0.1), "blob_x", "flag", 80.0, 2.0),
]


@pytest.mark.parametrize(("sensor", "name", "target", "mean", "spread"), NOISES)
def test_noise(sensor: Sensor, name: str, target: str | None, mean: float, spread: float) -> None:
    values = read_repeatedly(world_of(sensor), name, 3000, target)
    assert values.mean() == pytest.approx(mean, abs=5 * spread / 3000**0.5)
    assert values.std() == pytest.approx(spread, rel=0.05)
    assert abs(np.corrcoef(values[1:], values[:-1])[0, 1]) < 0.08


def test_what_is_absent_stays_absent_in_noise() -> None:
    world = world_of(
        TargetLocator(range=0.1, noise_range=1.0, noise_deg=10.0),
        Camera(noise_x=3.0, noise_size=1.0, range=0.2),
    )
    for name in ("range", "bearing", "blob_x", "blob_size"):
        assert np.isnan(read_repeatedly(world, name, 20, "flag")).all()


def test_misses_and_ghosts() -> None:
    seldom = world_of(Camera(misses=0.25))
    assert np.isnan(read_repeatedly(seldom, "blob_x", 2000, "flag")).mean() == pytest.approx(0.25, abs=0.04)
    haunted = world_of(Camera(ghosts=0.2))
    ghosts = read_repeatedly(haunted, "blob_x", 2000, "pointer")
    assert np.isnan(ghosts).mean() == pytest.approx(1.0)  # of no color: nothing to take for it
    nowhere = world_of(Camera(ghosts=0.2), objects=(ObjectClass(name="flag", color="red", at=((1.0, 7.0),)),))
    ghosts = read_repeatedly(nowhere, "blob_x", 2000, "flag")
    assert (~np.isnan(ghosts)).mean() == pytest.approx(0.2, abs=0.04)
    there = ghosts[~np.isnan(ghosts)]
    assert there.min() < 20 < 140 < there.max() <= 160


def test_chance() -> None:
    values = read_repeatedly(world_of(RandomSensor(every_s=0.5)), "random", 2000)
    assert (values.reshape(-1, 5) == values[::5, None]).all()
    fresh = values[::5]
    assert len(set(fresh)) == len(fresh)
    assert ((fresh >= 0) & (fresh < 1)).all()
    assert fresh.mean() == pytest.approx(0.5, abs=0.06)
    assert (
        read_repeatedly(world_of(RandomSensor(), seed=1), "random", 5).tolist()
        != read_repeatedly(world_of(RandomSensor()), "random", 5).tolist()
    )


def test_sensors_of_a_sort_draw_on_their_own() -> None:
    """Two robots, two sectors, two targets: no two draw the same, nor as places were drawn."""
    sonar = Sonar(sectors={"one": (0, 0), "two": (0, 0)}, noise=0.1, range=9.0)
    world = world_of(sonar, TargetLocator(noise_range=0.1), at=((5.0, 4.0, 0.0), (5.0, 5.0, 0.0)))
    percepts = []
    for _ in range(500):
        percept = world.sense(list_reading_keys(world))
        percepts.append([
            *percept["one", None][:2], *percept["two", None][:2],
            *percept["range", "flag"][:2], *percept["range", "second flag"][:2],
        ])  # fmt: skip
        world.act({})
    correlation = np.corrcoef(np.array(percepts).T) - np.eye(8)
    assert np.abs(correlation).max() < 0.2


def test_a_frozen_robot_reads_nothing_and_stays() -> None:
    world = world_of(
        PoseSensor(rate_hz=2.0), TargetLocator(), Bumper(), at=((5.0, 4.0, 0.0), (5.0, 5.0, 0.0))
    )
    drive(world, 3)
    world.freeze(0)
    before = world.state.robots[0].copy()
    drive(world, 10, turn=1.0)
    after = world.state.robots[0]
    assert (after["x"], after["y"], after["heading"]) == (before["x"], before["y"], before["heading"])
    percept = world.sense(list_reading_keys(world))
    assert all(np.isnan(column[0]) for column in percept.values())
    assert not np.isnan(percept["x", None][1])
    assert percept["range", "anyone"][1] < 2.0  # it is still there


@pytest.mark.parametrize("collides", [True, False])
def test_nearest_of_many_robots(collides: bool) -> None:
    """In a grid as in a list of all: also where robots let others pass and two are in the same place."""
    random = np.random.default_rng(3)
    places = [(*place, 0.0) for place in random.uniform(1.0, 7.0, (80, 2)).tolist()]
    kind = RobotType(radius=0.001, collides=collides, sensors=(TargetLocator(range=2.0),))
    extra = [] if collides else [places[0], places[0], places[7]]
    scenario = Scenario(
        size=(8.0, 8.0),
        types={"rover": kind},
        robots=(RobotGroup(type="rover", at=tuple(places + extra)),),
        targets={"anyone": TargetSpec(robot="any")},
    )
    world = World(scenario, (0,))
    x, y = world.state.robots["x"], world.state.robots["y"]
    apart = np.hypot(x[:, None] - x, y[:, None] - y)
    np.fill_diagonal(apart, np.inf)
    expected = np.where(apart.min(axis=1) <= 2.0, apart.min(axis=1), np.nan)
    assert (expected == 0.0).sum() == (0 if collides else 5)
    np.testing.assert_allclose(world.sense([("range", "anyone")])["range", "anyone"], expected, rtol=1e-12)


def test_a_reading_of_a_target_is_asked_for_with_one() -> None:
    sensors = (TargetLocator(), StallSensor(), ElapsedSensor(name="since_seen", of="range"))
    world = world_of(*sensors)
    with pytest.raises(SettingError, match="reading 'since_seen' needs a target; give one of flag, "):
        world.sense([("since_seen", None)])
    with pytest.raises(SettingError, match="reading 'stuck' takes no target, and 'flag' is given"):
        world.sense([("stuck", "flag")])
    with pytest.raises(UnknownName, match="no target 'flga'"):
        world.sense([("range", "flga")])
