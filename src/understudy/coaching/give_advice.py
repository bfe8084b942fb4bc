"""List what a lesson lacks, most useful first.

for each in give_advice(lesson, learn(lesson), kit=kit):
    print(each.sentence)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import count
from math import isinf, sqrt
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.advice import (
    MOST_ADVICE,
    Advice,
    AdviceKind,
    WrongDecisions,
    advise_on_contradictions,
    advise_on_isolated_presses,
    advise_on_mislabels,
    advise_on_overruled_defaults,
)
from understudy.coaching.lesson_analysis import (
    FAR,
    LessonAnalysis,
    MetDecision,
    StateAnalysis,
    predict_left_out,
)
from understudy.coaching.situation_text import match_cells
from understudy.errors import join_names
from understudy.learning.training_set import select_teaching_examples
from understudy.model.automaton import Transition
from understudy.model.lesson import Lesson
from understudy.model.library import Kit
from understudy.model.tree import STAY, Tree
from understudy.model.tree_regions import Box, ValueSet, find_tested_features, list_leaf_boxes

BEGINNING = 0.7
"""The weight of a gap in the start state, relative to other states: a run passes it only once."""
LEAST_SHARE = 0.02
"""The least share of situations that a gap must concern to be worth a person's time."""
LEAST_CONTRAST = 0.5
"""The least contrast by which examples of another outcome must be nearer than those of a leaf, to make it doubtful."""
MOST_SITUATIONS = 48
"""The number of situations that are moved into each leaf."""
MOST_PAIRS = 1_000_000
"""The largest number of pairs of a moved situation and an example that are compared; of more, fewer situations are."""
LEAST_CASES = 8
"""The least number of cases for which the share decided as shown is reported."""
GOOD = 0.95
"""The share of cases decided as shown from which on a lesson has enough examples."""
UNSURE = 0.3
"""The largest weight of advice on a lesson with very few examples."""
IN_WORLDS = 0.95
"""The largest weight of advice without trials in worlds; advice on mistakes found in worlds weighs more."""

LOOKS = 9


