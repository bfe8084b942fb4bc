"""Situations near no example: what was never shown in a state, in the widest words that hold no example."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.distances import FAR
from understudy.coaching.lesson_analysis import Survey
from understudy.coaching.situation_text import box_of, cells_of, within
from understudy.model.features import FlagFeature

MOST = 2
"""So many of one state."""
BEGINNING = 0.7
"""What a gap in the start state counts beside others: it is passed once, and what follows can make up for it."""
LEAST_SHARE = 0.02
"""A situation rarer than this is not worth a person's time."""


def gaps(survey: Survey) -> Iterator[Advice]:
    """What was never shown, state by state; the situations that are farthest from all examples first."""
    if survey.scant or not len(survey.situations):
        return
    for state in survey.learners:
        yield from _gaps(survey, state)


def _gaps(survey: Survey, state: str) -> Iterator[Advice]:
    rows = survey.learners[state].shown.values
    nearness = survey.nearness(state)
    nearest = nearness.distances(survey.situations[:, None], rows[None]).min(axis=1)
    shown = cells_of(survey.words, rows)
    open_ = (nearest >= FAR) & possible(survey, state)
    for _ in range(MOST):
        if not open_.any():
            return
        farthest = int(np.argmax(np.where(open_, nearest, -1.0)))
        open_[farthest] = False
        widest = _widest(survey, farthest, rows, shown, state)
        if widest is None:
            continue
        there = within(widest, survey.cells)
        open_ &= ~there
        share = float(there.mean())
        if share < LEAST_SHARE:
            continue
        said = survey.said(state, widest)
        place = survey.place(state)
        where = f" in {place}" if place else ""
        once = BEGINNING if place == survey.lesson.automaton.states[0].name else 1.0
        yield Advice(
            AdviceKind.GAP,
            f"Show me what to do{where} when {said}: I was never shown that.",
            place,
            0.3 + 0.35 * once * float(nearest[farthest]) * min(1.0, share / 0.25),
            box_of(survey.words, widest),
            at=tuple(survey.situations[farthest].tolist()),
        )


def possible(survey: Survey, state: str) -> NDArray[np.bool_]:
    """Which of the situations may come about in a state: a flag is raised there only where that was ever seen."""
    found = np.ones(len(survey.situations), np.bool_)
    if survey.lesson.automaton.stateless:
        return found
    rows = survey.learners[state].shown.values
    for column, bound in enumerate(survey.lesson.automaton.features):
        if isinstance(bound.feature, FlagFeature):
            found &= np.isin(survey.situations[:, column], rows[:, column])
    return found


def _widest(
    survey: Survey, farthest: int, rows: NDArray[np.float64], shown: NDArray[np.int64], state: str
) -> dict[int, frozenset[int]] | None:
    """The cells round a situation, without features that need not be said for no example to be there.

    First to go is the feature that differs least from the nearest example; None where an example is in its very cells.
    """
    cells = {feature: frozenset({int(cell)}) for feature, cell in enumerate(survey.cells[farthest])}
    if not cells or within(cells, shown).any():
        return None
    nearness = survey.nearness(state)
    here = survey.situations[farthest]
    nearest = int(np.argmin(nearness.distances(rows, here)))
    for feature in np.argsort(nearness.apart(rows[nearest], here), kind="stable").tolist():
        wider = {other: allowed for other, allowed in cells.items() if other != feature}
        if wider and not within(wider, shown).any():
            cells = wider
    return cells
