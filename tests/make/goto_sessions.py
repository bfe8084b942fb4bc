"""Lessons of a robot that finds a target: written by hand, and how to make them."""

from __future__ import annotations

from math import nan, radians
from typing import Any, TypeAlias

from understudy.model.automaton import START, Automaton, State
from understudy.model.binding import Binding
from understudy.model.features import BoundFeature
from understudy.model.lesson import Example, ExampleKind, Lesson
from understudy.sim.forage import FORAGE_KIT

ABSENT = nan
A = Binding(A="A")
DISTANCE = BoundFeature(FORAGE_KIT.features["distance_to"], A)
ANGLE = BoundFeature(FORAGE_KIT.features["angle_to"], A)
FOOD = BoundFeature(FORAGE_KIT.features["food_left"])
DONE = BoundFeature(FORAGE_KIT.features["done"])

Row: TypeAlias = tuple[str, str, str, float, float]

GOTO: tuple[Row, ...] = (
    ("start", "forward", "directive", 6.0, 10),
    ("forward", "forward", "default", 6.0, 10),
    ("forward", "done", "directive", 0.3, 350),
    ("start", "left", "directive", 5.0, 90),
    ("left", "left", "default", 5.0, 90),
    ("left", "forward", "directive", 5.0, 20),
    ("forward", "forward", "default", 5.0, 20),
)
"""Drives when the target is ahead, turns when it is to the left; nothing was shown with it to the right or behind."""


def make_goto_session(rows: tuple[Row, ...] = GOTO, **changes: Any) -> Lesson:
    """A lesson of GoTo: state, next, kind, distance in m, bearing in degrees."""
    states = (START, State("forward", "forward"), State("left", "rotate_left"), State("done", flag="done"))
    automaton = Automaton("goto", states, (DISTANCE, ANGLE), ("A",), **changes)
    return Lesson(automaton, tuple(_example(number, row) for number, row in enumerate(rows)))


def _example(number: int, row: Row) -> Example:
    state, following, kind, distance, angle = row
    return Example(number, state, (distance, radians(angle)), following, ExampleKind(kind))
