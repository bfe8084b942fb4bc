"""The driver of foraging: drives to food and loads it, drives to the station and unloads it, and never presses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi, tau
from types import MappingProxyType

import numpy as np

from understudy.model.features import Percept, ReadingKey
from understudy.model.kinds import NO, YES
from understudy_lab.recordings.drive_recording import DriverStep
from understudy_lab.tasks.forage_teacher import CAPACITY

MOVES = ("forward", "rotate_left", "rotate_right", "load_food", "unload_food")
FORWARD, LEFT, RIGHT, LOAD, UNLOAD = range(5)
ASTRAY, FACING = 0.5, 0.12
"""The angles (rad) beyond which a driver turns to a target again, and within which the driver drives on."""

FOOD, STATION = "nearest_food", "station"
GOTO, HARVEST, DEPOSIT, FORAGE = "goto", "harvest", "deposit", "forage"
STATES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        GOTO: ("forward", "rotate_left", "rotate_right"),
        HARVEST: (f"goto({FOOD})", "load_food"),
        DEPOSIT: (f"goto({STATION})", "unload_food"),
        FORAGE: (HARVEST, DEPOSIT),
    }
)
"""The behaviors that drivers mean by level, which explain the drives of this level."""

_FOOD_KEYS: Sequence[ReadingKey] = (("range", FOOD), ("bearing", FOOD), ("food_here", None))
_STATION_KEYS: Sequence[ReadingKey] = (("range", STATION), ("bearing", STATION), ("station_here", None))
_CARGO: Sequence[ReadingKey] = (("food_stored", None), ("food_left", None))
KEYS: Mapping[str, Sequence[ReadingKey]] = MappingProxyType(
    {
        GOTO: (("range", STATION), ("bearing", STATION), ("station_here", None)),
        HARVEST: (*_FOOD_KEYS, *_CARGO),
        DEPOSIT: (*_STATION_KEYS, _CARGO[0]),
        FORAGE: (*_FOOD_KEYS, *_STATION_KEYS, *_CARGO),
    }
)
"""The readings that drivers see by level."""


def choose_move(move: int, bearing: float) -> int:
    """Return what the hand aims at next on the way to a target: turn to it, drive, turn again where it lies aside."""
    off = (bearing + pi) % tau - pi
    if move in (LEFT, RIGHT):
        ahead = off if move == LEFT else -off
        return FORWARD if ahead < FACING else move
    if abs(off) > ASTRAY:
        return LEFT if off > 0 else RIGHT
    return FORWARD


def is_homing(level: str, homing: bool, stored: float, left: float) -> bool:
    """Return whether a driver deposits: on a forage, once full or without any food left, until nothing is stored."""
    if level in (GOTO, DEPOSIT):
        return True
    full = stored >= CAPACITY or left == NO
    return stored > 0 and (homing or full) if level == FORAGE else False


class ForagingDriver:
    """A driver of one level of foraging, such as `HARVEST`, in N worlds; the recording ends when it is done."""

    def __init__(self, worlds: int, level: str) -> None:
        self.keys = KEYS[level]
        self._level = level
        self._homing, self._move = np.zeros(worlds, np.bool_), np.full(worlds, FORWARD)
        self._meant = np.zeros(worlds, np.int64)

    def decide(self, percept: Percept) -> DriverStep:
        """Return what the drivers do in this tick; in the last one, what they did before."""
        absent = np.full(len(self._move), np.nan)
        seen = [
            percept.get(key, absent).tolist()
            for key in (("food_here", None), ("station_here", None), *_CARGO, ("bearing", FOOD), ("bearing", STATION))
        ]  # fmt: skip
        over = np.zeros(len(self._move), np.bool_)
        for world, (food, station, stored, left, to_food, to_station) in enumerate(zip(*seen, strict=True)):
            homing = is_homing(self._level, bool(self._homing[world]), stored, left)
            there = station == YES if homing else food > 0
            over[world] = is_over(self._level, stored, left, there=there)
            if over[world]:
                continue
            if there:
                move = UNLOAD if homing else LOAD
            else:
                move = choose_move(int(self._move[world]), to_station if homing else to_food)
            state = {GOTO: move, FORAGE: int(homing)}.get(self._level, int(there))
            self._homing[world], self._move[world], self._meant[world] = homing, move, state
        return DriverStep(self._meant, self._move, over)


def is_over(level: str, stored: float, left: float, *, there: bool) -> bool:
    """Return whether a driver has reached the aim of a level, where the recording ends."""
    if level == GOTO:
        return there
    if level == HARVEST:
        return stored >= CAPACITY or left == NO
    return stored == 0 and (level == DEPOSIT or left == NO)
