"""The uncertainty of decisions, from 0 (as demonstrated) to 1 (no similar example), with its reason.

doubts = UncertaintyModel(lesson, learn(lesson))
doubts.estimate("forward", [0.3, 1.2])
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.lesson_analysis import FAR, LessonAnalysis, StateAnalysis
from understudy.coaching.situation_text import describe_situation
from understudy.model.automaton import Transition, name_next_state
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
    ELSEWHERE = "elsewhere"  # a flag is raised elsewhere than it was shown
    REPEATING = "repeating"  # it stays in a state, and comes back to the same situation again and again


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """The uncertainty of one decision, 0 to 1, with its reason, a sentence, and the examples concerned."""

    amount: float
    because: DoubtReason
    reason: str
    examples: tuple[int, ...] = ()


NONE_SHOWN, HARDLY = 1.0, 0.6
"""The doubt in a state without examples, and the doubt in a lesson with very few."""
HANGS = 0.7
"""The largest doubt about a decision near a boundary that depends on a single example."""
CLOSE_BY = 0.05
"""The distance to the single example below which its decision is not in doubt."""


class UncertaintyModel:
    """The uncertainty of a lesson's transition functions, prepared once for a lesson and queried at every tick."""

    def __init__(self, lesson: Lesson, transitions: Mapping[str, Transition]) -> None:
        self._automaton, self._analysis = lesson.automaton, LessonAnalysis(lesson, transitions)
        self._flags = {state.name for state in lesson.automaton.states if state.flag is not None}

    def estimate(self, state: str, values: Sequence[float]) -> Uncertainty:
        """Estimate the uncertainty of the decision in a state for a feature vector; 0 in a flag state.

        Of several reasons for doubt, the strongest counts.
        """
        if state in self._flags:
            return Uncertainty(0.0, DoubtReason.SHOWN, "a raised flag is never left")
        here = self._analysis.find_state(state)
        if here is None:
            return Uncertainty(NONE_SHOWN, DoubtReason.UNTAUGHT, f"there are no examples in {state}")
        outcome = here.transition.decide(values)
        if outcome == STAY and isinstance(here.transition, Tree):
            return Uncertainty(0.9, DoubtReason.UNSHOWN, f"there are no examples like this in {here.name}")
        apart = here.distances.compute_by_feature(here.shown.values, np.array(values, np.float64))
        distances = here.distances.combine(apart)
        doubts = [
            _find_far(here, values, distances, apart),
            _find_hanging(here, values, outcome, distances),
            _find_otherwise(here, outcome, here.plain_distances.combine(apart)),
        ]
        leaf = here.transition.path(values)[1] if here.split_leaves else STAY
        if leaf in here.split_leaves:
            share, numbers = here.split_leaves[leaf]
            reason = f"examples {', '.join(map(str, numbers))} disagree here"
            doubts.append(Uncertainty(min(1.0, 2.0 * share), DoubtReason.DISAGREEING, reason, numbers))
        if self._analysis.is_scant:
            doubts.append(Uncertainty(HARDLY, DoubtReason.SCANT, "there are hardly any examples yet"))
        return max(doubts, key=lambda each: each.amount)

    def decide(self, state: str, values: Sequence[float]) -> str:
        """Return the next state that is decided for in a state; its own if nothing was shown in it."""
        here = None if state in self._flags else self._analysis.find_state(state)
        if here is None:
            return state
        return name_next_state(self._automaton, state, here.transition.decide(values))

    def rank_answers(self, state: str, values: Sequence[float]) -> tuple[str, ...]:
        """List all states: that of the decision, those of the nearest examples, the present one, then the others."""
        names, nearest = self._automaton.state_names, list[str]()
        here = None if state in self._flags else self._analysis.find_state(state)
        if here is not None:
            distances = here.plain_distances.compute(here.shown.values, np.array(values, np.float64))
            nearest = [
                names[row] for row in here.shown.outcomes[np.argsort(distances, kind="stable")].tolist()
            ]
        return tuple(dict.fromkeys((self.decide(state, values), *nearest, state, *names[1:])))


def _find_far(
    state: StateAnalysis,
    values: Sequence[float],
    distances: NDArray[np.float64],
    apart: NDArray[np.float64],
) -> Uncertainty:
    nearest = int(distances.argmin())
    amount, numbers = min(1.0, float(distances[nearest]) / (2 * FAR)), (state.examples[nearest].number,)
    if amount < 0.5:
        return Uncertainty(amount, DoubtReason.SHOWN, "there are examples like this", numbers)
    off, cells = apart[nearest], state.find_cells_around(values)
    telling = {feature: cells[feature] for feature in np.flatnonzero(off >= 0.6 * off.max()).tolist()}
    reason = f"there are no examples in {state.name} when {describe_situation(state.words, telling)}"
    return Uncertainty(amount, DoubtReason.FAR, reason, numbers)


def _find_hanging(
    state: StateAnalysis, values: Sequence[float], outcome: int, distances: NDArray[np.float64]
) -> Uncertainty:
    most, by = 0.0, -1
    for row, transition in state.fits_without_one:
        if transition.decide(values) != outcome:
            amount = HANGS * min(1.0, max(0.0, float(distances[row]) - CLOSE_BY) / FAR)
            if amount > most:
                most, by = amount, state.examples[row].number
    return Uncertainty(most, DoubtReason.HANGING, f"only example {by} says so", (by,))


def _find_otherwise(state: StateAnalysis, outcome: int, distances: NDArray[np.float64]) -> Uncertainty:
    amount, nearest = state.measure_contrast(distances, outcome)
    example = state.examples[int(nearest)]
    wish = "stay" if example.next == example.state else f"go to {example.next}"
    reason = f"example {example.number}, which is nearest, says {wish}"
    return Uncertainty(float(amount), DoubtReason.OTHERWISE, reason, (example.number,))
