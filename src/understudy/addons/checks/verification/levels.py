"""The hierarchy under an automaton, prepared for a check: its states, leaves and nested automata in one space."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from understudy.addons.checks.verification.cells import (
    NONEMPTY,
    Axis,
    Leaf,
    divide_axis,
    intersect,
    is_box_empty,
    list_feature_cuts,
    make_feature_domain,
    partition_tree,
)
from understudy.addons.checks.verification.ties import Possibility, Tie
from understudy.model.automaton import Automaton
from understudy.model.behaviors import StateEffect
from understudy.model.binding import NOTHING_BOUND, Binding
from understudy.model.features import BoundFeature, Feature, FlagFeature
from understudy.model.library import Library, TrainedAutomaton
from understudy.model.tree import STAY, TestKind, Tree
from understudy.model.tree_regions import ValueSet
from understudy.model.value_kinds import NO


@dataclass(eq=False)
class Level:
    """An automaton with its parameters bound as far as they are known, and the automata that its states run.

    Parameters
    ----------
    taught
        The automaton and its lesson.
    binding
        Target, or parameter of the root, by parameter.
    features
        The automaton's features, with the names of their targets replaced accordingly.
    children
        For each state the automaton that it runs; None for a basic behavior, an idle state or a flag state.
    changes
        For each state the changes of counters and timers that its start makes.
    axes
        The axis of each feature.
    leaves
        For each state the leaves of its tree; None without a tree.
    quiet
        For states of coordinators the statistics of flags that no member can change while the state's order stands.
    instant
        For states of coordinators the statistics of flags that members can change in the tick of the order. None: it
        is not known.
    """

    taught: TrainedAutomaton
    binding: Binding
    features: tuple[BoundFeature, ...]
    children: tuple[Level | None, ...]
    changes: tuple[tuple[StateEffect, ...], ...]
    axes: tuple[Axis, ...] = ()
    leaves: tuple[tuple[Leaf, ...] | None, ...] = ()
    quiet: Mapping[int, frozenset[str]] = field(default_factory=dict)
    instant: Mapping[int, frozenset[str]] | None = None
    space: Space = field(init=False)
    _domains: dict[int, int] = field(default_factory=dict, init=False)

    @property
    def automaton(self) -> Automaton:
        """The automaton."""
        return self.taught.automaton

    @property
    def name(self) -> str:
        """The name of the automaton."""
        return self.automaton.name

    @property
    def is_decided_by_trees(self) -> bool:
        """True if every transition function is a decision tree, so that it can be checked."""
        return all(isinstance(each, Tree) for each in self.automaton.transitions.values())

    @property
    def trees(self) -> list[Tree]:
        """The decision trees of the states; a stateless automaton's is listed once."""
        trees = {id(each): each for each in self.automaton.transitions.values() if isinstance(each, Tree)}
        return list(trees.values())

    @cached_property
    def own_bits(self) -> int:
        """The bits of the axes of the automaton's own features."""
        return sum(axis.whole for axis in self.axes if not isinstance(axis.bound.feature, Feature))

    def get_domain(self, state: int) -> int:
        """Return the box of feature vectors of a state, in which flags that its behavior cannot raise are down."""
        if state not in self._domains:
            box = self.space.full
            for axis, bit in self.list_constants(state):
                box &= bit | ~axis.whole
            self._domains[state] = box
        return self._domains[state]

    def list_constants(self, state: int) -> Iterator[tuple[Axis, int]]:
        """Yield the axes whose feature has one value in a state, with its bit: flags that nothing there can raise."""
        child = self.children[state]
        raised = child.possible_flags if child is not None else frozenset[str]()
        for axis in self.axes:
            feature = axis.bound.feature
            if isinstance(feature, FlagFeature) and feature.name not in raised:
                yield axis, axis.find_bit(NO)
            if isinstance(feature, Feature) and feature.fresh is not None:
                quiet = self.quiet.get(state, frozenset())
                if feature.reading in quiet:
                    yield axis, axis.find_bit(feature.fresh)

    @cached_property
    def exits(self) -> tuple[dict[int, list[Leaf]], ...]:
        """For each state the leaves that a possible feature vector reaches and that lead elsewhere, by next state."""
        exits: list[dict[int, list[Leaf]]] = []
        for state, leaves in enumerate(self.leaves):
            by_next: dict[int, list[Leaf]] = {}
            if leaves is None and self.automaton.states[state].name in self.automaton.transitions:
                by_next = {other: [] for other in range(len(self.leaves)) if other != state}  # a classifier
            domain = self.get_domain(state)
            for leaf in leaves or ():
                if leaf.outcome not in (STAY, state):
                    both = intersect(domain, leaf)
                    if both and self.space.possibility.narrow(both):
                        by_next.setdefault(leaf.outcome, []).append(leaf)
            exits.append(by_next)
        return tuple(exits)

    def _list_leaf_outcomes(self, state: int) -> list[int]:
        """List what each leaf of a state's tree leads to, whether or not it is reached."""
        tree = self.automaton.transitions.get(self.automaton.states[state].name)
        nodes = tree.nodes if isinstance(tree, Tree) else ()
        return [node.yes for node in nodes if node.test == TestKind.LEAF]

    def list_outcomes(self, state: int) -> set[int]:
        """List the states other than itself that leaves of a state's tree lead to, whether or not they are reached."""
        return set(self._list_leaf_outcomes(state)) - {STAY, state}

    def is_excluded_by_ties(self, state: int, outcome: int) -> bool:
        """Return whether ties, and not only flags, keep a state from going to another that its tree leads to."""
        domain = self.get_domain(state)
        left = [leaf for leaf in self.leaves[state] or () if leaf.outcome == outcome and leaf.node != STAY]
        whole = self._list_leaf_outcomes(state).count(outcome)
        return len(left) < whole or any(intersect(domain, leaf) for leaf in left)

    @cached_property
    def reachable_states(self) -> frozenset[int]:
        """The states that can be entered from the start state."""
        reachable, waiting = {0}, [0]
        while waiting:
            for following in self.exits[waiting.pop()]:
                if following not in reachable:
                    reachable.add(following)
                    waiting.append(following)
        return frozenset(reachable)

    @cached_property
    def possible_flags(self) -> frozenset[str]:
        """The flags that the automaton can raise."""
        states = self.automaton.states
        return frozenset(flag for state in self.reachable_states if (flag := states[state].flag) is not None)


