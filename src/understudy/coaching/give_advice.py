"""List what a lesson lacks, most useful first.

for each in give_advice(lesson, learn(lesson), kit=kit):
    print(each.sentence)
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import sqrt
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.conflicts import (
    advise_on_contradictions,
    advise_on_mislabels,
    advise_on_overruled_defaults,
)
from understudy.coaching.coverage import (
    advise_on_coverage_gaps,
    advise_on_states_never_entered,
    advise_on_states_never_left,
    advise_on_unused_features,
)
from understudy.coaching.cross_validation import (
    HALVES,
    Accuracy,
    score_half_of_examples,
    score_leave_one_out,
)
from understudy.coaching.fragile_boundaries import advise_on_isolated_presses, advise_on_stretched_leaves
from understudy.coaching.lesson_analysis import LessonAnalysis
from understudy.model.automaton import Transition
from understudy.model.learner_options import SklearnOptions
from understudy.model.lesson import Lesson
from understudy.model.library import Kit

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
