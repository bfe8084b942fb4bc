"""The simulated teacher of foraging: GoTo(A), Harvest, Deposit, Forage (paper section 4.1)."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isnan
from types import MappingProxyType

from understudy.model.learner_options import LearnerOptions
from understudy.model.value_kinds import NO, YES
from understudy.training.trainee import SessionView
from understudy_lab.tasks.goto_teacher import DESIGN, GotoRule, choose_turn, find_angle_ahead
from understudy_lab.teachers.person import find_bearing, has_raised_flag
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, PushAway, Situation

WATCHED: Mapping[str, LearnerOptions] = MappingProxyType(
    {
        "goto": LearnerOptions(watched=True, reaction_s=0.2),  # a lesson about motion: presses come late
        "harvest": LearnerOptions(watched=True),
        "deposit": LearnerOptions(watched=True),
        "forage": LearnerOptions(watched=True),
    }
)
"""The learning options that the demo uses, by lesson."""

PLAIN: Mapping[str, LearnerOptions] = MappingProxyType({name: LearnerOptions() for name in WATCHED})
"""The paper's method: neither examples recorded while watching nor a reaction time."""

THERE_M = 0.38  # what a person calls being there
NOT_THERE_M = 0.47  # what they call not being there yet
PAST_M = 0.2  # where it should long have said so
ASTRAY = 0.6  # rad: driving past it, plainly
FACED_AWAY = 0.45  # rad: not facing it
NEARLY_FACING = 0.25  # rad: turning and driving are both right
WRONG_WAY, LONG_WAY = (
    1.0,
    2.6,
)  # rad: A is behind a turn in the wrong direction from here on, and nearly ahead of it
AWAY_M = 0.1  # this much farther from A than before, it drives away
FAR_M = 1.0  # where it should drive straight at it


RULE = GotoRule(THERE_M, NOT_THERE_M, PAST_M, ASTRAY, FACED_AWAY)


def complain_live_goto(screen: SessionView) -> str | None:
    """Return the state to direct GoTo(A) to while it is taught live, or None where its behavior is acceptable.

    Corrected are, too: turning the long way round, and driving on while far from A and not facing it.
    """
    distance, bearing, ahead = (
        screen.features["distance_to(A)"],
        find_bearing(screen),
        find_angle_ahead(screen),
    )
    turning = screen.state in ("rotate_left", "rotate_right")
    if turning and distance >= PAST_M and -LONG_WAY < ahead < -FACED_AWAY:
        return choose_turn(screen) if ahead < -WRONG_WAY else "forward"
    if screen.state == "forward" and distance > FAR_M and abs(bearing) > ASTRAY:
        return choose_turn(screen)
    return RULE.complain(screen)


def accept_goto(screen: SessionView, state: str) -> bool:
    """Return whether GoTo(A) may go to a state now: turn to A, or drive at it, or stop near it."""
    distance, bearing = screen.features["distance_to(A)"], find_bearing(screen)
    if state == "done" or distance < THERE_M:
        return state == "done" and distance < NOT_THERE_M
    if state == "forward":
        return abs(bearing) < NEARLY_FACING or (screen.state == "forward" and abs(bearing) < FACED_AWAY)
    return state == choose_turn(screen) and abs(bearing) > NEARLY_FACING


def take_back_goto(screen: SessionView, before: str) -> bool:
    """Return whether GoTo(A) has plainly stopped turning too early, far from A."""
    if screen.state != "forward" or before not in ("rotate_left", "rotate_right"):
        return False
    left = find_bearing(screen) if before == "rotate_left" else -find_bearing(screen)
    return screen.features["distance_to(A)"] > FAR_M and NEARLY_FACING < left < ASTRAY


def settle_goto(screen: SessionView) -> str | None:
    """Return the state that a robot which switches back and forth should be in."""
    distance, bearing = screen.features["distance_to(A)"], find_bearing(screen)
    if isnan(distance):
        return None
    if distance < THERE_M:
        return "done"
    return choose_turn(screen) if abs(bearing) > ASTRAY else "forward"


class DrivesAway:
    """A property: the robot drives, and is farther from A than it was before. It holds once for each time."""

    def __init__(self) -> None:
        self._least_m = inf

    def __call__(self, screen: SessionView) -> bool:
        """Return whether the robot has begun to drive away from A."""
        distance = screen.features["distance_to(A)"]
        away = screen.state == "forward" and distance > self._least_m + AWAY_M
        self._least_m = distance if away else min(self._least_m, distance)
        return away


