"""The simulated teacher of visual servoing: find the ball, turn to it, walk up to it (paper section 4.2).

There are three variants: the paper's four states, a stateless policy that turns only while the ball is lost, and one
that also turns while the ball is near the edge of the frame. All use the same two features: the ball's x in the frame
and its number of pixels.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isnan
from types import MappingProxyType

from understudy.model.lesson import Lesson
from understudy.model.library import Library
from understudy.training.trainee import SessionView
from understudy_lab.teachers.person import Wish
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, PushAway, Situation

FEATURES = ("blob_x(ball)", "blob_size(ball)")
FOUR_STATES = ("left=turn_left", "right=turn_right", "forwardL=walk_forward", "forwardR=walk_forward")
BASIC_STATES = ("turn_left", "turn_right", "walk_forward")

MIDDLE_PX = 80.0
EMERGED_PX = 20.0  # so far from the edge the ball has come into the frame, while turning
OTHER_PX = 15.0  # so far beyond the middle it is plainly in the other part of the frame
EDGE_PX = 30.0  # so far from the edge it is near it
THERE_PX = 4500.0  # as large as it is 15 cm away


def blob_x(screen: SessionView) -> float:
    """Return the horizontal position of the ball in the frame, px; NaN where it is not visible."""
    return screen.features["blob_x(ball)"]


def there(screen: SessionView) -> bool:
    """Return whether the ball looks as large as at a distance of 15 cm."""
    return screen.features["blob_size(ball)"] >= THERE_PX


@dataclass(frozen=True, slots=True)
class StatefulServoTeacher:
    """The rule for four states: `forwardL` and `forwardR` store the side of the ball, and `search` is the first turn.

    `patience_px` widens the thresholds; it is 0 for demonstrations and larger for corrections.
    """

    search: str = "left"
    patience_px: float = 0.0

    def __call__(self, screen: SessionView) -> str | None:
        """Return the state that the robot should be in, or None where the current one is right."""
        x, state = blob_x(screen), screen.state
        if isnan(x):
            return {"start": self.search, "forwardL": "left", "forwardR": "right"}.get(state)
        side = "forwardL" if x < MIDDLE_PX else "forwardR"
        if state in ("left", "right"):
            inside = EMERGED_PX + self.patience_px
            return side if inside < x < 2 * MIDDLE_PX - inside else None
        if state == "start" or abs(x - MIDDLE_PX) > OTHER_PX + self.patience_px:
            return side
        return None


@dataclass(frozen=True, slots=True)
class StatelessServoTeacher:
    """The rule for a stateless policy: walk while the ball is visible, turn to the side `search` while it is not.

    With `edge_px` above 0 the robot also turns while the ball is closer than that to the edge, until it is well inside.
    """

    search: str = "left"
    edge_px: float = 0.0
    patience_px: float = 0.0

    def __call__(self, screen: SessionView) -> str | None:
        """Return the state that the robot should be in, or None where the current one is right."""
        x, state = blob_x(screen), screen.state
        if isnan(x):
            return f"turn_{self.search}"
        edge = max(0.0, self.edge_px - self.patience_px)
        if self.edge_px and not edge <= x <= 2 * MIDDLE_PX - edge:
            return "turn_left" if x < MIDDLE_PX else "turn_right"
        if state in ("turn_left", "turn_right"):
            inside = self.edge_px + EMERGED_PX + self.patience_px
            return "walk_forward" if inside < x < 2 * MIDDLE_PX - inside else None
        return "walk_forward"


@dataclass(frozen=True, slots=True)
class ApproachAndStopTeacher:
    """The rule for approaching by the rule `approach` and stopping at the ball, in one automaton with a flag `done`.

    The robot is corrected when it has stopped while the ball looks smaller than `too_early_px` pixels.
    """

    approach: Wish
    too_early_px: float = 0.6 * THERE_PX

    def __call__(self, screen: SessionView) -> str | None:
        """Return the state that the robot should be in, or None where the current one is right."""
        size = screen.features["blob_size(ball)"]
        if screen.state == "done":
            seen_small = size < self.too_early_px
            return ("forwardL" if blob_x(screen) < MIDDLE_PX else "forwardR") if seen_small else None
        return "done" if size >= THERE_PX else self.approach(screen)


def show_approach_then_stop(screen: SessionView) -> str | None:
    """Return the state of a two-layer solution: run the learned `approach` until the ball is large, then `done`."""
    size = screen.features["blob_size(ball)"]
    if screen.state == "done":
        return "approach" if size < 0.6 * THERE_PX else None
    return "done" if size >= THERE_PX else "approach"


def four_states(library: Library, name: str = "approach") -> Lesson:
    """Return an empty lesson with the paper's four states."""
    return STATEFUL.make_lesson(library, name)


STATEFUL = LessonDesign(FOUR_STATES, FEATURES)
STATELESS = LessonDesign(BASIC_STATES, FEATURES, stateless=True)


def _left(screen: SessionView) -> bool:
    return blob_x(screen) < MIDDLE_PX - 50.0


def _right(screen: SessionView) -> bool:
    return blob_x(screen) > MIDDLE_PX + 50.0


def _lost(screen: SessionView) -> bool:
    return isnan(blob_x(screen))


def topic(show: Wish, complain: Wish, *, stateful: bool, tries: int = 3, limit_s: float = 60.0) -> LessonPlan:
    """Return the plan of a lesson in approaching the ball.

    It practices with the ball left, right and lost, and with pushes to either side while the robot walks.
    """
    forward = ("forwardL", "forwardR") if stateful else ("walk_forward", "walk_forward")
    return LessonPlan(
        "approach",
        STATEFUL if stateful else STATELESS,
        show,
        complain,
        there,
        cases=(
            Situation(ANYWHERE, suits=_left),
            Situation(ANYWHERE, suits=_right),
            Situation(ANYWHERE, suits=_lost),
            Situation(ANYWHERE, suits=_right, push=PushAway(forward[1], "turn_right", PUSH_S)),
            Situation(ANYWHERE, suits=_left, push=PushAway(forward[0], "turn_left", PUSH_S)),
        ),
        tries=tries,
        limit_s=limit_s,
    )


ANYWHERE = "anywhere"
"""The name of the practice in which the ball is anywhere around the robot."""
PUSH_S = 1.3
SIDES = ("left", "right")


def topics(search: str) -> Mapping[str, LessonPlan]:
    """Return the three variants of approaching, by name, for a teacher whose first turn is to the side `search`."""
    return MappingProxyType(
        {
            "four states": topic(
                StatefulServoTeacher(search), StatefulServoTeacher(search, 15.0), stateful=True
            ),
            "stateless, turns when lost": topic(
                StatelessServoTeacher(search), StatelessServoTeacher(search, 0.0, 15.0), stateful=False
            ),
            "stateless, turns at edges": topic(
                StatelessServoTeacher(search, EDGE_PX),
                StatelessServoTeacher(search, EDGE_PX, 15.0),
                stateful=False,
            ),
        }
    )