@dataclass(eq=False)
class Space:
    """The feature space of an automaton and all that it runs, divided into cells, with the ties between features.

    Parameters
    ----------
    axes
        One for each body reading, shared by all levels, and for each own feature of each level.
    possibility
        The test whether the ties allow any feature vector in a box.
    before_end
        The same before the run has ended, because the goal is reached.
    tie_sentences
        All ties between its features, in words.
    """

    axes: tuple[Axis, ...]
    possibility: Possibility
    before_end: Possibility
    tie_sentences: tuple[str, ...] = ()

    @cached_property
    def full(self) -> int:
        """The box of all feature vectors."""
        return NONEMPTY | sum(axis.whole for axis in self.axes)

    def has_vectors(self, box: int) -> bool:
        """Return whether there are feature vectors in a box that the ties allow before the end of a run."""
        return not is_box_empty(box, self.axes) and self.before_end.narrow(box) != 0


def build_hierarchy(
    library: Library, name: str, ties: Sequence[Tie] = (), goal_ties: Sequence[Tie] = ()
) -> Level:
    """Expand an automaton with everything that it runs, and divide their common feature space.

    Parameters
    ----------
    library
        The library. What it does not have counts as a basic behavior.
    name
        Name of the automaton at the root. Its parameters stay free.
    ties
        Ties between features of the body, which divide and restrict the space.
    goal_ties
        What does not occur before the end of a run. It divides the space, and restricts only `before_end`: states that
        are entered at the end are entered.

    Returns
    -------
    Level
        The root.
    """
    expanded: dict[tuple[str, Binding], Level] = {}
    root = _expand(library, name, NOTHING_BOUND, expanded)
    levels = list(expanded.values())
    cuts: dict[BoundFeature, list[float]] = {}
    own: dict[tuple[int, int], list[float]] = {}
    for level in levels:
        for index, bound in enumerate(level.features):
            where = (
                cuts.setdefault(bound, [])
                if isinstance(bound.feature, Feature)
                else own.setdefault((id(level), index), [])
            )
            where += list_feature_cuts(level.trees, index)
    useful = [tie for tie in ties if all(bound in cuts for bound in tie.features)]
    ending = [tie for tie in goal_ties if all(bound in cuts for bound in tie.features)]
    domains = {bound: make_feature_domain(bound) for bound in cuts}
    for tie in (*useful, *ending):
        for bound, more in tie.cuts.items():
            cuts[bound] += more
    for tie in useful:
        if not tie.terms and len(tie.where) == 1:
            ((bound, region),) = tie.where.items()
            domains[bound] = _without(domains[bound], region)
    axes: list[Axis] = []
    shift = NONEMPTY.bit_length()
    shared: dict[BoundFeature, Axis] = {}
    for bound, feature_cuts in cuts.items():
        shared[bound] = divide_axis(bound, domains[bound], feature_cuts, shift)
        axes.append(shared[bound])
        shift += len(shared[bound].parts)
    for level in levels:
        mine = []
        for index, bound in enumerate(level.features):
            axis = shared.get(bound)
            if axis is None:
                axis = divide_axis(bound, make_feature_domain(bound), own[id(level), index], shift)
                axes.append(axis)
                shift += len(axis.parts)
            mine.append(axis)
        level.axes = tuple(mine)
    joint = [tie for tie in useful if tie.terms or len(tie.where) > 1]
    sentences = tuple(dict.fromkeys(tie.sentence for tie in (*useful, *ending)))
    possibility, before_end = (Possibility(each, [*shared.values()]) for each in (joint, [*joint, *ending]))
    space = Space(tuple(axes), possibility, before_end, sentences)
    for level in levels:
        level.space = space
        divided: dict[int, tuple[Leaf, ...]] = {}
        leaves: list[tuple[Leaf, ...] | None] = []
        for state in level.automaton.states:
            tree = level.automaton.transitions.get(state.name)
            if isinstance(tree, Tree) and id(tree) not in divided:
                divided[id(tree)] = partition_tree(tree, level.axes, space.full)
            leaves.append(divided.get(id(tree)))
        level.leaves = tuple(leaves)
    return root


