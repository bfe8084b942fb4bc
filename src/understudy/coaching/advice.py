"""Advice: one thing about a lesson that a person may want to do something about."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from understudy.model.tree_regions import Box


class AdviceKind(StrEnum):
    """What advice is about."""

    CONTRADICTION = "contradiction"  # directives or confirmations of one situation that say different things
    DISAGREEMENT = "disagreement"  # a directive and an automatic default of one situation
    SLIP = "slip"  # a press that the others speak against
    SEPARATING = "separating"  # a feature that would tell contradicting examples apart
    NEVER_LEFT = "never left"
    NEVER_ENTERED = "never entered"
    GAP = "gap"  # a situation near no example
    STRETCHED = "stretched"  # a state is left where what was shown nearest says otherwise
    SINGLE = "single"  # a boundary held up by one example
    IDLE = "idle"  # features that decide nothing
    OUTLOOK = "outlook"  # whether more examples are likely to help
    FEW = "few"  # too little was shown to tell


@dataclass(frozen=True, slots=True)
class Advice:
    """One sentence for a person, and the place to look.

    `state` is where to show something ("" for the lesson as a whole), `region` the feature vectors it is about, one
    part for each of the lesson's features (None: no place in particular), `at` one of them that is best looked at,
    `examples` the numbers of those concerned, `weight` how useful it is to follow, from 0 to 1; above 0.5 it is
    plainly so. `doubt` is how much speaks against a press that looks like a slip.
    """

    kind: AdviceKind
    sentence: str
    state: str
    weight: float
    region: Box | None = None
    examples: tuple[int, ...] = ()
    at: tuple[float, ...] | None = None
    doubt: float = 0.0
