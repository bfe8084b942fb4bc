"""The simulated teacher of the behaviors of a single robot on patrol, as listed in section 5.1 of the paper.

Servo raises `failed` after one full turn without finding its target. Attack then withdraws, that is, backs up, turns
and wanders for a while, before it searches again; it also withdraws when the robot is stuck, for example behind
teammates that are already home.
"""

from __future__ import annotations

from dataclasses import replace
from math import isnan

from understudy.model.value_kinds import YES
from understudy.training.trainee import SessionView
from understudy_lab.tasks.patrol_wander_teacher import (
    AROUND_S,
    AWAY_S,
    DISPERSE,
    LOOK_LEFT,
    LOOK_RIGHT,
    WITHDRAW,
)
from understudy_lab.teachers.person import KEEP, Seen, after, has_raised_flag
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, PushAway, Situation

MIDDLE_PX, WIDTH_PX = 80.0, 160.0
EMERGED_PX = 25.0  # so far into the frame, A is well in view
ASIDE_PX = 50.0  # at this distance from the middle, a slow person still has time to turn to it
OTHER_PX = 25.0  # so far beyond the middle it is plainly in the other part of the frame
CLOSE_PX = 6000.0  # as large as an intruder 0.7 m away
ALMOST_PX = 5000.0  # nearly so, and no reason yet
FAR_PX = 5200.0  # an intruder out of reach: too early to say done
TOO_CLOSE_PX = 7200.0
SEARCH_S = 60.0  # after this time of searching, the person has seen enough
BEHIND_M, CLOSE_BEHIND_M, ROOM_M = 0.45, 0.35, 0.9


# Servo(A): turn until A is seen, drive to it, remember on which side it was; failed where there is none.


def blob_x(screen: SessionView) -> float:
    """Return the horizontal position of A in the camera frame, px; NaN where A is not visible."""
    return screen.features["blob_x(A)"]


def show_servo(screen: SessionView) -> str | None:
    """Return the next state of Servo(A), or None: turn until A is well in view, drive; `failed` after a full turn."""
    return _servo(screen, turning=0.0, driving=0.0)


def complain_servo(screen: SessionView) -> str | None:
    """Return the state to correct Servo(A) to, or None; with wide margins, and where it fails too early."""
    return _complain_servo(screen, turning=90.0, driving=22.0)


def complain_live_servo(screen: SessionView) -> str | None:
    """Return the state to direct Servo(A) to in live teaching, or None: where it is about to lose A."""
    return _complain_servo(screen, turning=110.0, driving=45.0)


def _complain_servo(screen: SessionView, *, turning: float, driving: float) -> str | None:
    if screen.state != "failed":
        return _servo(screen, turning=turning, driving=driving)
    x, too_early = blob_x(screen), screen.time_s < AROUND_S - 1.0
    return _side(x) if not isnan(x) else "left" if too_early else None


def accept_servo(screen: SessionView, proposed: str) -> bool:
    """Return whether Servo(A) may go to a state: to drive, unless A is at the edge of the other side."""
    drives = proposed in ("forward_left", "forward_right") and not isnan(blob_x(screen))
    return drives and complain_servo(replace(screen, state=proposed)) is None


def _side(x: float) -> str:
    return "forward_left" if x < MIDDLE_PX else "forward_right"


def _servo(screen: SessionView, *, turning: float, driving: float) -> str | None:
    x, state = blob_x(screen), screen.state
    if state == "failed":
        return None
    if isnan(x):
        if state in ("left", "right"):
            return "failed" if screen.features.get("failed") == YES else None
        return "right" if state == "forward_right" else "left"
    if state == "start":
        return "left" if x < MIDDLE_PX else "right"
    if state == "left":
        return "forward_left" if x > EMERGED_PX + turning else None
    if state == "right":
        return "forward_right" if x < WIDTH_PX - EMERGED_PX - turning else None
    beyond = x - MIDDLE_PX if state == "forward_left" else MIDDLE_PX - x
    other = "forward_right" if state == "forward_left" else "forward_left"
    return other if beyond > OTHER_PX + driving else None


def on_the_left(screen: SessionView) -> bool:
    """Return whether A is in the left part of the frame."""
    return blob_x(screen) < MIDDLE_PX - ASIDE_PX


def on_the_right(screen: SessionView) -> bool:
    """Return whether A is in the right part of the frame."""
    return blob_x(screen) > MIDDLE_PX + ASIDE_PX


def has_lost_target(screen: SessionView) -> bool:
    """Return whether A is outside the frame."""
    return isnan(blob_x(screen))


def _over(during: str, behavior: str) -> PushAway:
    """Return a push that turns the robot until A is in the other half of the frame."""
    return PushAway(during, behavior, 0.35, within_s=5.0)


