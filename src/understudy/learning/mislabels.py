"""Find presses that are probably mislabeled: the other examples contradict them.

A press is looked at twice: among what was shown in its own state, and among all that was ever said, in whatever state,
since a wrong button is mostly wrong there, too. Both predict it from the other examples, see `fit_leave_one_out`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from understudy.learning.leave_one_out import LeaveOneOut, compute_pairwise_distances, fit_leave_one_out
from understudy.learning.training_set import make_training_set, select_teaching_examples
from understudy.model.lesson import Example, ExampleKind, Lesson

TRUST_CORRECTION, TRUST_SAID, TRUST_DEFAULT = 0.02, 0.1, 0.2
"""The variance of noise that is expected of each sort of example; who corrects has just seen what is wrong."""
WITNESSES = 3
"""How many examples a reason names at most."""


@dataclass(frozen=True, slots=True)
class SuspectExample:
    """An example that may be bad: why, and how much the others speak against it (0 to 1)."""

    example: Example
    reason: str
    doubt: float


def estimate_noise_variance(example: Example) -> float:
    """The variance of noise that is expected of an example."""
    if example.correction and example.is_shown:
        return TRUST_CORRECTION
    return TRUST_DEFAULT if example.kind is ExampleKind.DEFAULT else TRUST_SAID


def describe_counterevidence(pool: Sequence[Example], place: int, seen: LeaveOneOut) -> str:
    """Who speaks against an example: the most like it of those that say otherwise, none of them suspected."""
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
    """Examples by number: "example 3", "examples 3, 5 and 9"."""
    *most, last = [str(number) for number in sorted(example.number for example in examples)]
    return f"examples {', '.join(most)} and {last}" if most else f"example {last}"


ODD = 0.25
"""From here on a press is worth a second look. It finds most slips, and as many presses that were meant."""
ENOUGH = 6
"""So many others it takes to doubt a press."""


def find_mislabels(
    lesson: Lesson,
    *,
    least: float = ODD,
    meant: Mapping[int, float] = MappingProxyType({}),
    most: int | None = None,
) -> tuple[SuspectExample, ...]:
    """Directives and confirmations that look like slips, the most doubtful first, corrections too.

    Doubted from `least` on is the mean of both looks, about -1 to 1. Each suspect is left out before the others are
    looked at again, so that slips hide no other. `meant` are those that the demonstrator stands by, each with the
    doubt at that time: they are suspected again once it has grown by `least`. So `most` are looked for (None: all).
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
    """The numbers of an example and of the default that the same press recorded, if it is still there."""
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
    """What was said in all states; and each state's own, with its defaults, in lessons that tell states apart."""
    taught = select_teaching_examples(lesson)
    yield [example for example in taught if example.is_shown]
    for state in lesson.automaton.state_names:
        if lesson.automaton.stateless:
            yield [example for example in taught if example.is_shown]
            return
        yield [example for example in taught if example.is_from_press and example.state == state]


class _LeaveOneOutView:
    """Examples as each is seen from the others."""

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
        """By how much the others speak against each example, by number; of none where all say one thing."""
        if self._choices == 1:
            return {}
        doubt = self._seen.score_mislabels(self._choices)
        return {number: float(doubt[place]) for number, place in self._places.items()}

    def describe_counterevidence(self, number: int) -> str:
        """Who speaks against an example, "" where nobody here does."""
        place = self._places.get(number)
        if place is None or self._seen.score_mislabels(self._choices)[place] <= 0:
            return ""
        return describe_counterevidence(self._pool, place, self._seen)

    def exclude(self, number: int) -> None:
        """Look on without an example."""
        place = self._places.pop(number, None)
        if place is not None:
            self._seen = self._seen.exclude(place)
