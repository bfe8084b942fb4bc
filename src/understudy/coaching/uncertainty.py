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

from understudy.coaching.lesson_analysis import ENOUGH, FAR, FeatureDistances, StateFit, make_state_fits
from understudy.coaching.situation_sampling import stack_example_vectors
from understudy.coaching.situation_text import (
    FeaturePhrases,
    describe_situation,
    find_cells,
    make_feature_phrases,
)
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
        self._words = make_feature_phrases(lesson.automaton.features, stack_example_vectors(lesson))
        found = make_state_fits(lesson)
        scant = sum(example.is_shown for learner in found.values() for example in learner.examples) < ENOUGH
        made = {
            name: _StateModel(learner, transitions[name], self._words, scant=scant)
            for name, learner in found.items()
        }
        shared = next(iter(made.values()), None)
        self._states = (
            dict.fromkeys(group_examples_by_state(lesson), shared) if lesson.automaton.stateless else made
        )
        self._flags = {state.name for state in lesson.automaton.states if state.flag is not None}

    def estimate(self, state: str, values: Sequence[float]) -> Uncertainty:
        """Estimate the uncertainty of the decision in a state for a feature vector; 0 in a flag state."""
        known = self._states.get(state)
        if known is not None:
            return known.estimate(values)
        if state in self._flags:
            return Uncertainty(0.0, DoubtReason.SHOWN, "a raised flag is never left")
        return Uncertainty(NONE_SHOWN, DoubtReason.UNTAUGHT, f"there are no examples in {state}")

    def rank_answers(self, state: str, values: Sequence[float]) -> tuple[int, ...]:
        """List the next states, by index, that examples of this state have, that of the nearest example first."""
        known = self._states.get(state)
        return () if known is None else known.rank_answers(values)


class _StateModel:
    """The uncertainty of decisions in one state."""

    def __init__(
        self, learner: StateFit, transition: Transition, words: Sequence[FeaturePhrases], *, scant: bool
    ) -> None:
        self._learner, self._transition, self._words, self._scant = learner, transition, words, scant
        self._nearness, self._plain = FeatureDistances(words, transition), FeatureDistances(words, None)
        self._rows = learner.shown.values
        self._numbers = [example.number for example in learner.examples]
        outcomes = learner.shown.outcomes
        masks = {int(outcome): outcomes == outcome for outcome in np.unique(outcomes)}
        self._same = {outcome: mask for outcome, mask in masks.items() if not mask.all()}
        self._split = _split(learner, transition) if isinstance(transition, Tree) else {}

    @cached_property
    def _others(self) -> list[tuple[int, Transition]]:
        """The trees of the state learned without one example each, computed at the first use."""
        learner = self._learner
        if not isinstance(self._transition, Tree):
            return []
        rows = [row for row in learner.press_rows.tolist() if learner.examples[row].is_shown]
        return [(row, learner.fit_without(row)) for row in rows[:: -(-len(rows) // MOST_OTHERS) or 1]]

    def estimate(self, values: Sequence[float]) -> Uncertainty:
        """Return the strongest of the reasons for uncertainty."""
        outcome = self._transition.decide(values)
        leaf = self._transition.path(values)[1] if self._split else STAY
        if outcome == STAY and isinstance(self._transition, Tree):
            return Uncertainty(
                0.9, DoubtReason.UNSHOWN, f"there are no examples like this in {self._learner.state}"
            )
        here = np.array(values, np.float64)
        apart = self._nearness.compute_by_feature(self._rows, here)
        distances = self._nearness.combine(apart)
        nearest = int(distances.argmin())
        found = [
            self._far(float(distances[nearest]), nearest, here, apart[nearest]),
            self._hangs(values, outcome, distances),
            self._otherwise(self._plain.combine(apart), outcome),
        ]
        if leaf in self._split:
            share, numbers = self._split[leaf]
            found.append(
                Uncertainty(
                    min(1.0, 2.0 * share),
                    DoubtReason.DISAGREEING,
                    f"examples {', '.join(map(str, numbers))} disagree here",
                    numbers,
                )
            )
        if self._scant:
            found.append(Uncertainty(HARDLY, DoubtReason.SCANT, "there are hardly any examples yet"))
        return max(found, key=lambda each: each.amount)

    def rank_answers(self, values: Sequence[float]) -> tuple[int, ...]:
        """List the outcomes of the examples, that of the nearest one first."""
        here = np.array(values, np.float64)
        distances = self._plain.combine(self._plain.compute_by_feature(self._rows, here))
        outcomes = self._learner.shown.outcomes[np.argsort(distances, kind="stable")]
        return tuple(dict.fromkeys(outcomes.tolist()))

    def _far(
        self, distance: float, nearest: int, here: NDArray[np.float64], off: NDArray[np.float64]
    ) -> Uncertainty:
        amount = min(1.0, distance / (2 * FAR))
        if amount < 0.5:
            return Uncertainty(
                amount, DoubtReason.SHOWN, "there are examples like this", (self._numbers[nearest],)
            )
        cells = find_cells(self._words, here[None])[0]
        telling = {
            feature: frozenset({int(cells[feature])})
            for feature in np.flatnonzero(off >= 0.6 * off.max()).tolist()
        }
        said = describe_situation(self._words, telling)
        return Uncertainty(
            amount,
            DoubtReason.FAR,
            f"there are no examples in {self._learner.state} when {said}",
            (self._numbers[nearest],),
        )

    def _hangs(self, values: Sequence[float], outcome: int, distances: NDArray[np.float64]) -> Uncertainty:
        most, by = 0.0, -1
        for row, other in self._others:
            if other.decide(values) != outcome:
                amount = HANGS * min(1.0, max(0.0, float(distances[row]) - CLOSE_BY) / FAR)
                if amount > most:
                    most, by = amount, self._numbers[row]
        return Uncertainty(most, DoubtReason.HANGING, f"only example {by} says so", (by,))

    def _otherwise(self, distances: NDArray[np.float64], outcome: int) -> Uncertainty:
        """Return how much farther examples of this outcome are than examples of another, over all features."""
        same = self._same.get(outcome)
        if same is None:
            return Uncertainty(0.0, DoubtReason.SHOWN, "")
        others = np.where(same, np.inf, distances)
        nearest = int(others.argmin())
        amount = min(1.0, max(0.0, float(distances[same].min() - others[nearest])) / (2 * FAR))
        example = self._learner.examples[nearest]
        wish = "stay" if example.next == example.state else f"go to {example.next}"
        reason = f"example {example.number}, which is nearest, says {wish}"
        return Uncertainty(amount, DoubtReason.OTHERWISE, reason, (example.number,))


def _split(learner: StateFit, tree: Tree) -> dict[int, tuple[float, tuple[int, ...]]]:
    """Return the leaves whose examples disagree: the share of those outvoted, and the numbers of all in the leaf.

    A default counts only if its situation has no other example.
    """
    heard = [
        example
        for group in group_by_feature_vector(
            [each for each in learner.examples if each.is_from_press]
        ).values()
        for example in ([each for each in group if each.is_shown] or group)
    ]
    leaves: dict[int, list[tuple[int, str]]] = {}
    for example in heard:
        leaves.setdefault(tree.path(example.values)[1], []).append((example.number, example.next))
    found = {}
    for leaf, told in leaves.items():
        wishes = [wish for _, wish in told]
        most = max(wishes.count(wish) for wish in set(wishes))
        if most < len(wishes):
            found[leaf] = 1.0 - most / len(wishes), tuple(number for number, _ in told)
    return found
