"""The uncertainty of decisions, from 0 (as demonstrated) to 1 (no similar example), with its reason.

doubts = UncertaintyModel(lesson, learn(lesson))
doubts.estimate("forward", [0.3, 1.2])
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.lesson_analysis import FAR, LessonAnalysis, StateAnalysis, find_cells_around
from understudy.coaching.situation_text import describe_situation
from understudy.learning.training_set import group_by_feature_vector, group_examples_by_state
from understudy.model.automaton import Transition
from understudy.model.lesson import Lesson
from understudy.model.tree import STAY, Tree


class DoubtReason(StrEnum):
    """Why a decision is uncertain."""

    SHOWN = "shown"  # it is not
    UNTAUGHT = "untaught"  # nothing was ever shown in this state
    SCANT = "scant"  # hardly anything was shown in this lesson
    UNSHOWN = "unshown"  # the tree ends before an answer
    FAR = "far"  # far from all examples
    OTHERWISE = "otherwise"  # what was shown nearest says something else
    HANGING = "hanging"  # at a boundary held by one example
    DISAGREEING = "disagreeing"  # examples of the leaf want different things
    FIDGETING = "fidgeting"  # the robot switches back and forth
    REPEATING = "repeating"  # it stays in a state, and comes back to the same situation again and again


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """The uncertainty of one decision, 0 to 1, with its reason, a sentence, and the examples concerned."""

    amount: float
    because: DoubtReason
    reason: str
    examples: tuple[int, ...] = ()


NONE_SHOWN, HARDLY = 1.0, 0.6
"""What doubt is where a state was shown nothing, or a lesson hardly anything."""
HANGS = 0.7
"""The most that a boundary held by one example makes of it."""
CLOSE_BY = 0.05
"""As near to the one example as this, its word is good."""
MOST_OTHERS = 40
"""So many transition functions at most, each without one example, are asked in a state."""


class UncertaintyModel:
    """The uncertainty of a lesson's transition functions, prepared once for a lesson and queried at every tick."""

    def __init__(self, lesson: Lesson, transitions: Mapping[str, Transition]) -> None:
        analysis = LessonAnalysis(lesson, transitions)
        models = {name: _StateModel(state, analysis.is_scant) for name, state in analysis.states.items()}
        if lesson.automaton.stateless:  # all share one
            models = {name: model for model in models.values() for name in group_examples_by_state(lesson)}
        self._models = models
        self._flags = {state.name for state in lesson.automaton.states if state.flag is not None}

    def estimate(self, state: str, values: Sequence[float]) -> Uncertainty:
        """Estimate the uncertainty of the decision in a state for a feature vector; 0 in a flag state."""
        if state in self._models:
            return self._models[state].estimate(values)
        if state in self._flags:
            return Uncertainty(0.0, DoubtReason.SHOWN, "a raised flag is never left")
        return Uncertainty(NONE_SHOWN, DoubtReason.UNTAUGHT, f"there are no examples in {state}")

    def rank_answers(self, state: str, values: Sequence[float]) -> tuple[int, ...]:
        """List the next states, by index, that examples of this state have, that of the nearest example first."""
        return self._models[state].rank_answers(values) if state in self._models else ()