def _away(during: str, behavior: str) -> PushAway:
    """Return a push that turns the robot until A leaves the frame on the side on which it was."""
    return PushAway(during, behavior, 1.0)


SERVO = LessonPlan(
    "servo",
    LessonDesign(
        parameters=["A"],
        states=["left=look_left", "right=look_right", "forward_left=forwards", "forward_right=forwards"],
        flags=["failed"],
        features=["failed", "blob_x(A)"],
    ),
    show_servo,
    complain_servo,
    lambda screen: has_raised_flag(screen) or screen.time_s > 25.0,
    cases=(
        Situation(
            "an intruder", {"A": "intruder"}, on_the_left, after(5.0), push=_over("forward_left", "left")
        ),
        Situation(
            "an intruder", {"A": "intruder"}, on_the_right, after(5.0), push=_over("forward_right", "right")
        ),
        Situation("an intruder", {"A": "home"}, has_lost_target, after(12.0)),
        Situation(
            "an intruder that leaves", {"A": "intruder"}, on_the_left, push=_away("forward_left", "right")
        ),
        Situation(
            "an intruder that leaves", {"A": "intruder"}, on_the_right, push=_away("forward_right", "left")
        ),
    ),
    tries=10,
    limit_s=60.0,
    complain_live=complain_live_servo,
    accepts=accept_servo,
)


# Attack(A): servo to A; where it cannot be found or reached, go elsewhere and try again.


def show_attack(screen: SessionView) -> str | None:
    """Return the next state of Attack(A); None for no change, KEEP to confirm the current state.

    The robot servos until A looks large enough; it withdraws after a turn without finding A or when stuck, then servos
    again.
    """
    wished = _attack(screen, close=CLOSE_PX)
    almost = screen.state == "servo" and ALMOST_PX < screen.features["blob_size(A)"] < CLOSE_PX
    return KEEP if wished is None and almost else wished


def complain_attack(screen: SessionView) -> str | None:
    """Return the state to correct Attack(A) to, or None; with a margin, and where `done` is raised too early."""
    if screen.state == "done":
        return "servo" if not screen.features["blob_size(A)"] > FAR_PX else None
    return _attack(screen, close=TOO_CLOSE_PX)


def _attack(screen: SessionView, *, close: float) -> str | None:
    seen, state = screen.features, screen.state
    if state == "start":
        return "servo"
    if state == "servo":
        if seen["blob_size(A)"] >= close:
            return "done"
        return "withdraw" if YES in (seen.get("failed"), seen.get("stuck")) else None
    return "servo" if state != "done" and seen.get("done") == YES else None


def _afar(screen: SessionView) -> bool:
    return 300.0 < screen.features["blob_size(A)"] < 2500.0


def _back_to(state: str, seconds: float) -> Seen:
    return lambda screen: screen.state == state and screen.time_s > seconds


ATTACK = LessonPlan(
    "attack",
    LessonDesign(
        parameters=["A"],
        states=["servo(A)", "withdraw"],
        flags=["done"],
        features=["done", "failed", "stuck", "blob_size(A)"],
    ),
    show_attack,
    complain_attack,
    lambda screen: has_raised_flag(screen) or screen.time_s > SEARCH_S,
    cases=(
        Situation("teammates in the way", {"A": "home"}, enough=_back_to("servo", AWAY_S)),
        Situation("no intruder", {"A": "intruder"}, enough=_back_to("servo", AROUND_S)),
        Situation("alone", {"A": "home"}, _afar),
        Situation("alone", {"A": "home"}, _afar),
        Situation("an intruder", {"A": "intruder"}),
    ),
    tries=6,
    limit_s=180.0,
)


# Scatter(A): look for A, face it, back away from it slowly.


def show_scatter(screen: SessionView) -> str | None:
    """Return the next state of Scatter(A), or None: turn until A is well in view, then back away slowly."""
    return _scatter(screen, slack_px=0.0)


def complain_scatter(screen: SessionView) -> str | None:
    """Return the state to correct Scatter(A) to, or None: where it turns past A or lets A leave the frame."""
    return _scatter(screen, slack_px=20.0, edge_px=5.0)


def complain_live_scatter(screen: SessionView) -> str | None:
    """Return the state to direct Scatter(A) to in live teaching, or None: where it nearly loses A again."""
    return _scatter(screen, slack_px=90.0, edge_px=5.0)


def accept_scatter(screen: SessionView, proposed: str) -> bool:
    """Return whether Scatter(A) may go to a state: to back away from an A that is visible anywhere in the frame."""
    return proposed == "back" and not isnan(blob_x(screen))


