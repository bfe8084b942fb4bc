"""Derive how the content of a world looks in every kind of picture: shapes, sizes, colors and labels."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.sim.scenario.schema import MOUSE
from understudy.sim.view import RunFrame, WorldView
from understudy.viz.palette import FOOD, HOME, INK, SOLID, THING, choose_drawing_color

Points: TypeAlias = NDArray[np.float64]
Grid: TypeAlias = NDArray[np.int64]

FEW = 8
"""The largest number of robots that pictures distinguish one by one; more are drawn as a crowd."""
MOST_LABELS = 8
MOVED = 0.05
ROOMY = 64
"""The largest number of objects whose marks are enlarged fully; with more, marks are enlarged less."""


@dataclass(frozen=True, slots=True)
class ObjectMark:
    """An object as it is drawn: `size` is half its extent (m), `full` the filled share of its size."""

    slot: int
    name: str
    x: float
    y: float
    size: float
    square: bool
    color: str
    full: float
    rimmed: bool
    """Whether it is drawn with a rim, because it is solid or a box to pull."""
    units: int | None
    """The food left in a source; None for other objects."""
    label: str
    """The text beside it; empty if its class is in the legend instead."""
    served: bool
    """Whether robots load or unload here, within their reach."""


def measure_mark_unit(view: WorldView) -> float:
    """Return the unit (m) of marks without a size of their own: 1 m in an arena of 12 m."""
    return max(view.width, view.height) / 12.0


def list_object_marks(view: WorldView) -> list[ObjectMark]:
    """Return the marks of a world's objects, in order of their slots."""
    objects = view.objects
    kinds = objects.kind.tolist()
    one = measure_mark_unit(view) * min(1.0, (ROOMY / max(1, len(kinds))) ** 0.5)
    count = Counter(kinds)
    labeled = int((objects.at_first[objects.food] > 0).sum()) <= MOST_LABELS
    marks = []
    for at, kind in enumerate(kinds):
        name = view.names.classes[kind].replace("_", " ")
        food, home = bool(objects.food[at]), bool(objects.home[at])
        size, full, units, label = max(float(objects.radius[at]), 0.08 * one), 1.0, None, name
        if food:
            amount, at_first = int(objects.amount[at]), int(objects.at_first[at])
            if not at_first:
                continue
            size, full, units = min(0.1 * at_first**0.5, 0.6) * one, (amount / at_first) ** 0.5, amount
            part = 0 < amount < at_first
            label = (
                "" if not labeled else f"{amount} of {at_first} units left" if part else f"{at_first} units"
            )
        elif home:
            size = max(size, 0.24 * one)
        if not food and count[kind] > (MOST_LABELS if home else 1):
            label = ""
        color = view.color(int(objects.color[at]))
        plain = FOOD if food else HOME if home else INK if name == MOUSE else THING
        marks.append(
            ObjectMark(
                slot=int(objects.slot[at]),
                name=name,
                x=float(objects.x[at]),
                y=float(objects.y[at]),
                size=size,
                square=home or bool(objects.pull[at]),
                color=plain if color is None else choose_drawing_color(color),
                full=full,
                rimmed=bool(objects.solid[at] or objects.pull[at]),
                units=units,
                label=label,
                served=(food or home) and bool(view.robots.capacity.any()),
            )
        )
    return marks


def find_removed_objects(
    first: Sequence[ObjectMark], last: Sequence[ObjectMark], view: WorldView
) -> list[ObjectMark]:
    """Return the objects of `first` that are missing, or at another place, in `last`."""
    now = {thing.slot: thing for thing in last}
    far = MOVED * measure_mark_unit(view)

    def stayed(thing: ObjectMark) -> bool:
        other = now.get(thing.slot)
        return other is not None and abs(other.x - thing.x) + abs(other.y - thing.y) <= far

    return [thing for thing in first if not stayed(thing)]


def choose_obstacle_colors(view: WorldView) -> list[str]:
    """Return a color for each round obstacle."""
    names = (view.color(index) for index in view.discs.color.tolist())
    return [SOLID if name is None else choose_drawing_color(name) for name in names]


def measure_loading_reach(view: WorldView) -> float | None:
    """Return the distance (m) within which robots load and unload; None if no robot carries food."""
    carriers = view.robots.reach[view.robots.capacity > 0]
    return float(carriers.max()) if len(carriers) else None


def choose_robot_colors(view: WorldView) -> list[str | None]:
    """Return the drawing color of each robot from the scenario; None for robots without a color."""
    painted = {index: choose_drawing_color(name) for index, name in enumerate(view.names.colors)}
    return [painted.get(index) for index in view.robots.color.tolist()]


def format_thousands(number: int) -> str:
    """Format a number with spaces between thousands: 10 000."""
    return f"{number:,}".replace(",", " ")


def count_food_units(view: WorldView) -> int:
    """Return the units of food in a world: in sources, carried by robots and delivered."""
    robots = view.robots
    return int(robots.delivered.sum() + robots.stored.sum() + view.objects.amount[view.objects.food].sum())


def describe_delivered(view: WorldView) -> list[str]:
    """Describe in words the delivered food (if robots can carry any) and the delivered boxes (if there are any)."""
    words = []
    if view.robots.capacity.any() and count_food_units(view):
        words.append(f"{int(view.robots.delivered.sum())} of {count_food_units(view)} units home")
    if view.gathered or view.objects.pull.any():
        words.append(f"{view.gathered} {'box' if view.gathered == 1 else 'boxes'} home")
    return words


def collect_robot_places(frames: Sequence[RunFrame]) -> tuple[Points, Points]:
    """Return the places [F, N, 2] (m) and headings [F, N] (rad) of the robots in all frames."""
    robots = [frame.view.robots for frame in frames]
    at = np.stack([np.stack([each.x, each.y], axis=1) for each in robots])
    return at, np.stack([each.heading for each in robots])


def index_activities(frames: Sequence[RunFrame], names: Iterable[str]) -> Grid:
    """Return what each robot was doing in each frame [F, N], as indices into `names`."""
    index = {name: at for at, name in enumerate(names)}
    return np.array([[index[name] for name in frame.doing] for frame in frames])
