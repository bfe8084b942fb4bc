"""An account of what was taught: conditions, options and values as people and programs read them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import degrees, isnan
from typing import Any

from understudy.model.automaton import Automaton
from understudy.model.features import BoundFeature
from understudy.model.kinds import Categorical, Toroidal
from understudy.model.lesson import Lesson
from understudy.model.tree import Tree
from understudy.model.tree_text import describe_exits

ABSENT = "–"
BY_CLASSIFIER = "decided by a classifier of scikit-learn"
"""What is said in place of conditions, where there are none."""
_DIGITS = {"m": 2, "s": 1}
_DEGREES = re.compile(r"(\d+(?:\.\d+)?)°")


def list_shown_vectors(lesson: Lesson | None, state: str) -> list[tuple[float, ...]]:
    """The feature vectors that a state's function was learned from."""
    if lesson is None:
        return []
    pooled = lesson.automaton.stateless
    teaching = (example for example in lesson.examples if not example.quarantined)
    return [example.values for example in teaching if pooled or example.state == state]


def describe_transitions(automaton: Automaton, lesson: Lesson | None) -> dict[str, list[str]]:
    """By state, in words, when it switches to what, as it was learned from the lesson."""
    said = {}
    for state, function in automaton.transitions.items():
        if isinstance(function, Tree):
            vectors = list_shown_vectors(lesson, state)
            said[state] = list(
                describe_exits(function, automaton.features, automaton.state_names, state, vectors)
            )
        else:
            said[state] = [BY_CLASSIFIER]
    return said


def describe_options(lesson: Lesson) -> dict[str, Any]:
    """How a lesson is learned."""
    chosen = lesson.options
    learner = getattr(chosen.learner, "classifier", "trees")
    pruning = getattr(chosen.learner, "pruning", 0.0)
    return {
        "learner": learner,
        "reaction_s": chosen.reaction_s,
        "watched": chosen.watched,
        "unlearning": chosen.unlearning,
        **({"pruning": pruning} if pruning else {}),
    }


def convert_to_plain(value: float, bound: BoundFeature) -> float | str | None:
    """A value as people write it: a number, a label, or None where absent."""
    if isnan(value):
        return None
    return bound.kind.labels[int(value)] if isinstance(bound.kind, Categorical) else value


def is_angle(bound: BoundFeature) -> bool:
    """Whether its values are angles, said in degrees: left of ahead above 0, right below."""
    return isinstance(bound.kind, Toroidal) and bound.feature.unit == "rad"


def format_value(bound: BoundFeature, number: float, *, unit: bool = True) -> str:
    """A value with its unit: 3.42 m, −31°, yes; a dash where it is absent."""
    if isnan(number):
        return ABSENT
    if isinstance(bound.kind, Categorical):
        return bound.kind.labels[int(number)]
    if is_angle(bound):
        text = f"{around_zero(round(degrees(number))):d}°"
    else:
        name = bound.feature.unit
        digits = _DIGITS.get(name, 0 if float(number).is_integer() else 2)
        text = f"{number:.{digits}f}{f' {name}' if name and unit else ''}"
    return text.replace("-", "−")


def around_zero(angle: float) -> int:
    """An angle in degrees from −179 to 180, left of ahead above 0."""
    return int((angle + 179) % 360 - 179)


def format_condition(text: str) -> str:
    """A condition whose angles are said like the readings: "between 350° and 10°" is between −10° and 10°."""

    def turned(match: re.Match[str]) -> str:
        angle = float(match[1])
        return f"{angle - 360 if angle > 180 else angle:g}°".replace("-", "−")

    return _DEGREES.sub(turned, text)


def format_values(features: Sequence[BoundFeature], numbers: Sequence[float]) -> str:
    """Labels and values: "distance_to(A) = 3.42 m, angle_to(A) = −31°"."""
    return ", ".join(
        f"{bound} = {format_value(bound, number)}" for bound, number in zip(features, numbers, strict=True)
    )
