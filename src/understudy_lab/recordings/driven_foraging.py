"""Foraging from drives with a stick, level by level: GoTo, then Harvest and Deposit by GoTo, then Forage by these."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import add

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.recorded_drive import join_drives
from understudy.model.library import Library
from understudy.sim.forage import FORAGE_KIT, Forage, make_practice_worlds
from understudy_lab.forage.teach import judge, teach
from understudy_lab.recordings.drive_recording import MeantDrive, record_drives
from understudy_lab.recordings.driven_lesson import DrivenLesson, learn_from_drive
from understudy_lab.recordings.foraging_driver import (
    DEPOSIT,
    FORAGE,
    GOTO,
    HARVEST,
    MOVES,
    STATES,
    STATION,
    ForagingDriver,
)
from understudy_lab.recordings.stick_driver import StickSettings, draw_stick_settings

LEVELS = (GOTO, HARVEST, DEPOSIT, FORAGE)
FEATURES = {
    GOTO: (f"distance_to({STATION})", f"angle_to({STATION})"),
    HARVEST: ("food_left", "food_stored", "food_below_me"),
    DEPOSIT: ("food_stored", "at_station"),
    FORAGE: ("food_stored", "food_left"),
}
"""What decisions depend on, by level: as in the lesson by presses, without flags."""
PRACTICE = {
    GOTO: (("an arena", 32),),
    HARVEST: (("little food in many places", 8), ("the last food", 8)),
    DEPOSIT: (("some food to deposit", 8), ("one unit to deposit", 8)),
    FORAGE: (("food for two ways", 8),),
}
"""The practice worlds of each level, and the number of drives in each."""
DRIVE_S = 300.0
PUSH_S, PUSHES_S = 0.8, 6.0
"""How long a push turns the robot, and the mean time between two pushes in the drives of GoTo, s."""


def draw_pushes(
    random: np.random.Generator, ticks: int, worlds: int, tick_s: float, channels: Sequence[str]
) -> NDArray[np.float64]:
    """Draw the pushes [ticks, N, C] that turn robots aside while they are driven."""
    pushes = np.zeros((ticks, worlds, len(channels)))
    long, turn = round(PUSH_S / tick_s), channels.index("turn")
    for tick, world in zip(*np.nonzero(random.random((ticks, worlds)) < tick_s / PUSHES_S), strict=True):
        pushes[tick : tick + long, world, turn] = random.choice((-1.0, 1.0))
    return pushes


def drive_level(level: str, hand: StickSettings, seed: int) -> MeantDrive:
    """Drive one level of foraging in its practice worlds."""
    drives, first = [], 1000 * seed
    for name, count in PRACTICE[level]:
        seeds = range(first, first + count)
        body = Forage(seeds, make_practice_worlds()[name])
        channels = [each.name for each in body.channels]
        pushes = None
        if level == GOTO:
            random = np.random.default_rng([seed, 18])
            pushes = draw_pushes(random, round(DRIVE_S / body.tick_s), body.agents, body.tick_s, channels)
        driver = ForagingDriver(body.agents, level)
        drives.append(
            record_drives(
                body, driver, hand, MOVES, kit=FORAGE_KIT, seconds=DRIVE_S, seeds=seeds, place=name,
                buttons=("load", "unload"), pushes=pushes,
            )
        )  # fmt: skip
        first += count
    return MeantDrive(
        join_drives([each.recording for each in drives]), np.concatenate([each.meant for each in drives])
    )


def learn_foraging_from_drives(seed: int) -> DrivenLesson:
    """Drive with the hand of a seed, and learn each level with what the levels below learned as candidates."""
    hand, library, hits = draw_stick_settings(seed), Library(FORAGE_KIT), []
    for level in LEVELS:
        drive = drive_level(level, hand, seed)
        learned = learn_from_drive(
            drive,
            hand,
            library,
            level,
            STATES[level],
            features=FEATURES[level],
            targets={"A": STATION} if level == GOTO else {},
        )
        library = learned.library
        hits.append(learned.hits)
    return DrivenLesson(reduce(add, hits), library)


def teach_foraging_by_presses(seed: int) -> Library:
    """Teach the same levels by presses, as in the other experiments."""
    return teach(seed).library


def measure_foraging_success(library: Library, seed: int) -> float:
    """Return the share of unseen worlds in which all food is brought home in time."""
    return judge(library, seed).success
