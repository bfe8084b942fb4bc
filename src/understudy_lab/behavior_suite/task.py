"""A behavior of the suite: its lessons, its hand-written controller, and its test."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import radians
from types import MappingProxyType
from typing import Protocol, TypeAlias

import numpy as np

from understudy.model.features import Percept, ReadingKey
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Kit
from understudy.model.value_kinds import YES, Column
from understudy.runtime.body import Commands
from understudy.sim.scenario.schema import Camera, RobotType, Sonar, TargetLocator
from understudy.sim.world import World
from understudy.training.trainee import SessionView
from understudy_lab.behavior_suite.tracks import GroundTruth, Yes
from understudy_lab.teachers.person import Wish
from understudy_lab.teachers.teacher import LessonPlan, MakesBody


class Expert(Protocol):
    """A hand-written controller for N robots that runs one basic behavior at a time."""

    @property
    def keys(self) -> Sequence[ReadingKey]:
        """The sensor values that the controller needs."""
        ...

    def decide(self, percept: Percept) -> Commands:
        """Return the commands of all robots for this tick."""
        ...


@dataclass(frozen=True)
class TaskResult:
    """The results of W worlds as columns [W]; a world is a success if the task was completed in time."""

    seconds: Column
    """The time until completion, s; NaN where it was not completed."""
    measures: Mapping[str, Column] = field(default_factory=lambda: MappingProxyType({}))
    """Further measured columns, by name."""


@dataclass(frozen=True)
class TaskTrial:
    """The test of one teaching: unseen worlds, a time limit in s, a judge, and a lower bound."""

    world: World
    seconds: float
    judge: Callable[[GroundTruth], TaskResult]
    bound: Callable[[GroundTruth], Column]
    """A function that returns a lower bound on the time in s [W]."""
    bindings: Sequence[Mapping[str, str]] = ({},)
    """The bindings of the behavior's parameters for each robot of a world."""


MakesTrial: TypeAlias = Callable[[Sequence[int]], TaskTrial]


@dataclass(frozen=True)
class BehaviorTask:
    """One behavior of the suite with everything needed to teach and test it."""

    name: str
    does: str
    measured: str
    bounded: str
    kit: Kit
    topics: Sequence[LessonPlan]
    options: Mapping[str, LearnerOptions]
    practice: MakesBody
    trial: MakesTrial
    hand: Callable[[World], Expert]
    dead_ends: Mapping[str, Wish] = field(default_factory=lambda: MappingProxyType({}))
    """By the name of a topic, a function that returns the state to direct to where a robot would never get on."""

    @property
    def behavior(self) -> str:
        """The name of the tested automaton, the last of the topics."""
        return self.topics[-1].name


TICK_S, SPEED, TURNING_DEG, RADIUS = 0.1, 0.5, 70.0, 0.2
MOVES = {
    "forward": {"drive": 1.0},
    "backward": {"drive": -1.0},
    "rotate_left": {"turn": 1.0},
    "rotate_right": {"turn": -1.0},
    "veer_left": {"drive": 0.8, "turn": 0.6},
    "veer_right": {"drive": 0.8, "turn": -0.6},
    "wait": {"drive": 0.0},
}
SONAR = Sonar(
    sectors={"sonar_left": (30.0, 120.0), "sonar_ahead": (-30.0, 30.0), "sonar_right": (-120.0, -30.0)},
    range=2.0,
    noise=0.01,
)
LOCATOR = TargetLocator()
CAMERA = Camera(range=3.0, noise_x=1.0)


def rover(
    *moves: str, sensor: Sonar | TargetLocator | Camera = LOCATOR, team: str | None = None
) -> RobotType:
    """Return a rover with one sensor and some of the moves."""
    return RobotType(
        radius=RADIUS,
        speed=SPEED,
        turning_deg=TURNING_DEG,
        noise_drive=0.02,
        noise_turn=0.02,
        team=team,
        sensors=(sensor,),
        behaviors={name: MOVES[name] for name in moves},
    )


def alternate_moves(first: str, second: str) -> Wish:
    """Return a rule that alternates between two states, changing when the present one is done."""

    def wish(screen: SessionView) -> str | None:
        if screen.state == "start":
            return first
        if screen.features["done"] != YES:
            return None
        return second if screen.state == first else first

    return wish


class TurnController:
    """A rule that turns to within half a tick's turn of a target, and again only when it is off by `astray` rad."""

    facing = 0.55 * radians(TURNING_DEG) * TICK_S

    def __init__(self, agents: int, *, astray: float = 0.2) -> None:
        self._astray = astray
        self._turn = np.zeros(agents)

    def toward(self, off: Column, go: Yes) -> Column:
        """Return the direction to turn now [N] for the robots in `go`: 1 left, -1 right, 0 none."""
        off = np.where(go, off, 0.0)
        keep_on = (self._turn != 0.0) & (np.abs(off) > self.facing)
        begin = (self._turn == 0.0) & (np.abs(off) > self._astray)
        self._turn = np.where(begin, np.sign(off), np.where(keep_on, self._turn, 0.0))
        return self._turn
