"""Check automata of a library from their trees and examples, without a run.

for each in check_library(library).findings:
    print(each.sentence)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from understudy.addons.checks.verification.chatter import find_cycles
from understudy.addons.checks.verification.coordinators import (
    SquadMembers,
    find_orders_without_behavior,
    mark_statistics,
)
from understudy.addons.checks.verification.dead_ends import find_dead_ends
from understudy.addons.checks.verification.finding import Finding, sort_findings
from understudy.addons.checks.verification.influence import (
    find_constant_targets,
    find_unused_features,
    find_unused_parameters,
)
from understudy.addons.checks.verification.levels import build_hierarchy
from understudy.addons.checks.verification.reachability import (
    find_flags_never_raised,
    find_missing_behaviors,
    find_states_never_entered,
    find_states_never_left,
)
from understudy.addons.checks.verification.scenario_facts import NOTHING_ASSUMED, ScenarioFacts
from understudy.addons.checks.verification.subject import Subject
from understudy.addons.checks.verification.support import (
    find_absence_never_shown,
    find_branches_never_shown,
    find_cells_of_one_example,
    find_outliers,
)
from understudy.model.library import Library


@dataclass(frozen=True, slots=True)
class CheckedAutomaton:
    """What was checked of one automaton: the number of its states, and of the boxes that its trees divide."""

    name: str
    states: int
    boxes: int


@dataclass(frozen=True, slots=True)
class CheckReport:
    """The result of a check.

    Parameters
    ----------
    findings
        What was found, by automaton, the most severe first.
    checked
        What was checked.
    unchecked
        What could not be checked, with the reason, in one sentence each.
    ties
        The ties between features that were used, in words.
    """

    findings: tuple[Finding, ...]
    checked: tuple[CheckedAutomaton, ...]
    unchecked: tuple[str, ...] = ()
    ties: tuple[str, ...] = ()


Check = Callable[[Subject], Iterable[Finding]]

TREE_CHECKS: Sequence[Check] = (
    find_missing_behaviors,
    find_orders_without_behavior,
    find_states_never_entered,
    find_states_never_left,
    find_flags_never_raised,
    find_dead_ends,
    find_branches_never_shown,
    find_absence_never_shown,
    find_cells_of_one_example,
    find_outliers,
    find_constant_targets,
    find_unused_features,
    find_unused_parameters,
)
"""The checks of one automaton's trees, besides the search for cycles."""


def check_library(
    library: Library,
    names: Sequence[str] | None = None,
    *,
    facts: ScenarioFacts = NOTHING_ASSUMED,
    prefix: str = "",
    kit_known: bool = False,
    members: SquadMembers | None = None,
) -> CheckReport:
    """Check automata of a library.

    Parameters
    ----------
    library
        The library, with everything that its automata run.
    names
        Names of the automata to check. None: all.
    facts
        What is assumed of the world, such as `collect_scenario_facts` collects of a scenario. Nothing by default.
    prefix
        What to put before names in findings, such as "squad/".
    kit_known
        Whether the library's kit has all basic behaviors, so that a state that runs an unknown one is an error.
    members
        The squad whose coordinators the library is for, with its members' libraries. None for robots.

    Returns
    -------
    CheckReport
        The findings, and what was checked.

    Raises
    ------
    UnknownName
        If the library has no automaton of a name.
    """
    findings: list[Finding] = []
    checked, unchecked = [], []
    used: dict[str, None] = {}
    for name in library.taught if names is None else names:
        library.automaton(name)
        root = build_hierarchy(library, name, facts.ties, facts.goal_ties)
        if members is not None:
            mark_statistics(root, library, members)
        subject = Subject(f"{prefix}{name}", library, root, kit_known, members, facts.still_readings)
        unfinished: list[str] = []
        findings += _check_subject(subject, facts.tick_s, unfinished)
        unchecked += [
            f"cycles of {label}: there are too many to list all, and those found are reported"
            for label in unfinished
        ]
        if not subject.level.is_decided_by_trees:
            unchecked.append(f"decisions of {subject.label}: classifiers of scikit-learn have no cells")
        used |= dict.fromkeys(subject.level.space.tie_sentences)
        boxes = sum(len(leaves or ()) for leaves in subject.level.leaves)
        checked.append(CheckedAutomaton(subject.label, len(subject.level.leaves), boxes))
    return CheckReport(sort_findings(findings), tuple(checked), tuple(unchecked), tuple(used))


def _check_subject(subject: Subject, tick_s: float | None, unfinished: list[str]) -> Iterator[Finding]:
    for check in TREE_CHECKS:
        yield from check(subject)
    if subject.level.is_decided_by_trees:
        yield from find_cycles(subject, tick_s, unfinished)


def join_reports(reports: Iterable[CheckReport]) -> CheckReport:
    """Join the reports of several libraries."""
    all_reports = list(reports)
    return CheckReport(
        sort_findings([finding for each in all_reports for finding in each.findings]),
        tuple(automaton for each in all_reports for automaton in each.checked),
        tuple(reason for each in all_reports for reason in each.unchecked),
        tuple(dict.fromkeys(tie for each in all_reports for tie in each.ties)),
    )
