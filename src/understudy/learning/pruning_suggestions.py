"""Suggestions of how far to simplify trees by pruning, judged by examples that were left out of learning.

Nothing here changes a lesson; a person decides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.learning._split_kernels import WATCHED
from understudy.learning.explain import RowNumbers
from understudy.learning.fit import make_fitter
from understudy.learning.pruning import SAME, list_pruning_steps
from understudy.learning.training_set import TrainingSet, group_examples_by_state, make_training_set
from understudy.model.automaton import Transition
from understudy.model.learner_options import TreeOptions
from understudy.model.lesson import Lesson
from understudy.model.tree import STAY, Tree, make_leaf

ENOUGH = 30
"""The least number of press-made examples for which a pruning is suggested.

Fewer are no basis for predictions about further examples, and each of them was given on purpose.
"""
MOST_TRIALS = 48
"""The largest number of trials; in larger lessons, each trial leaves out several examples at once."""

Fit: TypeAlias = Callable[[TrainingSet], Transition]
"""A function that learns a transition function from a training set."""


@dataclass(frozen=True, slots=True)
class PruningSuggestion:
    """The suggested pruning: the one with the fewest wrong decisions, the strongest of equals.

    `wrong` and `wrong_pruned` are how many of the `left_out` press-made examples are decided wrongly by trees
    learned without them: without pruning and with it.
    """

    pruning: float
    left_out: int
    wrong: int
    wrong_pruned: int


def replace_pruning(lesson: Lesson, pruning: float) -> Lesson:
    """Return the lesson with another pruning in its options; lessons with classifiers are returned unchanged."""
    learner = lesson.options.learner
    if not isinstance(learner, TreeOptions):
        return lesson
    return replace(lesson, options=replace(lesson.options, learner=replace(learner, pruning=pruning)))


def suggest_pruning(lesson: Lesson) -> PruningSuggestion | None:
    """Suggest a pruning by cross-validation; None with a classifier, or if there are fewer than ENOUGH examples.

    Candidates are no pruning and those values at which the tree changes. Of the ones with the fewest wrong
    decisions, the largest is suggested.
    """
    if not isinstance(lesson.options.learner, TreeOptions):
        return None
    bare = replace_pruning(lesson, 0.0)
    fit, states = make_fitter(bare), _states(bare)
    pressed = [np.flatnonzero(training_set.groups != WATCHED) for training_set in states]
    count = sum(map(len, pressed))
    if count < ENOUGH:
        return None
    steps = sorted(
        {
            0.0,
            *(
                worth
                for training_set in states
                for worth, _ in list_pruning_steps(_tree(fit, training_set), training_set)
            ),
        }
    )
    wrong = np.zeros(len(steps), np.int64)
    together = -(-count // MOST_TRIALS)
    for training_set, rows in zip(states, pressed, strict=True):
        trials = -(-len(rows) // together)
        for first in range(trials):
            wrong += _count_wrong_by_pruning(fit, training_set, rows[first::trials], steps)
    best = int(np.flatnonzero(wrong == wrong.min())[-1])
    return PruningSuggestion(steps[best], count, int(wrong[0]), int(wrong[best]))


def _states(lesson: Lesson) -> list[TrainingSet]:
    """List the training set of each transition function; one for all states in a stateless lesson."""
    groups = [(state, examples) for state, examples in group_examples_by_state(lesson).items()]
    return [
        make_training_set(lesson, examples, state)
        for state, examples in groups[: 1 if lesson.automaton.stateless else None]
    ]


def _tree(fit: Fit, training_set: TrainingSet) -> Tree:
    """Learn a tree; without press-made examples, one that stays."""
    tree = fit(training_set) if (training_set.groups != WATCHED).any() else None
    return tree if isinstance(tree, Tree) else Tree((make_leaf(STAY),))


def _count_wrong_by_pruning(
    fit: Fit, training_set: TrainingSet, out: RowNumbers, steps: Sequence[float]
) -> NDArray[np.int64]:
    """Count for each pruning in `steps` how many of the left-out examples are decided wrongly."""
    rows = np.delete(np.arange(len(training_set.outcomes)), out)
    rest = TrainingSet(
        (),
        training_set.values[rows],
        training_set.outcomes[rows],
        training_set.groups[rows],
        training_set.current,
    )
    tree = _tree(fit, rest)
    pruning, wrong = list_pruning_steps(tree, rest), np.zeros(len(steps), np.int64)
    waiting = next(pruning, None)
    examples = [(training_set.examples[row], int(training_set.outcomes[row])) for row in out.tolist()]
    for place, step in enumerate(steps):
        while waiting is not None and waiting[0] <= step + SAME and step > 0.0:
            tree, waiting = waiting[1], next(pruning, None)
        for example, outcome in examples:
            decided = tree.decide(example.values)
            stays = decided == STAY and example.next == example.state
            wrong[place] += not (stays or decided == outcome)
    return wrong
