"""Where things are at first in each foraging world, laid out at random by its seed."""

from __future__ import annotations

from math import tau
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.model.kinds import Column
from understudy.worlds.draws import Seeds, uniform, whole
from understudy.worlds.forage_settings import BESIDE, ForageSettings, wrong

ATTEMPTS = 1000
STATION, ROBOT, COUNT, SOURCE = 0, 1, 2, 10  # items of a world; sources count up from SOURCE
X, Y, ANGLE, AMOUNT = 0, 1, 2, 3  # streams
Point: TypeAlias = tuple[Column, Column]


def lay_out(seeds: Seeds, settings: ForageSettings) -> dict[str, NDArray[Any]]:
    """The state at first: station and robot [N], sources [N, K]; a world with fewer than K has empty ones."""
    worlds, most = len(seeds), settings.sources[1]
    placed: list[Point] = [_free(seeds, STATION, [], settings)]
    count = whole(seeds, *settings.sources, item=COUNT, tick=0, stream=AMOUNT)
    amount = np.zeros((worlds, most), np.int64)
    for k in range(most):
        item = SOURCE + k
        if k == 0 and settings.food_beside_station:
            placed.append(_beside(seeds, placed[0], settings))
        else:
            placed.append(_free(seeds, item, placed, settings))
        drawn = whole(seeds, *settings.amounts, item=item, tick=0, stream=AMOUNT)
        amount[:, k] = np.where(k < count, drawn, 0)
    robot = placed[0] if settings.starts_at_station else _free(seeds, ROBOT, placed, settings)
    sources = placed[1:]
    return {
        "x": robot[0].copy(),
        "y": robot[1].copy(),
        "heading": uniform(seeds, item=ROBOT, tick=0, stream=ANGLE) * tau,
        "station_x": placed[0][0],
        "station_y": placed[0][1],
        "source_x": np.stack([x for x, _ in sources], axis=1) if most else np.zeros((worlds, 0)),
        "source_y": np.stack([y for _, y in sources], axis=1) if most else np.zeros((worlds, 0)),
        "amount": amount,
    }


def _free(seeds: Seeds, item: int, placed: list[Point], settings: ForageSettings) -> Point:
    """A place [N] off the walls and apart from what is placed; SettingError where no room is found."""
    x, y = np.zeros(len(seeds)), np.zeros(len(seeds))
    left = np.arange(len(seeds))
    for attempt in range(ATTEMPTS):
        margin = settings.margin
        draws = [uniform(seeds[left], item=item, tick=attempt, stream=stream) for stream in (X, Y)]
        at_x = margin + draws[0] * (settings.width - 2 * margin)
        at_y = margin + draws[1] * (settings.height - 2 * margin)
        clear = np.ones(len(left), np.bool_)
        for other_x, other_y in placed:
            dx, dy = at_x - other_x[left], at_y - other_y[left]
            clear &= dx * dx + dy * dy >= settings.apart**2
        x[left], y[left] = at_x, at_y
        left = left[~clear]
        if not len(left):
            return x, y
    room = f"{settings.width} x {settings.height} m"
    raise wrong("sources", f"do not fit into {room}", "give a larger width and height, or fewer sources")


def _beside(seeds: Seeds, station: Point, settings: ForageSettings) -> Point:
    """A place [N] so near the station that both are within reach in between, on the side of the center."""
    center_x, center_y = settings.width / 2, settings.height / 2
    spread = (uniform(seeds, item=SOURCE, tick=0, stream=ANGLE) - 0.5) * (tau / 8)
    angle = np.arctan2(center_y - station[1], center_x - station[0]) + spread
    distance = BESIDE * settings.reach
    return station[0] + distance * np.cos(angle), station[1] + distance * np.sin(angle)
