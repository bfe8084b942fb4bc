"""Findings: what a static check says about an automaton, as data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from math import inf

from understudy.model.features import BoundFeature
from understudy.model.tree_regions import Box


class FindingKind(StrEnum):
    """The subject of a finding."""

    MISSING_BEHAVIOR = "missing behavior"  # a state runs what no member, or no robot, has
    NEVER_ENTERED = "state never entered"
    NEVER_LEFT = "state never left"
    FLAG_NEVER_RAISED = "flag never raised"  # something waits for a flag that its automaton cannot raise
    CHATTER = "chatter"  # a switch that is undone in the same cell
    CYCLE = (
        "cycle"  # three switches or more, or several levels, that come back to the first state in one cell
    )
    REPEATED_ORDER = "repeated order"  # a coordinator orders the same again and again
    NEVER_SHOWN = "branch never shown"
    ABSENT_NEVER_SHOWN = "absence never shown"
    ONE_EXAMPLE = "one example"  # cells that a single example each decides
    DEAD_END = "dead end"  # a state that stays while what it runs has raised its flag and idles
    OUTLIER = "outlier"  # an example far outside all others
    CONSTANT_TARGET = "constant target"  # a state follows a fixed target, and its automaton a parameter
    UNUSED_FEATURE = "unused feature"
    UNUSED_PARAMETER = "unused parameter"


class Severity(StrEnum):
    """The weight of a finding.

    "error": the automaton cannot do its task, for any readings. "warning": it does something useless for the readings
    that the finding describes. "note": a decision depends on little evidence, or a part is not needed.
    """

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"

    @property
    def rank(self) -> int:
        """The position from the least severe, 0, to the most severe."""
        return (Severity.NOTE, Severity.WARNING, Severity.ERROR).index(self)


@dataclass(frozen=True, slots=True)
class FindingCell:
    """The feature vectors that a finding is about.

    Parameters
    ----------
    features
        The features that the cell restricts; those of nested automata with their targets.
    box
        The set of values of each of the features.
    at
        A value of each feature that represents the cell; NaN if absent.
    condition
        The same in words, such as "distance_to(A) is below 0.5 m".
    """

    features: tuple[BoundFeature, ...]
    box: Box
    at: tuple[float, ...]
    condition: str


@dataclass(frozen=True, slots=True)
class FindingTrial:
    """The number of trials in which the mistake that a finding describes happened.

    Parameters
    ----------
    worlds
        The number of worlds in which the automaton ran.
    happened
        The number of those in which it happened.
    share
        The share of the robots' ticks in which it happened, from 0 to 1.
    """

    worlds: int
    happened: int
    share: float

    def __str__(self) -> str:
        if not self.happened:
            return f"did not happen in {self.worlds} worlds"
        return f"happens in {self.happened} of {self.worlds} worlds"


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong with an automaton, or that rests on little.

    Parameters
    ----------
    kind
        Its subject.
    severity
        Its weight.
    automaton
        Name of the automaton, with the sort of agents before it if the library has several: "patrol/defer".
    sentence
        The finding in one sentence.
    states
        Names of the states concerned, in the order in which they follow each other; where single examples decide, the
        state of each cell.
    assumptions
        What is assumed, in one sentence each. Empty: the finding is certain.
    cells
        Where it happens. Empty: for all feature vectors.
    examples
        Numbers of the examples behind it.
    remedy
        What to show or change.
    trial
        How often it happened in worlds. None: it was not tried.
    """

    kind: FindingKind
    severity: Severity
    automaton: str
    sentence: str
    states: tuple[str, ...] = ()
    assumptions: tuple[str, ...] = ()
    cells: tuple[FindingCell, ...] = ()
    examples: tuple[int, ...] = ()
    remedy: str = ""
    trial: FindingTrial | None = None

    @property
    def is_certain(self) -> bool:
        """True if the finding assumes nothing."""
        return not self.assumptions


def sort_findings(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Sort findings by automaton, the one with the gravest finding first, and each automaton's, the gravest first.

    Of equal severity, dead ends are graver than others, then what happened more often where it was tried, then what is
    certain.
    """
    order: dict[str, tuple[float, ...]] = {}
    for at, each in enumerate(findings):
        order[each.automaton] = min(order.get(each.automaton, (inf,)), (*_make_rank(each), at))
    return tuple(sorted(findings, key=lambda each: (order[each.automaton], _make_rank(each))))


def _make_rank(finding: Finding) -> tuple[float, ...]:
    trial = finding.trial
    often = (0, 0.0) if trial is None else (-trial.happened, -trial.share)
    return (-finding.severity.rank, finding.kind is not FindingKind.DEAD_END, *often, not finding.is_certain)
