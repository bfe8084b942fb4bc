"""Find decisions with little evidence: cells with a single example, readings without any in a state, and outliers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import reduce
from itertools import product
from math import isfinite
from operator import or_
from typing import NamedTuple

from understudy.addons.checks.verification.cells import Leaf
from understudy.addons.checks.verification.finding import Finding, FindingCell, FindingKind, Severity
from understudy.addons.checks.verification.subject import MOST_EXAMPLES, Subject, join_conditions
from understudy.errors import join_names
from understudy.model.automaton import name_next_state
from understudy.model.describe import name_examples
from understudy.model.features import BoundFeature, Feature
from understudy.model.lesson import Example
from understudy.model.tree import STAY
from understudy.model.tree_text import FeatureText
from understudy.model.value_kinds import Continuous

MOST_WEAK = 3
"""The number of cells of one example that are described, the weakest first; the others are counted."""
FEWEST_OTHERS = 10
"""Among fewer other values no example counts as far outside. Of ten values that vary by chance in the manner of a
normal distribution, one lies as far outside in about one case of a hundred (Dixon 1950, Q above 0.5)."""
ABSENT = "the reading can be absent: whether it ever is, is not decided here"


def _list_states(subject: Subject) -> Iterator[tuple[str, str, int, Sequence[Leaf]]]:
    """Yield each state with a tree that can be entered: its name, words for it, its domain, and its leaves.

    The states of a stateless automaton share a tree, so its first stands for all, with what any of them can read.
    """
    level = subject.level
    entered = sorted(level.reachable_states)
    for index in entered:
        state, leaves = level.automaton.states[index].name, level.leaves[index]
        if leaves is not None and level.automaton.stateless:
            yield state, "it", reduce(or_, map(level.get_domain, entered)), leaves
            return
        if leaves is not None:
            yield state, f"in {state}, it", level.get_domain(index), leaves


class _OneExample(NamedTuple):
    """A leaf that a single press supports, with the watched examples that contradict it and those that confirm it."""

    contradicting: int
    agreeing: int
    does: str
    cell: FindingCell
    state: str
    example: int


def find_cells_of_one_example(subject: Subject) -> Iterator[Finding]:
    """Find leaves on whose answer a single press-made example agrees, in trees that test something; one finding.

    Watched examples do not count, since they decide nothing, and neither do defaults that a directive outvotes. The
    weakest come first: those that most watched examples contradict, then those that fewest confirm.
    """
    single = sorted(_list_single_examples(subject), key=lambda each: (-each.contradicting, each.agreeing))
    if not single:
        return
    if len(single) == 1:
        sentence = f"{single[0].does}: only example {single[0].example} says so."
    else:
        decisions = "; ".join(f"{each.does} (example {each.example})" for each in single[:MOST_WEAK])
        weakest = "the weakest: " if len(single) > MOST_WEAK else ""
        sentence = f"{len(single)} decisions rest on one example each; {weakest}{decisions}."
    yield Finding(
        FindingKind.ONE_EXAMPLE,
        Severity.NOTE,
        subject.label,
        sentence[0].upper() + sentence[1:],
        tuple(each.state for each in single),
        cells=tuple(each.cell for each in single),
        examples=tuple(each.example for each in single),
        remedy="Show once more what to do there.",
    )


def _list_single_examples(subject: Subject) -> Iterator[_OneExample]:
    level = subject.level
    for state, it, domain, leaves in _list_states(subject):
        for leaf in leaves:
            box = domain & leaf.box
            if leaf.node == STAY or not leaf.tested or not level.space.has_vectors(box):
                continue
            answer = name_next_state(level.automaton, state, leaf.outcome)
            here = subject.list_examples(state, leaf.node)
            agreeing = [each for each in here if each.next == answer]
            pressed = [each for each in agreeing if each.is_from_press]
            if len(pressed) != 1:
                continue
            watched, confirming = sum(not each.is_from_press for each in here), len(agreeing) - 1
            cell = subject.make_cell(box, domain)
            where = cell.condition if cell.condition == "always" else f"when {cell.condition}"
            does = f"{it} {'stays' if answer == state else f'goes to {answer}'} {where}"
            yield _OneExample(watched - confirming, confirming, does, cell, state, pressed[0].number)


def find_branches_never_shown(subject: Subject) -> Iterator[Finding]:
    """Find present values, such as a label, that reach no leaf, so that the state stays for want of examples."""
    level = subject.level
    for state, it, domain, leaves in _list_states(subject):
        boxes = []
        for leaf in leaves:
            present = (
                domain & leaf.box & ~sum(axis.absence for axis in level.axes if axis.whole in leaf.tested)
            )
            if leaf.node == STAY and level.space.has_vectors(present):
                boxes.append(present)
        if boxes:
            cells = subject.make_cells(boxes, domain)
            there = join_conditions(cells)
            yield Finding(
                FindingKind.NEVER_SHOWN,
                Severity.WARNING,
                subject.label,
                f"{it[0].upper()}{it[1:]} stays when {there} only because nothing was shown there.",
                (state,),
                level.space.tie_sentences,
                cells,
                remedy="Show what to do there.",
            )


def find_absence_never_shown(subject: Subject) -> Iterator[Finding]:
    """Find features whose absence no example of a state covers, and the states that stay for that; one finding."""
    level = subject.level
    boxes: list[int] = []
    states: dict[str, None] = {}
    absent: dict[str, None] = {}
    for state, _, domain, leaves in _list_states(subject):
        for leaf, axis in product(leaves, level.axes):
            box = domain & leaf.box & (axis.absence | ~axis.whole)
            is_open = (
                leaf.node == STAY and axis.whole in leaf.tested and isinstance(axis.bound.feature, Feature)
            )
            if is_open and level.space.has_vectors(box):
                boxes.append(box)
                states[state] = absent[str(axis.bound)] = None
    if not boxes:
        return
    stays = "" if level.automaton.stateless else f" in {join_names(states)}"
    while_absent = f"{join_names(absent, word='or')} is absent"
    yield Finding(
        FindingKind.ABSENT_NEVER_SHOWN,
        Severity.NOTE,
        subject.label,
        f"While {while_absent}, it stays{stays} only because no example there had it absent.",
        tuple(states),
        (ABSENT,),
        subject.make_cells(boxes),
        remedy=f"Show what to do while {while_absent}{stays}, if that can happen.",
    )


def find_outliers(subject: Subject) -> Iterator[Finding]:
    """Find examples with a number that is farther from all others than those are from each other.

    They are looked for among at least `FEWEST_OTHERS` other values of a continuous reading, in all states. A press and
    the default after it, which have the same readings, count as one.
    """
    level, lesson = subject.level, subject.level.taught.lesson
    used = [each for each in (lesson.examples if lesson is not None else ()) if not each.quarantined]
    for index, bound in enumerate(level.automaton.features):
        if not (isinstance(bound.feature, Feature) and isinstance(bound.kind, Continuous)):
            continue
        values = sorted({each.values[index] for each in used if isfinite(each.values[index])})
        if len(values) <= FEWEST_OTHERS:
            continue
        for far, near, opposite in ((values[-1], values[-2], values[0]), (values[0], values[1], values[-1])):
            there = [each for each in used if each.values[index] == far]
            is_one = len({repr(each.values) for each in there}) == 1 and there[0].is_from_press
            if is_one and abs(far - near) > abs(near - opposite):
                yield _make_outlier(subject, bound, there, far, near, opposite)


def _make_outlier(
    subject: Subject, bound: BoundFeature, there: list[Example], far: float, near: float, opposite: float
) -> Finding:
    text = FeatureText(bound, (), known_absent=True).number
    numbers = tuple(each.number for each in there)
    named, have = name_examples(numbers, most=MOST_EXAMPLES), "has" if len(numbers) == 1 else "have"
    low, high = sorted((near, opposite))
    return Finding(
        FindingKind.OUTLIER,
        Severity.WARNING,
        subject.label,
        f"{named.capitalize()} {have} {bound} at {text(far)}, farther from all others than those are from "
        f"each other: {text(low)} to {text(high)}.",
        tuple(dict.fromkeys(each.state for each in there)),
        examples=numbers,
        remedy=f"If that is a mistake, delete {named}; if not, show more between {text(near)} and {text(far)}.",
    )
