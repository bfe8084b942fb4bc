"""Visual servoing from drives with a stick: the driver sees the camera's picture, walks to the ball, and never presses.

The driver turns while the ball is near an edge of the picture, as in the lesson of a stateless policy that turns at
edges, which is taught by presses in comparison.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan

import numpy as np

from understudy.model.features import Percept, ReadingKey
from understudy.model.library import Library
from understudy.runtime.link import link
from understudy_lab.recordings.drive_recording import (
    DrivenLesson,
    DriverStep,
    MeantDrive,
    StickSettings,
    draw_stick_settings,
    learn_from_drive,
    record_drives,
)
from understudy_lab.servoing.trials import search_side
from understudy_lab.tasks.servo_teacher import EDGE_PX, EMERGED_PX, THERE_PX
from understudy_lab.tasks.soccer import MIDDLE_PX, SIZE, Soccer, X, approach_by, kit

MOVES = ("walk_forward", "turn_left", "turn_right")
WALK, LEFT, RIGHT = range(3)
METHOD = "stateless, turns at edges"
DRIVES, DRIVE_S, WORLDS = 24, 40.0, 100
HOLD_S = 0.5
"""The shortest time between two decisions, and the time until a driver believes that the ball is out of sight, s."""
INSIDE_PX = EDGE_PX + EMERGED_PX
"""How far from the edge the ball has to be for a driver to walk on, px."""


def choose_turn(meant: int, x: float, lost: int) -> int:
    """Return what a driver means to do next, from the ball's x (px) and the turn that finds a ball out of sight."""
    if isnan(x):
        return lost
    if not EDGE_PX <= x <= 2 * MIDDLE_PX - EDGE_PX:
        return LEFT if x < MIDDLE_PX else RIGHT
    return WALK if meant == WALK or INSIDE_PX < x < 2 * MIDDLE_PX - INSIDE_PX else meant


class ServoDriver:
    """A driver who walks to the ball, and turns where it is near an edge of the picture or out of sight.

    Drivers keep to a decision for `HOLD_S`, and believe that the ball is out of sight only after as long: it flickers.
    A lost ball is looked for where it was seen last, at first to the side `search`. The recording ends when the ball
    is reached.
    """

    keys: Sequence[ReadingKey] = (X, SIZE)

    def __init__(self, worlds: int, search: str, tick_s: float) -> None:
        self._hold = round(HOLD_S / tick_s)
        self._meant, self._x = np.full(worlds, WALK), np.full(worlds, np.nan)
        self._since, self._unseen = np.full(worlds, self._hold), np.full(worlds, self._hold)
        self._lost = np.full(worlds, LEFT if search == "left" else RIGHT)

    def decide(self, percept: Percept) -> DriverStep:
        """Return what the drivers do in this tick."""
        x, size = (percept[key] for key in self.keys)
        seen = ~np.isnan(x)
        self._unseen = np.where(seen, 0, self._unseen + 1)
        self._x = np.where(seen | (self._unseen >= self._hold), x, self._x)
        self._lost = np.where(seen, np.where(x < MIDDLE_PX, LEFT, RIGHT), self._lost)
        rows = zip(self._meant.tolist(), self._x.tolist(), self._lost.tolist(), strict=True)
        wished = np.array([choose_turn(*row) for row in rows])
        changes = (wished != self._meant) & (self._since >= self._hold)
        self._meant = np.where(changes, wished, self._meant)
        self._since = np.where(changes, 0, self._since + 1)
        return DriverStep(self._meant, self._meant, seen & (size >= THERE_PX))


def drive_to_ball(hand: StickSettings, seeds: Sequence[int], search: str) -> MeantDrive:
    """Drive to the ball from anywhere around it, once for each seed."""
    body = Soccer(seeds)
    return record_drives(
        body,
        ServoDriver(body.agents, search, body.tick_s),
        hand,
        MOVES,
        kit=kit,
        seconds=DRIVE_S,
        seeds=seeds,
        place="field",
    )


def learn_servoing_from_drives(seed: int) -> DrivenLesson:
    """Drive with the hand of a seed, segment the drives, and learn to approach the ball from them."""
    hand = draw_stick_settings(seed)
    drive = drive_to_ball(hand, range(1000 * seed, 1000 * seed + DRIVES), search_side(seed))
    return learn_from_drive(drive, hand, Library(kit), "approach", MOVES)


def measure_servoing_success(library: Library, seed: int) -> float:
    """Return the share of unseen worlds in which the robot comes within 15 cm of the ball in time."""
    body = Soccer(range(WORLDS * seed, WORLDS * (seed + 1)))
    return float((~np.isnan(approach_by(link(library, "approach"), body))).mean())
