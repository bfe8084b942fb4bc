"""Find dead ends: states that stay once the automaton they run has raised a flag and idles, so that nothing moves."""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce
from operator import or_

from understudy.addons.checks.verification.cells import Leaf, intersect, join_boxes
from understudy.addons.checks.verification.chatter import HELD
from understudy.addons.checks.verification.finding import Finding, FindingKind, Severity
from understudy.addons.checks.verification.levels import Level, build_hierarchy
from understudy.addons.checks.verification.subject import Subject, join_conditions, name_evidence
from understudy.errors import join_names
from understudy.model.features import CounterFeature, Feature, FlagFeature
from understudy.model.tree import STAY
from understudy.model.value_kinds import NO, YES

MOST_BOXES = 200
"""The largest number of boxes in which a flag is raised that are examined one by one; of more, only the box of all
readings is."""


def find_dead_ends(subject: Subject) -> Iterator[Finding]:
    """Find states that stay, in some cell, after the automaton that they run has raised a flag.

    That automaton idles from then on, so the robot stands, and only what moves by itself can still change a reading.
    States that are never left at all are found elsewhere. Coordinators wait for members, which go on.
    """
    level = subject.level
    leads = any(behavior.order is not None for behavior in subject.library.kit.behaviors.values())
    if leads or not level.is_decided_by_trees:
        return
    for index in sorted(level.reachable_states):
        child = level.children[index]
        if child is None or not level.exits[index]:
            continue
        for flag in sorted(child.possible_flags):
            yield from _find_after_flag(subject, index, child, flag)


def _find_after_flag(subject: Subject, index: int, child: Level, flag: str) -> Iterator[Finding]:
    level = subject.level
    raising = _list_raised_while_staying(level, index, child, flag)
    later = _raise_flag(level, index, flag)
    domain = later & reduce(or_, list_raising_boxes(child, flag), 0)
    leaves = level.leaves[index] or ()
    exits = [leaf for leaf in leaves if leaf.outcome not in (STAY, index) and intersect(later, leaf)]
    for_good: list[int] = []
    perhaps: list[int] = []
    others: dict[str, None] = {}
    for leaf in leaves:
        stays = intersect(domain, leaf)
        if not stays or leaf.outcome not in (STAY, index):
            continue
        for raised in raising:
            box = stays & raised
            if not level.space.has_vectors(box):
                continue
            ways = [way for other in exits if (way := _list_changes(subject, box, other)) is not None]
            if [] in ways:
                continue  # its clock leads out
            (perhaps if ways else for_good).append(box)
            others |= dict.fromkeys(name for way in ways for name in way)
    if for_good:
        yield _make_finding(subject, index, child, flag, domain, for_good)
    if perhaps:
        yield _make_finding(subject, index, child, flag, domain, perhaps, list(others))


def _list_raised_while_staying(level: Level, index: int, child: Level, flag: str) -> list[int]:
    """List the boxes of body readings with which a flag is raised while a state runs its automaton.

    The state is asked first in each tick, so it must stay with these readings before the flag; except in the tick in
    which it is entered, when only the automaton below is asked.
    """
    domain = _raise_flag(level, index, "")
    stays = [
        box | level.own_bits
        for leaf in level.leaves[index] or ()
        if leaf.outcome in (STAY, index) and (box := intersect(domain, leaf))
    ]
    later = [box & each for box in list_raising_boxes(child, flag) for each in stays]
    boxes = [*list_raising_boxes(child, flag, at_once=True), *later]
    return join_boxes([box for box in boxes if level.space.has_vectors(box)], level.space.axes)


def _raise_flag(level: Level, index: int, flag: str) -> int:
    """Return the box of a state in which the automaton it runs has raised a flag, and no other."""
    box = level.get_domain(index)
    for axis in level.axes:
        feature = axis.bound.feature
        if isinstance(feature, FlagFeature):
            box &= axis.find_bit(YES if feature.name == flag else NO) | ~axis.whole
    return box