GOTO = LessonPlan(
    "goto",
    DESIGN,
    RULE.show,
    RULE.complain,
    has_raised_flag,
    cases=RULE.list_cases(
        ("a small room", "an arena"), ("station", "nearest_food") * 2, (0.9, 1.8), (3.2, 5.5)
    ),
    tries=8,
    limit_s=60.0,
    complain_live=complain_live_goto,
    settle=settle_goto,
    accepts=accept_goto,
    takes_back=take_back_goto,
    fidgets=16,
    skips_after=2,
    make_alarm=DrivesAway,
)


def _full(screen: SessionView) -> bool:
    return screen.features["food_stored"] >= CAPACITY


CAPACITY = 12
"""Largest number of food units that the robot can carry."""


def show_harvest(screen: SessionView) -> str | None:
    """Return the next state while demonstrating Harvest, or None for no change.

    The robot goes to food and loads it, goes on to other food when that source is empty, and is done when it is full or
    no food is left.
    """
    if screen.state == "done":
        return None
    if _full(screen) or screen.features["food_left"] == NO:
        return "done"
    if screen.state == "start":
        return "goto"
    if screen.state == "goto":
        return "load_food" if screen.features["done"] == YES else None
    return "goto" if screen.features["food_below_me"] == 0 else None


def complain_harvest(screen: SessionView) -> str | None:
    """Return the state to correct Harvest to, or None: as demonstrated, and where `done` is raised too early."""
    if screen.state != "done":
        return show_harvest(screen)
    if _full(screen) or screen.features["food_left"] == NO:
        return None
    return "goto" if screen.features["food_below_me"] == 0 else "load_food"


def settle_harvest(screen: SessionView) -> str | None:
    """Return the state that a robot which switches back and forth should be in."""
    if _full(screen) or screen.features["food_left"] == NO:
        return "done"
    return "goto" if screen.features["food_below_me"] == 0 else "load_food"


HARVEST = LessonPlan(
    "harvest",
    LessonDesign(
        states=["goto(nearest_food)", "load_food"],
        flags=["done"],
        features=["done", "food_left", "food_stored", "food_below_me"],
    ),
    show_harvest,
    complain_harvest,
    has_raised_flag,
    cases=(Situation("little food in many places", again=True), Situation("the last food")),
    tries=4,
    limit_s=120.0,
    settle=settle_harvest,
    skips_after=0,
)


def show_deposit(screen: SessionView) -> str | None:
    """Return the next state of Deposit, or None: go to the station, unload, be done when nothing is left to unload."""
    if screen.state == "done":
        return None
    if screen.features["food_stored"] == 0:
        return "done"
    if screen.state == "start":
        return "goto"
    if screen.state == "goto":
        return "unload_food" if screen.features["done"] == YES else None
    return "goto" if screen.features["at_station"] == NO else None


def _on_its_way(screen: SessionView) -> bool:
    return screen.state == "goto"


def settle_deposit(screen: SessionView) -> str | None:
    """Return the state that a robot which switches back and forth should be in."""
    if screen.features["food_stored"] == 0:
        return "done"
    return "goto" if screen.features["at_station"] == NO else "unload_food"


DEPOSIT = LessonPlan(
    "deposit",
    LessonDesign(
        states=["goto(station)", "unload_food"],
        flags=["done"],
        features=["done", "food_stored", "at_station"],
    ),
    show_deposit,
    show_deposit,
    has_raised_flag,
    cases=(
        Situation("one unit to deposit"),
        Situation("some food to deposit", push=PushAway("unload_food", "forward", 3.0), enough=_on_its_way),
    ),
    tries=3,
    limit_s=120.0,
    settle=settle_deposit,
    skips_after=0,
)


def show_forage(screen: SessionView) -> str | None:
    """Return the next state of Forage, or None: alternate between Harvest and Deposit while there is food."""
    if screen.state == "start":
        return "harvest"
    if screen.features["done"] == NO:
        return None
    if screen.state == "harvest":
        return "deposit"
    return "harvest" if screen.features["food_left"] == YES else None


def all_home(screen: SessionView) -> bool:
    """Return whether no food is left outside the station."""
    return screen.features["food_left"] == NO and screen.features["food_stored"] == 0


FORAGE = LessonPlan(
    "forage",
    LessonDesign(states=["harvest", "deposit"], features=["done", "food_stored", "food_left"]),
    show_forage,
    show_forage,
    all_home,
    cases=(Situation("food for two ways"),),
    tries=1,
    limit_s=400.0,
    skips_after=0,
)

TOPICS = (GOTO, HARVEST, DEPOSIT, FORAGE)
