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
from understudy.coaching.conflicts import contradicting, disagreeing, slipped
from understudy.coaching.coverage import gaps
from understudy.coaching.fragile_boundaries import single, stretched
from understudy.coaching.learning_curve import outlook
from understudy.coaching.lesson_analysis import Survey
from understudy.coaching.unused_parts import idle, never_entered, never_left
from understudy.model.automaton import Transition
from understudy.model.lesson import Lesson
from understudy.model.library import Kit

UNSURE = 0.3
"""No advice on a lesson of hardly any examples weighs more."""


def advice(
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
    survey = Survey.of(lesson, transitions, situations)
    odd = list(slipped(survey, meant))
    doubted = {number for each in odd for number in each.examples}
    found = [
        *contradicting(survey, kit),
        *disagreeing(survey),
        *never_left(survey),
        *never_entered(survey),
        *gaps(survey),
        *stretched(survey),
        *odd,
        *(each for each in single(survey) if each.examples[0] not in doubted),
        *outlook(survey),
        *idle(survey),
    ]
    if survey.scant:
        found = [replace(each, weight=min(each.weight, UNSURE)) for each in found]
        found.insert(0, _few(survey))
    return tuple(sorted(found, key=lambda each: -each.weight))


def _few(survey: Survey) -> Advice:
    presses, held = survey.shown, any(example.quarantined for example in survey.lesson.examples)
    said = "You showed me nothing" if not presses else f"You pressed {'once' if presses == 1 else 'twice'}"
    so_far = ", beside what is in quarantine" if held else " so far" if presses else " yet"
    return Advice(
        AdviceKind.FEW, f"{said}{so_far}: show me more, and then I can tell you what is missing.", "", UNSURE
    )
