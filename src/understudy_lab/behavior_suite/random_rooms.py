"""Random rooms or obstacles, one per robot, side by side in one large world.

So robots with different walls run in one simulation. A plot is the square of one robot.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, degrees, pi, sqrt, tau

import numpy as np

from understudy.model.value_kinds import Column
from understudy.sim.scenario.schema import Obstacle, RobotGroup, Scenario, Wall
from understudy.sim.world import World
from understudy_lab.behavior_suite.task import SONAR, rover
from understudy_lab.behavior_suite.tracks import Table, distance_to_line, length_of

WIDE_M = 11.0
"""The width of a plot in m, so large that no sensor reaches the next plot."""
BEFORE_M = 4.2
"""The distance in m from the middle of an obstacle at which a robot starts."""


@dataclass(frozen=True)
class RoomLayout:
    """A closed line of corners [P, 2], counter-clockwise around the middle of the plot, m, and the robot's start pose.

    The middle lies in the obstacle, or in the room.
    """

    corners: Table
    x: float
    y: float
    heading: float


def rotate_corners(corners: Table, angle: float) -> Table:
    """Rotate corners [P, 2] around the origin by an angle in rad."""
    cosine, sine = np.cos(angle), np.sin(angle)
    rotated: Table = corners @ np.array([[cosine, sine], [-sine, cosine]])
    return rotated


def is_inside(corners: Table, x: float, y: float) -> bool:
    """Return whether a closed line encloses a point."""
    angles = np.arctan2(corners[:, 1] - y, corners[:, 0] - x)
    steps = (np.roll(angles, -1) - angles + pi) % tau - pi
    return bool(abs(steps.sum()) > pi)


def room(seed: int) -> RoomLayout:
    """Draw a room whose corners may be cut, square or slanted, with the robot anywhere in it."""
    draws = np.random.default_rng([seed, 2])
    wide, high = draws.uniform(4.5, 7.0, 2)
    corners: list[tuple[float, float]] = []
    for k, (x, y) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1))):
        a, b = draws.uniform(0.9, 1.5, 2)
        x0, y0 = x * wide / 2, y * high / 2
        first, last = (x0, y0 - y * b), (x0 - x * a, y0)  # on the vertical, on the horizontal side
        between = (x0 - x * a, y0 - y * b)
        cut = draws.choice(["square", "slanted", "none"], p=[0.45, 0.25, 0.3])
        points = {"square": [first, between, last], "slanted": [first, last], "none": [(x0, y0)]}[cut]
        corners += points if k % 2 == 0 else points[::-1]
    line = rotate_corners(np.array(corners), draws.uniform(0, tau))
    while True:
        x, y = draws.uniform(-5, 5, 2)
        far, _ = distance_to_line(np.array([x]), np.array([y]), line)
        if is_inside(line, x, y) and far[0] > 0.6:
            return RoomLayout(line, float(x), float(y), float(draws.uniform(0, tau)))


def convex(seed: int) -> RoomLayout:
    """Draw a convex obstacle with three to seven corners, with the robot in front of it."""
    draws = np.random.default_rng([seed, 3])
    count = int(draws.integers(3, 8))
    angles = (np.arange(count) + draws.uniform(-0.25, 0.25, count)) * tau / count
    radius = draws.uniform(0.7, 1.4)  # on one circle: always convex
    return _before(radius * np.stack([np.cos(angles), np.sin(angles)], axis=1), draws)


def concave(seed: int) -> RoomLayout:
    """Draw an L- or U-shaped obstacle with room for the robot in it, with the robot in front of it."""
    draws = np.random.default_rng([seed, 4])
    a, b = draws.uniform(2.2, 3.0, 2)
    thick = draws.uniform(0.3, 0.5)
    if draws.random() < 0.5:
        line = [(0, 0), (a, 0), (a, thick), (thick, thick), (thick, b), (0, b)]
        middle = [thick / 2, thick / 2]
    else:
        b = min(b, 2.4)
        line = [
            (0, 0),
            (a, 0),
            (a, b),
            (a - thick, b),
            (a - thick, thick),
            (thick, thick),
            (thick, b),
            (0, b),
        ]
        middle = [a / 2, thick / 2]
    return _before(rotate_corners(np.array(line) - middle, draws.uniform(0, tau)), draws)


def _before(corners: Table, draws: np.random.Generator) -> RoomLayout:
    around, aside = draws.uniform(0, tau), draws.uniform(-0.15, 0.15)
    x, y = BEFORE_M * np.cos(around), BEFORE_M * np.sin(around)
    return RoomLayout(corners, float(x), float(y), float((around + pi + aside) % tau))


def build_world(plots: Sequence[RoomLayout], *, solid: bool) -> World:
    """Make a world with a plot for each robot: rooms with walls, or solid obstacles."""
    return World(make_scenario(plots, solid=solid), [0])


def make_scenario(plots: Sequence[RoomLayout], *, solid: bool) -> Scenario:
    """Return the scenario with a plot for each robot: rooms with walls, or solid obstacles."""
    columns = ceil(sqrt(len(plots)))
    size = (columns * WIDE_M, ceil(len(plots) / columns) * WIDE_M)
    walls, obstacles, starts = [], [], []
    for (x, y), plot in zip(middles(len(plots)).tolist(), plots, strict=True):
        if solid:
            points = tuple((a, b) for a, b in plot.corners.tolist())
            obstacles.append(Obstacle(points=points, at=((x, y),)))
        else:
            line = tuple((a + x, b + y) for a, b in plot.corners.tolist())
            walls.append(Wall(points=line, closed=True))
        starts.append((x + plot.x, y + plot.y, degrees(plot.heading)))
    return Scenario(
        name="obstacles" if solid else "random-rooms",
        size=size,
        walls=tuple(walls),
        obstacles=tuple(obstacles),
        types={"rover": ROVER},
        robots=(RobotGroup(type="rover", at=tuple(starts)),),
    )


ROVER = rover("forward", "rotate_left", "rotate_right", "veer_left", "veer_right", sensor=SONAR)


def middles(count: int) -> Table:
    """Return the middles of the first plots [count, 2], m."""
    columns = ceil(sqrt(count))
    numbers = np.arange(float(count))
    centers: Table = (np.stack([numbers % columns, numbers // columns], axis=1) + 0.5) * WIDE_M
    return centers


def measure_line_distances(x: Table, y: Table, plots: Sequence[RoomLayout]) -> tuple[Table, Table]:
    """Return how far the robots' tracks [T, W] are from the lines of their plots, and where along these, m."""
    distances = [
        distance_to_line(x[:, w] - mx, y[:, w] - my, plot.corners)
        for w, ((mx, my), plot) in enumerate(zip(middles(len(plots)), plots, strict=True))
    ]
    return np.stack([far for far, _ in distances], axis=1), np.stack(
        [along for _, along in distances], axis=1
    )


def lengths(plots: Sequence[RoomLayout]) -> Column:
    """Return the length of each plot's line, m."""
    return np.array([length_of(plot.corners) for plot in plots])