def _scatter(screen: SessionView, *, slack_px: float, edge_px: float = 25.0) -> str | None:
    x, state = blob_x(screen), screen.state
    if isnan(x):
        return None if state in ("left", "right") else "left"
    if state == "start":
        return "left" if x < MIDDLE_PX else "right"
    if state == "left":
        return "back" if x > EMERGED_PX + slack_px else None
    if state == "right":
        return "back" if x < WIDTH_PX - EMERGED_PX - slack_px else None
    aside = not edge_px <= x <= WIDTH_PX - edge_px
    return ("left" if x < MIDDLE_PX else "right") if aside else None


def _boss(side: int) -> Seen:
    """Return a predicate: the boss is in the left (-1) or right (1) part of the frame, or not visible (0)."""

    def suits(screen: SessionView) -> bool:
        x = blob_x(screen)
        return isnan(x) if side == 0 else side * (x - MIDDLE_PX) > 30.0

    return suits


BOSS = {"A": "boss"}

SCATTER = LessonPlan(
    "scatter",
    LessonDesign(parameters=["A"], states=["left", "right", "back=back_slowly"], features=["blob_x(A)"]),
    show_scatter,
    complain_scatter,
    after(20.0),
    cases=(
        Situation("the boss", BOSS, _boss(-1), after(8.0), push=PushAway("back", "left", 0.8, within_s=8.0)),
        Situation("the boss", BOSS, _boss(1), after(8.0), push=PushAway("back", "right", 0.8, within_s=8.0)),
        Situation("the boss", BOSS, _boss(0), after(12.0)),
    ),
    tries=4,
    limit_s=60.0,
    patience_s=60.0,
    complain_live=complain_live_scatter,
    accepts=accept_scatter,
)


# RunAway: scatter from the boss, stop at what is behind.


def show_run_away(screen: SessionView) -> str | None:
    """Return the next state of RunAway: scatter from the boss; while facing him, stop if something is close behind."""
    return _run_away(screen, edge_px=20.0, behind=BEHIND_M, room=ROOM_M)


def complain_run_away(screen: SessionView) -> str | None:
    """Return the state to correct RunAway to, or None.

    Corrected are: backing into something, and standing still with room behind or without facing the boss.
    """
    return _run_away(screen, edge_px=12.0, behind=0.25, room=1.6)


def complain_live_run_away(screen: SessionView) -> str | None:
    """Return the state to direct RunAway to in live teaching, or None: as in a test, but farther from what is behind.

    It is confirmed that a robot which does not face the boss yet goes on turning, however close something is.
    """
    return _run_away(screen, edge_px=12.0, behind=CLOSE_BEHIND_M, room=1.6)


def _run_away(screen: SessionView, *, edge_px: float, behind: float, room: float) -> str | None:
    x, rear = screen.features["blob_x(boss)"], screen.features["sonar_rear"]
    facing = edge_px <= x <= WIDTH_PX - edge_px
    if screen.state == "start":
        return "scatter"
    if screen.state == "stop":
        return "scatter" if not facing or rear > room else None
    if rear < behind:
        return "stop" if facing else KEEP
    return None


def _stood(screen: SessionView) -> bool:
    return screen.state == "stop" and screen.time_s > 12.0


RUN_AWAY = LessonPlan(
    "run_away",
    LessonDesign(states=["scatter=scatter(boss)", "stop"], features=["blob_x(boss)", "sonar_rear"]),
    show_run_away,
    complain_run_away,
    after(40.0),
    cases=(
        Situation(
            "the boss on the left, a wall behind", enough=_stood, push=PushAway("stop", "forwards", 2.0)
        ),
        Situation("the boss on the right, a wall behind", enough=_stood, push=PushAway("stop", "left", 1.5)),
        Situation("the boss aside, a wall behind", enough=after(10.0)),
        Situation("the boss"),
    ),
    shown=3,
    tries=4,
    limit_s=60.0,
    patience_s=60.0,
    complain_live=complain_live_run_away,
)


# Patrol: all this alone, without a coordinator.


def show_patrol(screen: SessionView) -> str | None:
    """Return the next state of Patrol, or None: disperse, attack a visible intruder, go home, and disperse again."""
    seen = screen.features
    if screen.state == "start":
        return "disperse"
    if screen.state == "disperse":
        return None if isnan(seen["blob_size(intruder)"]) else "attack"
    if seen["done"] != YES:
        return None
    return "home" if screen.state == "attack" else "disperse"


PATROL = LessonPlan(
    "patrol",
    LessonDesign(
        states=["disperse", "attack=attack(intruder)", "home=attack(home)"],
        features=["done", "blob_size(intruder)"],
    ),
    show_patrol,
    show_patrol,
    after(150.0),
    cases=(Situation("on patrol", enough=after(90.0)),),
    tries=2,
    limit_s=200.0,
    patience_s=100.0,
    skips_after=0,
)

TOPICS = (DISPERSE, LOOK_LEFT, LOOK_RIGHT, WITHDRAW, SERVO, ATTACK, SCATTER, RUN_AWAY, PATROL)
