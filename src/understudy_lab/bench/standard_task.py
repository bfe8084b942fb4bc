"""The standard task, defined once: what every row of `bench swarm` runs, ours and the peers'.

A quarter of a robot per square metre, in an arena of side 2√N; robots are discs that collide, drive 0.1 m a tick or
turn 0.1 rad, and start at random places. They run for at most 100 ticks, and are then set back to the start.
*Base*: each tick every robot reads range and bearing of the nearest of 20 beacons, and of the nearest other robot
within 4 m. *Full*: also three sonar sectors, against 20 round obstacles and the walls.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, sqrt

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import TAU
from understudy.sim.scenario.schema import (
    Locator,
    Objects,
    Obstacle,
    Robots,
    RobotType,
    Scenario,
    Sensor,
    Sonar,
    TargetOf,
)

Column = NDArray[np.float64]

TICK_S = 0.1
STEP, TURN = 0.1, 0.1
"""What a robot drives (m) or turns (rad) in a tick."""

RADIUS, SIGHT = 0.2, 4.0
"""Of a robot; and how far it finds others."""

BEACONS, OBSTACLES, OBSTACLE_RADIUS = 20, 20, 0.5
SONAR_RANGE = 3.0
SECTORS = {"left": (20.0, 70.0), "front": (-20.0, 20.0), "right": (-70.0, -20.0)}

TICKS = 100
"""A run's length, from the start to the reset."""

CROWDING_TICKS = 3000

COMMANDS = {"forward": {"drive": 1.0}, "left": {"turn": 1.0}, "right": {"turn": -1.0}}


def side(robots: int) -> float:
    """The side of the arena for N robots, m."""
    return 2.0 * sqrt(robots)


def make_base_scenario(robots: int) -> Scenario:
    """The base task's world: beacons and robots, each with a locator."""
    return _scenario("base", robots, sensors=_LOCATORS)


def make_full_scenario(robots: int) -> Scenario:
    """The full task's world: base with obstacles, and a sonar on each robot."""
    return _scenario("full", robots, sensors=(*_LOCATORS, _SONAR), obstacles=_OBSTACLES)


def crowding(robots: int) -> Scenario:
    """The full task's world with all its beacons in one place, the middle."""
    middle = (side(robots) / 2, side(robots) / 2)
    beacons = Objects(name="beacon", at=(middle,) * BEACONS)
    return _scenario("crowding", robots, sensors=(*_LOCATORS, _SONAR), obstacles=_OBSTACLES, beacons=beacons)


_LOCATORS: tuple[Sensor, ...] = (Locator(targets=("beacon",)), Locator(targets=("robot",), range=SIGHT))
_SONAR = Sonar(sectors=SECTORS, range=SONAR_RANGE, sees=("walls", "obstacles"))
_OBSTACLES = (Obstacle(count=OBSTACLES, radius=OBSTACLE_RADIUS),)
_BEACONS = Objects(name="beacon", count=BEACONS)


def _scenario(
    name: str,
    robots: int,
    *,
    sensors: tuple[Sensor, ...],
    obstacles: tuple[Obstacle, ...] = (),
    beacons: Objects = _BEACONS,
) -> Scenario:
    robot = RobotType(
        radius=RADIUS,
        speed=STEP / TICK_S,
        turning_deg=degrees(TURN / TICK_S),
        sensors=sensors,
        behaviors=COMMANDS,
    )
    return Scenario(
        name=name,
        size=(side(robots), side(robots)),
        tick_s=TICK_S,
        limit_s=CROWDING_TICKS * TICK_S,
        obstacles=obstacles,
        objects=(beacons,),
        types={"robot": robot},
        robots=(Robots(type="robot", count=robots),),
        targets={"beacon": TargetOf(nearest="beacon"), "robot": TargetOf(robot="any")},
        spare_objects=0,
    )


@dataclass(frozen=True)
class Start:
    """Where a run starts for those that are not given a Scenario: places x, y and headings, columns [N]."""

    x: Column
    y: Column
    heading: Column
    beacon_x: Column
    beacon_y: Column
    obstacle_x: Column
    obstacle_y: Column

    @classmethod
    def of(cls, robots: int, seed: int = 0) -> Start:
        """Uniform over the arena, anew for each seed."""
        random = np.random.default_rng(seed)
        low, high = RADIUS, side(robots) - RADIUS

        def column(count: int) -> Column:
            return random.uniform(low, high, count)

        return cls(
            x=column(robots),
            y=column(robots),
            heading=random.uniform(0.0, TAU, robots),
            beacon_x=column(BEACONS),
            beacon_y=column(BEACONS),
            obstacle_x=column(OBSTACLES),
            obstacle_y=column(OBSTACLES),
        )
