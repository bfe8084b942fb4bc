"""Teaching of one behavior and its comparison with the hand-written controller: one row of the experiment."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from understudy.model.library import Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.link import link
from understudy_lab.behavior_suite.task import BehaviorTask, TaskResult, TaskTrial
from understudy_lab.behavior_suite.tracks import GroundTruth, record
from understudy_lab.lesson_stats import lessons_of
from understudy_lab.teachers.live_teacher import choose_teacher
from understudy_lab.teachers.teacher import TeachingResult

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
