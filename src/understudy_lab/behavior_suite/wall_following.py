"""Following a wall on one hand with two sonars: how it is taught, and by hand."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from understudy.model.features import Percept, ReadingKey
from understudy.runtime.body import Commands
from understudy.sim.world import World
from understudy.training.lesson_design import new_lesson
from understudy.training.session_view import Screen
from understudy_lab.behavior_suite.task import Hand
from understudy_lab.teachers.person import after
from understudy_lab.teachers.teacher import Case, Topic

LEFT, RIGHT = "left", "right"
OTHER = {LEFT: RIGHT, RIGHT: LEFT}

BLOCKED_M, CLEAR_M = 0.45, 0.8  # ahead
WIDE_M, WELL_M = 0.55, 0.45  # on the hand
AHEAD = "sonar_ahead"


def wanted(state: str, ahead: float, beside: float, hand: str, slack: float = 0.0) -> str | None:
    """What a person wants the robot to do, who lets this much (m) pass."""
    away, near = f"rotate_{OTHER[hand]}", f"veer_{hand}"
    if state == "start":
        return "seek"
    if state == away:
        return "along" if ahead > CLEAR_M + 2 * slack else None
    if ahead < BLOCKED_M - slack:
        return away
    if state in ("seek", near):
        return "along" if beside < WELL_M - slack else None
    return near if beside > WIDE_M + slack else None


def follow(name: str, hand: str, practice: str, *, cases: int, seconds: float) -> Topic:
    """Following a wall with one hand on it: seek one, go along it, veer to it, turn off where it ends ahead."""
    beside = f"sonar_{hand}"

    def pressing(slack: float) -> Callable[[Screen], str | None]:
        return lambda screen: wanted(
            screen.state, screen.features[AHEAD], screen.features[beside], hand, slack
        )

    states = ["seek=forward", "along=forward", f"rotate_{OTHER[hand]}", f"veer_{hand}"]
    return Topic(
        name,
        lambda library: new_lesson(library, name, states=states, features=[AHEAD, beside]),
        pressing(0.0),
        pressing(0.1),
        after(3 * seconds),
        cases=(Case(practice, enough=after(seconds)),) * cases,
        tries=4,
        limit_s=4 * seconds,
    )


class ByHand:
    """The same with the same sonars, reacting at once."""

    def __init__(self, world: World, hand: str) -> None:
        self.keys: Sequence[ReadingKey] = ((AHEAD, None), (f"sonar_{hand}", None))
        self._side = 1.0 if hand == LEFT else -1.0
        self._seeking = np.ones(world.agents, np.bool_)
        self._turning, self._veering = np.zeros((2, world.agents), np.bool_)

    def decide(self, percept: Percept) -> Commands:
        """What each robot does now."""
        ahead, beside = (percept[key] for key in self.keys)
        self._turning = ahead < np.where(self._turning, CLEAR_M, BLOCKED_M)
        self._seeking &= ~self._turning & (beside > WELL_M)
        self._veering = beside > np.where(self._veering, WELL_M, WIDE_M)
        veer = (self._veering & ~self._seeking).astype(np.float64)
        return {
            "drive": np.where(self._turning, 0.0, 1.0 - 0.2 * veer),
            "turn": self._side * np.where(self._turning, -1.0, 0.6 * veer),
        }


def by_hand(hand: str) -> Callable[[World], Hand]:
    """Makes the controller for one hand."""
    return lambda world: ByHand(world, hand)
