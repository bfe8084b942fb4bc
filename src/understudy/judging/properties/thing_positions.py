"""Places of robots and objects in simulated worlds: their distances, and regions of the scenario."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError, UnknownName
from understudy.sim.scenario.schema import MOUSE, ArenaRegion
from understudy.sim.world import World

ROBOT, OBSTACLE = "robot", "obstacle"
"""The names of all robots, and of all round obstacles, in conditions."""

_DISTANCE = re.compile(r"distance\s*\(([^(),]*),([^(),]*)\)")


@dataclass(frozen=True, slots=True)
class Place:
    """The present places of things of one kind: x and y [B, n], m; NaN where there is none."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]


def name_things(world: World) -> list[str]:
    """List the kinds of things that conditions can name: robots, their types, classes of objects, obstacles."""
    classes = [name for name in world.names.classes if name != MOUSE]
    types = [name for name in world.names.types if name not in classes and name != ROBOT]
    return list(dict.fromkeys([ROBOT, *types, *classes, OBSTACLE]))


def find_things(name: str, world: World) -> Callable[[], Place]:
    """Return a function that reads the present places of a kind of things; UnknownName if there is no such kind."""
    if name not in name_things(world):
        where = f"scenario {world.scenario.name!r}"
        raise UnknownName(what="robots or objects", name=name, where=where, known=name_things(world))
    if name in world.names.classes:
        row = world.rules.classes[world.names.classes.index(name)]
        first, end = int(row["first"]), int(row["end"])

        def read_objects() -> Place:
            objects = world.state.objects[:, first:end]
            there = objects["present"] != 0
            return Place(np.where(there, objects["x"], np.nan), np.where(there, objects["y"], np.nan))

        return read_objects
    if name == OBSTACLE:

        def read_obstacles() -> Place:
            discs = world.state.discs
            there = discs["radius"] > 0
            return Place(np.where(there, discs["x"], np.nan), np.where(there, discs["y"], np.nan))

        return read_obstacles
    of_type = world.names.types.index(name) if name != ROBOT else None

    def read_robots() -> Place:
        robots = world.state.robots.reshape(world.worlds, -1)
        x, y = robots["x"].copy(), robots["y"].copy()
        if of_type is not None:
            other = robots["type"] != of_type
            x[other] = y[other] = np.nan
        return Place(x, y)

    return read_robots


def is_distance(subject: str) -> bool:
    """Return whether the subject of a clause is a distance between two kinds of things."""
    return (
        subject == "distance" or _DISTANCE.fullmatch(subject) is not None or subject.startswith("distance(")
    )


def make_distance(subject: str, world: World) -> Callable[[], NDArray[np.float64]]:
    """Make a function that computes the distance of each thing of a kind from the nearest one of another kind.

    Parameters
    ----------
    subject
        "distance(robot, food)". If both kinds are the same, a thing is not compared with itself.
    world
        The worlds.

    Returns
    -------
    function
        Returns the distances [B, n], center to center, m; NaN where there is none. n is the number of things of the
        first kind, or of all robots if it is a type of robots.

    Raises
    ------
    SettingError
        If the subject does not name two kinds.
    UnknownName
        If the scenario does not have them.
    """
    match = _DISTANCE.fullmatch(subject)
    if match is None:
        raise SettingError(
            where="condition",
            setting=repr(subject),
            problem="does not name two kinds of things",
            remedy="write distance(robot, robot) or distance(robot, food)",
        )
    first, second = match[1].strip(), match[2].strip()
    one, other = find_things(first, world), find_things(second, world)
    classes = world.names.classes
    same = first == second or (first not in (*classes, OBSTACLE) and second not in (*classes, OBSTACLE))

    def read() -> NDArray[np.float64]:
        a, b = one(), other()
        if 0 in (a.x.shape[1], b.x.shape[1]):
            return np.full_like(a.x, np.nan)
        apart = np.hypot(a.x[:, :, None] - b.x[:, None, :], a.y[:, :, None] - b.y[:, None, :])
        if same:
            own = np.arange(a.x.shape[1])
            apart[:, own, own] = np.nan
        nearest: NDArray[np.float64] = np.fmin.reduce(apart, axis=2)
        return nearest

    return read


def measure_depth(place: Place, region: ArenaRegion) -> tuple[NDArray[np.float64], float]:
    """Measure how deep inside a region each thing is [B, n], m, negative outside; also return the region's half size.

    The half size is the radius of a circle, or half the shorter side of a box, m.
    """
    if region.box is None:
        (x, y), radius = region.center or (0.0, 0.0), region.radius or 0.0
        return radius - np.hypot(place.x - x, place.y - y), radius or 1.0
    x0, y0, x1, y1 = region.box
    right, up = (
        np.abs(place.x - (x0 + x1) / 2) - (x1 - x0) / 2,
        np.abs(place.y - (y0 + y1) / 2) - (y1 - y0) / 2,
    )
    outside = np.hypot(np.maximum(right, 0.0), np.maximum(up, 0.0))
    inside = np.minimum(np.maximum(right, up), 0.0)
    return -(outside + inside), min(x1 - x0, y1 - y0) / 2 or 1.0
