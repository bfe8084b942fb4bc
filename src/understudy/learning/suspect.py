"""Examples under suspicion: how much each sort is trusted, and who speaks against one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from understudy.learning.leave_one_out import Hindsight
from understudy.model.example import Example, ExampleKind

TRUST_CORRECTION, TRUST_SAID, TRUST_DEFAULT = 0.02, 0.1, 0.2
"""The variance of noise that is expected of each sort of example; who corrects has just seen what is wrong."""
WITNESSES = 3
"""How many examples a reason names at most."""


@dataclass(frozen=True, slots=True)
class Suspect:
    """An example that may be bad: why, and how much the others speak against it (0 to 1)."""

    example: Example
    reason: str
    doubt: float


def noise(example: Example) -> float:
    """The variance of noise that is expected of an example."""
    if example.correction and example.shown:
        return TRUST_CORRECTION
    return TRUST_DEFAULT if example.kind is ExampleKind.DEFAULT else TRUST_SAID


def evidence(pool: Sequence[Example], place: int, seen: Hindsight) -> str:
    """Who speaks against an example: the most like it of those that say otherwise, none of them suspected."""
    others = seen.here[seen.outcomes[seen.here] != seen.outcomes[place]]
    most = others[np.argsort(-seen.like[place, others], kind="stable")]
    outcome = pool[most[0]].next
    witnesses = [pool[other] for other in most if pool[other].next == outcome][:WITNESSES]
    ones = "is" if len(witnesses) == 1 else "are"
    example = pool[place]
    return (
        f"Example {example.number} says {example.next}, but {named(witnesses)}, which {ones} most like it, "
        f"{'says' if len(witnesses) == 1 else 'say'} {outcome}."
    )


def named(examples: Sequence[Example]) -> str:
    """Examples by number: "example 3", "examples 3, 5 and 9"."""
    *most, last = [str(number) for number in sorted(example.number for example in examples)]
    return f"examples {', '.join(most)} and {last}" if most else f"example {last}"
