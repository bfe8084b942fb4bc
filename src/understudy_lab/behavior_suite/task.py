"""A behavior of the suite: its lessons, its hand-written controller, how it is taught, and its test."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import radians
from types import MappingProxyType
from typing import Any, Protocol, TypeAlias

import numpy as np

from understudy.model.features import Percept, ReadingKey
from understudy.model.learner_options import LearnerOptions
from understudy.model.library import Kit, Library
from understudy.model.value_kinds import YES, Column
from understudy.runtime.body import Commands
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy.sim.scenario.schema import Camera, RobotType, Sonar, TargetLocator
from understudy.sim.world import World
from understudy.training.trainee import SessionView
from understudy_lab.behavior_suite.tracks import GroundTruth, record
from understudy_lab.lesson_stats import lessons_of
from understudy_lab.tasks.forage_expert import TurnController
from understudy_lab.teachers.live_teacher import choose_teacher
from understudy_lab.teachers.person import Wish
from understudy_lab.teachers.teacher import LessonPlan, MakesBody, TeachingResult


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


make_turn_controller = partial(TurnController, turning=radians(TURNING_DEG), tick_s=TICK_S)


def alternate_moves(first: str, second: str) -> Wish:
    """Return a rule that alternates between two states, changing when the present one is done."""

    def wish(screen: SessionView) -> str | None:
        if screen.state == "start":
            return first
        if screen.features["done"] != YES:
            return None
        return second if screen.state == first else first

    return wish


WORLDS = 100


def worlds_of(seed: int) -> range:
    """Return the seeds of the unseen worlds of a teaching; no two teachings share one."""
    return range(WORLDS * seed, WORLDS * (seed + 1))


PAPER = "paper"
"""The paper's training, as opposed to live teaching."""


def teach(feat: BehaviorTask, seed: int, *, method: str = PAPER) -> TeachingResult:
    """Teach the automata of a behavior one after another; the same seed gives the same library."""
    teacher = choose_teacher(method)
    return teacher(Library(feat.kit), feat.practice, seed, options=feat.options).teach(*feat.topics)


def make_taught_controller(trial: TaskTrial, library: Library, behavior: str) -> GroundTruth:
    """Run the taught behavior in all worlds, each robot with its own bindings, and return the tracks."""
    programs = [link(library, behavior, binding) for binding in trial.bindings]
    engine = Engine(trial.world, programs * (trial.world.agents // len(programs)))
    return record(trial.world, engine.tick, trial.seconds)


def make_expert_controller(trial: TaskTrial, feat: BehaviorTask) -> GroundTruth:
    """Run the hand-written controller in all worlds, and return the tracks."""
    world, hand = trial.world, feat.hand(trial.world)
    return record(world, lambda: world.act(hand.decide(world.sense(hand.keys))), trial.seconds)


def row_of(feat: BehaviorTask, seed: int, *, method: str = PAPER) -> dict[str, Any]:
    """Teach and test one behavior, and return the result as plain data."""
    teaching = teach(feat, seed, method=method)
    trial = feat.trial(worlds_of(seed))
    taught = trial.judge(make_taught_controller(trial, teaching.library, feat.behavior))
    trial = feat.trial(worlds_of(seed))
    tracks = make_expert_controller(trial, feat)
    hand, bound = trial.judge(tracks), trial.bound(tracks)
    accounts = teaching.accounts
    return {
        "success": share_done(taught),
        "ratio": compare_speed(taught, hand),
        "measures": {name: compute_median(column) for name, column in measures(taught).items()},
        "hand": {
            "success": share_done(hand),
            "of_bound": compute_median(hand.seconds / bound),
            "measures": {name: compute_median(column) for name, column in measures(hand).items()},
        },
        "examples": teaching.examples,
        "presses": sum(account.presses for account in accounts.values()),
        "seconds": round(teaching.seconds, 1),
        "lessons": [
            {**lesson, "attempts": accounts[lesson["name"]].lessons} for lesson in lessons_of(teaching)
        ],
    }


def share_done(judged: TaskResult) -> float:
    """Return the share of worlds in which the task was completed in time."""
    return float((~np.isnan(judged.seconds)).mean())


def compare_speed(taught: TaskResult, hand: TaskResult) -> float | None:
    """Return the median speed relative to the expert, over worlds that the expert completed; a failure counts 0."""
    finished = ~np.isnan(hand.seconds)
    return compute_median(np.nan_to_num(hand.seconds / taught.seconds)[finished])


def measures(judged: TaskResult) -> Mapping[str, Any]:
    """Return all measured columns by name, seconds first."""
    return {"seconds": judged.seconds, **judged.measures}


def compute_median(column: Any) -> float | None:
    """Return the median of the values that are not NaN, or None if there are none."""
    present = column[~np.isnan(column)]
    return round(float(np.median(present)), 4) if len(present) else None
