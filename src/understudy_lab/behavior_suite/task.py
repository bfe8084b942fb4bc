"""One behavior of the suite: how it is taught, its hand-written expert, and how it is judged."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import pi, radians, tau
from types import MappingProxyType
from typing import Protocol, TypeAlias

import numpy as np

from understudy.model.features import Percept, ReadingKey
from understudy.model.kinds import YES, Column
from understudy.model.lesson import LearnerOptions
from understudy.model.library import Kit
from understudy.runtime.body import Commands
from understudy.sim.scenario.schema import Camera, RobotType, Sonar, TargetLocator
from understudy.sim.world import World
from understudy.training.trainee import SessionView
from understudy_lab.behavior_suite.tracks import GroundTruth, Yes
from understudy_lab.teachers.person import Wish
from understudy_lab.teachers.teacher import LessonPlan, MakesBody


class Expert(Protocol):
    """A controller written by hand, for N robots at once, that does one basic behavior at a time."""

    @property
    def keys(self) -> Sequence[ReadingKey]:
        """What it reads."""
        ...

    def decide(self, percept: Percept) -> Commands:
        """What each robot does now."""
        ...


@dataclass(frozen=True)
class TaskResult:
    """How W worlds went: columns [W]. A world is a success where it was done in time."""

    seconds: Column
    """How long it took; absent where it was not done."""
    measures: Mapping[str, Column] = field(default_factory=lambda: MappingProxyType({}))
    """What else was measured, by name."""


@dataclass(frozen=True)
class TaskTrial:
    """Unseen worlds for one teaching: what they are, how to judge what was done in them, and what none can beat."""

    world: World
    seconds: float
    judge: Callable[[GroundTruth], TaskResult]
    bound: Callable[[GroundTruth], Column]
    """Seconds [W] that no robot can beat."""
    bindings: Sequence[Mapping[str, str]] = ({},)
    """What the parameters stand for, for each robot of a world in turn."""


MakesTrial: TypeAlias = Callable[[Sequence[int]], TaskTrial]


@dataclass(frozen=True)
class BehaviorTask:
    """One behavior of the repertoire; `behavior` is the last of its topics."""

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

    @property
    def behavior(self) -> str:
        """The automaton that is judged."""
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
    """A rover with one sensor, and some of the moves."""
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


def bearing(screen: SessionView, of: str = "A") -> float:
    """Signed bearing of a target on the screen, left positive, rad."""
    return (screen.features[f"angle_to({of})"] + pi) % tau - pi


def alternate_moves(first: str, second: str) -> Wish:
    """One, and when that is done the other, over and over."""

    def wish(screen: SessionView) -> str | None:
        if screen.state == "start":
            return first
        if screen.features["done"] != YES:
            return None
        return second if screen.state == first else first

    return wish


class TurnController:
    """Turns until it faces something to half a tick's turn, then not before it is off by more than `astray` (rad)."""

    facing = 0.55 * radians(TURNING_DEG) * TICK_S

    def __init__(self, agents: int, *, astray: float = 0.2) -> None:
        self._astray = astray
        self._turn = np.zeros(agents)

    def toward(self, off: Column, go: Yes) -> Column:
        """Which way to turn now [N], where it is to `go`: 1 left, -1 right, 0 not."""
        off = np.where(go, off, 0.0)
        keep_on = (self._turn != 0.0) & (np.abs(off) > self.facing)
        begin = (self._turn == 0.0) & (np.abs(off) > self._astray)
        self._turn = np.where(begin, np.sign(off), np.where(keep_on, self._turn, 0.0))
        return self._turn
