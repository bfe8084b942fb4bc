"""The task of reaching a walking target and staying with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import isnan

import numpy as np

from understudy.model.features import Percept, ReadingKey
from understudy.model.learner_options import LearnerOptions
from understudy.model.value_kinds import Column
from understudy.runtime.body import Commands
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.schema import (
    ArenaRegion,
    ObjectClass,
    RandomWalk,
    RobotGroup,
    Scenario,
    TargetSpec,
)
from understudy.sim.world import World
from understudy.training.trainee import SessionView
from understudy_lab.behavior_suite.task import (
    SPEED,
    BehaviorTask,
    TaskResult,
    TaskTrial,
    make_turn_controller,
    rover,
)
from understudy_lab.behavior_suite.tracks import GroundTruth, Table, wrap_signed
from understudy_lab.teachers.person import after, find_bearing
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, PushAway, Situation

ACQUIRED_M, WITH_IT_M = 0.6, 1.5
STAYS_S, LIMIT_S = 30.0, 60.0
HARE_SPEED = 0.25

SCENARIO = Scenario(
    name="chase",
    about="A rover, and a hare at half its speed.",
    size=(10.0, 10.0),
    limit_s=LIMIT_S,
    objects=(ObjectClass(name="hare", walk=RandomWalk(speed=HARE_SPEED, turn_s=4.0), within="field"),),
    regions={"field": ArenaRegion(box=(1.0, 1.0, 9.0, 9.0))},
    types={"rover": rover("forward", "rotate_left", "rotate_right", "wait")},
    robots=(RobotGroup(type="rover", apart=1.5),),
    targets={"hare": TargetSpec(object="hare", doc="What walks.")},
)

NEAR_M, FAR_M = 0.5, 0.75
FACING, ASTRAY = 0.12, 0.5


def show(screen: SessionView) -> str | None:
    """Return the next state, or None: turn to the hare, drive to it, wait beside it, follow when it leaves."""
    return _wanted(screen, astray=ASTRAY, near=NEAR_M, far=FAR_M)


def complain(screen: SessionView) -> str | None:
    """Return the state to correct to, or None: driving or turning past the hare, hitting it, or losing it."""
    return _wanted(screen, astray=1.6 * ASTRAY, near=0.3, far=1.0)


def _wanted(screen: SessionView, *, astray: float, near: float, far: float) -> str | None:
    distance, off = screen.features["distance_to(A)"], find_bearing(screen)
    state, toward = screen.state, "rotate_left" if off > 0 else "rotate_right"
    if isnan(distance) or (state == "wait" and distance < far):
        return None
    if distance < near:
        return "wait"
    if state in ("start", "wait"):
        return toward if abs(off) > ASTRAY else "forward"
    if state == "forward":
        return toward if abs(off) > astray else None
    ahead = off if state == "rotate_left" else -off
    slack = 0.0 if astray == ASTRAY else astray
    return "forward" if -1.5 < ahead < FACING - slack else None


def accept(screen: SessionView, state: str) -> bool:
    """Return whether the robot may go to a state that it asks about: one that a person would not correct there."""
    return complain(replace(screen, state=state)) in (None, state)


TOPIC = LessonPlan(
    "chase",
    LessonDesign(
        parameters=["A"],
        states=["forward", "rotate_left", "rotate_right", "wait"],
        features=["distance_to(A)", "angle_to(A)"],
    ),
    show,
    complain,
    after(25.0),
    cases=(
        Situation("chase", {"A": "hare"}, lambda screen: 0.8 < find_bearing(screen) < 2.6),
        Situation("chase", {"A": "hare"}, lambda screen: -2.6 < find_bearing(screen) < -0.8),
        Situation(
            "chase",
            {"A": "hare"},
            lambda screen: screen.features["distance_to(A)"] > 4.0,
            lambda screen: screen.state == "forward",
            push=PushAway("forward", "rotate_left", 0.8),
        ),
    ),
    tries=6,
    limit_s=60.0,
    accepts=accept,
)


class ExpertChase:
    """A hand-written controller that turns to the hare, drives, and waits beside it."""

    keys: Sequence[ReadingKey] = (("range", "hare"), ("bearing", "hare"))

    def __init__(self, world: World) -> None:
        self._turning = make_turn_controller(world.agents)
        self._resting = np.zeros(world.agents, np.bool_)

    def decide(self, percept: Percept) -> Commands:
        """Return the commands of all robots for this tick."""
        distance = percept["range", "hare"]
        self._resting = distance < np.where(self._resting, FAR_M, NEAR_M)
        turn = self._turning.toward(wrap_signed(percept["bearing", "hare"]), ~self._resting)
        return {"drive": (~self._resting & (turn == 0)).astype(np.float64), "turn": turn}


def judge(tracks: GroundTruth) -> TaskResult:
    """Return when the hare was reached, and the share of the time after that spent with it; success from 95 %."""
    far = distance(tracks)
    seconds = tracks.first(far <= ACQUIRED_M)
    begin = np.nan_to_num(seconds / tracks.tick_s, nan=0.0).round().astype(np.int64)
    ticks = tracks.ticks(STAYS_S)
    with_it = np.array([(far[b : b + ticks, w] <= WITH_IT_M).mean() for w, b in enumerate(begin)])
    done = (seconds <= LIMIT_S) & (with_it >= 0.95)
    return TaskResult(np.where(done, seconds, np.nan), {"share of time with it": with_it})


def bound(tracks: GroundTruth) -> Column:
    """Return the earliest time in s [W] at which a rover that knew the hare's path could reach it without turning."""
    x, y = tracks.objects_x[:, :, 0], tracks.objects_y[:, :, 0]
    far = np.hypot(x - tracks.x[0], y - tracks.y[0]) - ACQUIRED_M
    driven = SPEED * tracks.tick_s * np.arange(len(x))[:, None]
    return np.maximum(tracks.first(far <= driven), tracks.tick_s)


def distance(tracks: GroundTruth) -> Table:
    """Return the distance from the rover to the hare [T+1, W], m."""
    far: Table = np.hypot(tracks.objects_x[:, :, 0] - tracks.x, tracks.objects_y[:, :, 0] - tracks.y)
    return far


FEAT = BehaviorTask(
    name="chase",
    does="tracks and acquires a target that walks at half its speed",
    measured="within 0.6 m of it in 60 s, then within 1.5 m for 95 % of 30 s",
    bounded="a robot that knows where the target will go",
    kit=make_scenario_kit(SCENARIO),
    topics=(TOPIC,),
    options={"chase": LearnerOptions(watched=True, reaction_s=0.2)},
    practice=lambda practice, seed: World(SCENARIO, [seed]),
    trial=lambda seeds: TaskTrial(World(SCENARIO, seeds), LIMIT_S + STAYS_S, judge, bound, ({"A": "hare"},)),
    hand=ExpertChase,
)
