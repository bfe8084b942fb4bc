"""The fifty trials of one robot that approaches the ball: three start positions, and pushes to either side."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from understudy.model.library import Library
from understudy.runtime.link import link
from understudy_lab.tasks.servo_teacher import SIDES, topics
from understudy_lab.tasks.soccer import (
    AHEAD,
    POSITIONS,
    Disturbance,
    Soccer,
    StartPose,
    approach_by,
    approach_by_hand,
    kit,
)
from understudy_lab.teachers.teacher import ScriptedTeacher, TeachingResult

TRIALS = 10
PUSHED: Mapping[str, int] = {"pushed left": 1, "pushed right": -1}
CASES = (*POSITIONS, *PUSHED)
HAND = "written by hand"


def search_side(seed: int) -> str:
    """Return the side to which a robot turns that never saw the ball; it alternates with the seed."""
    return SIDES[seed % 2]


def opposite(search: str) -> tuple[str, str]:
    """Return the position and the push in which the ball is lost on the side to which the policy does not turn."""
    return ("ball right", "pushed left") if search == "left" else ("ball left", "pushed right")


def teach(seed: int, method: str) -> TeachingResult:
    """Teach the approach to the ball; the same seed and method give the same library."""
    teacher = ScriptedTeacher(Library(kit), lambda practice, world: Soccer([world]), seed, options={})
    return teacher.teach(topics(search_side(seed))[method])


def trials(seed: int) -> tuple[Soccer, dict[int, Disturbance]]:
    """Return the worlds of a seed's trials, in the order of CASES, and the pushed robots; all methods use the same."""
    starts: list[StartPose] = [start for start in POSITIONS.values() for _ in range(TRIALS)]
    pushes = {}
    for side in PUSHED.values():
        for trial in range(TRIALS):
            pushes[len(starts)] = Disturbance(2.0 + trial % 5, 0.8, side * 60.0, side * 0.2)
            starts.append(AHEAD)
    return Soccer(range(100 * seed, 100 * seed + len(starts)), starts), pushes


def judge(seed: int, library: Library | None) -> dict[str, list[float]]:
    """Return the seconds to the ball by case, NaN where the limit came first; None means the hand-written robot."""
    body, pushes = trials(seed)
    if library is None:
        seconds = approach_by_hand(body, pushes=pushes)
    else:
        seconds = approach_by(link(library, "approach", {}), body, pushes=pushes)
    rows = np.round(seconds, 1).reshape(len(CASES), TRIALS).tolist()
    return dict(zip(CASES, rows, strict=True))
