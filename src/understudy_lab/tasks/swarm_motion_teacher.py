"""The simulated teacher of motion in the swarm: wander, approach a target, and pull an object home."""

from __future__ import annotations

from math import isnan, pi

from understudy.model.value_kinds import YES
from understudy.training.trainee import SessionView
from understudy_lab.teachers.person import KEEP, Seen, Wish, after, find_bearing, has_raised_flag
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, PushAway, Situation

SELDOM, OFTEN = 0.06, 0.3
"""Thresholds on the chance drawn each second: below the first it starts to turn, above the second it drives on."""
THERE_M, NOT_THERE_M, PAST_M = 0.4, 0.6, 0.25
ASTRAY, FACING = 0.65, 0.4  # it turns on while the hand moves
ASIDE = 1.0  # so far off that it plainly drives past, rad


def yes(screen: SessionView, feature: str) -> bool:
    """Return whether a feature has the value YES."""
    return screen.features.get(feature) == YES


def there(screen: SessionView, target: str) -> bool:
    """Return whether the robot senses a target."""
    return not isnan(screen.features[f"distance_to({target})"])


# Wander: drive on, turn from time to time and at walls.


def show_wander(screen: SessionView) -> str | None:
    """Return the next state of Wander; KEEP confirms it: drive, and turn when stuck and at random times."""
    chance = screen.features["chance"]
    if screen.state == "left":
        return "forward" if chance > OFTEN else None
    if screen.state == "start":
        return "forward"
    if yes(screen, "stuck") or chance < SELDOM:
        return "left"
    return KEEP if 2 * SELDOM < chance < OFTEN else None


def complain_wander(screen: SessionView) -> str | None:
    """Return the state that Wander should have switched to, or None if nothing is wrong.

    It is wrong if the robot is stuck and does not turn, does not start, or turns for too long.
    """
    if screen.state == "forward":
        return "left" if yes(screen, "stuck") else None
    return "forward" if screen.state == "start" or screen.features["chance"] > 2 * OFTEN else None


WANDER = LessonPlan(
    "wander",
    LessonDesign(states=["forward", "left=rotate_left"], features=["stuck", "chance"]),
    show_wander,
    complain_wander,
    after(60.0),
    cases=(Situation("alone", enough=after(50.0)),),
    tries=2,
    limit_s=90.0,
    patience_s=70.0,
    complain_live=show_wander,  # both reasons to turn, not only that it is stuck
)


# Approach(A), and home with what is pulled.


def _turned(state: str, off: float, *, astray: float, facing: float) -> str | None:
    toward = "rotate_left" if off > 0 else "rotate_right"
    if state in ("start", "forward"):
        return toward if abs(off) > astray else "forward" if state == "start" else None
    ahead = off if state == "rotate_left" else -off
    return "forward" if -pi / 2 < ahead < facing else None


def show_approach(screen: SessionView) -> str | None:
    """Return the next state of Approach(A), or None: turn to A, drive to it, `done`; `failed` if A is not sensed."""
    if screen.flag:
        return None
    if not there(screen, "A"):
        return "failed"
    if screen.features["distance_to(A)"] < THERE_M:
        return "done"
    return _turned(screen.state, find_bearing(screen, "A"), astray=ASTRAY, facing=FACING)


def complain_approach(screen: SessionView) -> str | None:
    """Return the state to correct Approach(A) to, or None: driving or turning past A, or raising a flag wrongly."""
    return _complain_approach(screen, astray=1.5 * ASTRAY)


def complain_live_approach(screen: SessionView) -> str | None:
    """Return the state to direct Approach(A) to in live teaching, or None: as in a test, but where A is more aside."""
    return _complain_approach(screen, astray=ASIDE)


def _complain_approach(screen: SessionView, *, astray: float) -> str | None:
    distance = screen.features["distance_to(A)"]
    if screen.flag == "done":
        return "forward" if distance > NOT_THERE_M else None
    if screen.flag:
        return "forward" if there(screen, "A") else None
    if isnan(distance):
        return "failed"
    if distance < PAST_M:
        return "done"
    return _turned(screen.state, find_bearing(screen, "A"), astray=astray, facing=-ASTRAY)


def _beside(side: int) -> Seen:
    return lambda screen: 0.8 < side * find_bearing(screen, "A") < 2.6


def _behind(side: int) -> Seen:
    return lambda screen: 1.7 < side * find_bearing(screen, "A") < 2.8


def _ahead(screen: SessionView) -> bool:
    return 0.8 < screen.features["distance_to(A)"] < 2.0 and abs(find_bearing(screen, "A")) < 0.4


APPROACH = LessonPlan(
    "approach",
    LessonDesign(
        parameters=["A"],
        states=["forward", "rotate_left", "rotate_right"],
        flags=["done", "failed"],
        features=["distance_to(A)", "angle_to(A)"],
    ),
    show_approach,
    complain_approach,
    has_raised_flag,
    cases=(
        Situation("alone", {"A": "home"}, _beside(1), push=PushAway("forward", "rotate_right", 0.8)),
        Situation("alone", {"A": "home"}, _beside(-1), push=PushAway("forward", "rotate_left", 0.8)),
        Situation("a crate", {"A": "crate"}, _beside(1)),
        Situation("a crate", {"A": "crate"}, _beside(-1)),
        Situation("a crate", {"A": "crate"}, _ahead),
        Situation("alone", {"A": "caller"}),
        Situation("a help that stops", {"A": "caller"}),
        Situation("a help that stops soon", {"A": "caller"}, _behind(1)),
        Situation("a help that stops soon", {"A": "caller"}, _behind(-1)),
    ),
    tries=10,
    limit_s=60.0,
    complain_live=complain_live_approach,
    tries_cases=True,
)


def _steer(facing: float, astray: float) -> Wish:
    return lambda screen: _turned(screen.state, find_bearing(screen, "home"), astray=astray, facing=facing)


STEER = LessonPlan(
    "steer",
    LessonDesign(
        states=["forward=pull_forward", "rotate_left=pull_left", "rotate_right=pull_right"],
        features=["angle_to(home)"],
    ),
    _steer(FACING, ASTRAY),
    _steer(-ASTRAY, 2 * ASTRAY),
    after(15.0),
    cases=(
        Situation(
            "alone",
            suits=lambda screen: find_bearing(screen, "home") > 0.8,
            enough=after(8.0),
            push=PushAway("forward", "rotate_right", 0.8),
        ),
        Situation(
            "alone",
            suits=lambda screen: find_bearing(screen, "home") < -0.8,
            enough=after(8.0),
            push=PushAway("forward", "rotate_left", 0.8),
        ),
    ),
    tries=4,
    limit_s=40.0,
    complain_live=_steer(-ASTRAY, ASIDE + 0.2),
)


def show_haul(screen: SessionView) -> str | None:
    """Return the next state of Haul, or None: pull an object home if it moves, and let go of it otherwise."""
    if screen.flag:
        return None
    if yes(screen, "enough"):
        return "steer"
    return "drop" if yes(screen, "holding") else "done"


HAUL = LessonPlan(
    "haul",
    LessonDesign(states=["steer", "drop=let_go"], flags=["done"], features=["enough", "holding"]),
    show_haul,
    show_haul,
    has_raised_flag,
    cases=(
        Situation("holding a crate"),
        Situation("holding in vain"),
        Situation("losing hands"),
        Situation("alone"),
    ),
    tries=4,
    limit_s=90.0,
    patience_s=70.0,
)
