"""Situations far from all examples of a state, described by as few features as possible."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.distances import FAR
from understudy.coaching.lesson_analysis import LessonAnalysis
from understudy.coaching.situation_text import find_cells, make_situation_box, match_cells
from understudy.errors import join_names
from understudy.learning.training_set import select_teaching_examples
from understudy.model.features import FlagFeature
from understudy.model.tree import Tree
from understudy.model.tree_regions import find_tested_features

MOST = 2
"""So many of one state."""
BEGINNING = 0.7
"""What a gap in the start state counts beside others: it is passed once, and what follows can make up for it."""
LEAST_SHARE = 0.02
"""A situation rarer than this is not worth a person's time."""


def advise_on_coverage_gaps(survey: LessonAnalysis) -> Iterator[Advice]:
    """Advise on situations without examples, state by state, those farthest from all examples first."""
    if survey.is_scant or not len(survey.situations):
        return
    for state in survey.learners:
        yield from _gaps(survey, state)


def _gaps(survey: LessonAnalysis, state: str) -> Iterator[Advice]:
    rows = survey.learners[state].shown.values
    nearness = survey.make_distances(state)
    nearest = nearness.compute(survey.situations[:, None], rows[None]).min(axis=1)
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
        said = survey.describe_situation(state, widest)
        place = survey.place(state)
        where = f" in state {place}" if place else ""
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
    """Return which situations can occur in a state: a flag counts as raised only if an example has it raised there."""
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
    """Return the cells around a situation, without the features that are not needed to exclude all examples.

    The feature that differs least from the nearest example goes first. None if an example has the same cells.
    """
    cells = {feature: frozenset({int(cell)}) for feature, cell in enumerate(survey.cells[farthest])}
    if not cells or match_cells(cells, shown).any():
        return None
    nearness = survey.make_distances(state)
    here = survey.situations[farthest]
    nearest = int(np.argmin(nearness.compute(rows, here)))
    for feature in np.argsort(nearness.compute_by_feature(rows[nearest], here), kind="stable").tolist():
        wider = {other: allowed for other, allowed in cells.items() if other != feature}
        if wider and not match_cells(wider, shown).any():
            cells = wider
    return cells


def advise_on_states_never_left(survey: LessonAnalysis) -> Iterator[Advice]:
    """Advise on states, other than flag states, that no example leaves; the start state is the most urgent."""
    automaton, examples = survey.lesson.automaton, select_teaching_examples(survey.lesson)
    if automaton.stateless:
        return
    left = {example.state for example in examples if example.next != example.state}
    entered = {example.next for example in examples}
    for index, state in enumerate(automaton.states):
        if state.flag is not None or state.name in left or (index and state.name not in entered):
            continue
        if index == 0:
            sentence = f"Show me what to do first: nothing leads from {state.name} to any other state."
        else:
            sentence = f"Show me when to leave {state.name}: so far I stay in it for good."
        yield Advice(AdviceKind.NEVER_LEFT, sentence, state.name, 0.9 if index == 0 else 0.6)


def advise_on_states_never_entered(survey: LessonAnalysis) -> Iterator[Advice]:
    """Advise on states that no example leads to."""
    automaton = survey.lesson.automaton
    entered = {example.next for example in select_teaching_examples(survey.lesson)}
    for state in automaton.states[1:]:
        if state.name not in entered:
            what = f"say {state.flag}" if state.flag is not None else f"go to {state.name}"
            yield Advice(
                AdviceKind.NEVER_ENTERED,
                f"Show me when to {what}, or leave it out: nothing you showed leads there.",
                state.name,
                0.55 if state.flag is None else 0.8,
            )


def advise_on_unused_features(survey: LessonAnalysis) -> Iterator[Advice]:
    """Advise on features that no tree tests."""
    trees = [function for function in survey.transitions.values() if isinstance(function, Tree)]
    if survey.is_scant or not trees or len(trees) < len(survey.transitions):
        return
    used = find_tested_features(trees)
    names = [str(bound) for index, bound in enumerate(survey.lesson.automaton.features) if index not in used]
    if names:
        many = len(names) > 1
        yield Advice(
            AdviceKind.IDLE,
            f"Leave out {join_names(names)}, or show me where {'they matter' if many else 'it matters'}: so far "
            f"{'they decide' if many else 'it decides'} nothing.",
            "",
            0.2,
        )
