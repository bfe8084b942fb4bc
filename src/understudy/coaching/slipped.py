"""Presses that look like slips: was that meant?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from understudy.coaching.advice import Advice, AdviceKind
from understudy.coaching.survey import Survey
from understudy.learning.slips import same_press, slips

MOST = 3
"""So many at once: who is asked about more stops reading."""


def slipped(survey: Survey, meant: Mapping[int, float]) -> Iterator[Advice]:
    """Directives and confirmations that the others speak against, the oddest first (see `learning.slips`).

    `meant` are those that the demonstrator stands by, with the doubt then.
    """
    if survey.scant:
        return
    for suspect in slips(survey.lesson, meant=meant, most=MOST):
        example = suspect.example
        taught = example.state if example.state in survey.learners else next(iter(survey.learners))
        box, when = survey.where(taught, example)
        place = survey.place(example.state)
        yield Advice(
            AdviceKind.SLIP,
            f"Did you mean that{f' in {place}' if place else ''}{when}? {suspect.reason}",
            place,
            0.3 + 0.6 * min(1.0, suspect.doubt),
            box,
            same_press(survey.lesson, example.number),
            example.values,
            suspect.doubt,
        )