def _list_changes(subject: Subject, box: int, way_out: Leaf) -> list[str] | None:
    """List the readings that must change by themselves to leave a box by a leaf; None if that cannot be.

    Time passes by itself, so a leaf that only needs it needs no change.
    """
    changes = []
    for axis in subject.level.axes:
        feature = axis.bound.feature
        if axis.whole not in way_out.tested or box & way_out.box & axis.whole:
            continue
        if isinstance(feature, CounterFeature | FlagFeature):
            return None
        if isinstance(feature, Feature):
            if feature.reading in subject.still_readings:
                return None
            changes.append(str(axis.bound))
    return changes


def list_raising_boxes(level: Level, flag: str, *, at_once: bool = False) -> list[int]:
    """List boxes of body readings such that readings are in one of them when an automaton raises a flag."""
    raising: dict[int, None] = {}
    for state in [0] if at_once else sorted(level.reachable_states):
        for following, leaves in level.exits[state].items():
            if level.automaton.states[following].flag == flag:
                boxes = [box for leaf in leaves for box in _list_leaf_boxes(level, state, leaf)]
                raising |= dict.fromkeys(
                    boxes if leaves else [level.space.full]
                )  # a classifier has no leaves
    if len(raising) > MOST_BOXES:
        return [level.space.full]
    return join_boxes(list(raising), level.space.axes)


def _list_leaf_boxes(level: Level, state: int, leaf: Leaf) -> Iterator[int]:
    """Yield the boxes of body readings in which a leaf is reached; of one that waits for a flag, where it is raised."""
    readings, child = intersect(level.get_domain(state), leaf) | level.own_bits, level.children[state]
    raised = [level.space.full]
    for axis in level.axes:
        feature = axis.bound.feature
        if child is not None and isinstance(feature, FlagFeature) and not leaf.box & axis.find_bit(NO):
            raised = list_raising_boxes(child, feature.name)
    yield from (box for each in raised if level.space.has_vectors(box := readings & each))


def _make_finding(
    subject: Subject,
    index: int,
    child: Level,
    flag: str,
    domain: int,
    boxes: list[int],
    others: list[str] | None = None,
) -> Finding:
    """Make the finding of boxes in which a state waits: for good, or unless `others` change by themselves."""
    state = subject.level.automaton.states[index].name
    cells = subject.make_cells(boxes, domain)
    there = join_conditions(cells)
    examples = subject.find_examples_inside(*boxes)
    stoppers = _list_stoppers(subject)
    unless = f" unless {join_names(stoppers, word='or')} stops {subject.level.name}" if stoppers else ""
    assumptions = [] if there == "always" or examples else [HELD]
    if others:
        assumptions.append(f"nothing else changes {join_names(others, word='or')} while {child.name} idles")
    where = f", where {there}" if there != "always" else "" if others else ", whatever it reads"
    return Finding(
        FindingKind.DEAD_END,
        Severity.WARNING if others or stoppers else Severity.ERROR,
        subject.label,
        f"Once {child.name} has raised {flag}, {subject.level.name} stays in {state} for ever{unless}{where}: "
        f"{child.name} idles, so the robot stands.",
        (state,),
        tuple(assumptions),
        cells,
        examples,
        f"Show where to go from {state} then{name_evidence(examples)}, or show {child.name} not to raise {flag} there.",
    )


def _list_stoppers(subject: Subject) -> list[str]:
    """List the automata of the library that run this one in a state and may leave that state without its flag."""
    stoppers = []
    for name in subject.library.find_users(subject.level.name):
        user = build_hierarchy(subject.library, name)
        for index, state in enumerate(user.automaton.states):
            if state.behavior == subject.level.name and index in user.reachable_states:
                domain = _raise_flag(user, index, "")
                leaving = [leaf for leaves in user.exits[index].values() for leaf in leaves]
                if any(intersect(domain, leaf) for leaf in leaving) or not user.is_decided_by_trees:
                    stoppers.append(name)
                    break
    return stoppers
