"""Presses that look like slips: was that meant?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.lesson_analysis import Survey
from understudy.learning.mislabels import same_press, slips
from understudy.model.example import Example
from understudy.model.tree import Tree

MOST = 3
"""So many at once: who is asked about more stops reading."""


def slipped(survey: Survey, meant: Mapping[int, float]) -> Iterator[Advice]:
    """Directives and confirmations that the others speak against, the oddest first (see `learning.slips`).

    What would be decided as shown without them, too, is odd but no slip: it is rare. `meant` are those that the
    demonstrator stands by, with the doubt then.
    """
    if survey.scant:
        return
    for suspect in slips(survey.lesson, meant=meant, most=MOST):
        example = suspect.example
        taught = example.state if example.state in survey.learners else next(iter(survey.learners))
        if _foretold(survey, taught, example):
            continue
        box, when = survey.where(taught, example)
        place = survey.place(example.state)
        yield Advice(
            AdviceKind.SLIP,
            f"Did you mean that{f' in {place}' if place else ''}{when}? {suspect.reason}",
            place,
            0.15 + 0.6 * min(1.0, suspect.doubt),
            box,
            same_press(survey.lesson, example.number),
            example.values,
            suspect.doubt,
        )


def _foretold(survey: Survey, state: str, example: Example) -> bool:
    """Whether the tree that is learned without a press decides as it says; other classifiers take too long to ask."""
    learner = survey.learners[state]
    if not isinstance(survey.transition(state), Tree):
        return False
    row = learner.examples.index(example)
    return bool(learner.decided(learner.without(row), [example.values])[0] == learner.shown.outcomes[row])
