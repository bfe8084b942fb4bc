"""Advise on boundaries that depend on a single example, and on leaves that reach far beyond their examples."""

from __future__ import annotations

from collections.abc import Iterator
from math import isinf

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.coverage import find_possible_situations
from understudy.coaching.distances import FAR, FeatureDistances
from understudy.coaching.lesson_analysis import LessonAnalysis
from understudy.coaching.situation_text import Cells, find_cells, make_situation_box
from understudy.model.lesson import Example
from understudy.model.tree import STAY, Tree
from understudy.model.tree_regions import Box, ValueSet, list_leaf_boxes

NEARBY = 0.15
"""So near, another example says the same: well within what is far from one."""
MOST_FURTHER = 24
"""So many presses of a large lesson are left out one by one for this, beside those that were already."""
MOST_ADVICE = 2
"""So many of one state."""


def advise_on_isolated_presses(survey: LessonAnalysis) -> Iterator[Advice]:
    """Advise, for each state, on presses without similar ones that are decided differently once they are left out.

    Those that affect most situations come first. Classifiers other than trees would take too long.
    """
    if survey.is_scant:
        return
    vectors, left = survey.situations.tolist(), MOST_FURTHER
    for state, learner in survey.learners.items():
        if not isinstance(survey.transition(state), Tree):
            continue
        now = learner.decide_all(survey.transition(state), vectors)
        known = {trial.rows[0]: trial.transition for trial in survey.trials[state] if len(trial.rows) == 1}
        found = []
        for row in _without_fellows(survey, state):
            example, outcome = learner.examples[row], learner.shown.outcomes[row]
            if row not in known:
                if not left:
                    break
                left -= 1
            without = known.get(row) or learner.fit_without(row)
            if learner.decide_all(without, [example.values])[0] != outcome:
                changed = (now == outcome) & (learner.decide_all(without, vectors) != now)
                found.append((-float(changed.mean()) if len(changed) else 0.0, row, changed))
        told: set[str] = set()
        for share, row, changed in sorted(found, key=lambda each: each[:2]):
            example = learner.examples[row]
            if example.next not in told and len(told) < MOST_ADVICE:
                told.add(example.next)
                yield _make_isolated_press_advice(survey, state, example, changed, -share)


def _without_fellows(survey: LessonAnalysis, state: str) -> list[int]:
    """Return the rows of presses that no other nearby press agrees with; otherwise only the exact boundary is open."""
    learner = survey.learners[state]
    rows = np.flatnonzero([example.is_shown for example in learner.examples])
    values, outcomes = learner.shown.values[rows], learner.shown.outcomes[rows]
    near = survey.make_distances(state).compute(values[:, None], values[None]) < NEARBY
    near &= outcomes[:, None] == outcomes[None]
    alone: list[int] = rows[near.sum(axis=1) == 1].tolist()  # itself
    return alone


def _is_alone(survey: LessonAnalysis, state: str, example: Example) -> bool:
    """Return whether no other press leads from the state to the same next state."""
    said = [each for each in survey.learners[state].examples if each.is_shown and each.next == example.next]
    return len(said) == 1


def _make_isolated_press_advice(
    survey: LessonAnalysis, state: str, example: Example, changed: NDArray[np.bool_], share: float
) -> Advice:
    cells = _cells(survey, example, changed)
    said = survey.describe_situation(state, cells)
    place = survey.place(state)
    when = f" when {said}" if said else ""
    if example.next == example.state:
        what = f"to keep {example.state}{when}"
    else:
        what = f"to go from {example.state} to {example.next}{when}" if place else f"{example.next}{when}"
    return Advice(
        AdviceKind.SINGLE,
        f"Only example {example.number} tells me {what}: show me once more, or delete it.",
        place,
        (0.5 if _is_alone(survey, state, example) else 0.25) + 0.2 * min(1.0, share / 0.5),
        make_situation_box(survey.words, cells),
        (example.number,),
        example.values,
    )


