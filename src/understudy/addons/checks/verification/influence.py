"""Find features and parameters on which no decision depends, and states that ignore the parameter they decide by."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

from understudy.addons.checks.verification.cells import Axis, Leaf
from understudy.addons.checks.verification.finding import Finding, FindingKind, Severity
from understudy.addons.checks.verification.levels import Level
from understudy.addons.checks.verification.subject import Subject
from understudy.errors import join_names
from understudy.model.library import Library
from understudy.model.tree import STAY, Tree
from understudy.model.tree_regions import find_tested_features

MOST_PAIRS = 200_000
"""The largest number of pairs of leaves that are compared; in larger trees, each feature that is tested counts as one
on which decisions depend."""


def find_unused_features(subject: Subject) -> Iterator[Finding]:
    """Find features on which no decision depends: those that no tree tests, and those tested in vain."""
    level = subject.level
    if not level.is_decided_by_trees or not level.automaton.transitions:
        return
    deciding = find_deciding_features(level)
    tested = find_tested_features(level.trees)
    unused = [index for index in range(len(level.automaton.features)) if index not in deciding]
    for is_tested, why in (
        (False, "no tree tests"),
        (True, "both sides lead to the same states wherever trees test"),
    ):
        names = [str(level.automaton.features[index]) for index in unused if (index in tested) is is_tested]
        if names:
            one = len(names) == 1
            yield Finding(
                FindingKind.UNUSED_FEATURE,
                Severity.NOTE,
                subject.label,
                f"{join_names(names)} {'decides' if one else 'decide'} nothing: {why} {'it' if one else 'them'}.",
                remedy=f"Leave {join_names(names)} out, or show where {'it matters' if one else 'they matter'}.",
            )


def find_deciding_features(level: Level) -> set[int]:
    """Find the positions of the features on which some decision of an automaton's trees depends.

    A decision depends on a feature if two leaves with different outcomes have boxes that no other feature separates.
    """
    deciding: set[int] = set()
    left = MOST_PAIRS
    for index, leaves in enumerate(level.leaves):
        if leaves is None:
            continue
        tested = {
            at for at, axis in enumerate(level.axes) if any(axis.whole in leaf.tested for leaf in leaves)
        }
        if left <= 0:
            deciding |= tested
        for first, second in combinations(leaves, 2):
            if tested <= deciding:
                break
            left -= 1
            if _next(first, index) != _next(second, index):
                apart = _find_separating(first, second, level.axes)
                if len(apart) == 1:
                    deciding |= apart
    return deciding


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


def find_constant_targets(subject: Subject) -> Iterator[Finding]:
    """Find states that run something with a fixed target while they decide by readings of a parameter.

    It is right if the automaton looks at the fixed target, too. If it does not, and the state's own tree looks at the
    parameter, or no state passes the parameter on, the person probably meant the parameter.
    """
    automaton = subject.level.automaton
    parameters = set(automaton.parameters)
    sensed = [set(bound.binding.values()) for bound in automaton.features]
    followed = {name for names in sensed for name in names & parameters}
    passed = {name for state in automaton.states for name in state.binding.values()}
    for index in sorted(subject.level.reachable_states) if followed else ():
        state = automaton.states[index]
        tree = automaton.transitions.get(state.name)
        tested = find_tested_features([tree]) if isinstance(tree, Tree) else set()
        asks = {name for at in tested for name in sensed[at] & parameters}
        meant = sorted(asks or followed - passed)
        for target in sorted(set(state.binding.values()) - parameters - set().union(*sensed)):
            if not meant:
                continue
            runs = subject.library.format_call(state.behavior or "", state.binding)
            yield Finding(
                FindingKind.CONSTANT_TARGET,
                Severity.WARNING,
                subject.label,
                f"State {state.name} runs {runs} whatever {join_names(meant)} is, but {automaton.name} looks only at "
                f"{join_names(meant)}, never at {target}.",
                (state.name,),
                remedy=f"Let {state.name} follow {join_names(meant, word='or')}; if {target} is meant, add a feature "
                f"about {target}.",
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
