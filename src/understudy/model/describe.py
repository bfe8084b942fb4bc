"""An account of what was taught: conditions, options and values as people and programs read them."""

from __future__ import annotations

from math import isnan
from typing import Any

from understudy.model.automaton import Automaton
from understudy.model.features import BoundFeature
from understudy.model.kinds import Categorical
from understudy.model.lesson import Lesson
from understudy.model.tree import Tree
from understudy.model.tree_text import sentences


def shown(lesson: Lesson | None, state: str) -> list[tuple[float, ...]]:
    """The feature vectors that a state's function was learned from."""
    if lesson is None:
        return []
    pooled = lesson.automaton.stateless
    teaching = (example for example in lesson.examples if not example.quarantined)
    return [example.values for example in teaching if pooled or example.state == state]


def conditions(automaton: Automaton, lesson: Lesson | None) -> dict[str, list[str]]:
    """By state, in words, when it switches to what, as it was learned from the lesson."""
    said = {}
    for state, function in automaton.transitions.items():
        if isinstance(function, Tree):
            vectors = shown(lesson, state)
            said[state] = list(sentences(function, automaton.features, automaton.state_names, state, vectors))
        else:
            said[state] = ["decided by a classifier of scikit-learn"]
    return said


def options(lesson: Lesson) -> dict[str, Any]:
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


def plain(value: float, bound: BoundFeature) -> float | str | None:
    """A value as people write it: a number, a label, or None where absent."""
    if isnan(value):
        return None
    return bound.kind.labels[int(value)] if isinstance(bound.kind, Categorical) else value
