"""Cross-validation: what a state would decide without one of its examples, or without half of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError
from understudy.learning.fit import make_fitter
from understudy.learning.sklearn_adapter import ClassifierTransition
from understudy.learning.training_set import TrainingSet, group_examples_by_state, make_training_set
from understudy.model.automaton import Transition
from understudy.model.learner_options import SklearnOptions
from understudy.model.lesson import Example, Lesson
from understudy.model.tree import STAY, Tree, make_leaf

Chosen = NDArray[np.bool_]
MOST_TRIALS = 64
"""So many trials in a lesson at most: of a larger one, each trial leaves out several examples at once."""
MOST_SLOW_TRIALS = 8
"""The same for classifiers of scikit-learn, which take milliseconds each."""
SLOW = ("LogisticRegression", "MLPClassifier", "RandomForestClassifier")
"""Those that take a second: there is no trial of them."""


@dataclass(frozen=True)
class StateFit:
    """The examples that teach one state, and functions that learn from some of them.

    `press_rows` are the rows of examples made by presses: only these are left out and tested.
    """

    state: str
    shown: TrainingSet
    fit: Callable[[TrainingSet], Transition]

    @property
    def examples(self) -> tuple[Example, ...]:
        """The examples that teach the state."""
        return self.shown.examples

    @cached_property
    def press_rows(self) -> NDArray[np.int64]:
        """The numbers of the examples that a press of the teacher made."""
        return np.flatnonzero([example.is_from_press for example in self.examples])

    def fit_rows(self, kept: Chosen) -> Transition:
        """Learn the transition function from the chosen rows [n].

        It stays if none of them was made by a press, or if they are too few for the classifier.
        """
        shown = self.shown
        if not kept[self.press_rows].any():
            return Tree((make_leaf(STAY),))
        values, outcomes, groups = shown.values[kept], shown.outcomes[kept], shown.groups[kept]
        try:
            return self.fit(
                TrainingSet((), values, outcomes, groups, shown.current)
            )  # arrays are all that is fitted to
        except DefinitionError:
            return Tree((make_leaf(STAY),))

    def fit_without(self, *rows: int) -> Transition:
        """Learn the transition function without these rows."""
        kept = np.ones(len(self.examples), np.bool_)
        kept[list(rows)] = False
        return self.fit_rows(kept)

    def decide_all(self, transition: Transition, vectors: Sequence[Sequence[float]]) -> NDArray[np.int64]:
        """Return the index of the next state for each vector; its own where it stays (STAY if stateless)."""
        if isinstance(transition, ClassifierTransition):
            found = transition.decide_at_once(np.array(vectors, np.float64).reshape(len(vectors), -1))
        else:
            found = np.array([transition.decide(vector) for vector in vectors], np.int64)
        return np.where(found == STAY, self.shown.current, found)


def make_state_fits(lesson: Lesson) -> Mapping[str, StateFit]:
    """Collect the examples of each state that has any; a stateless lesson has one entry, under its first state."""
    fit = make_fitter(lesson)
    taught = group_examples_by_state(lesson)
    names = list(taught)[:1] if lesson.automaton.stateless else list(taught)
    return {name: StateFit(name, make_training_set(lesson, taught[name], name), fit) for name in names}


@dataclass(frozen=True, slots=True)
class LeaveOneOutFit:
    """A transition function learned without some rows."""

    rows: tuple[int, ...]
    transition: Transition


def refit_without_examples(
    lesson: Lesson, found: Mapping[str, StateFit], *, most: int | None = None
) -> Mapping[str, list[LeaveOneOutFit]]:
    """Learn again, by state, without each press-made example.

    In large lessons several are left out at a time. Classifiers listed in SLOW are skipped.
    """
    if isinstance(lesson.options.learner, SklearnOptions) and lesson.options.learner.classifier in SLOW:
        return {name: [] for name in found}
    if most is None:
        most = MOST_SLOW_TRIALS if isinstance(lesson.options.learner, SklearnOptions) else MOST_TRIALS
    total = sum(len(learner.press_rows) for learner in found.values())
    together = max(1, -(-total // most))
    made = {}
    for name, learner in found.items():
        rows = learner.press_rows.tolist()
        groups = -(-len(rows) // together)
        made[name] = [
            LeaveOneOutFit(tuple(left_out), learner.fit_without(*left_out))
            for left_out in (rows[first::groups] for first in range(groups))
        ]
    return made


@dataclass(frozen=True, slots=True)
class Accuracy:
    """The number of press-made examples that were decided as shown without them."""

    right: int
    of: int

    @property
    def share(self) -> float:
        """The share of correct decisions; 0 if there were none."""
        return self.right / self.of if self.of else 0.0


def score_leave_one_out(
    found: Mapping[str, StateFit], made: Mapping[str, Sequence[LeaveOneOutFit]]
) -> Accuracy:
    """Compute leave-one-out accuracy, pooled over all states with at least two press-made examples."""
    right = of = 0
    for name, learner in found.items():
        if len(learner.press_rows) < 2:
            continue
        for trial in made[name]:
            right_here, cases = _right(learner, trial)
            right, of = right + right_here, of + cases
    return Accuracy(right, of)


HALVES = 4
SEED = 1


def score_half_of_examples(found: Mapping[str, StateFit], *, halves: int = HALVES) -> Accuracy:
    """Compute the same accuracy when only a random half of the other examples is learned from, drawn several times."""
    right = of = 0
    draws = np.random.default_rng(SEED)
    for learner in found.values():
        rows = learner.press_rows
        if len(rows) < 2:
            continue
        for _ in range(halves):
            mixed = draws.permutation(rows)
            middle = len(rows) // 2
            for half in (mixed[:middle], mixed[middle:]):
                trial = LeaveOneOutFit(tuple(half.tolist()), learner.fit_without(*half.tolist()))
                right_here, cases = _right(learner, trial)
                right, of = right + right_here, of + cases
    return Accuracy(right, of)


def _right(learner: StateFit, trial: LeaveOneOutFit) -> tuple[int, int]:
    rows = list(trial.rows)
    decided = learner.decide_all(trial.transition, learner.shown.values[rows].tolist())
    return int((decided == learner.shown.outcomes[rows]).sum()), len(rows)
