"""Detection of presses that are probably mislabeled, because other examples contradict them.

A press is compared twice: with the examples of its own state, and with all directives and confirmations of all
states, since a wrong button is mostly wrong there, too. Both predict it from the other examples, see
`fit_leave_one_out`.
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
"""The noise variances expected of corrections, other directives and confirmations, and defaults.

Corrections are most reliable: who corrects has just seen what is wrong.
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

    Stateless lessons do not tell states apart; the second list is then the first one again.
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
