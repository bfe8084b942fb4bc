"""Leaves stretched too far: where a state is left although what was shown nearest says otherwise.

On a small lesson a question about the wrong feature often tells the examples apart as well as one about the right one;
"done when A is at 350° to 353°, however far" is what comes of that.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import isinf

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.coverage import possible
from understudy.coaching.distances import FAR, Nearness
from understudy.coaching.lesson_analysis import Survey
from understudy.coaching.situation_text import box_of, cells_of
from understudy.model.tree import STAY, Tree
from understudy.model.tree_regions import Box, Region, boxes

LEAST = 0.5
"""From so much farther on, as a share of what is twice as far as far, it is asked."""
MOST_SITUATIONS = 48
MOST_ADVICE = 2
"""So many of one state."""


def stretched(survey: Survey) -> Iterator[Advice]:
    """For each state, the leaves that leave it where other examples are much nearer than those behind them."""
    if survey.scant or not len(survey.situations):
        return
    for state in survey.learners:
        tree = survey.transition(state)
        if isinstance(tree, Tree):
            found = [each for each in _leaves(survey, state, tree) if each[0] >= LEAST]
            for amount, row, box, outcome, other in sorted(found, key=lambda each: -each[0])[:MOST_ADVICE]:
                yield _make_stretched_leaf_advice(survey, state, amount, row, box, outcome, other)


def _leaves(
    survey: Survey, state: str, tree: Tree
) -> Iterator[tuple[float, NDArray[np.float64], Box, int, int]]:
    """Of each leaf that leaves the state: how much nearer other examples are, at worst; where; the leaf's box and
    outcome; and the row of the nearest other example.
    """
    shown = survey.learners[state].shown
    plain = Nearness(survey.words, None)
    situations = survey.situations[possible(survey, state)][:MOST_SITUATIONS]
    for outcome, box in boxes(tree, [bound.kind for bound in survey.lesson.automaton.features]):
        same = shown.outcomes == outcome
        if outcome in (STAY, shown.current) or same.all() or not same.any() or not len(situations):
            continue
        rows = _moved_into(box, situations)
        distances = plain.distances(rows[:, None], shown.values[None])
        others = np.where(same, np.inf, distances)
        amounts = np.minimum((distances[:, same].min(axis=1) - others.min(axis=1)) / (2 * FAR), 1.0)
        worst = int(amounts.argmax())
        yield float(amounts[worst]), rows[worst], box, outcome, int(others[worst].argmin())


def _moved_into(box: Box, situations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Situations with every value that lies outside a box moved into it."""
    rows = situations.copy()
    for column, region in enumerate(box):
        outside = [value not in region for value in rows[:, column].tolist()]
        rows[outside, column] = _inside(region)
    return rows


def _inside(region: Region) -> float:
    if not region.parts:
        return np.nan
    low, high = region.parts[0]
    if isinf(low) or isinf(high):
        return high - 1e-6 * max(1.0, abs(high)) if isinf(low) and not isinf(high) else low
    return low if high - low == 1.0 and low == int(low) else (low + high) / 2


def _make_stretched_leaf_advice(
    survey: Survey, state: str, amount: float, row: NDArray[np.float64], box: Box, outcome: int, other: int
) -> Advice:
    cells = {
        feature: frozenset({int(cell)}) for feature, cell in enumerate(cells_of(survey.words, row[None])[0])
    }
    region = tuple(mine & leaf for mine, leaf in zip(box_of(survey.words, cells), box, strict=True))
    following = survey.lesson.automaton.state_names[outcome]
    nearest = survey.learners[state].examples[other]
    wish = "stay" if nearest.next == nearest.state else nearest.next
    place = survey.place(state)
    start = f"go from {place} to {following}" if place else f"do {following}"
    return Advice(
        AdviceKind.STRETCHED,
        f"Is it right that I {start} when {survey.said(state, cells)}? The nearest example, {nearest.number}, "
        f"says {wish}.",
        place,
        0.3 + 0.35 * amount,
        region,
        (nearest.number,),
        tuple(row.tolist()),
    )
