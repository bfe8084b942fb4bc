"""Walks through a hierarchy for a conformance file: readings at the boundaries of trees, absent values, seams.

Every reading that is a number is also infinite, with both signs, which an export must take as absent.

A walk often aims at a question that has not been asked with the values at both its sides, and sets the readings that
lead there. Otherwise it changes readings at random.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import inf, isfinite, nan, nextafter
from random import Random
from typing import TypeAlias

from understudy.addons.export.hierarchy import FeatureSource, GroundAutomaton, Hierarchy
from understudy.addons.export.single_precision import round_to_single, step_single
from understudy.model.tree import STAY, Node, TestKind, Tree, is_in_arc
from understudy.model.value_kinds import Categorical, Toroidal
from understudy.runtime.interpreter import RunningAutomaton
from understudy.runtime.link import Instance

USUAL = (-1.0, 0.0, 0.1, 0.5, 1.0, 2.0, 5.0)
"""Values of continuous readings that no tree compares."""
CHANGED = 0.3
"""The chance of a reading to change in a tick without an aim."""
AIMED = 0.6
"""The chance of a tick to aim at a boundary."""

Boundary: TypeAlias = tuple[int, int, int, float]
"""A value at a boundary: automaton, state whose tree it is, node, value (NaN: absent)."""


class ReadingWalk:
    """A source of rows of readings for a hierarchy, and a record of what they reached."""

    def __init__(self, hierarchy: Hierarchy, random: Random, *, single_precision: bool = False) -> None:
        self.hierarchy, self.random, self._single = hierarchy, random, single_precision
        self.values = [self._list_values(slot) for slot in range(len(hierarchy.readings))]
        self.row = [random.choice(values) for values in self.values]
        self._numbers = [
            slot
            for slot, reading in enumerate(hierarchy.readings)
            if not isinstance(reading.kind, Categorical)
        ]
        self._infinite = [(slot, end) for slot in self._numbers for end in (inf, -inf)]
        random.shuffle(self._infinite)
        self._parents: dict[tuple[int, int], list[int]] = {}
        self.deepest = 0
        """The largest number of questions on the way to an answer, of all trees."""
        self.leaves: set[tuple[int, int, int]] = set()
        self.boundaries: set[Boundary] = set()
        self.waiting: dict[tuple[int, int], list[Boundary]] = {}
        """The boundaries that were not met yet, in order, by automaton and state."""
        self.reached: set[tuple[int, int, int]] = set()
        self._first: dict[tuple[int, int], int] = {}  # a stateless automaton has one tree
        for number, automaton in enumerate(hierarchy.automata):
            for decision in automaton.decisions:
                first = decision.states[0]
                self._first |= {(number, state): first for state in decision.states}
                tree = automaton.states[first].tree
                if tree is not None:
                    self._add_tree(number, first, automaton, tree)
        for boundary in sorted(self.boundaries):
            self.waiting.setdefault(boundary[:2], []).append(boundary)
        self.indices = {each.name: number for number, each in enumerate(hierarchy.automata)}
        self._by_instance: dict[Instance, int] = {}  # without writing its name at every query

    def _add_tree(self, number: int, index: int, automaton: GroundAutomaton, tree: Tree) -> None:
        self._parents[number, index], depth = _find_parents(tree)
        self.deepest = max(self.deepest, depth)
        for at, node in enumerate(tree.nodes):
            if node.test == TestKind.LEAF:
                self.leaves.add((number, index, at))
                continue
            source = automaton.features[node.feature]
            if source.sort == "reading":
                for value in self._sides(node, source):
                    self.boundaries.add((number, index, at, value if value == value else inf))

    def _sides(self, node: Node, source: FeatureSource) -> Iterator[float]:
        if node.test == TestKind.LABEL:
            yield from map(float, range(len(node.branches)))
        if node.test in (TestKind.BELOW, TestKind.ARC):
            for cut in (node.low, node.high) if node.test == TestKind.ARC else (node.high,):
                for value in (cut, self._before(cut)):
                    if _is_of_kind(value, source):
                        yield value
        yield nan

    def _before(self, value: float) -> float:
        return step_single(value, -inf) if self._single else nextafter(value, -inf)

    def _list_values(self, slot: int) -> tuple[float, ...]:
        kind = self.hierarchy.readings[slot].kind
        if isinstance(kind, Categorical):
            return (*map(float, range(len(kind.labels))), nan)
        cuts = set()
        for automaton in self.hierarchy.automata:
            for state in automaton.states:
                for node in () if state.tree is None else state.tree.nodes:
                    source = automaton.features[node.feature] if node.test in (1, 2) else None
                    if source is not None and source.sort == "reading" and source.index == slot:
                        cuts |= {cut for cut in (node.low, node.high) if isfinite(cut)}
        ordered = sorted(cuts)
        values = {*ordered, *map(self._before, ordered)}
        values |= {(low + high) / 2 for low, high in pairwise(ordered)}
        if isinstance(kind, Toroidal):
            values |= {0.0, kind.period / 2, self._before(kind.period)}
            values = {value for value in values if 0.0 <= value < kind.period}
        elif ordered:
            values |= {0.0, ordered[0] - 1.0, ordered[-1] + 1.0}
        else:
            values |= set(USUAL)
        rounded = {round_to_single(value) for value in values} if self._single else values
        if isinstance(kind, Toroidal):
            rounded = {value for value in rounded if value < kind.period}
        return (*sorted(rounded), nan)

    def advance(self, active: Sequence[RunningAutomaton]) -> tuple[float, ...]:
        """Return the next row of readings, given the automata that are active before the tick."""
        boundary = self._choose(active) if self.random.random() < AIMED else None
        if boundary is None:
            for slot, values in enumerate(self.values):
                if self.random.random() < CHANGED:
                    self._set(slot, self.random.choice(values))
            if self._infinite:  # once for sure
                slot, end = self._infinite.pop()
                self.row[slot] = end
        else:
            self._aim(boundary)
        return tuple(self.row)

    def _choose(self, active: Sequence[RunningAutomaton]) -> Boundary | None:
        """Choose a boundary that was not met yet, in the tree of one of the active automata."""
        if not active:
            return None
        machine = self.random.choice(active)
        number = self._find_number(machine.instance)
        index = self._first.get((number, machine.state), -1)
        near = self.waiting.get((number, index), ())
        return self.random.choice(near) if near else None

    def _aim(self, boundary: Boundary) -> None:
        """Set the readings on the way to a node so that it is asked with the value of a boundary."""
        number, index, at, value = boundary
        automaton = self.hierarchy.automata[number]
        tree = automaton.states[index].tree
        if tree is None:
            return
        nodes: dict[int, list[tuple[Node, int]]] = {}
        for node, child in _list_path(self._parents[number, index], at):
            source = automaton.features[tree.nodes[node].feature]
            if source.sort == "reading":
                nodes.setdefault(source.index, []).append((tree.nodes[node], child))
        for slot, steps in nodes.items():
            fitting = _list_fitting(self.values[slot], steps)
            if fitting:
                self._set(slot, self.random.choice(fitting))
        self._set(automaton.features[tree.nodes[at].feature].index, nan if value == inf else value)

    def _set(self, slot: int, value: float) -> None:
        """Set a reading; a number that is absent is infinite now and then."""
        if value != value and slot in self._numbers:
            value = self.random.choice((nan, inf, -inf))
        self.row[slot] = value

    def note(self, machine: RunningAutomaton, state: int, values: Sequence[float]) -> None:
        """Note what a query reached: the leaf, and boundaries on the way."""
        number = self._find_number(machine.instance)
        index = self._first[number, state]
        tree = self.hierarchy.automata[number].states[index].tree
        if tree is None:
            return
        waiting = self.waiting.get((number, index), [])
        at, nodes = 0, tree.nodes
        while at != STAY and (node := nodes[at]).test != TestKind.LEAF:
            value = values[node.feature]
            met = (number, index, at, value if value == value else inf)
            place = bisect_left(waiting, met)
            if waiting[place : place + 1] == [met]:
                del waiting[place]
            at = find_child(node, value)
        if at != STAY:
            self.reached.add((number, index, at))

    def _find_number(self, instance: Instance) -> int:
        if instance not in self._by_instance:
            self._by_instance[instance] = self.indices[str(instance)]
        return self._by_instance[instance]


def find_child(node: Node, x: float) -> int:
    """Return the child of a node that a value leads to, or STAY."""
    if not isfinite(x):
        return node.yes if node.test == TestKind.ABSENT else node.absent
    if node.test == TestKind.LABEL:
        return node.branches[int(x)]
    if node.test == TestKind.BELOW:
        return node.yes if x < node.high else node.no
    return node.yes if node.test == TestKind.ARC and is_in_arc(x, node.low, node.high) else node.no


def _find_parents(tree: Tree) -> tuple[list[int], int]:
    """Return for each node the node before it on the first way from the root, -1 without one, and the longest way."""
    parents, depths = [-1] * len(tree.nodes), [0] * len(tree.nodes)
    for index, node in enumerate(tree.nodes):  # children come after their parents
        if node.test == TestKind.LEAF or (index and parents[index] < 0):
            continue
        for child in (node.yes, node.no, node.absent, *node.branches):
            if child > 0 and parents[child] < 0:
                parents[child], depths[child] = index, depths[index] + 1
    return parents, max(depths)


def _list_path(parents: Sequence[int], at: int) -> list[tuple[int, int]]:
    """List the way from the root to a node, as pairs of a node and its child."""
    path = []
    while parents[at] >= 0:
        path.append((parents[at], at))
        at = parents[at]
    return path[::-1]


def _list_fitting(values: Sequence[float], steps: Sequence[tuple[Node, int]]) -> list[float]:
    """List the values, in order, that lead from each of some nodes to its child; the last value is absent (NaN).

    Deep trees have many steps and many values, so that only what is no cut is tried value by value.
    """
    first, stop = 0, len(values) - 1
    others, is_absent = [], True
    for node, child in steps:
        if node.test == TestKind.BELOW and node.yes != node.no:
            is_absent = is_absent and node.absent == child
            if child == node.yes:
                stop = bisect_left(values, node.high, 0, stop)
            elif child == node.no:
                first = bisect_left(values, node.high, first, len(values) - 1)
            else:
                stop = 0
        else:
            others.append((node, child))
    tried = [*values[first : max(first, stop)], *(values[-1:] if is_absent else ())]
    return [x for x in tried if all(find_child(node, x) == child for node, child in others)]


def _is_of_kind(value: float, source: FeatureSource) -> bool:
    if not isfinite(value):
        return False
    return not isinstance(source.kind, Toroidal) or 0.0 <= value < source.kind.period
