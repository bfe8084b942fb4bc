"""Advice: a single suggestion about a lesson."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from understudy.model.tree_regions import Box


class AdviceKind(StrEnum):
    """The subject of advice."""

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
    """One sentence for a person, and the situation that it refers to.

    `state` is where to demonstrate ("" for the lesson as a whole). `region` has the feature vectors concerned, one part
    for each of the lesson's features (None: no situation in particular), and `at` is one of them that represents it.
    `examples` are the numbers of the examples concerned. `weight` says how useful the advice is, from 0 to 1; it is
    plainly useful above 0.5. `doubt` says how strongly other examples contradict a press that looks like a slip.
    """

    kind: AdviceKind
    sentence: str
    state: str
    weight: float
    region: Box | None = None
    examples: tuple[int, ...] = ()
    at: tuple[float, ...] | None = None
    doubt: float = 0.0
