"""Diagnosis of a correction: whether bad examples misled the robot and which, or whether there were too few.

The method follows the idea of Sullivan, ElMolla, Squires and Luke, "Unlearning from Demonstration" (IJCAI 2013), and
is our own (docs/correcting.md). It uses examples only, not what was learned from them, so the diagnosis is the same
for trees and for every classifier.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError
from understudy.learning.leave_one_out import (
    LeaveOneOut,
    Square,
    compute_pairwise_distances,
    fit_leave_one_out,
)
from understudy.learning.mislabels import (
    SuspectExample,
    describe_counterevidence,
    estimate_noise_variance,
    format_example_numbers,
)
from understudy.learning.training_set import (
    group_by_feature_vector,
    make_training_set,
    select_teaching_examples,
)
from understudy.model.lesson import Example, Lesson

ENOUGH = 6
"""The least number of examples beside the correction for which any is suspected."""
DOUBTED = 0.5
"""The least doubt with which an example is suspected."""
NEAR = 0.1
"""The least similarity to the correction, of 1, with which an example can have caused the mistake."""


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
    pool = _pool(lesson, correction)
    rivals = _rivals(pool, correction)
    if rivals:
        reason = (
            f"Correction {correction.number} contradicts {format_example_numbers(rivals)}: both are kept."
        )
        return CorrectionDiagnosis(correction, MistakeCause.CONTRADICTION, reason)
    if len(pool) - 1 < ENOUGH:
        count = f"{len(pool) - 1} other example{'s' * (len(pool) != 2)}"
        reason = f"With {count} beside correction {correction.number} it is too early to doubt any."
        return CorrectionDiagnosis(correction, MistakeCause.UNSURE, reason)
    shown = make_training_set(lesson, pool, correction.state)
    _, outcomes = np.unique(shown.outcomes, return_inverse=True)
    unlike = compute_pairwise_distances(shown.values, [bound.kind for bound in lesson.automaton.features])
    seen = fit_leave_one_out(
        unlike, outcomes, np.array([estimate_noise_variance(example) for example in pool])
    )
    return _judged(pool, pool.index(correction), unlike, seen)


def _pool(lesson: Lesson, correction: Example) -> tuple[Example, ...]:
    """List by number the press-made examples of the correction's state; refuse a correction that is not used.

    In a stateless lesson they are the directives and confirmations of all states.
    """
    stateless = lesson.automaton.stateless
    found = [
        example
        for example in select_teaching_examples(lesson)
        if (example.is_shown if stateless else example.is_from_press and example.state == correction.state)
    ]
    if correction not in found:
        raise DefinitionError(
            what=f"example {correction.number} of lesson {lesson.name!r}",
            problem="it cannot be diagnosed, since it teaches nothing there",
            remedy="give a directive or confirmation of the lesson that is not in quarantine",
        )
    return tuple(sorted(found, key=lambda example: example.number))


def _rivals(pool: Sequence[Example], correction: Example) -> list[Example]:
    """List other corrections with the same feature vector that show another next state."""
    alike = next(group for group in group_by_feature_vector(pool).values() if correction in group)
    return [
        example
        for example in alike
        if example.correction and example.is_shown and example.next != correction.next
    ]


def _judged(pool: Sequence[Example], place: int, unlike: Square, seen: LeaveOneOut) -> CorrectionDiagnosis:
    correction, outcomes = pool[place], seen.outcomes
    reach = seen.like[place] > NEAR
    against = (outcomes != outcomes[place]) & reach
    itself = float(seen.score_mislabels(int(outcomes.max()) + 1)[place])
    suspects = _suspects(pool, against, unlike, seen)
    said = f"correction {correction.number}"
    if suspects:
        bad = format_example_numbers([suspect.example for suspect in suspects])
        reason = f"The decision at {said} was wrong because of {bad}."
        return CorrectionDiagnosis(correction, MistakeCause.BAD, reason, suspects)
    if itself >= DOUBTED:
        reason = (
            f"Examples like {said} agree on something else, so either it is wrong or a boundary is close by."
        )
        return CorrectionDiagnosis(correction, MistakeCause.UNSURE, reason)
    if against.any():
        reason = f"There were too few examples around {said}, and none of them is clearly bad."
    elif reach.sum() > 1:  # itself
        reason = f"Examples like {said} agree with it: the boundary was in the wrong place."
    else:
        reason = f"There were no examples like {said}: it adds what was missing."
    return CorrectionDiagnosis(correction, MistakeCause.FEW, reason)


def _suspects(
    pool: Sequence[Example], against: NDArray[np.bool_], unlike: Square, seen: LeaveOneOut
) -> tuple[SuspectExample, ...]:
    """List the suspected examples, the most doubtful first.

    Each is left out before the others are examined again, since one bad example may hide another.
    """
    found: list[tuple[int, float]] = []
    candidates = against & [not example.correction for example in pool]
    choices = int(seen.outcomes.max()) + 1
    while candidates.any():
        doubt = np.where(candidates, seen.score_mislabels(choices), -np.inf)
        place = int(doubt.argmax())
        if doubt[place] < DOUBTED:
            break
        candidates[place] = False
        if _alone(place, seen) and not _surrounded(place, unlike, seen):
            continue
        found.append((place, float(doubt[place])))
        seen = seen.exclude(place)
    return tuple(
        SuspectExample(pool[place], describe_counterevidence(pool, place, seen), round(min(doubt, 1.0), 3))
        for place, doubt in found
    )


def _alone(place: int, seen: LeaveOneOut) -> bool:
    return int((seen.outcomes[seen.here] == seen.outcomes[place]).sum()) == 1


def _surrounded(place: int, unlike: Square, seen: LeaveOneOut) -> bool:
    """Return whether an example has others on both sides: two of them at more than a right angle as seen from it.

    The only example of an outcome is not suspected at the edge of the others, where it may begin a region of
    its own.
    """
    near = seen.here[(seen.like[place, seen.here] > NEAR) & (seen.here != place)]
    apart = unlike[np.ix_(near, near)]
    return bool((apart > unlike[place, near][:, None] + unlike[place, near][None, :]).any())
