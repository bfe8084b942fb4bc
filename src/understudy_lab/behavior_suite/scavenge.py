"""The task of collecting objects: look around, drive up to a visible object until it is picked up, repeat."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan

import numpy as np
from msgspec.structs import replace

from understudy.model.features import Percept, ReadingKey
from understudy.model.learner_options import LearnerOptions
from understudy.model.value_kinds import Column
from understudy.runtime.body import Commands
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.schema import CaptureRule, ObjectClass, RobotGroup, Scenario, TargetSpec
from understudy.sim.world import World
from understudy.training.trainee import SessionView
from understudy_lab.behavior_suite.task import (
    CAMERA,
    SPEED,
    TICK_S,
    BehaviorTask,
    TaskResult,
    TaskTrial,
    rover,
)
from understudy_lab.behavior_suite.tracks import GroundTruth
from understudy_lab.teachers.person import Seen, after
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, Situation

CANS, ENOUGH = 10, 9
TOUCH_M, LIMIT_S = 0.35, 300.0
MIDDLE = CAMERA.width_px / 2
ASIDE, WAY_ASIDE, CENTERED = 35.0, 60.0, 14.0  # pixels
LOOKED_S, WANDERED_S = 5.6, 4.0
TURNED_S, LATE_S = LOOKED_S - 0.1, 100.0
"""How long a robot looks round at most, and when a robot has long seen all that it finds on its way."""

SCENARIO = Scenario(
    name="scavenge",
    about="A rover with a camera, and cans to pick up by touching.",
    size=(9.0, 9.0),
    limit_s=LIMIT_S,
    objects=(
        ObjectClass(name="can", count=CANS, color="red", apart=0.4, capture=CaptureRule(range=TOUCH_M)),
    ),
    types={"rover": rover("forward", "rotate_left", "rotate_right", sensor=CAMERA)},
    robots=(RobotGroup(type="rover", apart=0.4),),
    targets={"can": TargetSpec(nearest="can", doc="Things to pick up.")},
)


def _toward(off: float) -> str:
    return "rotate_left" if off < 0 else "rotate_right"


def show_approach(screen: SessionView) -> str | None:
    """Return the next state of the approach, or None: turn until the object is in the middle of the image, drive."""
    return _approached(screen, ASIDE, CENTERED)


def complain_approach(screen: SessionView) -> str | None:
    """Return the state to correct the approach to, or None: where the robot drives or turns past the object."""
    return _approached(screen, WAY_ASIDE, -20.0)


def _approached(screen: SessionView, aside: float, centered: float) -> str | None:
    off = screen.features["blob_x(A)"] - MIDDLE
    if isnan(off):
        return None
    if screen.state == "start":
        return _toward(off) if abs(off) > CENTERED else "forward"
    if screen.state == "forward":
        return _toward(off) if abs(off) > aside else None
    left = -off if screen.state == "rotate_left" else off
    return "forward" if left < centered else None


def _gone(screen: SessionView) -> bool:
    return screen.time_s > 1.0 and isnan(screen.features["blob_x(A)"])


def _beside(side: int) -> Seen:
    return lambda screen: side * (screen.features["blob_x(A)"] - MIDDLE) > ASIDE


def _at(side: int) -> Situation:
    """Return a situation with a can well to one side of the image."""
    return Situation("cans", {"A": "can"}, _beside(side), after(4.0))


APPROACH = LessonPlan(
    "approach",
    LessonDesign(parameters=["A"], states=["forward", "rotate_left", "rotate_right"], features=["blob_x(A)"]),
    show_approach,
    complain_approach,
    _gone,
    cases=(_at(-1), _at(1)),
    tries=6,
    limit_s=30.0,
)


def show_scavenge(screen: SessionView) -> str | None:
    """Return the next state, or None: look around, approach a visible can, wander after a turn without one."""
    return _scavenged(screen, patience=1.0)


def complain_scavenge(screen: SessionView) -> str | None:
    """Return the state to correct to, or None: ignoring a visible can, looking or wandering too long or too short."""
    return _scavenged(screen, patience=1.4)


def _scavenged(screen: SessionView, patience: float) -> str | None:
    is_visible, passed = not isnan(screen.features["blob_x(can)"]), screen.features["time_in_state"]
    if screen.state == "approach":
        return None if is_visible else "search"
    if is_visible:
        return "approach"
    if screen.state == "start" or (screen.state == "wander" and passed > patience * WANDERED_S):
        return "search"
    return "wander" if screen.state == "search" and passed > patience * LOOKED_S else None


def find_way_out(screen: SessionView) -> str | None:
    """Return the state that leads out of a dead end, or None: late and without a can, it looks round too long.

    It turns by more than a round each time, and by that much its way bends: it closes to a circle if it is much.
    """
    late = screen.time_s > LATE_S and isnan(screen.features["blob_x(can)"])
    turned = screen.state == "search" and screen.features["time_in_state"] > TURNED_S
    return "wander" if late and turned else None


SCAVENGE = LessonPlan(
    "scavenge",
    LessonDesign(
        states=["search=rotate_left", "wander=forward", "approach(can)"],
        features=["blob_x(can)", "time_in_state"],
    ),
    show_scavenge,
    complain_scavenge,
    lambda screen: screen.time_s >= 50.0,
    cases=(Situation("few cans"),),
    tries=3,
    limit_s=80.0,
)


def practice(name: str, seed: int) -> World:
    """Return a practice world: "cans" has many cans; any other name has three, which have to be searched for."""
    if name == "cans":
        return World(SCENARIO, [seed])
    few = ObjectClass(name="can", count=3, color="red", apart=0.4, capture=CaptureRule(range=TOUCH_M))
    return World(replace(SCENARIO, objects=(few,)), [seed])


class ExpertScavenger:
    """A hand-written controller: look around, turn to a visible can, drive to it; wander after a turn without one."""

    keys: Sequence[ReadingKey] = (("blob_x", "can"),)

    def __init__(self, world: World) -> None:
        self._turn = np.zeros(world.agents)
        self._looked = np.zeros(world.agents)
        self._wandering = np.zeros(world.agents, np.bool_)

    def decide(self, percept: Percept) -> Commands:
        """Return the commands of all robots for this tick."""
        off = percept["blob_x", "can"] - MIDDLE
        is_visible = ~np.isnan(off)
        off = np.nan_to_num(off)
        keep_on = (np.sign(off) == self._turn) & (np.abs(off) > CENTERED)
        begin = (self._turn == 0) & (np.abs(off) > ASIDE)
        self._turn = np.where(begin, np.sign(off), np.where(keep_on, self._turn, 0.0))
        self._looked = np.where(is_visible, 0.0, self._looked + TICK_S)
        over = self._looked > np.where(self._wandering, WANDERED_S, LOOKED_S)
        self._wandering = np.where(over, ~self._wandering, self._wandering) & ~is_visible
        self._looked = np.where(over, 0.0, self._looked)
        turn = np.where(is_visible, -self._turn, np.where(self._wandering, 0.0, 1.0))
        return {"drive": (turn == 0).astype(np.float64), "turn": turn}


def judge(tracks: GroundTruth) -> TaskResult:
    """Return when nine of ten cans were picked up, and the share of all cans that were."""
    taken = np.isnan(tracks.objects_x[:, :, :CANS]).sum(axis=2)
    return TaskResult(tracks.first(taken >= ENOUGH), {"share picked up": taken[-1] / CANS})


def bound(tracks: GroundTruth) -> Column:
    """Return the least time in s [W] to touch nine cans at full speed.

    No path to nine cans is shorter than the nine shortest edges of the minimum spanning tree of all (Kruskal 1956),
    less the touching distance at either end.
    """
    return np.array(
        [
            _shortest(
                np.append(tracks.objects_x[0, w, :CANS], tracks.x[0, w]),
                np.append(tracks.objects_y[0, w, :CANS], tracks.y[0, w]),
            )
            for w in range(tracks.x.shape[1])
        ]
    )


def _shortest(x: Column, y: Column) -> float:
    far = np.hypot(x[:, None] - x, y[:, None] - y)
    joined, nearest, edges = np.zeros(len(x), np.bool_), far[0].copy(), []
    joined[0] = True
    while not joined.all():
        following = int(np.argmin(np.where(joined, np.inf, nearest)))
        edges.append(float(nearest[following]))
        joined[following] = True
        nearest = np.minimum(nearest, far[following])
    return sum(max(0.0, edge - 2 * TOUCH_M) for edge in sorted(edges)[:ENOUGH]) / SPEED


FEAT = BehaviorTask(
    name="scavenge",
    does="looks for things with a camera and picks them up",
    measured="nine of ten cans picked up in 300 s",
    bounded="the shortest lines that connect nine cans",
    kit=make_scenario_kit(SCENARIO),
    topics=(APPROACH, SCAVENGE),
    options={
        "approach": LearnerOptions(watched=True, reaction_s=0.2),
        "scavenge": LearnerOptions(watched=True),
    },
    practice=practice,
    trial=lambda seeds: TaskTrial(World(SCENARIO, seeds), LIMIT_S, judge, bound),
    hand=ExpertScavenger,
    dead_ends={"scavenge": find_way_out},
)
