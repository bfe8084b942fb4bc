"""A foraging world as plain data, for drawing and for looking at."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from understudy.worlds.rules import Names
from understudy.worlds.view import DiscsView, ObjectsView, RobotsView, WorldView


class SourceView(NamedTuple):
    """One source of food, for drawing."""

    x: float
    y: float
    amount: int
    at_first: int


class ForageView(NamedTuple):
    """One world as plain data, for drawing."""

    width: float
    height: float
    reach: float
    radius: float
    time_s: float
    x: float
    y: float
    heading: float
    stored: int
    capacity: int
    delivered: int
    station: tuple[float, float]
    sources: tuple[SourceView, ...]


NAMES = Names(classes=("food", "station"), types=("forager",), colors=(), teams=("forager",))
_NONE = np.full(1, -1)
_ZERO = np.zeros(1, np.int64)
_NO_DISCS = DiscsView(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0, np.int64))
_NO_LINES = np.zeros((0, 4))
_SOURCE_M, _STATION_M = 0.1, 0.24


def from_forage(view: ForageView) -> WorldView:
    """The same world as any world's view."""
    x, y, amount, at_first = zip(*view.sources, strict=True) if view.sources else ((), (), (), ())
    food = np.arange(len(x) + 1) < len(x)
    solid = np.zeros(len(food), np.bool_)
    robots = RobotsView(
        x=np.array([view.x]),
        y=np.array([view.y]),
        heading=np.array([view.heading]),
        radius=np.array([view.radius]),
        reach=np.array([view.reach]),
        color=_NONE,
        team=_ZERO,
        type=_ZERO,
        stored=np.array([view.stored]),
        capacity=np.array([view.capacity]),
        delivered=np.array([view.delivered]),
        frozen=_ZERO != 0,
    )
    objects = ObjectsView(
        slot=np.arange(len(food)),
        kind=np.where(food, 0, 1),
        x=np.array([*x, view.station[0]]),
        y=np.array([*y, view.station[1]]),
        radius=np.where(food, _SOURCE_M, _STATION_M),
        color=np.full(len(food), -1),
        amount=np.array([*amount, 0], np.int64),
        at_first=np.array([*at_first, 0], np.int64),
        food=food,
        home=~food,
        solid=solid,
        pushable=solid,
    )
    return WorldView(
        view.width, view.height, view.time_s, robots, objects, _NO_DISCS, _NO_LINES, _NO_LINES, NAMES
    )


def place_of(view: ForageView, target: str) -> tuple[float, float] | None:
    """Where a target is now; None where there is none."""
    if target == "station":
        return view.station
    food = [source for source in view.sources if source.amount]
    if target != "nearest_food" or not food:
        return None
    nearest = min(food, key=lambda source: (source.x - view.x) ** 2 + (source.y - view.y) ** 2)
    return nearest.x, nearest.y
