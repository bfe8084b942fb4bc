"""The coach: what a lesson lacks, most useful first.

for each in advice(lesson, learn(lesson), kit=kit):
    print(each.sentence)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.conflicts import (
    advise_on_contradictions,
    advise_on_mislabels,
    advise_on_overruled_defaults,
)
from understudy.coaching.coverage import advise_on_coverage_gaps
from understudy.coaching.fragile_boundaries import advise_on_isolated_presses, advise_on_stretched_leaves
from understudy.coaching.learning_curve import advise_on_accuracy
from understudy.coaching.lesson_analysis import LessonAnalysis
from understudy.coaching.unused_parts import (
    advise_on_states_never_entered,
    advise_on_states_never_left,
    advise_on_unused_features,
)
from understudy.model.automaton import Transition
from understudy.model.lesson import Lesson
from understudy.model.library import Kit

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
    """What a lesson lacks, most useful first, given what was learned from it.

    With a `kit`, its other features are tried on contradictions. `situations` [M, F] are feature vectors that the
    robot may come into (see `situations_in`); without them, they are imagined from the examples. `meant` are
    presses that the demonstrator stands by, by number, with the `doubt` about each then.
    """
    survey = LessonAnalysis.of(lesson, transitions, situations)
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
    if survey.scant:
        found = [replace(each, weight=min(each.weight, UNSURE)) for each in found]
        found.insert(0, _few(survey))
    return tuple(sorted(found, key=lambda each: -each.weight))


def _few(survey: LessonAnalysis) -> Advice:
    presses, held = survey.shown, any(example.quarantined for example in survey.lesson.examples)
    said = "You showed me nothing" if not presses else f"You pressed {'once' if presses == 1 else 'twice'}"
    so_far = ", beside what is in quarantine" if held else " so far" if presses else " yet"
    return Advice(
        AdviceKind.FEW, f"{said}{so_far}: show me more, and then I can tell you what is missing.", "", UNSURE
    )