def _expand(
    library: Library, name: str, binding: Binding, expanded: dict[tuple[str, Binding], Level]
) -> Level:
    """Make the level of an automaton, and those of all that it runs, each once for each binding."""
    if (name, binding) in expanded:
        return expanded[name, binding]
    taught = library.taught[name]
    automaton = taught.automaton
    children: list[Level | None] = []
    changes = []
    for state in automaton.states:
        runs = state.behavior
        nested = runs in library.taught and runs is not None
        children.append(
            _expand(library, runs, state.binding.substitute(binding), expanded) if nested and runs else None
        )
        basic = library.kit.behaviors.get(runs or "")
        changes.append(basic.changes if basic else ())
    features = tuple(
        BoundFeature(bound.feature, bound.binding.substitute(binding)) for bound in automaton.features
    )
    level = Level(taught, binding, features, tuple(children), tuple(changes))
    expanded[name, binding] = level
    return level


def _without(domain: ValueSet, region: ValueSet) -> ValueSet:
    """Return the values of a domain that are not in a region, or the domain if none are left."""
    parts = []
    for low, high in domain.parts:
        at = low
        for start, stop in sorted(region.parts):
            if stop <= at or start >= high:
                continue
            if at < start:
                parts.append((at, start))
            at = max(at, stop)
        if at < high:
            parts.append((at, high))
    left = ValueSet(tuple(parts), domain.absent and not region.absent)
    return domain if left.empty else left


def list_levels(root: Level) -> Iterator[Level]:
    """Yield an automaton and all that it runs, each once."""
    levels: dict[int, Level] = {}
    waiting = [root]
    while waiting:
        level = waiting.pop()
        if id(level) not in levels:
            levels[id(level)] = level
            yield level
            waiting += [child for child in level.children if child is not None]
