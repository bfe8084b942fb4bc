"""Lesson plans for foraging in three layers, two, or one, taught by a person who knows the task.

With two layers, GoTo is taught first and the rest is one automaton that runs it. With one layer, everything is one
automaton of basic behaviors, with a state for each step on the way to food and on the way home. These states are a hint
at the solution; the variant "told nothing" has one state for each basic behavior instead.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isnan, pi, tau
from types import MappingProxyType

from understudy.model.learner_options import LearnerOptions
from understudy.model.value_kinds import NO, YES
from understudy.training.trainee import SessionView
from understudy_lab.tasks.forage_teacher import ASTRAY, CAPACITY, DEPOSIT, FORAGE, GOTO, HARVEST, all_home
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, Situation

NEARLY_FACING = 0.35
"""rad: who knows that they react late presses that much before the robot faces where it has to go."""
TRIES = 6
"""The number of successful tries of the whole task in a row after which the person is content."""


def should_go_home(screen: SessionView) -> bool:
    """Return whether to go home: full, nothing left to fetch, or on the way home and not empty yet."""
    stored, left = screen.features["food_stored"], screen.features["food_left"]
    on_its_way = screen.state.endswith("home") or screen.state == "unload_food"
    return stored >= CAPACITY or (stored > 0 and (left == NO or on_its_way))


def show_two_layers(screen: SessionView) -> str | None:
    """Return the next state, or None: go to food and load, go home and unload."""
    seen, state = screen.features, screen.state
    if all_home(screen):
        return None
    if should_go_home(screen):
        if state == "unload_food":
            return "go_home" if seen["at_station"] == NO else None
        return "unload_food" if state == "go_home" and seen["done"] == YES else _other(state, "go_home")
    if state == "load_food":
        return None if seen["food_below_me"] > 0 else "go_to_food"
    return "load_food" if state == "go_to_food" and seen["done"] == YES else _other(state, "go_to_food")


def _other(state: str, wanted: str) -> str | None:
    return None if state == wanted else wanted


@dataclass(frozen=True, slots=True)
class OneLayer:
    """The rule for one layer: turn, drive, load; turn, drive, unload; states are separate by target or `shared`.

    `patience` multiplies the angle by which the robot has to be off before it is corrected.
    """

    patience: float = 1.0
    shared: bool = False

    def __call__(self, screen: SessionView) -> str | None:
        """Return the state that the robot should be in, or None where the current one is right."""
        seen, state = screen.features, screen.state
        if all_home(screen):
            return None
        if should_go_home(screen):
            if seen["at_station"] == YES:
                return _other(state, "unload_food")
            return self._drive(state, seen["angle_to(station)"], "home")
        if seen["food_below_me"] > 0:
            return _other(state, "load_food")
        return self._drive(state, seen["angle_to(nearest_food)"], "food")

    def _drive(self, state: str, angle: float, where: str) -> str | None:
        if isnan(angle):
            return None
        bearing = (angle + pi) % tau - pi  # left positive
        forward, left, right = MOVES if self.shared else (f"{move}_{where}" for move in MOVES)
        toward = left if bearing > 0 else right
        if state == forward:
            return toward if abs(bearing) > self.patience * ASTRAY else None
        if state in (left, right):
            ahead = bearing if state == left else -bearing
            facing = NEARLY_FACING if self.patience == 1.0 else -ASTRAY
            return forward if -pi / 2 < ahead < facing else None
        return toward if abs(bearing) > ASTRAY else forward


MOVES: Mapping[str, str] = MappingProxyType(
    {"forward": "forward", "left": "rotate_left", "right": "rotate_right"}
)
"""The basic behaviors for driving, by short name."""


CASES = (Situation("little food in many places"), Situation("the last food"), Situation("food for two ways"))


def _lean(topic: LessonPlan, *, shown: int, tries: int) -> LessonPlan:
    """Return the plan with fewer demonstrations and tries and no pushes; higher layers reveal what is still wrong."""
    cases = tuple(replace(case, push=None, again=False) for case in topic.cases)
    return replace(topic, cases=cases, shown=shown, tries=tries)


LEAN_GOTO = _lean(GOTO, shown=2, tries=4)

TWO_LAYERS = LessonPlan(
    "forage",
    LessonDesign(
        states=["go_to_food=goto(nearest_food)", "load_food", "go_home=goto(station)", "unload_food"],
        features=["done", "food_left", "food_stored", "food_below_me", "at_station"],
    ),
    show_two_layers,
    show_two_layers,
    all_home,
    cases=CASES,
    tries=TRIES,
    limit_s=400.0,
)


def _unloading(screen: SessionView) -> bool:
    return screen.state == "unload_food"


BOTH_WAYS, ARENA = CASES[2], Situation("an arena", enough=_unloading)
READINGS = (
    "food_left",
    "food_stored",
    "food_below_me",
    "at_station",
    "distance_to(nearest_food)",
    "angle_to(nearest_food)",
    "distance_to(station)",
    "angle_to(station)",
)
NEEDED = tuple(reading for reading in READINGS if not reading.startswith("distance_to"))
"""The features needed to forage with basic behaviors; arrival is visible without distances."""


def _one_layer(moves: Sequence[str], features: Sequence[str], *, shared: bool) -> LessonPlan:
    return LessonPlan(
        "forage",
        LessonDesign(states=[*moves, "load_food", "unload_food"], features=features),
        OneLayer(shared=shared),
        OneLayer(1.5, shared=shared),
        all_home,
        cases=(*CASES, ARENA),
        tries=TRIES + 2,  # each practice twice
        limit_s=900.0,
    )


ONE_LAYER = replace(
    _one_layer(
        [f"{move}_{where}={basic}" for where in ("food", "home") for move, basic in MOVES.items()],
        NEEDED,
        shared=False,
    ),
    cases=(BOTH_WAYS, ARENA, *CASES[:2]),
    shown=1,
)
TOLD_NOTHING = _one_layer(
    [f"{move}={basic}" for move, basic in MOVES.items()],
    READINGS,
    shared=True,
)

LAYERS: Mapping[str, tuple[LessonPlan, ...]] = MappingProxyType(
    {
        "three layers": (
            LEAN_GOTO,
            _lean(HARVEST, shown=2, tries=1),
            _lean(DEPOSIT, shown=1, tries=1),
            replace(FORAGE, tries=TRIES),
        ),
        "two layers": (LEAN_GOTO, TWO_LAYERS),
        "one layer": (ONE_LAYER,),
        "one layer, told nothing": (TOLD_NOTHING,),
    }
)
OPTIONS: Mapping[str, LearnerOptions] = MappingProxyType({"goto": LearnerOptions(reaction_s=0.2)})
"""The paper's method, without watched examples; a lesson about motion says how late presses come."""
