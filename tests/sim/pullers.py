"""Robots of the boxes world, written by hand: they show that it can be solved with what they sense and raise."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, tau

import numpy as np
from numpy.typing import NDArray

from understudy.model.features import Percept, ReadingKey
from understudy.model.value_kinds import Column
from understudy.runtime.body import Commands
from understudy.sim.world import World

Bools = NDArray[np.bool_]

FACING, ROUGHLY = 0.15, 0.6
"""rad off, up to which they drive straight on, and up to which they drive while they turn."""
PATIENCE, AWAY, DODGE = 300, 100, 30
"""Ticks that they wait for help, leave boxes alone afterwards, and turn and drive away from what they are stuck at."""


class HandPullers:
    """All robots of a world. In this order, each does what it can:

    Holding a box that can move, it pulls it home, and claims it. Holding one that needs more hands, it waits, calls
    for help, and gives up in the end. With a box or crate in reach that nobody claims, it takes hold. One it sees it
    drives to, and claims it where one robot is enough. It goes to who calls. Else it wanders.
    """

    keys: Sequence[ReadingKey] = (
        *((name, of) for of in ("home", "caller", "free_box", "free_crate") for name in ("range", "bearing")),
        *((name, None) for name in ("holding", "enough", "stuck", "chance")),
    )

    def __init__(self, world: World) -> None:
        signals = world.names.signals
        self._claim, self._help = 1.0 + signals.index("claim"), 1.0 + signals.index("help")
        self._reach = world.scenario.types["puller"].reach
        self._waited, self._away, self._dodge = np.zeros((3, world.agents), np.int64)

    def decide(self, percept: Percept) -> Commands:
        """What each robot does now."""
        holding, enough = percept["holding", None] == 1, percept["enough", None] == 1
        pulls, waits = holding & enough, holding & ~enough
        gives_up = self._wait(waits)
        free = ~holding & (self._away == 0)
        sees_box, sees_crate = (free & ~np.isnan(percept["range", of]) for of in ("free_box", "free_crate"))
        near = np.fmin(percept["range", "free_box"], percept["range", "free_crate"]) <= self._reach
        rests = waits | (free & near)
        goals = {
            "home": pulls,
            "free_box": sees_box,
            "free_crate": sees_crate,
            "caller": free & ~np.isnan(percept["range", "caller"]),
        }
        drive, turn = self._towards(percept, goals)
        drive, turn = self._steer_around(percept, drive, turn)
        return {
            "drive": np.where(rests, 0.0, drive),
            "turn": np.where(rests, 0.0, turn),
            "load": np.where(rests & ~gives_up, 1.0, 0.0),
            "unload": np.where(gives_up, 1.0, 0.0),
            "signal": np.where(waits, self._help, np.where(pulls | sees_box, self._claim, 0.0)),
        }

    def _wait(self, waits: Bools) -> Bools:
        """Who has waited too long, and leaves boxes alone for a while."""
        self._waited = np.where(waits, self._waited + 1, 0)
        gives_up: Bools = self._waited > PATIENCE
        self._away = np.where(gives_up, AWAY, np.maximum(self._away - 1, 0))
        return gives_up

    def _towards(self, percept: Percept, goals: dict[str, Bools]) -> tuple[Column, Column]:
        """Drive and turn of each towards the first of its goals; who has none wanders."""
        bearing = np.full(len(self._away), np.nan)
        for of, have in goals.items():
            bearing = np.where(have & np.isnan(bearing), percept["bearing", of], bearing)
        chance, wanders = percept["chance", None], np.isnan(bearing)
        off = np.where(wanders, 0.0, (bearing + pi) % tau - pi)
        turn = np.where(np.abs(off) > FACING, np.sign(off), 0.0)
        turn = np.where(wanders & (chance < 0.3), np.where(chance < 0.15, 1.0, -1.0), turn)
        return np.where(np.abs(off) <= ROUGHLY, 1.0, 0.0), turn

    def _steer_around(self, percept: Percept, drive: Column, turn: Column) -> tuple[Column, Column]:
        """Who is stuck turns this way or that, and drives on for a while."""
        stuck = (percept["stuck", None] == 1) & (self._dodge == 0)
        self._dodge = np.where(stuck, DODGE, np.maximum(self._dodge - 1, 0))
        turns, drives = self._dodge > DODGE / 2, (self._dodge > 0) & (self._dodge <= DODGE / 2)
        side = np.where(percept["chance", None] < 0.5, 1.0, -1.0)
        return (
            np.where(turns, 0.0, np.where(drives, 1.0, drive)),
            np.where(turns, side, np.where(drives, 0.0, turn)),
        )
