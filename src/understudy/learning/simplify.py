"""Simplifying: how much of what was learned can go without loss, judged by examples that were left out of learning.

Nothing here changes a lesson: it says what pruning would come to, and a person decides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from understudy.learning._kernels import WATCHED
from understudy.learning.arrays import Shown, arrays, teaching
from understudy.learning.pruning import SAME, links
from understudy.learning.transitions import fitting, learn_state
from understudy.model.automaton import Transition
from understudy.model.example import Example
from understudy.model.lesson import Lesson, Trees
from understudy.model.tree import STAY, Tree

Fit: TypeAlias = Callable[[Shown], Transition]
ENOUGH = 30
"""Fewer press-made examples say too little about examples to come; and each of them was meant."""


@dataclass(frozen=True, slots=True)
class Suggestion:
    """The pruning that decides fewest examples wrong, and of several the one that decides most simply: of `examples`,
    each left out in turn, so many were decided otherwise than shown without pruning, and with it.
    """

    pruning: float
    examples: int
    wrong: int
    wrong_pruned: int


def with_pruning(lesson: Lesson, pruning: float) -> Lesson:
    """The lesson, learned with a pruning; 0 prunes nothing."""
    learner = lesson.options.learner
    if not isinstance(learner, Trees):
        return lesson
    return replace(lesson, options=replace(lesson.options, learner=replace(learner, pruning=pruning)))


def suggestion(lesson: Lesson) -> Suggestion | None:
    """The pruning to try; None where a classifier learns, or where there are too few examples to tell.

    Of no pruning and those at which something changes, the one with the fewest wrong decisions; of several, the most.
    """
    bare = with_pruning(lesson, 0.0)
    pressed = [example for example in lesson.examples if example.pressed and not example.quarantined]
    if not isinstance(lesson.options.learner, Trees) or len(pressed) < ENOUGH:
        return None
    steps = sorted({0.0, *(worth for state in teaching(bare) for worth in _worths(bare, state))})
    wrong = [0] * len(steps)
    left_out, fit = 0, fitting(bare)
    for state, examples in list(teaching(bare).items())[: 1 if bare.automaton.stateless else None]:
        shown = arrays(bare, examples, state)
        for row, example in enumerate(examples):
            if example.pressed:
                left_out += 1
                for step, decided in enumerate(
                    _decided(bare, fit, state, _without(shown, row), example, steps)
                ):
                    wrong[step] += decided != example.next
    best = max(step for step in range(len(steps)) if wrong[step] == min(wrong))
    return Suggestion(steps[best], left_out, wrong[0], wrong[best])


def _worths(lesson: Lesson, state: str) -> list[float]:
    """What the questions of a state are worth, weakest first."""
    examples = teaching(lesson)[state]
    tree = learn_state(lesson, state, examples)
    shown = arrays(lesson, examples, state)
    return [worth for worth, _ in links(tree, shown)] if isinstance(tree, Tree) else []


def _without(shown: Shown, row: int) -> Shown:
    """All examples but one."""
    return Shown(
        (*shown.examples[:row], *shown.examples[row + 1 :]),
        np.delete(shown.values, row, axis=0),
        np.delete(shown.outcomes, row),
        np.delete(shown.groups, row),
        shown.current,
    )


def _decided(
    lesson: Lesson, fit: Fit, state: str, others: Shown, example: Example, steps: list[float]
) -> list[str]:
    """What is decided at an example that was left out of `others`, by each pruning."""
    if (others.groups == WATCHED).all():
        return [state] * len(steps)
    tree = fit(others)
    if not isinstance(tree, Tree):
        return [state] * len(steps)
    trees, pruning = [], links(tree, others)
    waiting = next(pruning, None)
    for step in steps:
        while waiting is not None and waiting[0] <= step + SAME and step > 0.0:
            tree, waiting = waiting[1], next(pruning, None)
        trees.append(tree)
    names = lesson.automaton.state_names
    outcomes = [tree.decide(example.values) for tree in trees]
    return [state if outcome == STAY else names[outcome] for outcome in outcomes]
