"""GoTo from drives with a stick: the driver turns to a post, drives to it and lets the stick go, and never presses."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, tau

import numpy as np
from msgspec import structs
from numpy.typing import NDArray

from understudy.model.features import Percept, ReadingKey
from understudy.model.library import Kit, Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.sim.kit import make_scenario_kit
from understudy.sim.world import World
from understudy_lab.behavior_suite.task import rover
from understudy_lab.behavior_suite.waypoints import GOTO
from understudy_lab.behavior_suite.waypoints import SCENARIO as POSTS
from understudy_lab.recordings.drive_recording import (
    DrivenLesson,
    DriverStep,
    MeantDrive,
    StickSettings,
    draw_stick_settings,
    learn_from_drive,
    record_drives,
)
from understudy_lab.tasks.forage_teacher import WATCHED
from understudy_lab.teachers.teacher import ScriptedTeacher

POST = "post_1"
MOVES = ("wait", "forward", "rotate_left", "rotate_right")
WAIT, FORWARD, LEFT, RIGHT = range(4)
SCENARIO = structs.replace(POSTS, name="posts", types={"rover": rover(*MOVES)})
KIT: Kit = make_scenario_kit(SCENARIO)
DRIVES, DRIVE_S, LIMIT_S = 24, 30.0, 60.0
REST_S = 2.0
THERE_M, ASTRAY, FACING, REACHED_M = 0.4, 0.5, 0.12, 0.5
WORLDS = 100


def intend(intent: NDArray[np.int64], distance: NDArray[np.float64], off: NDArray[np.float64]) -> None:
    """Change what drivers mean to do, in place, from distance and bearing (rad, positive to the left) of the post."""
    for world, (far, angle) in enumerate(zip(distance.tolist(), off.tolist(), strict=True)):
        if far < THERE_M:
            intent[world] = WAIT
        elif intent[world] in (WAIT, FORWARD) and abs(angle) > ASTRAY:
            intent[world] = LEFT if angle > 0 else RIGHT
        elif intent[world] != FORWARD:
            ahead = {LEFT: angle, RIGHT: -angle}.get(int(intent[world]), 0.0)
            intent[world] = FORWARD if ahead < FACING else intent[world]


class GoToDriver:
    """A driver who turns to a target, drives to it, lets the stick go, and rests until the recording ends."""

    def __init__(self, worlds: int, target: str, tick_s: float) -> None:
        self.keys: Sequence[ReadingKey] = (("range", target), ("bearing", target))
        self._intent, self._rested = np.full(worlds, WAIT), np.zeros(worlds)
        self._tick_s = tick_s

    def decide(self, percept: Percept) -> DriverStep:
        """Return what the drivers do in this tick."""
        distance, bearing = (percept[key] for key in self.keys)
        intend(self._intent, distance, (bearing + pi) % tau - pi)
        self._rested = np.where(self._intent == WAIT, self._rested + self._tick_s, 0.0)
        return DriverStep(self._intent, self._intent, self._rested > REST_S)


def drive(hand: StickSettings, seeds: Sequence[int]) -> MeantDrive:
    """Drive to the post in each world."""
    world = World(SCENARIO, seeds)
    driver = GoToDriver(world.agents, POST, world.tick_s)
    return record_drives(world, driver, hand, MOVES, kit=KIT, seconds=DRIVE_S, seeds=seeds, place="world")


def learn_from_drives(seed: int) -> DrivenLesson:
    """Drive with the hand of a seed, segment the drives, and learn GoTo from them."""
    hand = draw_stick_settings(seed)
    return learn_from_drive(
        drive(hand, range(1000 * seed, 1000 * seed + DRIVES)), hand, Library(KIT), "goto", MOVES
    )


def teach_by_presses(seed: int) -> Library:
    """Teach GoTo(A) by presses, as in the other experiments."""
    teacher = ScriptedTeacher(
        Library(KIT), lambda practice, world: World(SCENARIO, [world]), seed, options=WATCHED
    )
    return teacher.teach(GOTO).library


def measure_success(library: Library, seed: int) -> float:
    """Return the share of unseen worlds in which the robot stands within 0.5 m of the post in the end."""
    world = World(SCENARIO, range(WORLDS * seed, WORLDS * (seed + 1)))
    binding = dict.fromkeys(library.automaton("goto").parameters, POST)  # GoTo(A) was taught by presses
    engine = Engine.from_program(world, link(library, "goto", binding))
    for _ in range(round(LIMIT_S / world.tick_s)):
        engine.tick()
    before = world.sense([("range", POST), ("bearing", POST)])
    for _ in range(round(REST_S / world.tick_s)):
        engine.tick()
    after = world.sense([("range", POST), ("bearing", POST)])
    still = np.abs(after["range", POST] - before["range", POST]) < 0.05
    return float((still & (after["range", POST] <= REACHED_M)).mean())
