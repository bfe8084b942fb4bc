"""List what a lesson lacks, most useful first.

for each in give_advice(lesson, learn(lesson), kit=kit):
    print(each.sentence)
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import isinf, sqrt
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.advice import (
    MOST_ADVICE,
    Advice,
    AdviceKind,
    advise_on_contradictions,
    advise_on_isolated_presses,
    advise_on_mislabels,
    advise_on_overruled_defaults,
)
from understudy.coaching.lesson_analysis import (
    FAR,
    HALVES,
    Accuracy,
    FeatureDistances,
    LessonAnalysis,
    score_half_of_examples,
    score_leave_one_out,
)
from understudy.coaching.situation_text import find_cells, make_situation_box, match_cells
from understudy.errors import join_names
from understudy.learning.training_set import select_teaching_examples
from understudy.model.automaton import Transition
from understudy.model.features import FlagFeature
from understudy.model.learner_options import SklearnOptions
from understudy.model.lesson import Lesson
from understudy.model.library import Kit
from understudy.model.tree import STAY, Tree
from understudy.model.tree_regions import Box, ValueSet, find_tested_features, list_leaf_boxes

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


LEAST_CASES = 8
"""With fewer cases such a share says nothing."""
GOOD = 0.95


def advise_on_accuracy(survey: LessonAnalysis) -> Iterator[Advice]:
    """Report the leave-one-out accuracy in one sentence; nothing if there are too few examples."""
    whole = score_leave_one_out(survey.learners, survey.trials)
    if survey.is_scant or whole.of < LEAST_CASES:
        return
    slow = isinstance(survey.lesson.options.learner, SklearnOptions)
    half = score_half_of_examples(survey.learners, halves=1 if slow else HALVES)
    told = f"leave each example out in turn and I get {whole.right} of {whole.of} right"
    if whole.share >= GOOD:
        yield _advice(f"I have seen enough of what you showed: {told}.", 0.05)
    elif has_accuracy_grown(whole, half):
        sentence = f"More examples are likely to help: {told}, and with half of the others {half.share:.0%}."
        yield _advice(sentence, 0.35)
    else:
        sentence = (
            f"More of the same may not help: {told}, and no fewer with half of the others; look at features."
        )
        yield _advice(sentence, 0.3)


def has_accuracy_grown(whole: Accuracy, half: Accuracy) -> bool:
    """Return whether accuracy grew from half of the examples to all by more than its standard error."""
    error = sqrt(max(whole.share * (1 - whole.share), 0.01) / max(1, whole.of))
    return whole.share - half.share > error


def _advice(sentence: str, weight: float) -> Advice:
    return Advice(AdviceKind.OUTLOOK, sentence, "", weight)


UNSURE = 0.3
"""No advice on a lesson of hardly any examples weighs more."""


def give_advice(
    lesson: Lesson,
    transitions: Mapping[str, Transition],
    *,
    kit: Kit | None = None,
    situations: NDArray[np.float64] | None = None,
    meant: Mapping[int, float] = MappingProxyType({}),
) -> tuple[Advice, ...]:
    """List what a lesson lacks, most useful first, given the transition functions learned from it.

    With a `kit`, its unused features are tried on contradictions. `situations` [M, F] are feature vectors that the
    robot may meet (see `sample_posed_situations`); None: they are sampled from the examples. `meant` has the presses
    that the demonstrator has confirmed, by number, with the `doubt` at that time.
    """
    survey = LessonAnalysis.from_lesson(lesson, transitions, situations)
    odd = list(advise_on_mislabels(survey, meant))
    doubted = {number for each in odd for number in each.examples}
    found = [
        *advise_on_contradictions(survey, kit),
        *advise_on_overruled_defaults(survey),
        *advise_on_states_never_left(survey),
        *advise_on_states_never_entered(survey),
        *advise_on_coverage_gaps(survey),
        *advise_on_stretched_leaves(survey),
        *odd,
        *(each for each in advise_on_isolated_presses(survey) if each.examples[0] not in doubted),
        *advise_on_accuracy(survey),
        *advise_on_unused_features(survey),
    ]
    if survey.is_scant:
        found = [replace(each, weight=min(each.weight, UNSURE)) for each in found]
        found.insert(0, _few(survey))
    return tuple(sorted(found, key=lambda each: -each.weight))


def _few(survey: LessonAnalysis) -> Advice:
    presses, held = survey.demonstration_count, any(example.quarantined for example in survey.lesson.examples)
    said = "You showed me nothing" if not presses else f"You pressed {'once' if presses == 1 else 'twice'}"
    so_far = ", beside what is in quarantine" if held else " so far" if presses else " yet"
    return Advice(
        AdviceKind.FEW, f"{said}{so_far}: show me more, and then I can tell you what is missing.", "", UNSURE
    )
