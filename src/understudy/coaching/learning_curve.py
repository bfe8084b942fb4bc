"""Whether more examples are likely to help: how well a lesson foretells each of its own examples."""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.cross_validation import (
    HALVES,
    Accuracy,
    score_half_of_examples,
    score_leave_one_out,
)
from understudy.coaching.lesson_analysis import LessonAnalysis
from understudy.model.lesson import SklearnOptions

LEAST_CASES = 8
"""With fewer cases such a share says nothing."""
GOOD = 0.95


def advise_on_accuracy(survey: LessonAnalysis) -> Iterator[Advice]:
    """One sentence on what was left out and foretold; nothing where too little was shown."""
    whole = score_leave_one_out(survey.learners, survey.trials)
    if survey.scant or whole.of < LEAST_CASES:
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
    """Whether accuracy grew from half to all of the examples by more than its standard error."""
    error = sqrt(max(whole.share * (1 - whole.share), 0.01) / max(1, whole.of))
    return whole.share - half.share > error


def _advice(sentence: str, weight: float) -> Advice:
    return Advice(AdviceKind.OUTLOOK, sentence, "", weight)
