"""Find features and parameters that decide nothing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

from understudy.errors import join_names
from understudy.model.library import Library
from understudy.model.tree import STAY
from understudy.model.tree_regions import find_tested_features
from understudy.verification.cells import Axis, Leaf
from understudy.verification.finding import Finding, FindingKind, Severity
from understudy.verification.levels import Level
from understudy.verification.subject import Subject

MOST_PAIRS = 200_000
"""So many pairs of leaves are compared; a feature of larger trees that is tested counts as one that decides."""


def find_unused_features(subject: Subject) -> Iterator[Finding]:
    """Find features on which no decision depends, though a tree may test them."""
    level = subject.level
    if not level.is_decided_by_trees or not level.automaton.transitions:
        return
    deciding = find_deciding_features(level)
    tested = find_tested_features(level.trees)
    for index, bound in enumerate(level.automaton.features):
        if index in deciding:
            continue
        why = "both sides of its tests lead to the same states" if index in tested else "no tree tests it"
        yield Finding(
            FindingKind.UNUSED_FEATURE,
            Severity.NOTE,
            subject.label,
            f"{bound} decides nothing: {why}.",
            remedy=f"Leave {bound} out, or show where it matters.",
        )


def find_deciding_features(level: Level) -> set[int]:
    """Find the positions of the features on which some decision of an automaton's trees depends.

    A decision depends on a feature if two leaves with different outcomes have boxes that no other feature separates.
    """
    found: set[int] = set()
    left = MOST_PAIRS
    for index, leaves in enumerate(level.leaves):
        if leaves is None:
            continue
        tested = {
            at for at, axis in enumerate(level.axes) if any(axis.whole in leaf.tested for leaf in leaves)
        }
        if left <= 0:
            found |= tested
        for first, second in combinations(leaves, 2):
            if tested <= found:
                break
            left -= 1
            if _next(first, index) != _next(second, index):
                apart = _find_separating(first, second, level.axes)
                if len(apart) == 1:
                    found |= apart
    return found


def _next(leaf: Leaf, index: int) -> int:
    return index if leaf.outcome == STAY else leaf.outcome


def _find_separating(first: Leaf, second: Leaf, axes: Sequence[Axis]) -> set[int]:
    both = first.box & second.box
    return {at for at, axis in enumerate(axes) if not both & axis.whole}


def find_unused_parameters(subject: Subject) -> Iterator[Finding]:
    """Find parameters that no deciding feature and no behavior of a state uses."""
    level = subject.level
    for parameter in level.automaton.parameters:
        if uses_parameter(subject.library, level, parameter):
            continue
        idle = [str(bound) for bound in level.automaton.features if parameter in bound.binding.values()]
        why = (
            f"{join_names(idle)} {'decides' if len(idle) == 1 else 'decide'} nothing"
            if idle
            else "nothing uses it"
        )
        yield Finding(
            FindingKind.UNUSED_PARAMETER,
            Severity.NOTE,
            subject.label,
            f"Parameter {parameter} decides nothing: {why}, and no state passes it on to what needs it.",
            remedy=f"Remove {parameter}, or show where it matters.",
        )


def uses_parameter(library: Library, level: Level, parameter: str) -> bool:
    """Return whether a decision of an automaton, or what a state of it runs, depends on a parameter."""
    deciding = find_deciding_features(level) if level.is_decided_by_trees else range(len(level.features))
    if any(parameter in level.automaton.features[index].binding.values() for index in deciding):
        return True
    for index in sorted(level.reachable_states):
        state, child = level.automaton.states[index], level.children[index]
        for inner, name in state.binding.items():
            if name == parameter and (child is None or uses_parameter(library, child, inner)):
                return True
    return False
