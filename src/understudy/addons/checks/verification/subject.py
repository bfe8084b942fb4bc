"""The subject of a check: an automaton of a library with its lesson, its cells, and the words for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import inf, isinf
from typing import TYPE_CHECKING

from understudy.addons.checks.verification.cells import NO_VALUES, Axis, choose_vector, join_boxes
from understudy.addons.checks.verification.finding import FindingCell
from understudy.addons.checks.verification.levels import Level, list_levels
from understudy.model.describe import name_examples
from understudy.model.features import Feature
from understudy.model.lesson import Example
from understudy.model.library import Library
from understudy.model.tree import Tree
from understudy.model.tree_regions import ValueSet
from understudy.model.tree_text import FeatureText
from understudy.model.value_kinds import Categorical, Toroidal

if TYPE_CHECKING:
    from understudy.addons.checks.verification.coordinators import SquadMembers

MOST_CELLS = 3
"""The number of cells of one finding that are described; the others are counted."""
MOST_EXAMPLES = 5
"""The number of examples of one finding that are named; the others are counted."""


@dataclass(frozen=True, eq=False)
class Subject:
    """An automaton that is checked.

    Parameters
    ----------
    label
        The name by which findings call it.
    library
        The library that has it.
    level
        It and all that it runs.
    kit_known
        True if the library's kit has the basic behaviors; False if the library was opened without one.
    members
        The squad that it coordinates, with its members' libraries. None for robots, or if no scenario is known.
    still_readings
        Names of the readings that do not change while the robot idles.
    """

    label: str
    library: Library
    level: Level
    kit_known: bool
    members: SquadMembers | None = None
    still_readings: frozenset[str] = frozenset()

    @cached_property
    def examples_by_leaf(self) -> dict[tuple[str, int], list[Example]]:
        """The examples that reach each leaf, by state and index of the leaf's node."""
        by_leaf: dict[tuple[str, int], list[Example]] = {}
        lesson, automaton = self.level.taught.lesson, self.level.automaton
        for example in () if lesson is None else lesson.examples:
            states = [example.state]
            if automaton.stateless:
                states = list(automaton.transitions) if example.is_shown else []
            for state in states:
                tree = automaton.transitions.get(state)
                if not example.quarantined and isinstance(tree, Tree):
                    by_leaf.setdefault((state, tree.path(example.values)[1]), []).append(example)
        return by_leaf

    def list_examples(self, state: str, node: int) -> list[Example]:
        """List the examples of a state that reach the leaf with a node's index."""
        return self.examples_by_leaf.get((state, node), [])

    def find_examples_inside(self, *boxes: int) -> tuple[int, ...]:
        """Find the examples, in any state, whose body readings lie in one of some boxes.

        There are none in a box that restricts a reading that the automaton does not use, since its examples lack it.
        """
        lesson = self.level.taught.lesson
        body = [
            (index, axis)
            for index, axis in enumerate(self.level.axes)
            if isinstance(axis.bound.feature, Feature)
        ]
        own_axes = {axis.shift for _, axis in body}
        others = [
            axis.whole
            for axis in self.level.space.axes
            if isinstance(axis.bound.feature, Feature) and axis.shift not in own_axes
        ]
        usable = [box for box in boxes if body and all(box & whole == whole for whole in others)]
        return tuple(
            example.number
            for example in (() if lesson is None else lesson.examples)
            if any(all(axis.find_bit(example.values[index]) & box for index, axis in body) for box in usable)
        )

    @cached_property
    def _shown_values(self) -> dict[int, list[float]]:
        """The values of each axis in press-made examples, by the axis' shift."""
        values: dict[int, list[float]] = {}
        for level in list_levels(self.level):
            lesson = level.taught.lesson
            for index, axis in enumerate(level.axes):
                axis_values = values.setdefault(axis.shift, [])
                for each in () if lesson is None else lesson.examples:
                    if each.is_from_press:
                        axis_values.append(each.values[index])
        return values

    def _describe_region(self, axis: Axis, region: ValueSet) -> str:
        """Describe some values of an axis, such that each press stays on its side of a rounded threshold."""
        values = self._shown_values.get(axis.shift, [])
        ends = [end for part in region.parts for end in part if not isinf(end)]
        return FeatureText(axis.bound, ends, known_absent=bool(axis.absence), values=values).statement(region)

    def describe_box(self, box: int, domain: int) -> str:
        """Describe a box in words: "distance_to(A) is below 0.5 m"; "always" if it is all of a domain."""
        statements = [
            self._describe_region(axis, _open_ends(axis, axis.region(box)))
            for axis in self.level.space.axes
            if box & axis.whole not in (0, domain & axis.whole)
        ]
        return " and ".join(statements) or "always"

    def make_cell(self, box: int, domain: int) -> FindingCell:
        """Make the cell of a finding from a box, described by where it is smaller than the domain."""
        possible = self.level.space.before_end.narrow(box) or box
        axes = [axis for axis in self.level.space.axes if box & axis.whole != axis.whole]
        regions = tuple(axis.region(box) for axis in axes)
        at = choose_vector(possible, axes)
        return FindingCell(tuple(axis.bound for axis in axes), regions, at, self.describe_box(box, domain))

    def make_cells(self, boxes: Sequence[int], domain: int | None = None) -> tuple[FindingCell, ...]:
        """Make the cells of a finding from boxes, joined where they are neighbors, in a domain (None: all vectors)."""
        space = self.level.space
        within = space.full if domain is None else domain
        return tuple(self.make_cell(box, within) for box in join_boxes(boxes, space.axes))


def _open_ends(axis: Axis, region: ValueSet) -> ValueSet:
    """Extend a region over values outside the feature's domain, which need not be excluded in words."""
    if isinstance(axis.bound.kind, Toroidal | Categorical) or not region.parts:
        return region
    intervals = [part.parts[0] for part in axis.parts if part.parts]
    following = {high: low for (_, high), (low, _) in pairwise(intervals)} | {intervals[-1][1]: inf}
    open_values = NO_VALUES
    for low, high in region.parts:
        start = -inf if low == intervals[0][0] else low
        open_values |= ValueSet(((start, following.get(high, high)),), False)
    return ValueSet(open_values.parts, region.absent)


def name_evidence(examples: Sequence[int]) -> str:
    """Name the examples whose readings are in the cells of a finding, for a sentence; an empty text without any."""
    have = "has" if len(examples) == 1 else "have"
    return f" ({name_examples(examples, most=MOST_EXAMPLES)} {have} such readings)" if examples else ""


def join_conditions(cells: Sequence[FindingCell]) -> str:
    """Join the conditions of cells for a sentence: "where A is close", with the number of those left out."""
    conditions = [cell.condition for cell in cells[:MOST_CELLS] if cell.condition != "always"]
    if not conditions or any(cell.condition == "always" for cell in cells):
        return "always"
    more = len(cells) - len(conditions)
    return ", or ".join(conditions) + (f", or in {more} more cells" if more > 0 else "")
