"""Descriptions of automata and lessons, for people and programs: conditions, options and feature values as text."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees, isnan
from typing import Any

from understudy.errors import join_names
from understudy.model.automaton import Automaton
from understudy.model.features import BoundFeature
from understudy.model.lesson import Lesson
from understudy.model.tree import STAY, Tree
from understudy.model.tree_text import describe_exits, describe_tree_outcomes
from understudy.model.value_kinds import Categorical, Toroidal

ABSENT = "–"
BY_CLASSIFIER = "decided by a classifier of scikit-learn"
"""The text that replaces conditions if a transition function is no decision tree."""
_DIGITS = {"m": 2, "s": 1}


def name_examples(names: Sequence[object], *, most: int | None = None) -> str:
    """Name examples in a sentence: "example 3", "examples 3, 7 and 12"; those beyond `most` are only counted."""
    listed = [str(each) for each in names[:most]]
    more = [f"{len(names) - len(listed)} more"] if len(names) > len(listed) else []
    return f"example{'s' * (len(names) > 1)} {join_names([*listed, *more])}"


def list_shown_vectors(lesson: Lesson | None, state: str) -> list[tuple[float, ...]]:
    """List the feature vectors of a state's examples, to which its transition function must fit.

    Examples in quarantine are left out. A stateless automaton pools the examples of all states.
    """
    if lesson is None:
        return []
    pooled = lesson.automaton.stateless
    teaching = (example for example in lesson.examples if not example.quarantined)
    return [example.values for example in teaching if pooled or example.state == state]


def describe_transitions(automaton: Automaton, lesson: Lesson | None) -> dict[str, list[str]]:
    """Describe in words, for each state, the conditions under which the automaton switches to other states.

    Numbers are rounded such that every example of the lesson stays on its side of each threshold.
    """
    conditions = {}
    for state, function in automaton.transitions.items():
        if isinstance(function, Tree):
            vectors = list_shown_vectors(lesson, state)
            conditions[state] = list(
                describe_exits(function, automaton.features, automaton.state_names, state, vectors)
            )
        else:
            conditions[state] = [BY_CLASSIFIER]
    return conditions


def list_conditions_by_switch(
    automaton: Automaton, lesson: Lesson | None
) -> dict[tuple[str, str], list[str]]:
    """List the conditions in words for each pair of state and next state, as labels of a diagram.

    Numbers are rounded as in `describe_transitions`. A classifier has no conditions: its pairs are those of the
    lesson's examples.
    """
    conditions: dict[tuple[str, str], list[str]] = {}
    for state, function in automaton.transitions.items():
        vectors = list_shown_vectors(lesson, state)
        if isinstance(function, Tree):
            texts = describe_tree_outcomes(function, automaton.features, vectors)
            nexts = {
                automaton.state_names[outcome]: list(each)
                for outcome, each in texts.items()
                if outcome != STAY
            }
        else:
            examples = () if lesson is None else lesson.examples
            next_states = [each.next for each in examples if automaton.stateless or each.state == state]
            nexts = {following: [BY_CLASSIFIER] for following in next_states}
        conditions |= {(state, following): each for following, each in nexts.items() if following != state}
    return conditions


def describe_options(lesson: Lesson) -> dict[str, Any]:
    """Return the options with which a lesson is learned, as plain values by name."""
    chosen = lesson.options
    learner = getattr(chosen.learner, "classifier", "trees")
    pruning = getattr(chosen.learner, "pruning", 0.0)
    own = sorted({each.reaction_s for each in lesson.examples if each.reaction_s is not None})
    return {
        "learner": learner,
        "reaction_s": chosen.reaction_s,
        "watched": chosen.watched,
        "unlearning": chosen.unlearning,
        "live": chosen.live,
        **({"pruning": pruning} if pruning else {}),
        **({"reaction_times_of_drivers_s": own} if own else {}),
    }


def convert_to_plain(value: float, bound: BoundFeature) -> float | str | None:
    """Convert a feature value to a number, to its label if categorical, or to None if absent."""
    if isnan(value):
        return None
    return bound.kind.labels[int(value)] if isinstance(bound.kind, Categorical) else value


def is_angle(bound: BoundFeature) -> bool:
    """Return whether a feature's values are angles in radians, which are displayed in degrees."""
    return isinstance(bound.kind, Toroidal) and bound.feature.unit == "rad"


def format_value(bound: BoundFeature, number: float, *, unit: bool = True) -> str:
    """Format a feature value for people, such as "3.42 m", "−31°" or "yes", or a dash if absent.

    Angles run from −179° to 180°, positive to the left of straight ahead. `unit=False` leaves out units of lengths
    and the like; the degree sign stays.
    """
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
    """Wrap an angle in degrees to −179 to 180; positive is to the left of straight ahead."""
    return int((angle + 179) % 360 - 179)


def format_values(features: Sequence[BoundFeature], numbers: Sequence[float]) -> str:
    """Format a feature vector as text, such as "distance_to(A) = 3.42 m, angle_to(A) = −31°"."""
    return ", ".join(
        f"{bound} = {format_value(bound, number)}" for bound, number in zip(features, numbers, strict=True)
    )
