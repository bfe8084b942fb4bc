"""Findings: what a static check says about an automaton, as data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

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
    ONE_EXAMPLE = "one example"  # a cell that a single example decides
    UNUSED_FEATURE = "unused feature"
    UNUSED_PARAMETER = "unused parameter"


class Severity(StrEnum):
    """The weight of a finding.

    "error": the automaton cannot do what it was taught for, whatever it reads. "warning": it does something useless
    wherever it reads what the finding describes. "note": it depends on little, or has more than it needs.
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
        Names of the states concerned, in the order in which they follow each other.
    assumptions
        What is assumed, in one sentence each. Empty: the finding is certain.
    cells
        Where it happens. Empty: for all feature vectors.
    examples
        Numbers of the examples behind it.
    remedy
        What to show or change.
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

    @property
    def is_certain(self) -> bool:
        """True if the finding assumes nothing."""
        return not self.assumptions


def sort_findings(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Sort findings by automaton as they come, in each the most severe first, and certain ones before others."""
    order = {name: at for at, name in enumerate(dict.fromkeys(each.automaton for each in findings))}
    return tuple(
        sorted(findings, key=lambda each: (order[each.automaton], -each.severity.rank, not each.is_certain))
    )
