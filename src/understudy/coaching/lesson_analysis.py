"""The analysis of a lesson: all that advice and doubts about decisions need, computed once.

Of each state these are its examples, the distances between situations, and what would be decided without some examples.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from typing import NamedTuple, TypeAlias

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
from understudy.learning.training_set import (
    TrainingSet,
    group_by_feature_vector,
    group_examples_by_state,
    make_training_set,
)
from understudy.model.automaton import Transition
from understudy.model.features import FlagFeature
from understudy.model.learner_options import SklearnOptions
from understudy.model.lesson import Example, Lesson
from understudy.model.tree import STAY, Tree, make_leaf
from understudy.model.tree_regions import Box, find_tested_features
from understudy.model.value_kinds import Toroidal

UNTESTED = 0.25
"""The weight of a feature that a state's tree does not test; it may matter, since the lesson has it."""
FAR = 0.35
"""The distance from which on a situation is far from an example: a third of a number's range, or 60 degrees."""
ENOUGH = 3
"""The least number of directives and confirmations from which gaps in a lesson are reported."""
MOST_TRIALS, MOST_SLOW_TRIALS = 64, 8
"""The largest numbers of trials in a lesson, each without an example, for trees and for classifiers of scikit-learn.

In larger lessons each trial leaves out several examples at once.
"""
SLOW = ("LogisticRegression", "MLPClassifier", "RandomForestClassifier")
"""Classifiers that take a second to fit: there are no trials of them."""
MOST_FITS = 40
"""The largest number of transition functions, each learned without one example, that decide one situation again."""
MOST_NUMBERS = 2_000_000
"""The largest number of differences that are computed at a time, so that a large lesson does not fill the memory."""
DRAWS, SEED = 4, 1
"""The number of random halves of the examples that are drawn, and the seed of the draws."""


