"""The analysis of a lesson: all that the different kinds of advice need, computed once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.cross_validation import (
    LeaveOneOutFit,
    StateFit,
    make_state_fits,
    refit_without_examples,
)
from understudy.coaching.distances import FeatureDistances
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
from understudy.model.automaton import Transition
from understudy.model.lesson import Example, Lesson
from understudy.model.tree_regions import Box

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
