"""The standard task, which every row of `bench swarm` runs, ours and the other programs'.

There is a quarter of a robot per square metre, in an arena of side 2√N; robots are discs that collide, drive 0.1 m a
tick or turn 0.1 rad, and start at random places. They run for at most 100 ticks, and are then reset to the start.
*Base*: each tick every robot reads range and bearing of the nearest of 20 beacons, and of the nearest other robot
within 4 m. *Full*: also three sonar sectors, against 20 round obstacles and the walls.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees, pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.model.automaton import Automaton
from understudy.model.behaviors import Behavior, Command
from understudy.model.binding import Binding, Target
from understudy.model.features import BoundFeature, Feature
from understudy.model.library import Kit, Library
from understudy.model.value_kinds import TAU, Continuous, Toroidal
from understudy.sim.scenario.schema import (
    ObjectClass,
    Obstacle,
    RobotGroup,
    RobotType,
    Scenario,
    Sensor,
    Sonar,
    TargetLocator,
    TargetSpec,
)
from understudy_lab.tree_builder import (
    TreeBranch,
    build_automaton,
    split_below,
    split_on_flag,
    split_on_left,
    split_within,
)

Column = NDArray[np.float64]

TICK_S = 0.1
STEP, TURN = 0.1, 0.1
"""The distance (m) and the angle (rad) of one tick of driving or turning."""

RADIUS, SIGHT = 0.2, 4.0
"""The radius of a robot, and the range of its sensor for others, m."""

BEACONS, OBSTACLES, OBSTACLE_RADIUS = 20, 20, 0.5
SONAR_RANGE = 3.0
SECTORS = {"left": (20.0, 70.0), "front": (-20.0, 20.0), "right": (-70.0, -20.0)}

TICKS = 100
"""The number of ticks of a run, from the start to the reset."""

CROWDING_TICKS = 3000

COMMANDS = {"forward": {"drive": 1.0}, "left": {"turn": 1.0}, "right": {"turn": -1.0}}


def side(robots: int) -> float:
    """Return the side of the arena for N robots, m."""
    return 2.0 * sqrt(robots)


def make_base_scenario(robots: int) -> Scenario:
    """Return the world of the base task: beacons and robots, each with a locator."""
    return _scenario("base", robots, sensors=_LOCATORS)


def make_full_scenario(robots: int) -> Scenario:
    """Return the world of the full task: base with obstacles, and a sonar on each robot."""
    return _scenario("full", robots, sensors=(*_LOCATORS, _SONAR), obstacles=_OBSTACLES)


def make_crowded_scenario(robots: int) -> Scenario:
    """Return the world of the full task with all its beacons in the middle."""
    middle = (side(robots) / 2, side(robots) / 2)
    beacons = ObjectClass(name="beacon", at=(middle,) * BEACONS)
    return _scenario("crowding", robots, sensors=(*_LOCATORS, _SONAR), obstacles=_OBSTACLES, beacons=beacons)


_LOCATORS: tuple[Sensor, ...] = (
    TargetLocator(targets=("beacon",)),
    TargetLocator(targets=("robot",), range=SIGHT),
)
_SONAR = Sonar(sectors=SECTORS, range=SONAR_RANGE, sees=("walls", "obstacles"))
_OBSTACLES = (Obstacle(count=OBSTACLES, radius=OBSTACLE_RADIUS),)
_BEACONS = ObjectClass(name="beacon", count=BEACONS)


def _scenario(
    name: str,
    robots: int,
    *,
    sensors: tuple[Sensor, ...],
    obstacles: tuple[Obstacle, ...] = (),
    beacons: ObjectClass = _BEACONS,
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
        robots=(RobotGroup(type="robot", count=robots),),
        targets={"beacon": TargetSpec(nearest="beacon"), "robot": TargetSpec(robot="any")},
        spare_objects=0,
    )


@dataclass(frozen=True)
class StartLayout:
    """The start of a run for programs without scenarios: positions x, y and headings as columns [N]."""

    x: Column
    y: Column
    heading: Column
    beacon_x: Column
    beacon_y: Column
    obstacle_x: Column
    obstacle_y: Column

    @classmethod
    def of(cls, robots: int, seed: int = 0) -> StartLayout:
        """Draw a layout uniformly over the arena."""
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


BASE, FULL = "base", "errand"
"""The names of the behaviors at the root."""

PERSONAL, AHEAD, ARRIVED = 0.6, 0.3, 0.5
"""The thresholds of the base task: distance to keep (m), straight ahead (rad), and arrival (m)."""


@dataclass(frozen=True)
class TaskParams:
    """The parameters of robots in the full task: lengths in m, angles in rad."""

    personal: float = 0.8
    arrived: float = 0.5
    away: float = 3.0
    close: float = 0.5
    free: float = 0.8
    beside: float = 0.3


CROWD = TaskParams(personal=0.0, arrived=0.0)
"""The parameters of robots that never give way and never arrive, so that they crowd at the beacon."""


def make_base_library() -> Library:
    """Return the behavior of the base task: drive to the nearest beacon, but away from a robot close ahead."""
    decide = split_below(
        "robot_range",
        PERSONAL,
        split_within("robot_angle", pi / 2, split_on_left("robot_angle", "right", "left"), _seek()),
        _seek(),
    )
    return _library(_automaton(BASE, dict.fromkeys(("start", "there", *COMMANDS), decide), basics=COMMANDS))


def _seek() -> TreeBranch:
    return split_below("beacon_range", ARRIVED, "there", _toward("beacon_angle", AHEAD))


def _toward(angle: str, ahead: float) -> TreeBranch:
    return split_within(angle, ahead, "forward", split_on_left(angle, "left", "right"))


def make_full_library(manners: TaskParams = TaskParams()) -> Library:
    """Return the behavior `errand`: visit beacon after beacon, around obstacles, and give way to near robots."""
    return _library(_steer(manners), _dodge(manners), _travel(manners), _give_way(manners), _errand(manners))


def _errand(m: TaskParams) -> Automaton:
    visit = split_below(
        "robot_range", m.personal, split_within("robot_angle", pi / 2, "give_way", "visit"), "visit"
    )
    return _automaton(
        FULL,
        {
            "start": split_below("robot_range", m.personal, "give_way", "visit"),
            "visit": split_on_flag("arrived", "leave", visit),
            "give_way": split_on_flag(
                "clear", "visit", split_below("robot_range", 2 * m.personal, "give_way", "visit")
            ),
            "leave": split_below(
                "front", m.close, "visit", split_below("beacon_range", m.away, "leave", "visit")
            ),
        },
        runs={"visit": "travel", "give_way": "give_way", "leave": "forward"},
    )


def _travel(m: TaskParams) -> Automaton:
    sides = split_below("left", m.beside, "skirt", split_below("right", m.beside, "skirt", "approach"))
    near = split_below("beacon_range", m.arrived, "arrived", "skirt")
    return _automaton(
        "travel",
        {
            "start": split_below(
                "front", m.close, "skirt", split_below("beacon_range", m.arrived, "arrived", "approach")
            ),
            "approach": split_on_flag("there", "arrived", split_below("front", m.close, "skirt", sides)),
            "skirt": split_on_flag("past", split_below("front", m.close, "skirt", "approach"), near),
        },
        runs={"approach": "steer", "skirt": "dodge"},
        flags=("arrived",),
    )


def _steer(m: TaskParams) -> Automaton:
    """Return an automaton that steers to the beacon, with a wider angle while driving to prevent oscillation."""
    wide = {"start": 0.3, "forward": 0.45, "left": 0.15, "right": 0.15}
    return _automaton(
        "steer",
        {
            state: split_below("beacon_range", m.arrived, "there", _toward("beacon_angle", ahead))
            for state, ahead in wide.items()
        },
        flags=("there",),
        basics=COMMANDS,
    )


def _dodge(m: TaskParams) -> Automaton:
    beside = split_below("left", m.beside, "forward", split_below("right", m.beside, "forward", "past"))
    turn = split_below(
        "left",
        m.beside,
        "right",
        split_below("right", m.beside, "left", split_on_left("beacon_angle", "left", "right")),
    )
    return _automaton(
        "dodge",
        {
            "start": split_below("front", m.close, turn, beside),
            "forward": split_below("front", m.close, split_below("left", m.beside, "right", "left"), beside),
            "left": split_below(
                "front", m.free, split_below("left", m.beside / 2, "right", "left"), "forward"
            ),
            "right": split_below(
                "front", m.free, split_below("right", m.beside / 2, "left", "right"), "forward"
            ),
        },
        flags=("past",),
        basics=COMMANDS,
    )


def _give_way(m: TaskParams) -> Automaton:
    turn = split_on_left("robot_angle", "right", "left")

    def aside(way: str) -> TreeBranch:
        return split_below(
            "robot_range", m.personal, split_within("robot_angle", pi / 2, way, "forward"), "clear"
        )

    pass_by = split_within("robot_angle", pi / 3, turn, split_below("front", m.close, "clear", "forward"))
    return _automaton(
        "give_way",
        {
            "start": split_below("robot_range", m.personal, turn, "clear"),
            "forward": split_below("robot_range", m.personal, pass_by, "clear"),
            "left": aside("left"),
            "right": aside("right"),
        },
        flags=("clear",),
        basics=COMMANDS,
    )


_READINGS = {
    "beacon_range": BoundFeature(Feature("distance_to", Continuous(), "range", "A"), Binding(A="beacon")),
    "beacon_angle": BoundFeature(Feature("angle_to", Toroidal(), "bearing", "A"), Binding(A="beacon")),
    "robot_range": BoundFeature(Feature("distance_to", Continuous(), "range", "A"), Binding(A="robot")),
    "robot_angle": BoundFeature(Feature("angle_to", Toroidal(), "bearing", "A"), Binding(A="robot")),
    **{
        name: BoundFeature(Feature(f"sonar_{name}", Continuous(), name))
        for name in ("left", "front", "right")
    },
}


def _library(*automata: Automaton) -> Library:
    features = {bound.feature.name: bound.feature for bound in _READINGS.values()}
    basics = [Behavior(name, Command(**channels)) for name, channels in COMMANDS.items()]
    return Library.from_automata(
        Kit.from_parts(*features.values(), *basics, Target("beacon"), Target("robot")), *automata
    )


def _automaton(name: str, asks: Mapping[str, TreeBranch], **more: Any) -> Automaton:
    return build_automaton(name, asks, readings=_READINGS, **more)
