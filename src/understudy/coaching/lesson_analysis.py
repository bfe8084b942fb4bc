"""The analysis of a lesson: all that the different kinds of advice need, computed once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.situation_sampling import (
    fill_own_features,
    sample_similar_situations,
    stack_example_vectors,
)
from understudy.coaching.situation_text import (
    Cells,
    FeaturePhrases,
    describe_situation,
    find_cells,
    find_usual_cells,
    make_feature_phrases,
    make_situation_box,
)
from understudy.errors import DefinitionError
from understudy.learning.fit import make_fitter
from understudy.learning.sklearn_adapter import ClassifierTransition
from understudy.learning.training_set import TrainingSet, group_examples_by_state, make_training_set
from understudy.model.automaton import Transition
from understudy.model.kinds import Categorical, Toroidal
from understudy.model.learner_options import SklearnOptions
from understudy.model.lesson import Example, Lesson
from understudy.model.tree import STAY, TestKind, Tree, make_leaf
from understudy.model.tree_regions import Box

UNASKED = 0.25
"""What a feature counts that a state's tree does not ask about: the lesson chose it, so it may matter all the same."""
FAR = 0.35
"""From here on a situation is far from an example: a third of what was seen of a number, or 60 degrees."""


class FeatureDistances:
    """Distances between feature vectors in one state.

    Features that the state's transition function tests have weight 1, all others `UNASKED`.

    Numbers differ by their share of the observed range, angles by their share of half a turn, labels and absence by 0
    or 1.
    """

    def __init__(self, words: Sequence[FeaturePhrases], transition: Transition | None) -> None:
        self._weights = np.where(_asked(transition, len(words)), 1.0, UNASKED)
        self._scale, self._turn = np.ones(len(words)), np.zeros(len(words))
        self._labels = np.zeros(len(words), np.bool_)
        for column, word in enumerate(words):
            kind = word.bound.kind
            if isinstance(kind, Categorical):
                self._labels[column] = True
            elif isinstance(kind, Toroidal):
                self._turn[column], self._scale[column] = kind.period, kind.period / 2
            elif word.high > word.low:
                self._scale[column] = word.high - word.low

    def compute_by_feature(
        self, rows: NDArray[np.float64], values: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Compute distances, from 0 to 1, between vectors [..., F] and others, broadcast, for each feature."""
        off = np.abs(rows - values)
        off = np.where(off > self._turn / 2, np.abs(self._turn - off), off)  # of what has no period: itself
        off = np.where(self._labels & (off > 0), 1.0, np.minimum(off / self._scale, 1.0))
        missing = np.isnan(off)
        return np.where(missing, (np.isnan(rows) != np.isnan(values)) * 1.0, off) if missing.any() else off

    def compute(self, rows: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute distances between vectors [..., F] and others, broadcast, over all features; 1 is far."""
        return self.combine(self.compute_by_feature(rows, values))

    def combine(self, apart: NDArray[np.float64]) -> NDArray[np.float64]:
        """Combine distances `apart` [..., F] of features into one."""
        found: NDArray[np.float64] = np.minimum(np.sqrt(apart * apart @ self._weights), 1.0)
        return found


def _asked(transition: Transition | None, features: int) -> NDArray[np.bool_]:
    """Return a mask [F] of the features that a transition function tests; all if it is no tree or has no test."""
    if not isinstance(transition, Tree) or len(transition.nodes) == 1:
        return np.ones(features, np.bool_)
    asked = {node.feature for node in transition.nodes if node.test != TestKind.LEAF}
    return np.isin(np.arange(features), list(asked))


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


ENOUGH = 3
"""So many presses that said something are the least to say anything about what is missing."""


@dataclass(frozen=True)
class LessonAnalysis:
    """A lesson, its transition functions, and by state its examples and what is learned without some of them.

    `situations` [M, F] are feature vectors that the robot may meet; `cells` [M, F] are the same as people describe
    them.
    """

    lesson: Lesson
    transitions: Mapping[str, Transition]
    words: tuple[FeaturePhrases, ...]
    situations: NDArray[np.float64]
    cells: NDArray[np.int64]
    learners: Mapping[str, StateFit]
    trials: Mapping[str, Sequence[LeaveOneOutFit]]

    @classmethod
    def from_lesson(
        cls,
        lesson: Lesson,
        transitions: Mapping[str, Transition],
        situations: NDArray[np.float64] | None = None,
    ) -> LessonAnalysis:
        """Analyze a lesson; `situations` [M, F] are feature vectors that the robot may meet (None: they are sampled).

        Values of the automaton's own features are taken from examples instead.
        """
        seen = stack_example_vectors(lesson)
        if situations is None:
            words = make_feature_phrases(lesson.automaton.features, seen)
            situations = sample_similar_situations(lesson, seen)
        else:
            situations = fill_own_features(lesson, situations, seen)
            words = make_feature_phrases(lesson.automaton.features, np.concatenate([seen, situations]))
        found = make_state_fits(lesson)
        return cls(
            lesson,
            transitions,
            words,
            situations,
            find_cells(words, situations),
            found,
            refit_without_examples(lesson, found),
        )

    @property
    def demonstration_count(self) -> int:
        """The number of directives and confirmations."""
        return sum(example.is_shown for learner in self.learners.values() for example in learner.examples)

    @property
    def is_scant(self) -> bool:
        """Whether there are too few examples to say what is missing."""
        return self.demonstration_count < ENOUGH

    def transition(self, state: str) -> Transition:
        """Get the transition function of a state of `make_state_fits`."""
        return self.transitions[state]

    def make_distances(self, state: str) -> FeatureDistances:
        """Make the distances between situations in a state."""
        return FeatureDistances(self.words, self.transitions.get(state))

    def describe_situation(self, state: str, cells: Cells) -> str:
        """Describe a situation of a state in words, without what is usual in its examples."""
        rows = self.learners[state].shown.values
        return describe_situation(
            self.words, cells, find_usual_cells(find_cells(self.words, rows), self.words)
        )

    def describe_example(self, state: str, example: Example) -> tuple[Box, str]:
        """Return the box of an example's situation, and its description: " when A is close", or nothing."""
        row = find_cells(self.words, np.array([example.values], np.float64).reshape(1, -1))[0]
        cells = {
            feature: frozenset({int(cell)})
            for feature, cell in enumerate(row)
            if self.words[feature].cells != (cell,)  # it tells nothing: all values that were seen are one
        }
        said = self.describe_situation(state, cells)
        return make_situation_box(self.words, cells), f" when {said}" if said else ""

    def place(self, state: str) -> str:
        """Return the state that advice refers to: the state itself, or "" in a stateless automaton."""
        return "" if self.lesson.automaton.stateless else state