def give_advice(
    lesson: Lesson,
    transitions: Mapping[str, Transition],
    *,
    kit: Kit | None = None,
    situations: NDArray[np.float64] | None = None,
    meant: Mapping[int, float] = MappingProxyType({}),
    wrong: WrongDecisions | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> tuple[Advice, ...]:
    """List what a lesson lacks, most useful first, given the transition functions learned from it.

    With a `kit`, its unused features are tried on contradictions. `situations` [M, F] are feature vectors that the
    robot may meet (see `sample_posed_situations`); None: they are sampled from the examples. `meant` has the presses
    that the demonstrator has confirmed, by number, with the `doubt` at that time. Advice that would change most of the
    `wrong` decisions in new worlds comes first. `progress` is called with the number of looks at the lesson, one for
    each kind of advice, and their total.
    """
    analysis, looks = LessonAnalysis(lesson, transitions, situations), count(1)

    def look(pieces: Iterable[Advice]) -> list[Advice]:
        listed = list(pieces)
        progress(next(looks), LOOKS)
        return listed

    advice = [
        *look(advise_on_contradictions(analysis, kit)),
        *look(advise_on_overruled_defaults(analysis)),
        *look(advise_on_missing_switches(analysis)),
    ]
    if analysis.is_scant:
        advice = [replace(each, weight=min(each.weight, UNSURE)) for each in advice]
        advice.insert(0, _advise_on_few_presses(analysis))
    else:
        slips = look(advise_on_mislabels(analysis, meant))
        doubted = {number for each in slips for number in each.examples}
        advice += look(advise_on_coverage_gaps(analysis))
        advice += look(advise_on_stretched_leaves(analysis))
        advice += slips
        isolated = look(advise_on_isolated_presses(analysis))
        advice += [each for each in isolated if each.examples[0] not in doubted]
        advice += look(advise_on_accuracy(analysis))
        advice += look(advise_on_unused_features(analysis))
        if wrong is not None:
            advice = [_weigh_by_worlds(each, analysis, wrong) for each in advice]
    return tuple(sorted(advice, key=lambda each: -each.weight))


def _weigh_by_worlds(advice: Advice, analysis: LessonAnalysis, wrong: WrongDecisions) -> Advice:
    """Return advice with the number of new worlds in which its mistake happened; such advice comes first."""
    seeds = {met.seed for met in wrong.met if _concerns(advice, met, analysis)}
    if not seeds:
        return advice
    first = next(why for seed, why in wrong.why.items() if seed in seeds)
    evidence = f"I went wrong there in {len(seeds)} of {wrong.worlds} new worlds ({first})."
    weight = IN_WORLDS + (1.0 - IN_WORLDS) * len(seeds) / wrong.worlds
    return replace(advice, weight=weight, evidence=evidence)


def _concerns(advice: Advice, met: MetDecision, analysis: LessonAnalysis) -> bool:
    """Return whether advice is about a decision: about its leaf, its situation, or an example that it rests on."""
    state = analysis.find_state(met.state)
    if advice.kind in (AdviceKind.GAP, AdviceKind.NEVER_LEFT):
        parts = zip(met.values, advice.region or (), strict=advice.region is not None)
        return advice.state in ("", met.state) and all(value in part for value, part in parts)
    if state is None or not isinstance(state.transition, Tree) or advice.state != state.place:
        return False
    if advice.kind is AdviceKind.STRETCHED and advice.at is not None:
        return state.transition.path(met.values)[1] == state.transition.path(advice.at)[1]
    answers: dict[str, list[int]] = {}
    for row, example in enumerate(state.examples):
        if example.number in advice.examples:
            answers.setdefault(example.next, []).append(row)
    now = state.transition.decide(met.values)
    return any(state.fit_without(tuple(rows)).decide(met.values) != now for rows in answers.values())


def _advise_on_few_presses(analysis: LessonAnalysis) -> Advice:
    presses, held = analysis.demonstration_count, any(each.quarantined for each in analysis.lesson.examples)
    beginning = (
        "You showed me nothing" if not presses else f"You pressed {'once' if presses == 1 else 'twice'}"
    )
    so_far = ", beside what is in quarantine" if held else " so far" if presses else " yet"
    sentence = f"{beginning}{so_far}: show me more, and then I can tell you what is missing."
    return Advice(AdviceKind.FEW, sentence, "", UNSURE)


def advise_on_missing_switches(analysis: LessonAnalysis) -> Iterator[Advice]:
    """Advise on states, other than flag states, that no example leaves, and on states that no example leads to."""
    automaton, examples = analysis.lesson.automaton, select_teaching_examples(analysis.lesson)
    left = {example.state for example in examples if example.next != example.state}
    entered = {automaton.states[0].name, *(example.next for example in examples)}
    for index, state in enumerate(() if automaton.stateless else automaton.states):
        if state.flag is None and state.name in entered - left:
            sentence, weight = f"Show me when to leave {state.name}: so far I stay in it for good.", 0.6
            if index == 0:
                sentence = f"Show me what to do first: nothing leads from {state.name} to any other state."
                weight = 0.9
            yield Advice(AdviceKind.NEVER_LEFT, sentence, state.name, weight)
    for state in automaton.states:
        if state.name not in entered:
            what, weight = (f"go to {state.name}", 0.55) if state.flag is None else (f"say {state.flag}", 0.8)
            sentence = f"Show me when to {what}, or leave it out: nothing you showed leads there."
            yield Advice(AdviceKind.NEVER_ENTERED, sentence, state.name, weight)


def advise_on_coverage_gaps(analysis: LessonAnalysis) -> Iterator[Advice]:
    """Advise on situations without examples, state by state, those farthest from all examples first."""
    for state in analysis.states.values():
        nearest = state.distances.find_nearest(analysis.situations, state.shown.values)
        is_open = (nearest >= FAR) & analysis.find_possible_situations(state)
        for _ in range(MOST_ADVICE):
            if not is_open.any():
                break
            farthest = int(np.argmax(np.where(is_open, nearest, -1.0)))
            is_open[farthest] = False
            widest = _find_widest_gap(state, analysis.situations[farthest])
            if widest is None:
                continue
            there = match_cells(widest, analysis.cells)
            is_open &= ~there
            share = float(there.mean())
            if share < LEAST_SHARE:
                continue
            once = BEGINNING if state.place == analysis.lesson.automaton.states[0].name else 1.0
            weight = 0.3 + 0.35 * once * float(nearest[farthest]) * min(1.0, share / 0.25)
            where = f" in state {state.place}" if state.place else ""
            box, when = state.describe(widest)
            sentence = f"Show me what to do{where}{when}: I was never shown that."
            at = tuple(analysis.situations[farthest].tolist())
            yield Advice(AdviceKind.GAP, sentence, state.place, weight, box, at=at)


def _find_widest_gap(state: StateAnalysis, here: NDArray[np.float64]) -> dict[int, frozenset[int]] | None:
    """Find the cells around a situation, without the features that are not needed to exclude all examples.

    The feature that differs least from the nearest example goes first. None if an example has the same cells.
    """
    cells = state.find_cells_around(here.tolist())
    if not cells or match_cells(cells, state.cells).any():
        return None
    apart = state.distances.compute_by_feature(state.shown.values, here)
    nearest = apart[state.distances.combine(apart).argmin()]
    for feature in np.argsort(nearest, kind="stable").tolist():
        wider = {other: allowed for other, allowed in cells.items() if other != feature}
        if wider and not match_cells(wider, state.cells).any():
            cells = wider
    return cells


def advise_on_stretched_leaves(analysis: LessonAnalysis) -> Iterator[Advice]:
    """Advise, for each state, on leaves that leave it where other examples are much nearer than their own."""
    kinds = [bound.kind for bound in analysis.lesson.automaton.features]
    for state in analysis.states.values():
        situations = analysis.situations[analysis.find_possible_situations(state)][:MOST_SITUATIONS]
        if not isinstance(state.transition, Tree) or not len(situations):
            continue
        stretched = []
        leaves = list(list_leaf_boxes(state.transition, kinds))
        situations = situations[: max(1, MOST_PAIRS // (len(leaves) * len(state.examples)))]
        for outcome, box in leaves:
            if outcome not in (STAY, state.shown.current):
                rows = _move_into_box(box, situations)
                distances = state.plain_distances.compute(rows[:, None], state.shown.values)
                amounts, others = state.measure_contrast(distances, outcome)
                worst = int(amounts.argmax())
                amount, nearest = float(amounts[worst]), state.examples[others[worst]]
                if amount < LEAST_CONTRAST:
                    continue
                around, when = state.describe(state.find_cells_around(rows[worst].tolist()))
                following = analysis.lesson.automaton.state_names[outcome]
                start = f"go from {state.place} to {following}" if state.place else f"do {following}"
                answer = "stay" if nearest.next == nearest.state else nearest.next
                stretched.append(
                    Advice(
                        AdviceKind.STRETCHED,
                        f"Is it right that I {start}{when}? The nearest example, {nearest.number}, says {answer}.",
                        state.place,
                        0.3 + 0.35 * amount,
                        tuple(mine & leaf for mine, leaf in zip(around, box, strict=True)),
                        (nearest.number,),
                        tuple(rows[worst].tolist()),
                    )
                )
        yield from sorted(stretched, key=lambda each: -each.weight)[:MOST_ADVICE]


def _move_into_box(box: Box, situations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return situations with every value outside a box moved to its edge."""
    rows = situations.copy()
    for column, region in enumerate(box):
        outside = [value not in region for value in rows[:, column].tolist()]
        rows[outside, column] = _choose_value(region)
    return rows


def _choose_value(region: ValueSet) -> float:
    if not region.parts:
        return np.nan
    low, high = region.parts[0]
    if isinf(low) or isinf(high):
        return high - 1e-6 * max(1.0, abs(high)) if isinf(low) and not isinf(high) else low
    return low if high - low == 1.0 and low == int(low) else (low + high) / 2


def advise_on_accuracy(analysis: LessonAnalysis) -> Iterator[Advice]:
    """Report the leave-one-out accuracy in one sentence; nothing if there are too few examples."""
    whole = predict_left_out(analysis.trials)
    if len(whole) < LEAST_CASES:
        return
    share, half = whole.mean(), predict_left_out(analysis.draw_halves()).mean()
    error = sqrt(max(share * (1 - share), 0.01) / len(whole))
    result = f"leave each example out in turn and I get {whole.sum()} of {len(whole)} right"
    if share >= GOOD:
        sentence, weight = f"I have seen enough of what you showed: {result}.", 0.05
    elif share - half > error:
        sentence = f"More examples are likely to help: {result}, and with half of the others {half:.0%}."
        weight = 0.35
    else:
        sentence = f"More of the same may not help: {result}, and no fewer with half of the others; look at features."
        weight = 0.3
    yield Advice(AdviceKind.OUTLOOK, sentence, "", weight)


def advise_on_unused_features(analysis: LessonAnalysis) -> Iterator[Advice]:
    """Advise on features that no tree tests."""
    trees = [each.transition for each in analysis.states.values() if isinstance(each.transition, Tree)]
    used = find_tested_features(trees)
    features = enumerate(analysis.lesson.automaton.features)
    names = [str(bound) for index, bound in features if index not in used]
    if names and 0 < len(trees) == len(analysis.states):
        they, decide = ("they matter", "they decide") if len(names) > 1 else ("it matters", "it decides")
        sentence = f"Leave out {join_names(names)}, or show me where {they}: so far {decide} nothing."
        yield Advice(AdviceKind.IDLE, sentence, "", 0.2)
