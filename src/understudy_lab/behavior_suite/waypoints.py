"""The task of patrolling waypoints: go to each in turn, using the done flag, round after round."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from understudy.model.features import Percept, ReadingKey
from understudy.model.learner_options import LearnerOptions
from understudy.model.value_kinds import YES, Column
from understudy.runtime.body import Commands
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.schema import ObjectClass, RobotGroup, Scenario, TargetSpec
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
from understudy_lab.behavior_suite.tracks import GroundTruth, Table, count_reached_in_turn, wrap_signed
from understudy_lab.tasks import forage_teacher
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, Situation

POSTS, LAPS = 4, 2
THERE_M, LIMIT_S = 0.5, 180.0
NAMES = tuple(f"post_{k + 1}" for k in range(POSTS))

SCENARIO = Scenario(
    name="waypoints",
    about="A rover, and four posts to patrol in turn.",
    size=(10.0, 10.0),
    limit_s=LIMIT_S,
    objects=(ObjectClass(name="post", count=POSTS, apart=1.0),),
    types={"rover": rover("forward", "rotate_left", "rotate_right")},
    robots=(RobotGroup(type="rover", apart=1.0),),
    targets={name: TargetSpec(object="post", index=k, doc="A post.") for k, name in enumerate(NAMES)},
)


GOTO = replace(
    forage_teacher.GOTO,
    cases=forage_teacher.RULE.list_cases(("posts", "posts"), NAMES, (1.0, 2.5), (3.0, 6.0)),
)
"""The plan of GoTo as for foraging, with posts as targets."""

ROUNDS = [f"goto({name})" for name in NAMES]
STATES = [f"to_{name}" for name in NAMES]


def show(screen: SessionView) -> str | None:
    """Return the next state, or None: go to the next post when GoTo is done."""
    if screen.state == "start":
        return STATES[0]
    if screen.features["done"] != YES:
        return None
    return STATES[(STATES.index(screen.state) + 1) % POSTS]


def _rounds_shown(screen: SessionView) -> bool:
    return screen.time_s > 30.0 and screen.state == STATES[1]


PATROL = LessonPlan(
    "patrol",
    LessonDesign(
        states=[f"{state}={call}" for state, call in zip(STATES, ROUNDS, strict=True)], features=["done"]
    ),
    show,
    show,
    _rounds_shown,
    cases=(Situation("posts"),),
    tries=2,
    limit_s=150.0,
)


class ExpertWaypoints:
    """A hand-written controller that turns to the present post, drives there, and goes on to the next."""

    keys: Sequence[ReadingKey] = tuple((reading, name) for reading in ("range", "bearing") for name in NAMES)

    def __init__(self, world: World) -> None:
        self._turning = make_turn_controller(world.agents)
        self._next = np.zeros(world.agents, np.int64)

    def decide(self, percept: Percept) -> Commands:
        """Return the commands of all robots for this tick."""
        rows = np.arange(len(self._next))
        distances = np.stack([percept["range", name] for name in NAMES])
        self._next = (self._next + (distances[self._next, rows] < THERE_M - 0.05)) % POSTS
        off = wrap_signed(np.stack([percept["bearing", name] for name in NAMES])[self._next, rows])
        turn = self._turning.toward(off, np.ones(len(rows), np.bool_))
        return {"drive": (turn == 0).astype(np.float64), "turn": turn}


def judge(tracks: GroundTruth) -> TaskResult:
    """Return when two laps were complete, and how many laps there were; each post counts in turn within 0.5 m."""
    x, y = tracks.objects_x[:, :, :POSTS], tracks.objects_y[:, :, :POSTS]
    reached = np.hypot(x - tracks.x[:, :, None], y - tracks.y[:, :, None]) <= THERE_M
    count = count_reached_in_turn(reached)
    return TaskResult(tracks.first(count >= LAPS * POSTS), {"laps": count[-1] / POSTS})


def bound(tracks: GroundTruth) -> Column:
    """Return the time in s [W] of the straight lines from post to post, less 0.5 m at either end, at full speed."""
    posts: Table = np.stack([tracks.objects_x[0, :, :POSTS], tracks.objects_y[0, :, :POSTS]])
    begin = np.stack([tracks.x[0], tracks.y[0]])
    first = np.maximum(0.0, np.hypot(*(posts[:, :, 0] - begin)) - THERE_M)
    lap = np.maximum(0.0, np.hypot(*(np.roll(posts, -1, axis=2) - posts)) - 2 * THERE_M)
    meters: Column = first + LAPS * lap.sum(axis=1) - lap[:, -1]
    return meters / SPEED


FEAT = BehaviorTask(
    name="patrol",
    does="patrols four waypoints in turn",
    measured="two laps in 180 s, every post passed within 0.5 m",
    bounded="straight lines from post to post",
    kit=make_scenario_kit(SCENARIO),
    topics=(GOTO, PATROL),
    options={"goto": LearnerOptions(watched=True, reaction_s=0.2), "patrol": LearnerOptions(watched=True)},
    practice=lambda practice, seed: World(SCENARIO, [seed]),
    trial=lambda seeds: TaskTrial(World(SCENARIO, seeds), LIMIT_S, judge, bound),
    hand=ExpertWaypoints,
)
