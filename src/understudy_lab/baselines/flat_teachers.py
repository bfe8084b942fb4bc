"""Rules by which a simulated person demonstrates a whole task with basic behaviors only."""

from __future__ import annotations

from math import isnan, pi, tau

from understudy.model.value_kinds import YES
from understudy.training.trainee import SessionView
from understudy_lab.behavior_suite.wall_following import AHEAD, LEFT, choose_wall_action
from understudy_lab.tasks.forage_teacher import ASTRAY, CAPACITY, all_home
from understudy_lab.tasks.goto_teacher import FACING
from understudy_lab.tasks.servo_teacher import (
    BASIC_STATES,
    EMERGED_PX,
    FEATURES,
    MIDDLE_PX,
    OTHER_PX,
    blob_x,
    there,
)
from understudy_lab.teachers.person import after
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan

FOLLOWING = ("forward", "rotate_right", "veer_left")
"""The basic behaviors of a robot that follows a wall on its left."""
ASIDE = 0.3
"""The bearing from which a standing robot turns before it drives, rad."""


def show_foraging(screen: SessionView) -> str | None:
    """Return the next behavior, or None: turn to food, drive, load; when full or no food is left, go to the station."""
    features, state = screen.features, screen.state
    stored, left = features["food_stored"], features["food_left"] == YES
    if state == "unload_food" and stored > 0 and features["at_station"] == YES:
        return None
    if stored >= CAPACITY or (stored > 0 and not left):
        return (
            "unload_food" if features["at_station"] == YES else head_for(features["angle_to(station)"], state)
        )
    if not left:
        return None
    return (
        "load_food" if features["food_below_me"] > 0 else head_for(features["angle_to(nearest_food)"], state)
    )


def head_for(bearing: float, state: str) -> str | None:
    """Return the next behavior: turn until it faces the bearing (rad), drive, turn again when clearly off."""
    bearing = (bearing + pi) % tau - pi
    toward = "rotate_left" if bearing > 0 else "rotate_right"
    if state.startswith("rotate"):
        ahead = -bearing if state == "rotate_right" else bearing
        return "forward" if ahead < FACING else None
    return toward if abs(bearing) > (ASTRAY if state == "forward" else ASIDE) else "forward"


FLAT_FORAGE = LessonPlan(
    "forage_flat",
    LessonDesign(
        states=["forward", "rotate_left", "rotate_right", "load_food", "unload_food"],
        features=[
            "angle_to(nearest_food)",
            "angle_to(station)",
            "food_below_me",
            "food_stored",
            "food_left",
            "at_station",
        ],
    ),
    show_foraging,
    show_foraging,
    all_home,
    cases=(),
    tries=0,
    limit_s=600.0,
)


class FlatServo:
    """The rule of finding the ball and walking to it; a lost ball is searched on the side where it was last seen."""

    def __init__(self, search: str = "left") -> None:
        self._search = self._side = search

    def __call__(self, screen: SessionView) -> str | None:
        """Return the basic behavior that the robot should run, or None where the current one is right."""
        x, turning = blob_x(screen), screen.state.startswith("turn")
        if screen.state == "start":
            self._side = self._search
        if isnan(x):
            return None if turning else f"turn_{self._side}"
        if abs(x - MIDDLE_PX) > OTHER_PX:
            self._side = "left" if x < MIDDLE_PX else "right"
        inside = EMERGED_PX < x < 2 * MIDDLE_PX - EMERGED_PX
        return "walk_forward" if inside or not turning else None


class FlatWallFollower:
    """The rule of wall following: drive to a wall, go along it, turn off at a wall ahead, veer to a far one."""

    def __init__(self, hand: str) -> None:
        self._hand, self._seeking = hand, True

    def __call__(self, screen: SessionView) -> str | None:
        """Return the basic behavior that the robot should run, or None where the current one is right."""
        if screen.state == "start":
            self._seeking = True
        doing = {"forward": "seek" if self._seeking else "along"}.get(screen.state, screen.state)
        wished = choose_wall_action(
            doing, screen.features[AHEAD], screen.features[f"sonar_{self._hand}"], self._hand
        )
        if wished is not None:
            self._seeking = wished == "seek"
        return "forward" if wished in ("seek", "along") else wished


FLAT_WALLS = LessonPlan(
    "walls_flat",
    LessonDesign(states=FOLLOWING, features=[AHEAD, f"sonar_{LEFT}"]),
    FlatWallFollower(LEFT),
    FlatWallFollower(LEFT),
    after(40.0),
    cases=(),
    tries=0,
    limit_s=60.0,
)

FLAT_SERVOING = LessonPlan(
    "servoing_flat",
    LessonDesign(states=BASIC_STATES, features=FEATURES),
    FlatServo(),
    FlatServo(),
    there,
    cases=(),
    tries=0,
    limit_s=60.0,
)
