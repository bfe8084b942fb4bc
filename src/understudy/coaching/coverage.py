"""Situations near no example: what was never shown in a state, in the widest words that hold no example."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.distances import FAR
from understudy.coaching.lesson_analysis import LessonAnalysis
from understudy.coaching.situation_text import find_cells, make_situation_box, match_cells
from understudy.model.features import FlagFeature

MOST = 2
"""So many of one state."""
BEGINNING = 0.7
"""What a gap in the start state counts beside others: it is passed once, and what follows can make up for it."""
LEAST_SHARE = 0.02
"""A situation rarer than this is not worth a person's time."""


def advise_on_coverage_gaps(survey: LessonAnalysis) -> Iterator[Advice]:
    """What was never shown, state by state; the situations that are farthest from all examples first."""
    if survey.scant or not len(survey.situations):
        return
    for state in survey.learners:
        yield from _gaps(survey, state)


def _gaps(survey: LessonAnalysis, state: str) -> Iterator[Advice]:
    rows = survey.learners[state].shown.values
    nearness = survey.nearness(state)
    nearest = nearness.distances(survey.situations[:, None], rows[None]).min(axis=1)
    shown = find_cells(survey.words, rows)
    open_ = (nearest >= FAR) & find_possible_situations(survey, state)
    for _ in range(MOST):
        if not open_.any():
            return
        farthest = int(np.argmax(np.where(open_, nearest, -1.0)))
        open_[farthest] = False
        widest = _widest(survey, farthest, rows, shown, state)
        if widest is None:
            continue
        there = match_cells(widest, survey.cells)
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
            make_situation_box(survey.words, widest),
            at=tuple(survey.situations[farthest].tolist()),
        )


def find_possible_situations(survey: LessonAnalysis, state: str) -> NDArray[np.bool_]:
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
    survey: LessonAnalysis, farthest: int, rows: NDArray[np.float64], shown: NDArray[np.int64], state: str
) -> dict[int, frozenset[int]] | None:
    """The cells round a situation, without features that need not be said for no example to be there.

    First to go is the feature that differs least from the nearest example; None where an example is in its very cells.
    """
    cells = {feature: frozenset({int(cell)}) for feature, cell in enumerate(survey.cells[farthest])}
    if not cells or match_cells(cells, shown).any():
        return None
    nearness = survey.nearness(state)
    here = survey.situations[farthest]
    nearest = int(np.argmin(nearness.distances(rows, here)))
    for feature in np.argsort(nearness.apart(rows[nearest], here), kind="stable").tolist():
        wider = {other: allowed for other, allowed in cells.items() if other != feature}
        if wider and not match_cells(wider, shown).any():
            cells = wider
    return cells
