"""Boundaries held up by one example: what would be decided otherwise had a single press never been."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.survey import Survey
from understudy.coaching.wording import Cells, box_of, situation
from understudy.model.example import Example

LEAST_SHARE = 0.05
"""A boundary counts where so much of all situations would be decided otherwise."""
MOST = 2
"""So many of one state."""


def single(survey: Survey) -> Iterator[Advice]:
    """For each state, the press that most hangs on: leave it out, and many situations are decided otherwise."""
    if survey.scant or not len(survey.situations):
        return
    vectors = survey.situations.tolist()
    names = survey.lesson.automaton.state_names
    for state, learner in survey.learners.items():
        now = learner.decided(survey.transition(state), vectors)
        found = []
        for trial in survey.trials[state]:
            example = learner.examples[trial.rows[0]]
            if len(trial.rows) == 1 and example.shown:
                changed = (learner.decided(trial.transition, vectors) != now) & (
                    now == learner.shown.outcomes[trial.rows[0]]
                )
                found.append((float(changed.mean()), example, changed))
        found.sort(key=lambda each: (-each[0], each[1].number))
        told = dict.fromkeys(names, 0)
        for share, example, changed in found:
            if share >= LEAST_SHARE and told[example.next] < 1 and sum(told.values()) < MOST:
                told[example.next] += 1
                yield _advice(survey, state, example, changed, share)


def _advice(survey: Survey, state: str, example: Example, changed: NDArray[np.bool_], share: float) -> Advice:
    cells = _cells(survey, changed)
    said = situation(survey.words, cells)
    place = survey.place(state)
    when = f" when {said}" if said else ""
    if example.next == example.state:
        what = f"to keep {example.state}{when}"
    else:
        what = f"to go from {example.state} to {example.next}{when}" if place else f"{example.next}{when}"
    return Advice(
        AdviceKind.SINGLE,
        f"Only example {example.number} tells me {what}: show me once more.",
        place,
        0.25 + 0.35 * min(1.0, share / 0.5),
        box_of(survey.words, cells),
        (example.number,),
    )


def _cells(survey: Survey, chosen: NDArray[np.bool_]) -> Cells:
    """The cells that some situations have, of the features of which they do not have all that any has."""
    cells = {}
    for feature in range(survey.cells.shape[1]):
        here = set(survey.cells[chosen, feature].tolist())
        if here != set(survey.cells[:, feature].tolist()):
            cells[feature] = frozenset(here)
    return cells
