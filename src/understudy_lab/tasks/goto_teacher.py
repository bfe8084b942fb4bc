"""The rule by which teachers show GoTo(A) and correct it: turn to A, drive to it, raise `done`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan, pi

from understudy.training.trainee import SessionView
from understudy_lab.teachers.person import Seen, find_bearing
from understudy_lab.teachers.teacher import LessonDesign, PushAway, Situation

DESIGN = LessonDesign(
    parameters=["A"],
    states=["forward", "rotate_left", "rotate_right"],
    flags=["done"],
    features=["distance_to(A)", "angle_to(A)"],
)
FACING = 0.12
"""The bearing that is as good as facing A while turning, rad."""


def find_angle_ahead(screen: SessionView) -> float:
    """Return the angle in rad that a robot still has to turn to A; negative when it has turned too far."""
    return -find_bearing(screen) if screen.state == "rotate_right" else find_bearing(screen)


def is_beside(side: int, nearest: float, farthest: float) -> Seen:
    """Return a predicate: A is to the left (1) or right (-1), at a distance between `nearest` and `farthest` (m)."""

    def suits(screen: SessionView) -> bool:
        distance = screen.features["distance_to(A)"]
        return 0.8 < side * find_bearing(screen) < 2.6 and nearest < distance < farthest

    return suits


def choose_turn(screen: SessionView) -> str:
    """Return the turn to the side on which A is."""
    return "rotate_left" if find_bearing(screen) > 0 else "rotate_right"


@dataclass(frozen=True)
class GotoRule:
    """The distances (m) and bearings (rad) by which a teacher judges GoTo(A)."""

    there_m: float
    """The distance that the teacher calls being there."""
    not_there_m: float
    """The distance that is not being there yet."""
    past_m: float
    """The distance at which `done` should long have been raised."""
    astray: float
    """The bearing at which a robot plainly drives past A."""
    faced_away: float
    """The bearing at which a robot does not face A."""

    def show(self, screen: SessionView) -> str | None:
        """Return the next state of a demonstration, or None."""
        distance, drives = screen.features["distance_to(A)"], screen.state in ("start", "forward")
        if screen.state == "done" or isnan(distance):
            return None
        if distance < self.there_m:
            return "done"
        if drives and abs(find_bearing(screen)) > self.astray:
            return choose_turn(screen)
        turned = not drives and find_angle_ahead(screen) < FACING
        return "forward" if screen.state == "start" or turned else None

    def complain(self, screen: SessionView) -> str | None:
        """Return the state to correct to, or None where the behavior is acceptable.

        Corrected are: idling, driving past A, turning on past it, not stopping, and stopping too far away.
        """
        distance, astray = screen.features["distance_to(A)"], abs(find_bearing(screen))
        if isnan(distance):
            return None
        if screen.state == "start":
            return self.show(screen)
        if screen.state == "done":
            if distance < self.not_there_m:
                return None
            return choose_turn(screen) if astray > self.faced_away else "forward"
        if distance < self.past_m:
            return "done"
        if screen.state == "forward":
            return choose_turn(screen) if astray > 1.5 * self.astray else None
        return "forward" if -pi / 2 < find_angle_ahead(screen) < -self.astray else None

    def list_cases(
        self,
        practices: tuple[str, str],
        targets: Sequence[str],
        near_m: tuple[float, float],
        far_m: tuple[float, float],
    ) -> tuple[Situation, ...]:
        """List the situations to show, near in the first practice and far in the second, with targets in turn.

        Each side is shown once near and once far, so that only the side can tell which way to turn; and the robot is
        pushed off its way to either side while driving, which seldom happens by itself.
        """

        def is_on_its_way(screen: SessionView) -> bool:
            return screen.state == "forward" and abs(find_bearing(screen)) < self.astray

        sides = (1, -1, -1, 1)
        pushes = (None, None, *(PushAway("forward", turn, 0.8) for turn in ("rotate_right", "rotate_left")))
        return tuple(
            Situation(practices[0], {"A": target}, is_beside(side, *near_m))
            if push is None
            else Situation(practices[1], {"A": target}, is_beside(side, *far_m), is_on_its_way, push=push)
            for target, side, push in zip(targets, sides, pushes, strict=True)
        )