def _cells(survey: LessonAnalysis, example: Example, changed: NDArray[np.bool_]) -> Cells:
    """Return the cells of an example and of the situations that depend on it, unless these are all cells."""
    own = find_cells(survey.words, np.array([example.values], np.float64).reshape(1, -1))[0]
    cells = {}
    for feature, word in enumerate(survey.words):
        here = {int(own[feature]), *survey.cells[changed, feature].tolist()}
        if not here >= {*word.cells, *survey.cells[:, feature].tolist()}:
            cells[feature] = frozenset(here)
    return cells


LEAST = 0.5
"""From so much farther on, as a share of what is twice as far as far, it is asked."""
MOST_SITUATIONS = 48


def advise_on_stretched_leaves(survey: LessonAnalysis) -> Iterator[Advice]:
    """Advise, for each state, on leaves that leave it where other examples are much nearer than their own."""
    if survey.is_scant or not len(survey.situations):
        return
    for state in survey.learners:
        tree = survey.transition(state)
        if isinstance(tree, Tree):
            found = [each for each in _leaves(survey, state, tree) if each[0] >= LEAST]
            for amount, row, box, outcome, other in sorted(found, key=lambda each: -each[0])[:MOST_ADVICE]:
                yield _make_stretched_leaf_advice(survey, state, amount, row, box, outcome, other)


def _leaves(
    survey: LessonAnalysis, state: str, tree: Tree
) -> Iterator[tuple[float, NDArray[np.float64], Box, int, int]]:
    """Yield data of each leaf that leaves the state.

    These are how much nearer other examples are, at worst; where; the leaf's box and outcome; and the row of the
    nearest other example.
    """
    shown = survey.learners[state].shown
    plain = FeatureDistances(survey.words, None)
    situations = survey.situations[find_possible_situations(survey, state)][:MOST_SITUATIONS]
    for outcome, box in list_leaf_boxes(tree, [bound.kind for bound in survey.lesson.automaton.features]):
        same = shown.outcomes == outcome
        if outcome in (STAY, shown.current) or same.all() or not same.any() or not len(situations):
            continue
        rows = _moved_into(box, situations)
        distances = plain.compute(rows[:, None], shown.values[None])
        others = np.where(same, np.inf, distances)
        amounts = np.minimum((distances[:, same].min(axis=1) - others.min(axis=1)) / (2 * FAR), 1.0)
        worst = int(amounts.argmax())
        yield float(amounts[worst]), rows[worst], box, outcome, int(others[worst].argmin())


def _moved_into(box: Box, situations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return situations with every value outside a box moved to its edge."""
    rows = situations.copy()
    for column, region in enumerate(box):
        outside = [value not in region for value in rows[:, column].tolist()]
        rows[outside, column] = _inside(region)
    return rows


def _inside(region: ValueSet) -> float:
    if not region.parts:
        return np.nan
    low, high = region.parts[0]
    if isinf(low) or isinf(high):
        return high - 1e-6 * max(1.0, abs(high)) if isinf(low) and not isinf(high) else low
    return low if high - low == 1.0 and low == int(low) else (low + high) / 2


def _make_stretched_leaf_advice(
    survey: LessonAnalysis,
    state: str,
    amount: float,
    row: NDArray[np.float64],
    box: Box,
    outcome: int,
    other: int,
) -> Advice:
    cells = {
        feature: frozenset({int(cell)}) for feature, cell in enumerate(find_cells(survey.words, row[None])[0])
    }
    region = tuple(
        mine & leaf for mine, leaf in zip(make_situation_box(survey.words, cells), box, strict=True)
    )
    following = survey.lesson.automaton.state_names[outcome]
    nearest = survey.learners[state].examples[other]
    wish = "stay" if nearest.next == nearest.state else nearest.next
    place = survey.place(state)
    start = f"go from {place} to {following}" if place else f"do {following}"
    return Advice(
        AdviceKind.STRETCHED,
        f"Is it right that I {start} when {survey.describe_situation(state, cells)}? "
        f"The nearest example, {nearest.number}, says {wish}.",
        place,
        0.3 + 0.35 * amount,
        region,
        (nearest.number,),
        tuple(row.tolist()),
    )
