"""The baseline of the foraging world: a hand-written controller, and a lower bound on the time needed."""

from __future__ import annotations

from collections.abc import Sequence
from math import dist, pi, tau
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.judging.baseline import Baseline, measure_baseline
from understudy.judging.outcomes import Outcomes
from understudy.model.features import Percept, ReadingKey
from understudy.model.value_kinds import Column
from understudy.runtime.body import Commands
from understudy.sim.forage import ForageSettings, recover_forage_settings
from understudy.sim.scenario.schema import RobotType, Scenario
from understudy.sim.view import WorldView
from understudy.sim.world import World

Point: TypeAlias = tuple[float, float]


class TurnController:
    """A rule that turns to within half a tick's turn of a target, and again only when it is off by `astray` rad.

    `turning` is the speed of turning, rad/s.
    """

    def __init__(self, agents: int, turning: float, tick_s: float, *, astray: float = 0.2) -> None:
        self._facing = 0.55 * turning * tick_s
        self._astray = max(astray, 2.0 * self._facing)
        self._turn = np.zeros(agents)

    def toward(self, off: Column, go: NDArray[np.bool_]) -> Column:
        """Return the direction to turn now [N] for the robots in `go`: 1 left, -1 right, 0 none."""
        off = np.where(go, off, 0.0)
        keep_on = (self._turn != 0.0) & (np.abs(off) > self._facing)
        begin = (self._turn == 0.0) & (np.abs(off) > self._astray)
        self._turn = np.where(begin, np.sign(off), np.where(keep_on, self._turn, 0.0))
        return self._turn


class ExpertForager:
    """A hand-written foraging controller for N robots, used as the baseline.

    Each robot turns until it faces its target to within half a tick's turn, then drives, and turns again only when the
    target is off by more than `astray` (rad), so that it does not alternate between the two. It heads for the station
    when full or when no food is left, and does so until it carries nothing.
    """

    keys: Sequence[ReadingKey] = (
        ("range", "nearest_food"),
        ("bearing", "nearest_food"),
        ("bearing", "station"),
        ("food_here", None),
        ("food_stored", None),
        ("food_left", None),
        ("station_here", None),
    )

    def __init__(self, agents: int, settings: ForageSettings, *, astray: float = 0.2) -> None:
        self._capacity = settings.capacity
        self._homing = np.zeros(agents, np.bool_)
        self._turning = TurnController(agents, settings.turning_speed, settings.tick_s, astray=astray)

    def decide(self, percept: Percept) -> Commands:
        """Return the commands of all robots for this tick."""
        stored, none_left = percept["food_stored", None], percept["food_left", None] == 0.0
        self._homing = (stored > 0) & (self._homing | (stored >= self._capacity) | none_left)
        unload = self._homing & (percept["station_here", None] == 1.0)
        load = ~self._homing & (percept["food_here", None] > 0)
        go = ~(unload | load) & (self._homing | ~none_left)
        bearing = np.where(self._homing, percept["bearing", "station"], percept["bearing", "nearest_food"])
        turn = self._turning.toward((bearing + pi) % tau - pi, go)  # left positive
        drive = go & (turn == 0.0)
        return {
            "drive": drive.astype(np.float64),
            "turn": turn,
            "load": load.astype(np.float64),
            "unload": unload.astype(np.float64),
        }


def lower_bound(world: World) -> Column:
    """Return for each world the least time in s [B] of a robot that visits food sources nearest first.

    A trip goes to the nearest source with food, and on to the next nearest while there is room and food, then to the
    station; "nearest" is measured from the point where a straight path comes within reach. The bound adds the straight
    distances between those places, less the reach at either end, at forward speed, and the loading and unloading of
    each unit. Turning costs nothing and ticks need not be whole, so it is a true bound for that order of visits. A
    robot that chooses another order may need less.
    """
    (robot,) = world.scenario.types.values()
    return np.array([_bound(world.view(row), robot) for row in range(world.worlds)])


def _bound(view: WorldView, robot: RobotType) -> float:
    places = list(zip(view.objects.x.tolist(), view.objects.y.tolist(), strict=True))
    sources = [place for place, food in zip(places, view.objects.food, strict=True) if food]
    (station,) = (place for place, home in zip(places, view.objects.home, strict=True) if home)
    amounts: list[int] = view.objects.amount[view.objects.food].tolist()
    stored = at_first = int(view.robots.stored[0])
    unload = sum(amounts) + stored
    route = _GreedyRoute(robot.reach, (float(view.robots.x[0]), float(view.robots.y[0])))
    while stored or any(amounts):
        while stored < robot.capacity and any(amounts):
            with_food = [k for k, amount in enumerate(amounts) if amount]
            nearest = min(with_food, key=lambda k: dist(route.spot, sources[k]))
            route.go(sources[nearest])
            taken = min(amounts[nearest], robot.capacity - stored)
            amounts[nearest] -= taken
            stored += taken
        route.go(station)
        stored = 0
    work = (unload - at_first) * robot.load_s + unload * robot.unload_s
    return route.meters / robot.speed + work


class _GreedyRoute:
    """A path of straight lines from place to place, each from and to any point within reach of its ends."""

    def __init__(self, reach: float, start: Point) -> None:
        self.reach, self.spot, self.meters = reach, start, 0.0
        self._place, self._slack = start, 0.0

    def go(self, place: Point) -> None:
        """Extend the path to the nearest point from which `place` is within reach, and update `spot` and `meters`."""
        self.meters += max(0.0, dist(self._place, place) - self._slack - self.reach)
        straight = dist(self.spot, place)
        if straight > self.reach:
            left = self.reach / straight
            (x, y), (to_x, to_y) = self.spot, place
            self.spot = (to_x + (x - to_x) * left, to_y + (y - to_y) * left)
        self._place, self._slack = place, self.reach


def find_forage_baseline(scenario: Scenario) -> Baseline | None:
    """Return the baseline of a scenario that differs from the foraging scenario only in numbers, otherwise None."""
    settings = recover_forage_settings(scenario)
    return None if settings is None else make_baseline(settings)


def make_baseline(settings: ForageSettings) -> Baseline:
    """Make the baseline of foraging worlds with these settings."""
    return Baseline(
        settings.scenario(),
        make_controller=lambda world: ExpertForager(world.agents, settings),
        limits_s=lambda world: 10.0 * lower_bound(world) + 60.0,
    )


def evaluate_expert(settings: ForageSettings, seeds: Sequence[int]) -> Outcomes:
    """Measure the hand-written controller on one world per seed."""
    return measure_baseline(make_baseline(settings), seeds)
