"""Examples that others contradict: presses that are probably slips, and those behind a mistake that was corrected.

Both are found from examples only, never from what was learned from them, so they are the same for trees and for every
classifier. The rules are our own, on top of `fit_leave_one_out`. The diagnosis of corrections follows the idea of
Sullivan, ElMolla, Squires and Luke, "Unlearning from Demonstration" (IJCAI 2013); see docs/correcting.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError
from understudy.learning.leave_one_out import LeaveOneOut, fit_leave_one_out
from understudy.learning.training_set import group_by_feature_vector, select_teaching_examples
from understudy.model.describe import name_examples
from understudy.model.lesson import Example, ExampleKind, Lesson

ENOUGH = 6
"""The least number of other examples with which any is doubted."""
ODD = 0.25
"""The least doubt with which a press is suspected by default.

It finds most slips, and as many presses that were intended.
"""
DOUBTED = 0.5
"""The least doubt with which an example is suspected to have caused a mistake."""
NEAR = 0.1
"""The least similarity to the correction, of 1, with which an example can have caused the mistake."""


@dataclass(frozen=True, slots=True)
class SuspectExample:
    """An example that may be bad: the reason, and how strongly the other examples contradict it (0 to 1)."""

    example: Example
    reason: str
    doubt: float


def find_mislabels(
    lesson: Lesson,
    *,
    least: float = ODD,
    meant: Mapping[int, float] = MappingProxyType({}),
    most: int | None = None,
) -> tuple[SuspectExample, ...]:
    """Find directives and confirmations, corrections included, that were probably given by mistake.

    The doubt about an example is about -1 to 1: how strongly the other examples predict another next state, averaged
    over the examples of its state and what was shown in all states, because a wrong button is mostly wrong in other
    states too. Each suspect is left out before the others are examined again, since one slip may hide another.

    Parameters
    ----------
    lesson
        The lesson; it stays unchanged.
    least
        Doubt from which an example is suspected.
    meant
        Examples that the demonstrator has declared intended: by number, the doubt at that time. Such an example is
        suspected again only when its doubt has grown by `least`.
    most
        Largest number of suspects to look for. None: all.

    Returns
    -------
    tuple[SuspectExample, ...]
        The suspects with reasons, in the order in which they were found, the most doubtful first.

    Raises
    ------
    DefinitionError
        If an example does not fit the automaton's features.
    """
    names = lesson.automaton.state_names[: 1 if lesson.automaton.stateless else None]
    pools = [_select_evidence(lesson, name) for name in ("", *names)]
    fits = [fit_leave_one_out(lesson, pool) for pool in pools if len(pool) > ENOUGH]
    left = {example.number: example for example in pools[0]}
    suspects: list[SuspectExample] = []
    while most is None or len(suspects) < most:
        scores = [fit.score_mislabels() for fit in fits]
        doubts = {number: sum(score.get(number, 0.0) for score in scores) / 2 for number in left}
        odd = [number for number, doubt in doubts.items() if doubt >= meant.get(number, 0.0) + least]
        if not odd:
            break
        number = max(odd, key=lambda each: (doubts[each], -each))
        suspect = left.pop(number)
        against = [fit for fit, score in zip(fits, scores, strict=True) if score.get(number, 0.0) > 0]
        reason = against[0].describe_counterevidence(suspect) if against else ""
        suspects.append(SuspectExample(suspect, reason, round(doubts[number], 3)))
        fits = [fit.exclude(number) for fit in fits]
    return tuple(suspects)


def _select_evidence(lesson: Lesson, state: str) -> list[Example]:
    """Return the press-made examples of a state; in a stateless lesson, or for "", what was shown in all states."""
    taught = select_teaching_examples(lesson)
    if lesson.automaton.stateless or not state:
        return [example for example in taught if example.is_shown]
    return [example for example in taught if example.is_from_press and example.state == state]


def list_press_examples(lesson: Lesson, number: int) -> tuple[int, ...]:
    """Return the numbers of an example and of the default that the same press recorded, if that still exists."""
    example = next(each for each in lesson.examples if each.number == number)
    if example.moment is None:  # no press made it
        return (number,)
    defaults = [
        each.number
        for each in lesson.examples
        if each.kind is ExampleKind.DEFAULT
        and (each.number, each.moment, each.state) == (number + 1, example.moment, example.next)
    ]
    return number, *defaults


class MistakeCause(StrEnum):
    """The cause of a mistake of the robot."""

    BAD = "bad examples"
    FEW = "too few examples"
    CONTRADICTION = "corrections that contradict each other"
    UNSURE = "hard to say"


@dataclass(frozen=True, slots=True)
class CorrectionDiagnosis:
    """The result of `diagnose_correction`.

    Parameters
    ----------
    correction
        The correction that was examined.
    verdict
        The cause of the robot's mistake.
    reason
        A sentence for people that explains the verdict.
    suspects
        The examples that probably caused the mistake, the most doubtful first; empty unless the verdict is BAD.
    """

    correction: Example
    verdict: MistakeCause
    reason: str
    suspects: tuple[SuspectExample, ...] = ()

    @property
    def reasons(self) -> dict[int, str]:
        """The reason for each suspect by its number, as `Session.quarantine` takes it."""
        return {suspect.example.number: suspect.reason for suspect in self.suspects}

    def __str__(self) -> str:
        return " ".join([self.reason, *(suspect.reason for suspect in self.suspects)])


def diagnose_correction(lesson: Lesson, correction: Example) -> CorrectionDiagnosis:
    """Diagnose why the robot decided wrongly at the moment of a correction.

    Press-made examples of the same state (of all states in stateless lessons) are suspected if they are similar to
    the correction, show another next state, and are contradicted by other examples. Corrections are never suspected.

    Parameters
    ----------
    lesson
        The lesson, with the correction among its examples.
    correction
        The directive or confirmation by which the demonstrator corrected the robot.

    Returns
    -------
    CorrectionDiagnosis
        The cause of the mistake, and the suspected examples. The lesson stays unchanged.

    Raises
    ------
    DefinitionError
        If the lesson has no such example, or does not learn from it.
    """
    pool = _select_evidence(lesson, correction.state)
    if correction not in pool:
        raise DefinitionError(
            what=f"example {correction.number} of lesson {lesson.name!r}",
            problem="it cannot be diagnosed, since it teaches nothing there",
            remedy="give a directive or confirmation of the lesson that is not in quarantine",
        )
    label, others = f"correction {correction.number}", len(pool) - 1
    alike = next(group for group in group_by_feature_vector(pool).values() if correction in group)
    rivals = [each for each in alike if each.correction and each.is_shown and each.next != correction.next]
    if rivals:
        named = name_examples(sorted(each.number for each in rivals))
        reason = f"{label.capitalize()} contradicts {named}: both are kept."
        return CorrectionDiagnosis(correction, MistakeCause.CONTRADICTION, reason)
    if others < ENOUGH:
        count = f"{others} other example{'s' * (others != 1)}"
        reason = f"With {count} beside {label} it is too early to doubt any."
        return CorrectionDiagnosis(correction, MistakeCause.UNSURE, reason)
    fit = fit_leave_one_out(lesson, pool)
    near = [fit.examples[place] for place in _find_near(correction, fit)]
    against = [each for each in near if each.next != correction.next]
    suspects, verdict = _find_causes(fit, against), MistakeCause.FEW
    if suspects:
        verdict = MistakeCause.BAD
        bad = name_examples(sorted(suspect.example.number for suspect in suspects))
        reason = f"The decision at {label} was wrong because of {bad}."
    elif fit.score_mislabels()[correction.number] >= DOUBTED:
        verdict = MistakeCause.UNSURE
        reason = (
            f"Examples like {label} agree on something else, so either it is wrong or a boundary is close by."
        )
    elif against:
        reason = f"There were too few examples around {label}, and none of them is clearly bad."
    elif near:
        reason = f"Examples like {label} agree with it: the boundary was in the wrong place."
    else:
        reason = f"There were no examples like {label}: it adds what was missing."
    return CorrectionDiagnosis(correction, verdict, reason, suspects)


def _find_causes(fit: LeaveOneOut, against: Sequence[Example]) -> tuple[SuspectExample, ...]:
    """Find the examples that caused a mistake among those that contradict its correction, the most doubtful first.

    Each is left out before the others are examined again, since one bad example may hide another.
    """
    causes: list[tuple[Example, float]] = []
    left = {example.number: example for example in against if not example.correction}
    while left:
        doubts = fit.score_mislabels()
        number = max(left, key=lambda each: (doubts[each], -each))
        if doubts[number] < DOUBTED:
            break
        example = left.pop(number)
        if not _may_begin_region(example, fit):
            causes.append((example, min(doubts[number], 1.0)))
            fit = fit.exclude(number)
    return tuple(
        SuspectExample(example, fit.describe_counterevidence(example), round(doubt, 3))
        for example, doubt in causes
    )


def _find_near(example: Example, fit: LeaveOneOut) -> NDArray[np.int64]:
    """Find the places of the examples, not left out, that are so similar that they can have caused a mistake there."""
    place = fit.examples.index(example)
    near: NDArray[np.int64] = fit.here[(fit.like[place, fit.here] > NEAR) & (fit.here != place)]
    return near


def _may_begin_region(example: Example, fit: LeaveOneOut) -> bool:
    """Return whether an example is the only one of its outcome, and at the edge of the others.

    It is not at their edge if two of them are at more than a right angle as seen from it.
    """
    place = fit.examples.index(example)
    if (fit.outcomes[fit.here] == fit.outcomes[place]).sum() > 1:
        return False
    near = _find_near(example, fit)
    apart, to_each = fit.unlike[np.ix_(near, near)], fit.unlike[place, near]
    return not (apart > to_each[:, None] + to_each[None, :]).any()