class _StateModel:
    """The uncertainty of decisions in one state."""

    def __init__(self, state: StateAnalysis, scant: bool) -> None:
        self._state, self._scant = state, scant
        self._tree = state.transition if isinstance(state.transition, Tree) else None
        self._split = {} if self._tree is None else _find_split_leaves(state, self._tree)

    @cached_property
    def _others(self) -> list[tuple[int, Transition]]:
        """The trees of the state learned without one example each, computed at the first use."""
        rows = [row for row, example in enumerate(self._state.examples) if example.is_shown and self._tree]
        return [(row, self._state.fit_without((row,))) for row in rows[:: -(-len(rows) // MOST_OTHERS) or 1]]

    def estimate(self, values: Sequence[float]) -> Uncertainty:
        """Return the strongest of the reasons for uncertainty."""
        state = self._state
        outcome = state.transition.decide(values)
        if outcome == STAY and self._tree is not None:
            return Uncertainty(0.9, DoubtReason.UNSHOWN, f"there are no examples like this in {state.name}")
        apart = state.distances.compute_by_feature(state.shown.values, np.array(values, np.float64))
        distances = state.distances.combine(apart)
        found = [
            self._far(values, distances, apart),
            self._hangs(values, outcome, distances),
            self._otherwise(state.plain_distances.combine(apart), outcome),
        ]
        leaf = self._tree.path(values)[1] if self._tree is not None and self._split else STAY
        if leaf in self._split:
            share, numbers = self._split[leaf]
            reason = f"examples {', '.join(map(str, numbers))} disagree here"
            found.append(Uncertainty(min(1.0, 2.0 * share), DoubtReason.DISAGREEING, reason, numbers))
        if self._scant:
            found.append(Uncertainty(HARDLY, DoubtReason.SCANT, "there are hardly any examples yet"))
        return max(found, key=lambda each: each.amount)

    def rank_answers(self, values: Sequence[float]) -> tuple[int, ...]:
        """List the outcomes of the examples, that of the nearest one first."""
        shown = self._state.shown
        distances = self._state.plain_distances.compute(shown.values, np.array(values, np.float64))
        return tuple(dict.fromkeys(shown.outcomes[np.argsort(distances, kind="stable")].tolist()))

    def _far(
        self, values: Sequence[float], distances: NDArray[np.float64], apart: NDArray[np.float64]
    ) -> Uncertainty:
        nearest = int(distances.argmin())
        amount, numbers = (
            min(1.0, float(distances[nearest]) / (2 * FAR)),
            (self._state.examples[nearest].number,),
        )
        if amount < 0.5:
            return Uncertainty(amount, DoubtReason.SHOWN, "there are examples like this", numbers)
        off = apart[nearest]
        cells = find_cells_around(self._state.words, values)
        telling = {feature: cells[feature] for feature in np.flatnonzero(off >= 0.6 * off.max()).tolist()}
        said = describe_situation(self._state.words, telling)
        reason = f"there are no examples in {self._state.name} when {said}"
        return Uncertainty(amount, DoubtReason.FAR, reason, numbers)

    def _hangs(self, values: Sequence[float], outcome: int, distances: NDArray[np.float64]) -> Uncertainty:
        most, by = 0.0, -1
        for row, other in self._others:
            if other.decide(values) != outcome:
                amount = HANGS * min(1.0, max(0.0, float(distances[row]) - CLOSE_BY) / FAR)
                if amount > most:
                    most, by = amount, self._state.examples[row].number
        return Uncertainty(most, DoubtReason.HANGING, f"only example {by} says so", (by,))

    def _otherwise(self, distances: NDArray[np.float64], outcome: int) -> Uncertainty:
        """Return how much farther examples of this outcome are than examples of another, over all features."""
        amount, nearest = self._state.measure_contrast(distances, outcome)
        example = self._state.examples[int(nearest)]
        wish = "stay" if example.next == example.state else f"go to {example.next}"
        reason = f"example {example.number}, which is nearest, says {wish}"
        return Uncertainty(float(amount), DoubtReason.OTHERWISE, reason, (example.number,))


def _find_split_leaves(state: StateAnalysis, tree: Tree) -> dict[int, tuple[float, tuple[int, ...]]]:
    """Find the leaves whose examples disagree: the share of those outvoted, and the numbers of all in the leaf.

    A default counts only if its situation has no other example.
    """
    groups = group_by_feature_vector([each for each in state.examples if each.is_from_press]).values()
    leaves: dict[int, list[tuple[int, str]]] = {}
    for group in groups:
        for example in [each for each in group if each.is_shown] or group:
            leaf = tree.path(example.values)[1]
            leaves.setdefault(leaf, []).append((example.number, example.next))
    found = {}
    for leaf, answers in leaves.items():
        outcomes = [outcome for _, outcome in answers]
        most = max(map(outcomes.count, outcomes))
        if most < len(outcomes):
            found[leaf] = 1.0 - most / len(outcomes), tuple(number for number, _ in answers)
    return found
