"""The simulated teacher of roaming and going to a target, for scouts and carriers, and of finding wrecks, for scouts.

Both types of robot learn their own version of roaming and going, because scouts are faster and carriers reach farther.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan

from understudy.model.value_kinds import YES
from understudy.training.trainee import SessionView
from understudy_lab.tasks.goto_teacher import DESIGN, GotoRule
from understudy_lab.teachers.person import (
    KEEP,
    Seen,
    Wish,
    after,
    has_raised_flag,
    never_confirm,
)
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, Situation

ASTRAY = 0.5  # rad: driving past it, plainly
FACED_AWAY = 0.6  # rad: not facing it
VERY_LOW, LOW, HIGH = 0.25, 0.4, 0.6  # chances, drawn every second
NEAR_M = 1.3  # near enough for a scout to stay
LEFT_M = 2.0  # what is so far away is another wreck


# Roam: drive; at a wall, turn away from it, and on for as long as chance will have it, so as to get everywhere.


def roam(who: str, *, near_m: float, clear_m: float, bump_m: float, wide_m: float) -> LessonPlan:
    """Return the plan of Roam: drive, turn away from walls, and go on turning for a random time.

    The robot turns at a wall closer than `near_m`, until it has `clear_m` of room and the chance feature is low. It is
    corrected when closer than `bump_m`, or when it turns on with `wide_m` of room and a very low chance. All are in m.
    """

    def wish(near: float, clear: float, low: float) -> Wish:
        def wished(screen: SessionView) -> str | None:
            room, chance = screen.features["sonar_front"], screen.features["chance"]
            if screen.state != "turn":
                return "turn" if room < near else "forward"
            if room > clear and chance < low:
                return "forward"
            return KEEP if room > clear and chance > HIGH else None

        return wished

    return LessonPlan(
        "roam",
        LessonDesign(states=["forward", "turn=rotate_left"], features=["chance", "sonar_front"]),
        wish(near_m, clear_m, LOW),
        never_confirm(wish(bump_m, wide_m, VERY_LOW)),
        after(80.0),
        cases=(Situation(f"a {who} between walls"), Situation(f"a {who} between walls")),
        tries=4,
        limit_s=90.0,
        patience_s=60.0,
    )


# Goto(A): turn to A, drive to it, say done.


def goto(
    who: str, targets: Sequence[str], *, far_m: float, there_m: float, beyond_m: float, past_m: float
) -> LessonPlan:
    """Return the plan of GoTo(A): turn to A, drive to it, and raise `done` at `there_m` from it.

    The robot is corrected when it raises `done` farther away than `beyond_m`, or has not raised it within `past_m`.
    Practice begins up to `far_m` away. All are in m.
    """
    rule, yard = GotoRule(there_m, beyond_m, past_m, ASTRAY, FACED_AWAY), f"a {who} in a yard"
    ends = (targets[0], targets[-1]) * 2
    cases = rule.list_cases((yard, yard), ends, (1.5, 0.5 * far_m), (0.6 * far_m, far_m))
    return LessonPlan(
        "goto", DESIGN, rule.show, rule.complain, has_raised_flag, cases=cases, tries=6, limit_s=60.0
    )


# What scouts do: Explore until they are at a wreck; Lookout, all by themselves, goes on when it is empty.


def sees_wreck(screen: SessionView) -> bool:
    """Return whether a wreck is in view."""
    return not isnan(screen.features["distance_to(wreck)"])


def is_done(screen: SessionView) -> bool:
    """Return whether the behavior that the automaton runs has raised `done`."""
    return screen.features.get("done") == YES


def raised_or_after(seconds: float) -> Seen:
    """Return a predicate: a flag is raised, or the given time in s is over."""
    return lambda screen: has_raised_flag(screen) or screen.time_s >= seconds


def show_explore(screen: SessionView) -> str | None:
    """Return the next state of Explore, or None: roam until a wreck is visible, go to it, raise `done` near it.

    The robot roams again when the wreck is emptied before it arrives.
    """
    if screen.state == "done":
        return None
    if not sees_wreck(screen):
        return "roam"
    return "done" if screen.state == "near" and screen.features["distance_to(wreck)"] < NEAR_M else "near"


def show_lookout(screen: SessionView) -> str | None:
    """Return the next state of Lookout: explore, and rest at a wreck while something is left in it."""
    if screen.state == "rest":
        return None if screen.features["distance_to(wreck)"] < LEFT_M else "explore"
    return "rest" if screen.state == "explore" and is_done(screen) else "explore"


EXPLORE = LessonPlan(
    "explore",
    LessonDesign(states=["roam", "near=goto(wreck)"], flags=["done"], features=["distance_to(wreck)"]),
    show_explore,
    show_explore,
    raised_or_after(60.0),
    cases=(Situation("a scout, a wreck somewhere"), Situation("a scout, wrecks that others empty")),
    tries=4,
    limit_s=90.0,
    patience_s=60.0,
)

LOOKOUT = LessonPlan(
    "lookout",
    LessonDesign(states=["explore", "rest=wait"], features=["done", "distance_to(wreck)"]),
    show_lookout,
    show_lookout,
    after(90.0),
    cases=(
        Situation("a scout, many wrecks that are emptied", enough=after(60.0)),
        Situation("a scout, wrecks that are emptied", enough=after(60.0)),
    ),
    tries=4,
    limit_s=120.0,
    patience_s=90.0,
)

SCOUTS = (
    roam("scout", near_m=1.3, clear_m=2.2, bump_m=0.7, wide_m=2.5),
    goto("scout", ["wreck"], far_m=4.0, there_m=0.8, beyond_m=1.1, past_m=0.35),
    EXPLORE,
    LOOKOUT,
)
