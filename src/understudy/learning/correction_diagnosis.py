"""What a correction says of the examples before it: whether bad ones misled the robot, and which, or too few.

In the spirit of Sullivan, ElMolla, Squires and Luke, "Unlearning from Demonstration" (IJCAI 2013); the method is our
own (docs/correcting.md). It looks at examples only, never into what was learned from them, so it is the same for trees
and for every classifier.
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
"""Examples beside the correction that it takes to doubt one of them."""
DOUBTED = 0.5
"""From here on the others speak so clearly against an example that it is suspected."""
NEAR = 0.1
"""How like the correction an example must be, of 1, to have had a part in the mistake."""


class MistakeCause(StrEnum):
    """Where a mistake came from."""

    BAD = "bad examples"
    FEW = "too few examples"
    CONTRADICTION = "corrections that contradict each other"
    UNSURE = "hard to say"


@dataclass(frozen=True, slots=True)
class CorrectionDiagnosis:
    """What a correction came to: the verdict, why, and whom to suspect, the most doubtful first."""

    correction: Example
    verdict: MistakeCause
    reason: str
    suspects: tuple[SuspectExample, ...] = ()

    @property
    def reasons(self) -> dict[int, str]:
        """The suspects by number, each with its reason: what `Session.quarantine` takes."""
        return {suspect.example.number: suspect.reason for suspect in self.suspects}

    def __str__(self) -> str:
        return " ".join([self.reason, *(suspect.reason for suspect in self.suspects)])


def diagnose_correction(lesson: Lesson, correction: Example) -> CorrectionDiagnosis:
    """Why the robot was wrong where this correction, one of the lesson's examples, was made.

    Suspected are press-made examples of the same state (of all states in stateless lessons) that are like the
    correction, say otherwise, and are contradicted by the others; never a correction. DefinitionError where the lesson
    has no such example, or where it teaches nothing.
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
    """The press-made examples that teach what the correction does, in one order whatever order they came in."""
    stateless = lesson.automaton.stateless
    found = [
        example
        for example in select_teaching_examples(lesson)
        if (example.is_shown if stateless else example.is_from_press and example.state == correction.state)
    ]
    if correction not in found:
        raise DefinitionError(
            what=f"example {correction.number} of lesson {lesson.name!r}",
            problem="it cannot be judged, since it teaches nothing there",
            remedy="give a directive or confirmation of the lesson that is not in quarantine",
        )
    return tuple(sorted(found, key=lambda example: example.number))


def _rivals(pool: Sequence[Example], correction: Example) -> list[Example]:
    """Other corrections with the very same feature vector that say otherwise; defaults beside them said nothing."""
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
        reason = f"What {said} shows was decided wrongly because of {bad}."
        return CorrectionDiagnosis(correction, MistakeCause.BAD, reason, suspects)
    if itself >= DOUBTED:
        reason = f"What is like {said} agrees on something else, so either it is wrong or a boundary runs close by."
        return CorrectionDiagnosis(correction, MistakeCause.UNSURE, reason)
    if against.any():
        reason = f"Too little had been shown around {said}, and no example there is clearly bad."
    elif reach.sum() > 1:  # itself
        reason = f"What is like {said} agrees with it: it shows where the boundary is not."
    else:
        reason = f"Nothing like {said} had been shown: it adds what was missing."
    return CorrectionDiagnosis(correction, MistakeCause.FEW, reason)


def _suspects(
    pool: Sequence[Example], against: NDArray[np.bool_], unlike: Square, seen: LeaveOneOut
) -> tuple[SuspectExample, ...]:
    """The most doubtful first; each is left out before the next is looked at, so that bad ones hide no other."""
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
    """Whether others lie on either side of an example: two of them see it at more than a right angle.

    The only example of an outcome is not suspected at an edge, where it may well begin a region of its own.
    """
    near = seen.here[(seen.like[place, seen.here] > NEAR) & (seen.here != place)]
    apart = unlike[np.ix_(near, near)]
    return bool((apart > unlike[place, near][:, None] + unlike[place, near][None, :]).any())
