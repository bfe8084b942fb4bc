"""The simulated teacher of wandering and of behaviors that last a fixed time: turning around, withdrawing.

Each timed behavior is an automaton of its own whose only feature is the time in its state, so that no other lesson can
learn a spurious rule about time.
"""

from __future__ import annotations

from collections.abc import Sequence

from understudy.training.trainee import SessionView
from understudy_lab.teachers.person import KEEP, Wish, after, has_raised_flag
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, Situation

NEAR_M, CLEAR_M = 0.6, 0.9
BUMP_M = 0.3  # this close to something, it should long have turned
WIDE_M = 1.25  # with this much room, it still turns
WIDER_M = 1.8  # so much that there is no doubt
AROUND_S = 6.8  # a bit more than once around
AWAY_S = 6.0


# Disperse: wander, and turn away from what is near.


def show_disperse(screen: SessionView) -> str | None:
    """Return the next state of Disperse; KEEP to confirm that it goes on turning.

    The robot drives; near an obstacle it turns away from it until the way is clear.
    """
    left, right = screen.features["sonar_front_left"], screen.features["sonar_front_right"]
    if screen.state in ("left", "right"):
        near, far = (left, right) if screen.state == "right" else (right, left)
        return "forwards" if min(left, right) > CLEAR_M else KEEP if near < NEAR_M < WIDE_M < far else None
    if left < NEAR_M:
        return "right"
    if right < NEAR_M:
        return "left"
    return "forwards"


def complain_disperse(screen: SessionView) -> str | None:
    """Return the state to correct Disperse to, or None: before a collision, or where it turns on with enough room."""
    return _complain_disperse(screen, wide_m=WIDE_M)


def complain_live_disperse(screen: SessionView) -> str | None:
    """Return the state to direct Disperse to in live teaching, or None: as in a test, but where it turns for longer."""
    return _complain_disperse(screen, wide_m=WIDER_M)


def _complain_disperse(screen: SessionView, *, wide_m: float) -> str | None:
    left, right = screen.features["sonar_front_left"], screen.features["sonar_front_right"]
    if screen.state == "start":
        return show_disperse(screen)
    if screen.state in ("left", "right"):
        return "forwards" if min(left, right) > wide_m else None
    return show_disperse(screen) if min(left, right) < BUMP_M else None


def accept_disperse(screen: SessionView, proposed: str) -> bool:
    """Return whether Disperse may go to a state: to drive from the start, or where nothing is near."""
    left, right = screen.features["sonar_front_left"], screen.features["sonar_front_right"]
    return proposed == "forwards" and (screen.state == "start" or min(left, right) > NEAR_M)


DISPERSE = LessonPlan(
    "disperse",
    LessonDesign(states=["forwards", "left", "right"], features=["sonar_front_left", "sonar_front_right"]),
    show_disperse,
    complain_disperse,
    after(40.0),
    cases=(
        Situation("a wall on the left", enough=after(8.0)),
        Situation("a wall on the right", enough=after(8.0)),
        Situation("among others", enough=after(20.0)),
    ),
    tries=6,
    limit_s=60.0,
    patience_s=60.0,
    complain_live=complain_live_disperse,
    accepts=accept_disperse,
)


# What lasts for a while: turning around, withdrawing.


def make_timed_sequence(
    name: str, steps: Sequence[tuple[str, str, float]], flag: str, practice: str = "alone"
) -> LessonPlan:
    """Return the plan of a lesson that runs behaviors one after another for fixed times, then raises `flag`.

    Each step is (state, behavior, duration in s).
    """
    names = [state for state, _, _ in steps]
    following = dict(zip(["start", *names], [*names, flag], strict=True))
    limits = {state: seconds for state, _, seconds in steps}

    def wish(slack_s: float) -> Wish:
        def wished(screen: SessionView) -> str | None:
            late = screen.features["time_in_state"] >= limits.get(screen.state, 0.0) + slack_s
            return following.get(screen.state) if late else None

        return wished

    return LessonPlan(
        name,
        LessonDesign(
            states=[f"{state}={behavior}" for state, behavior, _ in steps],
            flags=[flag],
            features=["time_in_state"],
        ),
        wish(0.0),
        wish(2.0),
        has_raised_flag,
        cases=(Situation(practice),),
        tries=1,
        limit_s=60.0,
    )


LOOK_LEFT = make_timed_sequence("look_left", [("turn", "left", AROUND_S)], "failed")
LOOK_RIGHT = make_timed_sequence("look_right", [("turn", "right", AROUND_S)], "failed")
WITHDRAW = make_timed_sequence(
    "withdraw", [("back", "backwards", 2.0), ("turn", "left", 1.5), ("walk", "disperse", AWAY_S)], "done"
)
