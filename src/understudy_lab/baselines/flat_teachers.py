"""How a person shows a whole task with basic behaviors alone, without automata in between."""

from __future__ import annotations

from math import isnan, pi, tau

from understudy.model.kinds import YES
from understudy.training.lesson_design import new_lesson
from understudy.training.trainee import SessionView
from understudy_lab.behavior_suite.wall_following import AHEAD, LEFT, choose_wall_action
from understudy_lab.tasks.forage_teacher import ASTRAY, CAPACITY, FACING, all_home
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
from understudy_lab.teachers.teacher import LessonPlan

FOLLOWING = ("forward", "rotate_right", "veer_left")
"""The basic behaviors of a robot with its left hand on the wall."""
ASIDE = 0.3
"""From here on, standing, they would turn before they drive, rad."""


def show_foraging(screen: SessionView) -> str | None:
    """Turn to food, drive there, load; when full, or when no food is left, the same with the station."""
    seen, state = screen.features, screen.state
    stored, left = seen["food_stored"], seen["food_left"] == YES
    if state == "unload_food" and stored > 0 and seen["at_station"] == YES:
        return None
    if stored >= CAPACITY or (stored > 0 and not left):
        return "unload_food" if seen["at_station"] == YES else head_for(seen["angle_to(station)"], state)
    if not left:
        return None
    return "load_food" if seen["food_below_me"] > 0 else head_for(seen["angle_to(nearest_food)"], state)


def head_for(bearing: float, state: str) -> str | None:
    """Turn until it faces that way, then drive, and turn again only when it is plainly off."""
    bearing = (bearing + pi) % tau - pi
    toward = "rotate_left" if bearing > 0 else "rotate_right"
    if state.startswith("rotate"):
        ahead = -bearing if state == "rotate_right" else bearing
        return "forward" if ahead < FACING else None
    return toward if abs(bearing) > (ASTRAY if state == "forward" else ASIDE) else "forward"


FLAT_FORAGE = LessonPlan(
    "forage_flat",
    lambda library: new_lesson(
        library,
        "forage_flat",
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
    """Find the ball, walk to it, and where it is lost turn to the side where it was last seen."""

    def __init__(self, search: str = "left") -> None:
        self._search = self._side = search

    def __call__(self, screen: SessionView) -> str | None:
        """The basic behavior it would rather have the robot do."""
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
    """Go on until a wall is on the hand, along it, turn off where it ends ahead, and veer to it where it is far."""

    def __init__(self, hand: str) -> None:
        self._hand, self._seeking = hand, True

    def __call__(self, screen: SessionView) -> str | None:
        """The basic behavior it would rather have the robot do."""
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
    lambda library: new_lesson(library, "walls_flat", states=FOLLOWING, features=[AHEAD, f"sonar_{LEFT}"]),
    FlatWallFollower(LEFT),
    FlatWallFollower(LEFT),
    after(40.0),
    cases=(),
    tries=0,
    limit_s=60.0,
)

FLAT_SERVOING = LessonPlan(
    "servoing_flat",
    lambda library: new_lesson(library, "servoing_flat", states=BASIC_STATES, features=FEATURES),
    FlatServo(),
    FlatServo(),
    there,
    cases=(),
    tries=0,
    limit_s=60.0,
)
