"""Random scenarios, for whatever has to hold in any world: all sorts of robots, sensors, obstacles and objects.

All is drawn from a `random.Random`: a number says which scenario it was.
"""

from __future__ import annotations

from collections.abc import Iterator
from random import Random
from typing import Any

import numpy as np
from msgspec.structs import replace

from understudy.errors import SettingError
from understudy.runtime.body import Commands
from understudy.sim.scenario.schema import (
    AppearanceSchedule,
    Breakdown,
    Bumper,
    Camera,
    CaptureRule,
    CargoSensor,
    ClaimSensor,
    ElapsedSensor,
    Goal,
    GripSensor,
    Lidar,
    ObjectClass,
    Obstacle,
    PoseSensor,
    PullRule,
    RandomSensor,
    RandomWalk,
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
from understudy.sim.world import World

COLORS = ("red", "green", "blue", "yellow")
SQUARE = ((-0.4, -0.3), (0.4, -0.3), (0.4, 0.3), (-0.4, 0.3))
CORNER = ((-0.5, -0.5), (0.5, -0.5), (0.5, -0.2), (-0.2, -0.2), (-0.2, 0.5), (-0.5, 0.5))
SPIKE = ((-0.6, 0.0), (0.6, -0.03), (0.6, 0.03))
SECTORS: tuple[dict[str, tuple[float, float]], ...] = (
    {"ahead": (0.0, 0.0), "left": (20.0, 70.0), "right": (-70.0, -20.0)},
    {"ahead": (-30.0, 30.0), "left": (30.0, 250.0), "right": (-110.0, -30.0), "around": (-180.0, 180.0)},
)
BEHAVIORS = {
    "forward": {"drive": 1.0},
    "back": {"drive": -0.6},
    "left": {"turn": 1.0},
    "right": {"turn": -1.0},
    "curve": {"drive": 0.8, "turn": 0.4},
    "stand": {},
}
CARRYING = {"load": {"load": 1.0}, "unload": {"unload": 1.0}}


def draw_world(number: int, *, worlds: int = 1) -> World:
    """Worlds of the random scenario of this number; their seeds follow it."""
    random = Random(number)
    while True:
        scenario = with_breakdowns(Random(number), random_scenario(random))
        try:
            return World(scenario, range(number, number + worlds))
        except SettingError as error:
            if not any(word in str(error) for word in ("fit", "room", "overlap")):
                raise


def draw_pulling_world(number: int, *, worlds: int = 1) -> World:
    """Worlds of a random scenario with boxes to pull, and robots that call and claim; their seeds follow its number."""
    random = Random(number)
    while True:
        scenario = with_breakdowns(Random(number), with_boxes(random, random_scenario(random)))
        try:
            return World(scenario, range(number, number + worlds))
        except SettingError as error:
            if not any(word in str(error) for word in ("fit", "room", "overlap")):
                raise


def with_breakdowns(random: Random, scenario: Scenario) -> Scenario:
    """The scenario with some robots, in a third of its groups, that fail within the first 20 ticks."""
    robots = []
    for group in scenario.robots:
        if random.random() < 0.3 and isinstance(group.count, int):
            at_s = (0.0, 20 * scenario.tick_s)
            group = replace(group, fails=(Breakdown(at_s=at_s, count=(0, group.count)),))
        robots.append(group)
    return replace(scenario, robots=tuple(robots))


def with_boxes(random: Random, scenario: Scenario) -> Scenario:
    """The scenario with boxes that some robots begin beside, homes to pull them to, and signals."""
    width, height = (min(side, 8.0) for side in scenario.size)
    walls = scenario.walls if (width, height) == scenario.size else ()
    boxes = tuple(
        ObjectClass(
            name=f"crate {robots}",
            count=random.randint(1, 3),
            radius=random.uniform(0.05, 0.2),
            pull=PullRule(robots=robots, respawn=random.random() < 0.5),
            color=random.choice((None, "red")),
        )
        for robots in random.sample((1, 1, 2, 3), 2)
        if robots > 1 or random.random() < 0.7
    )
    boxes = tuple({box.name: box for box in boxes}.values()) or (
        ObjectClass(name="crate 1", pull=PullRule()),
    )
    goal = ObjectClass(name="goal", home=True, radius=random.uniform(0.3, 0.8), color="blue")
    boxes = (replace(boxes[0], near="goal", near_m=goal.radius + random.uniform(0.05, 0.4)), *boxes[1:])
    signals = random.choice(("help", "claim")), random.choice(("help", "claim"))
    raised = {
        "call": {"signal": "help"}, "grab": {"load": 1.0, "signal": signals[0]}, "drop": {"unload": 1.0},
        "tow": {"drive": 1.0, "signal": "claim"}, "haul": {"drive": 0.7, "turn": 0.3},
    }  # fmt: skip
    chosen = random.choice(boxes).name
    targets = {
        "caller": TargetSpec(signal="help"),
        "mate": TargetSpec(signal="claim", robot=random.choice(("teammate", "opponent", "any"))),
        "free": TargetSpec(nearest=chosen, unclaimed="claim", within=random.choice((0.3, 1.0, 3.0))),
        "crate": TargetSpec(nearest=chosen),
    }
    claimed = ClaimSensor(signal="claim", range=random.choice((0.3, 1.0)), dropout=random.choice((0.0, 0.2)))
    sensors: tuple[Sensor, ...] = (GripSensor(), claimed, ElapsedSensor(name="unclaimed for", of="claimed"))
    types = {}
    for name, kind in scenario.types.items():
        behaviors = {**kind.behaviors, **raised}
        sees = (
            kind.sensors
            if any(isinstance(each, TargetLocator) for each in kind.sensors)
            else (*kind.sensors, TargetLocator())
        )
        reach = random.uniform(0.4, 1.2)
        types[name] = replace(kind, behaviors=behaviors, sensors=(*sees, *sensors), reach=reach)
    robots = tuple(
        replace(each, count=min(6, each.count if isinstance(each.count, int) else 1))
        for each in scenario.robots
    )
    near = RobotGroup(type=next(iter(types)), count=random.randint(2, 4), near=boxes[0].name, near_m=0.4)
    gathering = Goal(gathered=1) if scenario.goal is None else scenario.goal
    return replace(
        scenario, size=(width, height), walls=walls, objects=(*scenario.objects, *boxes, goal),
        types=types, robots=(*robots, near), targets={**scenario.targets, **targets}, goal=gathering,
        spare_objects=random.choice((0, 2, 100)),
    )  # fmt: skip


def random_scenario(random: Random) -> Scenario:
    """A scenario that can be, but for what finds no place in it."""
    side = random.choice((2.5, 3.5, 5.0, 5.0, 9.0, 14.0, 60.0))
    size = (side, side * random.uniform(0.6, 1.5))
    tick_s = random.choice((0.05, 0.1, 0.1, 0.25))
    objects = _objects(random, tick_s)
    obstacles = _obstacles(random, size)
    carries = any(thing.amount != 0 for thing in objects)
    names = ("alpha", "beta", "gamma")[: random.choice((1, 1, 2, 3))]
    types = {name: _type(random, tick_s, carries=carries) for name in names}
    colors = {
        color
        for color in (
            *(each.color for each in obstacles),
            *(each.color for each in objects),
            *(each.color for each in types.values()),
        )
        if color
    }
    targets = _targets(random, objects, {kind.team or name for name, kind in types.items()}, colors)
    types = {name: _with_targets(random, kind, tuple(targets)) for name, kind in types.items()}
    most = random.choice((1, 4, 10, 60))
    return Scenario(
        name="random",
        size=size,
        tick_s=tick_s,
        walls=_walls(random, size),
        obstacles=obstacles,
        objects=objects,
        types=types,
        robots=tuple(
            _robots(random, name, kind, objects, most=-(-most // len(types))) for name, kind in types.items()
        ),
        targets=targets,
        goal=_goal(random, objects),
        spare_objects=random.choice((0, 2, 16)),
        generator=1 if most in (1, 10) else 2,
    )


def draw_commands(draw: np.random.Generator, world: World) -> Commands:
    """Commands, good for some ticks: most robots drive ahead, some turn, some stand still and may load."""
    count = world.agents
    drive, turn, load, unload = draw.uniform(-1.3, 1.3, (4, count)).clip(-1.1, 1.1)
    does = draw.integers(0, 4, count)
    drive = np.where(does == 1, drive, 1.0)
    commands = {"drive": np.where(does > 0, drive, 0.0), "turn": np.where(does <= 2, turn, 0.0)}
    commands["turn"][draw.random(count) < 0.3] = 0.0
    names = [channel.name for channel in world.channels]
    if "load" in names:
        commands |= {"load": load, "unload": unload}
    if "signal" in names:  # those of worlds with boxes: some take hold, and few let go at once
        grabs, drops = draw.random((2, count)) < 0.3
        for name in ("drive", "turn"):
            commands[name] = np.where(grabs, 0.0, commands[name])
        commands |= {"load": np.where(grabs, 1.0, load), "unload": np.where(drops, unload, 0.0)}
        commands["signal"] = draw.integers(-1, 4, count).astype(np.float64)
    return commands


def _robots(
    random: Random, name: str, kind: RobotType, objects: tuple[ObjectClass, ...], *, most: int
) -> RobotGroup:
    """Robots anywhere, or a few of them beside an object: to load, unload or push."""
    stored = random.randint(0, kind.capacity)
    beside = [
        thing for thing in objects
        if thing.presence is None and (not isinstance(thing.count, tuple) or thing.count[0] > 0)
    ]  # fmt: skip
    if not beside or random.random() < 0.4:
        return RobotGroup(type=name, count=random.randint(1, most), stored=stored)
    thing = random.choice(beside)
    away = thing.radius + kind.radius + random.uniform(0.001, 0.1)
    return RobotGroup(
        type=name, count=random.randint(1, min(4, most)), near=thing.name, near_m=away, stored=stored
    )


def _walls(random: Random, size: tuple[float, float]) -> tuple[Wall, ...]:
    def point() -> tuple[float, float]:
        return random.uniform(0, size[0]), random.uniform(0, size[1])

    return tuple(
        Wall(points=tuple(point() for _ in range(random.randint(3, 4))), closed=random.random() < 0.2)
        for _ in range(random.choice((0, 0, 1, 3)))
    )


def _obstacles(random: Random, size: tuple[float, float]) -> tuple[Obstacle, ...]:
    found: list[Obstacle] = []
    many = 1 + int(max(size) / 4)
    if random.random() < 0.6:
        color = random.choice((None, *COLORS))
        found.append(Obstacle(radius=random.uniform(0.05, 0.5), count=random.randint(1, many), color=color))
    shapes = [points for points in (SQUARE, CORNER, SPIKE, CORNER[::-1]) if random.random() < 0.25]
    return (*found, *(Obstacle(points=points, count=(0, many)) for points in shapes))


def _objects(random: Random, tick_s: float) -> tuple[ObjectClass, ...]:
    def size() -> float:
        return random.uniform(0.05, 0.3)

    some = random.random
    solid, walking = some() < 0.5, some() < 0.5
    presence = AppearanceSchedule(
        away_s=(0.0, 20 * tick_s),
        stays_s=random.choice((None, (tick_s, 15 * tick_s))),
        first_s=(0.0, 3 * tick_s),
    )
    candidates = (
        ObjectClass(name="food", amount=random.choice((1, (0, 6), (3, 9))), count=(1, 4), radius=size(), color="green"),
        ObjectClass(name="berries", amount=(1, 3), count=2, presence=presence, color="yellow"),
        ObjectClass(name="home", home=True, radius=size(), color="blue", aloft=walking),
        ObjectClass(name="marker", count=random.randint(1, 3), radius=0.0),
        ObjectClass(name="pillar", solid=True, count=(0, 3), radius=size(), color="red", height=0.2),
        ObjectClass(name="box", pushable=True, count=random.randint(1, 6), radius=size()),
        ObjectClass(name="crate", pushable=True, pushers=2, count=2, radius=size(), color="blue"),
        ObjectClass(
            name="walker", solid=solid, radius=size(), color="yellow", count=random.randint(1, 3),
            walk=RandomWalk(speed=random.choice((0.1, 1.0, 30.0)), turn_s=random.choice((0.5, 5.0))),
        ),
        ObjectClass(
            name="visitor", solid=solid, radius=size(), color="green", count=2, presence=presence,
            capture=random.choice((None, CaptureRule(range=0.7, after_s=3 * tick_s))),
            walk=RandomWalk(speed=0.3) if walking else None,
        ),
        ObjectClass(name="coin", count=3, color="yellow", capture=CaptureRule(range=0.5)),
    )  # fmt: skip
    return tuple(thing for thing in candidates if some() < 0.4)


def _type(random: Random, tick_s: float, *, carries: bool) -> RobotType:
    def maybe(*values: float) -> Any:
        return random.choice((None, *values))

    step = random.choice((0.01, 0.05, 0.05, 0.2, 3.0))  # m per tick
    noisy = random.random() < 0.4
    capacity = random.randint(0, 4) if carries else 0
    behaviors: dict[str, dict[str, float]] = {name: dict(value) for name, value in BEHAVIORS.items()}
    if capacity:
        behaviors |= {name: dict(value) for name, value in CARRYING.items()}
    return RobotType(
        radius=random.uniform(0.05, 0.3),
        speed=step / tick_s,
        turning_deg=random.uniform(1.0, 170.0) / max(1.0, tick_s),
        acceleration=maybe(step / tick_s),
        turning_acceleration_deg=maybe(300.0),
        noise_drive=random.choice((0.05, 0.8)) if noisy else 0.0,
        noise_turn=random.choice((0.05, 0.8)) if noisy else 0.0,
        color=random.choice((None, *COLORS)),
        team=random.choice((None, "home", "away")),
        capacity=capacity,
        reach=random.uniform(0.2, 0.8),
        load_s=tick_s * random.randint(1, 3),
        unload_s=tick_s * random.randint(1, 3),
        collides=random.random() < 0.9,
        sensors=_sensors(random, tick_s, carries=carries),
        behaviors=behaviors,
    )


def _sensors(random: Random, tick_s: float, *, carries: bool) -> tuple[Sensor, ...]:
    def draw_measurement() -> dict[str, Any]:
        rate = random.choice((None, None, 1.0 / tick_s, 0.3 / tick_s, 0.07 / tick_s))
        return {"dropout": random.choice((0.0, 0.0, 0.3)), "rate_hz": rate}

    noisy = random.random() < 0.5
    locator = TargetLocator(
        range=random.choice((None, 1.5)), noise_range=0.1 * noisy, noise_deg=5.0 * noisy, **draw_measurement()
    )
    sees: tuple[Any, ...] = random.choice(
        (("walls", "obstacles", "robots"), ("walls",), ("robots",), ("obstacles", "robots"))
    )
    sonar = Sonar(
        sectors=random.choice(SECTORS), range=random.choice((0.3, 2.0, 8.0)), noise=0.02 * noisy, sees=sees,
        **draw_measurement(),
    )  # fmt: skip
    camera = Camera(
        view_deg=random.choice((20.0, 60.0, 150.0)), range=random.choice((None, 3.0)),
        choose=random.choice(("largest", "nearest")), noise_x=2.0 * noisy, noise_size=0.1 * noisy,
        misses=0.1 * noisy, ghosts=0.1 * noisy, **draw_measurement(),
    )  # fmt: skip
    bumper = Bumper(sectors={"front": (-90.0, 90.0), "rear": (90.0, 270.0)}, **draw_measurement())
    chance = RandomSensor(every_s=random.choice((None, 3 * tick_s)), **draw_measurement())
    pose = PoseSensor(noise=0.01 * noisy, noise_deg=1.0 * noisy, **draw_measurement())
    candidates: list[Sensor] = [locator, sonar, camera, bumper, chance, pose, StallSensor(after_s=3 * tick_s)]
    candidates += [CargoSensor(**draw_measurement())] if carries else []
    chosen = [sensor for sensor in candidates if random.random() < 0.6] or [locator]
    for name, of, sensor in (
        ("unseen", "blob_x", camera),
        ("lost", "range", locator),
        ("free", "front", bumper),
    ):
        if sensor in chosen and random.random() < 0.5:
            chosen.append(ElapsedSensor(name=name, of=of))
    random.shuffle(chosen)
    return (*chosen, *_lidars(Random(repr(chosen)), tick_s))


def _lidars(random: Random, tick_s: float) -> Iterator[Lidar]:
    """Up to two lidars; all else in a random world stays as it is without them."""
    for number in range(random.choice((0, 0, 1, 2))):
        reach, around = random.choice((0.3, 2.0, 8.0)), random.random() < 0.5
        sectors = {f"lidar_{number}_ahead": (-35.0, 35.0)}
        sectors |= (
            {f"lidar_{number}_rear": (100.0, 260.0), f"lidar_{number}_all": (-180.0, 180.0)} if around else {}
        )
        yield Lidar(
            name=f"lidar_{number}", view_deg=360.0 if around else random.choice((90.0, 355.0)),
            beams=random.choice((12, 17, 36)), range=reach, clear=random.choice((0.2, 0.5, 1.0)) * reach,
            noise=random.choice((0.0, 0.02, 5.0)), dropout=random.choice((0.0, 0.0, 0.3)),
            rate_hz=random.choice((None, None, 0.3 / tick_s)), sectors=sectors,
            sees=random.choice((("walls", "obstacles", "robots"), ("robots",))),
        )  # fmt: skip


def _targets(
    random: Random, objects: tuple[ObjectClass, ...], teams: set[str], colors: set[str]
) -> dict[str, TargetSpec]:
    found = {f"nearest {thing.name}": TargetSpec(nearest=thing.name) for thing in objects}
    found |= {f"the {thing.name}": TargetSpec(object=thing.name) for thing in objects}
    found |= {f"team {team}": TargetSpec(team=team) for team in sorted(teams)}
    found |= {
        "anyone": TargetSpec(robot="any"),
        "teammate": TargetSpec(robot="teammate"),
        "opponent": TargetSpec(robot="opponent"),
        "mouse": TargetSpec(object="mouse"),
    }
    found |= {f"color {color}": TargetSpec(color=color) for color in sorted(colors)}
    names = random.sample(list(found), min(len(found), random.randint(1, 6)))
    return {name: found[name] for name in names}


def _with_targets(random: Random, kind: RobotType, targets: tuple[str, ...]) -> RobotType:
    """Sometimes two locators instead of one, the other for some targets only."""
    if (
        len(targets) < 2
        or random.random() < 0.7
        or not any(isinstance(each, TargetLocator) for each in kind.sensors)
    ):
        return kind
    return replace(
        kind, sensors=(*kind.sensors, TargetLocator(targets=targets[:1], range=random.uniform(0.5, 4.0)))
    )


def _goal(random: Random, objects: tuple[ObjectClass, ...]) -> Goal | None:
    if not objects or random.random() < 0.6:
        return None
    return Goal(target=random.choice(objects).name, within=0.6, all=random.random() < 0.5)