class FeatureDistances:
    """Distances between feature vectors: 0 for equal ones, 1 for the largest difference.

    Numbers differ by their share of the observed range, angles by their share of half a turn, labels and absence by 0
    or 1. Features that a state's tree tests have weight 1, all others `UNTESTED`; without a tree that tests any, all
    have weight 1.
    """

    def __init__(self, words: Sequence[FeaturePhrases], transition: Transition | None) -> None:
        tested = find_tested_features([transition]) if isinstance(transition, Tree) else set()
        columns = range(len(words))
        self._weights = np.array([1.0 if not tested or each in tested else UNTESTED for each in columns])
        self._scale = np.array([word.extent for word in words])
        self._is_circle = np.array([isinstance(word.bound.kind, Toroidal) for word in words], np.bool_)

    def compute_by_feature(
        self, rows: NDArray[np.float64], values: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Compute distances, from 0 to 1, between vectors [..., F] and others, broadcast, for each feature."""
        off = np.abs(rows - values)
        off = np.where(self._is_circle & (off > self._scale), 2 * self._scale - off, off)
        distances: NDArray[np.float64] = np.minimum(off / self._scale, 1.0)  # labels are at least 1 apart
        missing = np.isnan(distances)
        return (
            np.where(missing, (np.isnan(rows) != np.isnan(values)) * 1.0, distances)
            if missing.any()
            else distances
        )

    def compute(self, rows: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Compute distances between vectors [..., F] and others, broadcast, over all features; 1 is far."""
        return self.combine(self.compute_by_feature(rows, values))

    def find_nearest(self, rows: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Find how far each of m vectors [m, F] is from the nearest of n others [n, F]."""
        few = max(1, MOST_NUMBERS // max(values.size, 1))
        parts = [rows[first : first + few] for first in range(0, len(rows), few)]
        nearest = [self.compute(part[:, None], values).min(axis=1) for part in parts]
        return np.concatenate([np.zeros(0), *nearest])

    def combine(self, apart: NDArray[np.float64]) -> NDArray[np.float64]:
        """Combine distances `apart` [..., F] of features into one."""
        distances: NDArray[np.float64] = np.minimum(np.sqrt(apart * apart @ self._weights), 1.0)
        return distances


class StateAnalysis:
    """The examples that teach one state, with its transition function and those learned without some examples.

    `place` is the state that advice refers to: "" in a stateless automaton. `distances` weigh features by the state's
    tree, `plain_distances` weigh all alike. `press_rows` are the rows of examples made by presses, which are left out
    and predicted; `shown_rows` are those of directives and confirmations.
    """

    def __init__(
        self,
        lesson: Lesson,
        name: str,
        examples: tuple[Example, ...],
        transition: Transition,
        words: Sequence[FeaturePhrases],
    ) -> None:
        self.name, self.examples, self.transition, self.words = name, examples, transition, words
        self.place = "" if lesson.automaton.stateless else name
        self.shown = make_training_set(lesson, examples, name)
        self.distances = FeatureDistances(words, transition)
        self.plain_distances = FeatureDistances(words, None)
        self.press_rows = [row for row, example in enumerate(examples) if example.is_from_press]
        self.shown_rows = [row for row, example in enumerate(examples) if example.is_shown]
        self._fit = make_fitter(lesson)
        self._without: dict[tuple[int, ...], Transition] = {}

    def fit_without(self, rows: tuple[int, ...]) -> Transition:
        """Learn the transition function without some rows, once.

        It stays if no other example was made by a press, or if the others are too few for the classifier.
        """
        if rows not in self._without:
            training_set, others = self.shown, np.delete(np.arange(len(self.examples)), rows)
            arrays = TrainingSet(
                (),
                training_set.values[others],
                training_set.outcomes[others],
                training_set.groups[others],
                training_set.current,
            )
            self._without[rows] = Tree((make_leaf(STAY),))
            if not set(self.press_rows) <= set(rows):
                with suppress(DefinitionError):
                    self._without[rows] = self._fit(arrays)
        return self._without[rows]

    @cached_property
    def fits_without_one(self) -> list[tuple[int, Transition]]:
        """The trees learned without one directive or confirmation, with its row; of many, evenly chosen ones."""
        rows = self.shown_rows if isinstance(self.transition, Tree) else []
        return [(row, self.fit_without((row,))) for row in rows[:: -(-len(rows) // MOST_FITS) or 1]]

    def decide(self, transition: Transition, vectors: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the index of the next state for each vector [n, F]; its own where it stays (STAY if stateless)."""
        if isinstance(transition, ClassifierTransition):
            outcomes = transition.decide_at_once(vectors)
        else:
            outcomes = np.array([transition.decide(vector) for vector in vectors.tolist()], np.int64)
        return np.where(outcomes == STAY, self.shown.current, outcomes)

    def predict_without(self, rows: tuple[int, ...]) -> NDArray[np.bool_]:
        """Return which of some rows would be decided as shown without them."""
        chosen = list(rows)
        decided = self.decide(self.fit_without(rows), self.shown.values[chosen])
        is_right: NDArray[np.bool_] = decided == self.shown.outcomes[chosen]
        return is_right

    def measure_contrast(
        self, distances: NDArray[np.float64], outcome: int
    ) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Measure how much nearer other examples are to situations than examples of an outcome, from 0 to 1.

        `distances` [..., n] are those of the situations to all examples. The second result is the row of the nearest
        other example. Where all examples have the outcome, or none has, nothing is nearer.
        """
        same = self.shown.outcomes == outcome
        others = np.where(same, np.inf, distances)
        nearest = others.argmin(axis=-1)
        if not same.any():
            return np.zeros(distances.shape[:-1]), nearest
        nearer = distances[..., same].min(axis=-1) - others.min(axis=-1)
        return np.minimum(np.maximum(nearer / (2 * FAR), 0.0), 1.0), nearest

    @cached_property
    def split_leaves(self) -> Mapping[int, tuple[float, tuple[int, ...]]]:
        """The leaves whose examples disagree: the share of those outvoted, and the numbers of all in the leaf.

        A default counts only if its situation has no other example.
        """
        leaves: dict[int, list[Example]] = {}
        pressed = group_by_feature_vector([self.examples[row] for row in self.press_rows]).values()
        for group in pressed if isinstance(self.transition, Tree) else ():
            leaf = self.transition.path(group[0].values)[1]
            leaves.setdefault(leaf, []).extend([each for each in group if each.is_shown] or group)
        split = {}
        for leaf, examples in leaves.items():
            outcomes = [example.next for example in examples]
            outvoted = 1.0 - max(map(outcomes.count, outcomes)) / len(outcomes)
            if outvoted:
                split[leaf] = outvoted, tuple(example.number for example in examples)
        return split

    @cached_property
    def cells(self) -> NDArray[np.int64]:
        """The situations of the examples [n, F] as people describe them."""
        return find_cells(self.words, self.shown.values)

    def find_cells_around(self, values: Sequence[float]) -> dict[int, frozenset[int]]:
        """Find the cell of each feature for one feature vector."""
        cells = find_cells(self.words, np.array([values], np.float64).reshape(1, -1))[0]
        return {feature: frozenset({cell}) for feature, cell in enumerate(cells.tolist())}

    def describe(self, cells: Cells) -> tuple[Box, str]:
        """Return the box of a situation, and its description: " when A is close", or nothing.

        What is usual in the state's examples is left out.
        """
        words = describe_situation(self.words, cells, find_usual_cells(self.cells, self.words))
        return make_situation_box(self.words, cells), f" when {words}" if words else ""

    def describe_example(self, example: Example) -> tuple[Box, str]:
        """Describe an example's situation without features that tell nothing: all values that were seen are one."""
        cells = self.find_cells_around(example.values)
        return self.describe(
            {each: cell for each, cell in cells.items() if self.words[each].cells != (*cell,)}
        )


class MetDecision(NamedTuple):
    """A decision that was met in a new world."""

    seed: int
    time_s: float
    state: str
    values: tuple[float, ...]


Trial: TypeAlias = tuple[StateAnalysis, tuple[int, ...]]
"""A state, and the rows that are left out and then decided."""


class LessonAnalysis:
    """A lesson and its transition functions, with the analysis of each state that has examples.

    A stateless lesson has one entry in `states`, under its first state. `situations` [M, F] are feature vectors that
    the robot may meet; None: they are sampled from the examples. Values of the automaton's own features are taken from
    examples instead. `cells` [M, F] are the situations as people describe them.
    """

    def __init__(
        self,
        lesson: Lesson,
        transitions: Mapping[str, Transition],
        situations: NDArray[np.float64] | None = None,
    ) -> None:
        self.lesson = lesson
        self._seen = vectors = stack_example_vectors(lesson)
        if situations is not None:
            self.situations = fill_own_features(lesson, situations, vectors)
            vectors = np.concatenate([vectors, self.situations])
        self.words = make_feature_phrases(lesson.automaton.features, vectors)
        taught = group_examples_by_state(lesson)
        self.states = {
            name: StateAnalysis(lesson, name, taught[name], transitions[name], self.words)
            for name in list(taught)[: 1 if lesson.automaton.stateless else None]
        }
        self.demonstration_count = sum(len(state.shown_rows) for state in self.states.values())
        self.is_scant = self.demonstration_count < ENOUGH

    @cached_property
    def situations(self) -> NDArray[np.float64]:
        """Feature vectors [M, F] that the robot may meet."""
        return sample_similar_situations(self.lesson, self._seen)

    @cached_property
    def cells(self) -> NDArray[np.int64]:
        """The situations [M, F] as people describe them."""
        return find_cells(self.words, self.situations)

    def find_state(self, name: str) -> StateAnalysis | None:
        """Return the analysis of a state; that of all states in a stateless lesson. None if nothing was shown in it."""
        return next((each for each in self.states.values() if each.place in ("", name)), None)

    def find_possible_situations(self, state: StateAnalysis) -> NDArray[np.bool_]:
        """Return which situations can occur in a state: each flag as some example has it there."""
        possible = np.ones(len(self.situations), np.bool_)
        for column, bound in enumerate(self.lesson.automaton.features):
            if isinstance(bound.feature, FlagFeature) and not self.lesson.automaton.stateless:
                possible &= np.isin(self.situations[:, column], state.shown.values[:, column])
        return possible

    @cached_property
    def trials(self) -> list[Trial]:
        """The press-made examples to leave out: one at a time, or several in large lessons."""
        learner, states, most = self.lesson.options.learner, self.states.values(), MOST_TRIALS
        if isinstance(learner, SklearnOptions):
            most = MOST_SLOW_TRIALS
            if learner.classifier in SLOW:
                return []
        together = max(1, -(-sum(len(state.press_rows) for state in states) // most))
        trials = []
        for state in states:
            count = -(-len(state.press_rows) // together)
            trials += [(state, tuple(state.press_rows[first::count])) for first in range(count)]
        return trials

    def draw_halves(self) -> list[Trial]:
        """Draw random halves of the press-made examples of each state to leave out."""
        draws = 1 if isinstance(self.lesson.options.learner, SklearnOptions) else DRAWS
        generator = np.random.default_rng(SEED)
        halves = []
        for state in self.states.values():
            middle = len(state.press_rows) // 2
            for _ in range(draws if middle else 0):
                mixed = tuple(generator.permutation(state.press_rows).tolist())
                halves += [(state, mixed[:middle]), (state, mixed[middle:])]
        return halves


def predict_left_out(trials: Iterable[Trial]) -> NDArray[np.bool_]:
    """Return which examples are decided as shown without them, of states with at least two press-made examples."""
    predictions = [state.predict_without(rows) for state, rows in trials if len(state.press_rows) > 1]
    return np.concatenate([np.zeros(0, np.bool_), *predictions])
