"""Wall following from drives with a stick: the driver keeps a hand on the wall of a random room, and never presses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from understudy.model.features import Percept, ReadingKey
from understudy.model.learner_options import TreeOptions
from understudy.model.library import Library
from understudy_lab.behavior_suite.random_rooms import build_world, room
from understudy_lab.behavior_suite.task import (
    BehaviorTask,
    make_taught_controller,
    share_done,
    worlds_of,
)
from understudy_lab.behavior_suite.wall_following import (
    AHEAD,
    BLOCKED_M,
    CLEAR_M,
    LEFT,
    OTHER,
    RIGHT,
    WALL_TASKS,
    WELL_M,
    WIDE_M,
)
from understudy_lab.recordings.drive_recording import (
    DrivenLesson,
    DriverStep,
    MeantDrive,
    StickSettings,
    draw_stick_settings,
    learn_from_drive,
    record_drives,
)

FORWARD, AWAY, NEARER = range(3)
BESIDE_M = 0.8
"""How near a wall has to be for a driver to see that it is beside the robot, m."""
DRIVES, DRIVE_S = 12, 40.0
LEARNER = TreeOptions(pruning=6.0)


def list_moves(side: str) -> tuple[str, str, str]:
    """Return the basic behaviors of following a wall on a side: go on, turn away from it, veer to it."""
    return "forward", f"rotate_{OTHER[side]}", f"veer_{side}"


def choose_move(meant: int, ahead: float, beside: float) -> int:
    """Return what a driver means to do next: turn at a wall ahead until it is clear, veer to a wall that recedes."""
    if meant == AWAY:
        return FORWARD if ahead > CLEAR_M else AWAY
    if ahead < BLOCKED_M:
        return AWAY
    if meant == NEARER:
        return FORWARD if beside < WELL_M else NEARER
    return NEARER if WIDE_M < beside < BESIDE_M else FORWARD


class WallDriver:
    """A driver who goes straight on to a wall, and then along it on one side."""

    def __init__(self, worlds: int, side: str) -> None:
        self.keys: Sequence[ReadingKey] = ((AHEAD, None), (f"sonar_{side}", None))
        self._meant = np.full(worlds, FORWARD)

    def decide(self, percept: Percept) -> DriverStep:
        """Return what the drivers do in this tick."""
        rows = zip(self._meant.tolist(), *(percept[key].tolist() for key in self.keys), strict=True)
        self._meant = np.array([choose_move(*row) for row in rows])
        return DriverStep(self._meant, self._meant, np.zeros(len(self._meant), np.bool_))


def choose_side(seed: int) -> str:
    """Return the side on which a driver has the wall; it alternates with the seed."""
    return (LEFT, RIGHT)[seed % 2]


def find_wall_task(seed: int) -> BehaviorTask:
    """Return the task of following a wall on the side of a driver."""
    return WALL_TASKS[seed % 2]


def drive_along_walls(hand: StickSettings, seeds: Sequence[int], side: str) -> MeantDrive:
    """Drive along the walls of a room for each seed."""
    world = build_world([room(seed) for seed in seeds], solid=False)
    return record_drives(
        world,
        WallDriver(world.agents, side),
        hand,
        list_moves(side),
        kit=world.kit,
        seconds=DRIVE_S,
        seeds=seeds,
        place="room",
    )


def learn_walls_from_drives(seed: int) -> DrivenLesson:
    """Drive with the hand of a seed, segment the drives, and learn to follow walls from them."""
    hand, side = draw_stick_settings(seed), choose_side(seed)
    drive = drive_along_walls(hand, range(1000 * seed, 1000 * seed + DRIVES), side)
    task = find_wall_task(seed)
    moves = list_moves(side)
    return learn_from_drive(drive, hand, Library(task.kit), task.behavior, moves, learner=LEARNER)


def measure_wall_success(library: Library, seed: int) -> float:
    """Return the share of unseen rooms in which the loop along the wall is closed in time."""
    task = find_wall_task(seed)
    trial = task.trial(worlds_of(seed))
    return share_done(trial.judge(make_taught_controller(trial, library, task.behavior)))
