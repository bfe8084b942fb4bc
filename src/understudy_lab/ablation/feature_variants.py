"""Other features for the same lessons: angles as plain numbers or as sine and cosine, all features, no flags.

The simulated person's rules use the usual features, so each variant has a function that recovers those from the shown
ones.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from math import atan2, pi, tau
from typing import TypeAlias

import numpy as np

from understudy.model.features import ReadingsView, feature
from understudy.model.library import Kit
from understudy.model.value_kinds import NO, YES, Column, Continuous
from understudy.sim.forage import FORAGE_KIT as usual_kit
from understudy.training.trainee import SessionView
from understudy_lab.tasks.forage_teacher import CAPACITY, TOPICS
from understudy_lab.teachers.person import Seen, Wish
from understudy_lab.teachers.teacher import LessonPlan

Translate: TypeAlias = Callable[[SessionView], Mapping[str, float]]
"""A function that recovers usual features from a view that does not show them."""


@feature(Continuous(), unit="rad")
def signed_angle_to(robot: ReadingsView, A: ReadingsView) -> Column:
    """Where it is, from -pi to pi: 0 ahead, left positive."""
    return np.mod(A.bearing + pi, tau) - pi


@feature(Continuous(), unit="rad")
def round_angle_to(robot: ReadingsView, A: ReadingsView) -> Column:
    """Where it is, from 0 to 2 pi as a plain number."""
    return A.bearing


@feature(Continuous())
def sine_to(robot: ReadingsView, A: ReadingsView) -> Column:
    """The sine of where it is: positive to the left."""
    return np.sin(A.bearing)


@feature(Continuous())
def cosine_to(robot: ReadingsView, A: ReadingsView) -> Column:
    """The cosine of where it is: positive ahead."""
    return np.cos(A.bearing)


kit = usual_kit + Kit.from_parts(signed_angle_to, round_angle_to, sine_to, cosine_to)


def with_angle_as(*features: str) -> tuple[LessonPlan, ...]:
    """Return the usual plans with these features in place of the angle."""

    def angle(screen: SessionView) -> Mapping[str, float]:
        values = [screen.features[name] for name in features]
        return {"angle_to(A)": (values[0] if len(values) == 1 else atan2(*values)) % tau}

    goto, *others = TOPICS
    return (_choosing(_seen_as(goto, angle), ("distance_to(A)", *features)), *others)


def with_all_features() -> tuple[LessonPlan, ...]:
    """Return the usual plans, each with every feature of the kit for every target, in the order of the kit."""
    chosen = []
    for topic in TOPICS:
        targets = [*(["A"] if topic.name == "goto" else []), *usual_kit.targets]
        features = [
            f"{name}({target})" if each.parameters else name
            for name, each in usual_kit.features.items()
            for target in (targets if each.parameters else targets[:1])
        ]
        chosen.append(_choosing(topic, features))
    return tuple(chosen)


def with_features_of_all() -> tuple[LessonPlan, ...]:
    """Return the usual plans, each with every feature that any of the four lessons needs."""
    own = ("done", "food_left", "food_stored", "food_below_me", "at_station")
    goto, *others = TOPICS
    return (
        _choosing(goto, ("distance_to(A)", "angle_to(A)", *own)),
        *(_choosing(topic, own) for topic in others),
    )


def without_flags() -> tuple[LessonPlan, ...]:
    """Return the usual plans without flags of lower automata as features, so that other features must replace them."""
    goto, harvest, deposit, forage = TOPICS

    def at_food(screen: SessionView) -> Mapping[str, float]:
        return {"done": YES if screen.features["food_below_me"] > 0 else NO}

    def at_station(screen: SessionView) -> Mapping[str, float]:
        return {"done": screen.features["at_station"]}

    def half_done(screen: SessionView) -> Mapping[str, float]:
        stored, left = screen.features["food_stored"], screen.features["food_left"]
        harvested = stored >= CAPACITY or left == NO
        return {"done": YES if (harvested if screen.state == "harvest" else stored == 0) else NO}

    return (
        goto,
        _choosing(_seen_as(harvest, at_food), ("food_left", "food_stored", "food_below_me")),
        _choosing(_seen_as(deposit, at_station), ("food_stored", "at_station")),
        _choosing(_seen_as(forage, half_done), ("food_stored", "food_left")),
    )


def _choosing(topic: LessonPlan, features: Sequence[str]) -> LessonPlan:
    """Return the plan with other features for its lesson."""
    return replace(topic, design=replace(topic.design, features=features))


def _seen_as(topic: LessonPlan, translate: Translate) -> LessonPlan:
    """Return the plan with rules that first translate the view."""

    def known(screen: SessionView) -> SessionView:
        return replace(screen, features={**screen.features, **translate(screen)})

    def wish(of: Wish) -> Wish:
        return lambda screen: of(known(screen))

    def seen(of: Seen) -> Seen:
        return lambda screen: of(known(screen))

    cases = tuple(replace(case, suits=seen(case.suits), enough=seen(case.enough)) for case in topic.cases)
    return replace(
        topic,
        show=wish(topic.show),
        complain=wish(topic.complain),
        finished=seen(topic.finished),
        cases=cases,
    )
