"""Examples that others contradict: presses that are probably slips, and those behind a mistake that was corrected.

For slips, each press is compared twice: with the examples of its own state, and with all directives and confirmations
of all states, because a wrong button is mostly wrong in other states too. Both predict it from the other examples, see
`fit_leave_one_out`.

The diagnosis of a correction says whether bad examples misled the robot and which, or whether there were too few.
It follows the idea of Sullivan, ElMolla, Squires and Luke, "Unlearning from Demonstration" (IJCAI 2013), and is our
own (docs/correcting.md). It uses examples only, not what was learned from them, so the diagnosis is the same for trees
and for every classifier.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError
from understudy.learning.leave_one_out import (
    LeaveOneOut,
    Square,
    compute_pairwise_distances,
    fit_leave_one_out,
)
from understudy.learning.training_set import (
    group_by_feature_vector,
    make_training_set,
    select_teaching_examples,
)
from understudy.model.lesson import Example, ExampleKind, Lesson

TRUST_CORRECTION, TRUST_SAID, TRUST_DEFAULT = 0.02, 0.1, 0.2
"""The noise variances expected of corrections, other directives and confirmations, and defaults.

Corrections are most reliable, because demonstrators who correct have just seen what is wrong.
"""
WITNESSES = 3
"""The largest number of examples that a reason names."""


@dataclass(frozen=True, slots=True)
class SuspectExample:
    """An example that may be bad: the reason, and how strongly the other examples contradict it (0 to 1)."""

    example: Example
    reason: str
    doubt: float


def estimate_noise_variance(example: Example) -> float:
    """Return the noise variance expected of an example: lowest for corrections, highest for defaults."""
    if example.correction and example.is_shown:
        return TRUST_CORRECTION
    return TRUST_DEFAULT if example.kind is ExampleKind.DEFAULT else TRUST_SAID


def describe_counterevidence(pool: Sequence[Example], place: int, seen: LeaveOneOut) -> str:
    """Describe which examples contradict an example: the most similar ones with another next state.

    `place` is the index of the example in `pool`. Examples that were left out of `seen` are not named.
    """
    others = seen.here[seen.outcomes[seen.here] != seen.outcomes[place]]
    most = others[np.argsort(-seen.like[place, others], kind="stable")]
    outcome = pool[most[0]].next
    witnesses = [pool[other] for other in most if pool[other].next == outcome][:WITNESSES]
    ones = "is" if len(witnesses) == 1 else "are"
    example = pool[place]
    return (
        f"Example {example.number} says {example.next}, but {format_example_numbers(witnesses)}, "
        f"which {ones} most like it, {'says' if len(witnesses) == 1 else 'say'} {outcome}."
    )


def format_example_numbers(examples: Sequence[Example]) -> str:
    """Format the numbers of examples, such as "example 3" or "examples 3, 5 and 9"."""
    *most, last = [str(number) for number in sorted(example.number for example in examples)]
    return f"examples {', '.join(most)} and {last}" if most else f"example {last}"


ODD = 0.25
"""The least doubt with which a press is suspected by default.

It finds most slips, and as many presses that were intended.
"""
ENOUGH = 6
"""The least number of other examples with which a press is doubted."""


def find_mislabels(
    lesson: Lesson,
    *,
    least: float = ODD,
    meant: Mapping[int, float] = MappingProxyType({}),
    most: int | None = None,
) -> tuple[SuspectExample, ...]:
    """Find directives and confirmations, corrections included, that were probably given by mistake.

    The doubt about an example is about -1 to 1: how strongly the other examples predict another next state,
    averaged over the examples of its state and those of all states. Each suspect is left out before the others
    are examined again, since one slip may hide another.

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

    Notes
    -----
    Gaussian process with leave-one-out prediction: Rasmussen and Williams, Gaussian Processes for Machine Learning
    (2006), equation 5.12 and section 6.5. The rule for suspects is our own.
    """
    looks = [_LeaveOneOutView(lesson, pool) for pool in _pools(lesson) if len(pool) > ENOUGH]
    doubted = {each.number: each for each in select_teaching_examples(lesson) if each.is_shown}
    found: list[SuspectExample] = []
    while most is None or len(found) < most:
        seen = [look.score_mislabels() for look in looks]
        doubts = {number: sum(each.get(number, 0.0) for each in seen) / 2 for number in doubted}
        odd = [number for number, doubt in doubts.items() if doubt >= meant.get(number, 0.0) + least]
        if not odd:
            break
        number = max(odd, key=lambda each: (doubts[each], -each))
        reason = next(said for look in looks if (said := look.describe_counterevidence(number)))
        found.append(SuspectExample(doubted.pop(number), reason, round(doubts[number], 3)))
        for look in looks:
            look.exclude(number)
    return tuple(found)


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


def _pools(lesson: Lesson) -> Iterator[Sequence[Example]]:
    """Yield the examples to compare: those of all states, then those of each state with its defaults.

    Stateless lessons do not distinguish states; the second list is then the first one again.
    """
    taught = select_teaching_examples(lesson)
    yield [example for example in taught if example.is_shown]
    for state in lesson.automaton.state_names:
        if lesson.automaton.stateless:
            yield [example for example in taught if example.is_shown]
            return
        yield [example for example in taught if example.is_from_press and example.state == state]


class _LeaveOneOutView:
    """A set of examples, each predicted from the others."""

    def __init__(self, lesson: Lesson, pool: Sequence[Example]) -> None:
        self._pool = sorted(pool, key=lambda example: example.number)
        self._places = {example.number: place for place, example in enumerate(self._pool)}
        shown = make_training_set(lesson, tuple(self._pool), self._pool[0].state)
        names, outcomes = np.unique(shown.outcomes, return_inverse=True)
        self._choices = len(names)
        unlike = compute_pairwise_distances(shown.values, [bound.kind for bound in lesson.automaton.features])
        self._seen = fit_leave_one_out(
            unlike, outcomes, np.array([estimate_noise_variance(each) for each in self._pool])
        )

    def score_mislabels(self) -> Mapping[int, float]:
        """Compute the doubt about each example by number; empty if all examples have one outcome."""
        if self._choices == 1:
            return {}
        doubt = self._seen.score_mislabels(self._choices)
        return {number: float(doubt[place]) for number, place in self._places.items()}

    def describe_counterevidence(self, number: int) -> str:
        """Describe which examples contradict an example; an empty text if none does."""
        place = self._places.get(number)
        if place is None or self._seen.score_mislabels(self._choices)[place] <= 0:
            return ""
        return describe_counterevidence(self._pool, place, self._seen)

    def exclude(self, number: int) -> None:
        """Leave an example out from now on."""
        place = self._places.pop(number, None)
        if place is not None:
            self._seen = self._seen.exclude(place)


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
