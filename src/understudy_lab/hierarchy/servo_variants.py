"""Lesson plans for approaching the ball and stopping there: in one automaton, or in two (paper section 4.2)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from understudy.model.library import Library
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import link
from understudy.training.trainee import SessionView
from understudy_lab.tasks.servo_teacher import (
    FEATURES,
    FOUR_STATES,
    ApproachAndStopTeacher,
    StatefulServoTeacher,
    show_approach_then_stop,
    topic,
)
from understudy_lab.tasks.soccer import ANYWHERE, Soccer
from understudy_lab.teachers.teacher import LessonDesign, LessonPlan, Situation

NAME = "approach_and_stop"
TRIES, SHOWN = 6, 3
LIMIT_S = 60.0
NEAR_M = 0.5
"""The largest distance in m from the ball's center at which stopping counts: 25 cm from rim to rim."""


def says_it_arrived(screen: SessionView) -> bool:
    """Return whether the automaton has raised a flag."""
    return screen.flag is not None


def topics(search: str) -> Mapping[str, tuple[LessonPlan, ...]]:
    """Return the lesson plans by variant: one automaton for all, or an approach and an automaton above it.

    The teacher first turns to the side `search`, "left" or "right".
    """
    shown, complained = StatefulServoTeacher(search), StatefulServoTeacher(search, 15.0)
    approach = topic(shown, complained, stateful=True, tries=0)
    approach = replace(approach, cases=approach.cases[:SHOWN])  # the rest is tried out in the whole task
    whole = LessonPlan(
        NAME,
        LessonDesign(states=FOUR_STATES, flags=["done"], features=FEATURES),
        ApproachAndStopTeacher(shown),
        ApproachAndStopTeacher(complained),
        says_it_arrived,
        cases=approach.cases,
        tries=TRIES,
        limit_s=LIMIT_S,
    )
    above = LessonPlan(
        NAME,
        LessonDesign(states=["approach"], flags=["done"], features=["blob_size(ball)"]),
        show_approach_then_stop,
        show_approach_then_stop,
        says_it_arrived,
        cases=(Situation("anywhere", suits=_seen), Situation("anywhere", suits=_seen)),
        tries=TRIES,
        limit_s=LIMIT_S,
    )
    return {"one automaton": (whole,), "two automata": (approach, above)}


def _seen(screen: SessionView) -> bool:
    size = screen.features.get("blob_size(ball)", float("nan"))
    return size == size


def success(library: Library, seeds: range) -> float:
    """Return the share of worlds in which the robot stops beside the ball."""
    body = Soccer(seeds, ANYWHERE)
    engine = Engine.from_program(body, link(library, NAME))
    for _ in range(round(LIMIT_S / body.tick_s)):
        engine.tick()
    distance = np.array([_to_ball(body, world) for world in range(len(seeds))])
    said = np.array([engine.path(world)[-1] == "done" for world in range(len(seeds))])
    return float((said & (distance <= NEAR_M)).mean())


def _to_ball(body: Soccer, world: int) -> float:
    view = body.view(world)
    return float(np.hypot(view.robots.x[0] - view.objects.x[0], view.robots.y[0] - view.objects.y[0]))
