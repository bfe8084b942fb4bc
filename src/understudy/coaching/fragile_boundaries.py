"""Boundaries held up by one example: what would be decided otherwise had a single press never been."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.lesson_analysis import Survey
from understudy.coaching.situation_text import Cells, box_of, cells_of
from understudy.model.example import Example
from understudy.model.tree import Tree

NEARBY = 0.15
"""So near, another example says the same: well within what is far from one."""
MOST_FURTHER = 24
"""So many presses of a large lesson are left out one by one for this, beside those that were already."""
MOST_ADVICE = 2
"""So many of one state."""


def single(survey: Survey) -> Iterator[Advice]:
    """For each state, presses without a fellow nearby that are decided otherwise than shown once they are left out.

    Those that decide most come first. Classifiers other than trees take too long to ask.
    """
    if survey.scant:
        return
    vectors, left = survey.situations.tolist(), MOST_FURTHER
    for state, learner in survey.learners.items():
        if not isinstance(survey.transition(state), Tree):
            continue
        now = learner.decided(survey.transition(state), vectors)
        known = {trial.rows[0]: trial.transition for trial in survey.trials[state] if len(trial.rows) == 1}
        found = []
        for row in _without_fellows(survey, state):
            example, outcome = learner.examples[row], learner.shown.outcomes[row]
            if row not in known:
                if not left:
                    break
                left -= 1
            without = known.get(row) or learner.without(row)
            if learner.decided(without, [example.values])[0] != outcome:
                changed = (now == outcome) & (learner.decided(without, vectors) != now)
                found.append((-float(changed.mean()) if len(changed) else 0.0, row, changed))
        told: set[str] = set()
        for share, row, changed in sorted(found, key=lambda each: each[:2]):
            example = learner.examples[row]
            if example.next not in told and len(told) < MOST_ADVICE:
                told.add(example.next)
                yield _make_isolated_press_advice(survey, state, example, changed, -share)


def _without_fellows(survey: Survey, state: str) -> list[int]:
    """The rows of presses that no other press nearby says the same as: else it is a matter of a little more or less."""
    learner = survey.learners[state]
    rows = np.flatnonzero([example.shown for example in learner.examples])
    values, outcomes = learner.shown.values[rows], learner.shown.outcomes[rows]
    near = survey.nearness(state).distances(values[:, None], values[None]) < NEARBY
    near &= outcomes[:, None] == outcomes[None]
    alone: list[int] = rows[near.sum(axis=1) == 1].tolist()  # itself
    return alone


def _is_alone(survey: Survey, state: str, example: Example) -> bool:
    """Whether no other press leads from the state to where it leads, wherever."""
    said = [each for each in survey.learners[state].examples if each.shown and each.next == example.next]
    return len(said) == 1


def _make_isolated_press_advice(
    survey: Survey, state: str, example: Example, changed: NDArray[np.bool_], share: float
) -> Advice:
    cells = _cells(survey, example, changed)
    said = survey.said(state, cells)
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
        box_of(survey.words, cells),
        (example.number,),
        example.values,
    )


def _cells(survey: Survey, example: Example, changed: NDArray[np.bool_]) -> Cells:
    """The cells of an example and of the situations that hang on it, where these are not all cells there are."""
    own = cells_of(survey.words, np.array([example.values], np.float64).reshape(1, -1))[0]
    cells = {}
    for feature, word in enumerate(survey.words):
        here = {int(own[feature]), *survey.cells[changed, feature].tolist()}
        if not here >= {*word.cells, *survey.cells[:, feature].tolist()}:
            cells[feature] = frozenset(here)
    return cells
