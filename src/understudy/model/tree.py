"""Decision trees as flat frozen records: learned transition functions (paper section 3.2).

A tree maps a feature vector to the index of the next state, or to `STAY`. It needs no learner to run.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from math import isfinite, isnan, nan
from numbers import Real
from typing import Any, NamedTuple, TypeAlias

from understudy.errors import KindError
from understudy.model.drawing import Axes, call_plot, format_number_of, format_repr
from understudy.model.features import BoundFeature
from understudy.model.value_kinds import LARGEST

STAY = -1  # as an outcome: keep the current state; as a child: nothing was ever shown there, so keep it too
"""The outcome, or child, that keeps the current state; as a child it stands for values that no example had."""


class TestKind(IntEnum):
    """The kind of test that a node makes on the value x of its feature."""

    __test__ = False  # not a test case, as pytest would conclude from the name

    LEAF = 0
    BELOW = 1  # x < high
    ARC = 2  # low <= x < high, across the seam where low > high
    ABSENT = 3  # x is absent
    LABEL = 4  # which label: one branch each


class Node(NamedTuple):
    """A node of a tree: a test whose children are indices of nodes, or STAY; or a leaf with its outcome in `yes`."""

    test: int
    feature: int = -1
    low: float = nan
    high: float = nan
    yes: int = STAY
    no: int = STAY
    absent: int = STAY
    branches: tuple[int, ...] = ()


def make_leaf(outcome: int) -> Node:
    """Make a leaf whose outcome is the index of a state, or STAY."""
    return Node(TestKind.LEAF, yes=outcome)


class PathStep(NamedTuple):
    """One step down a tree: the index of the node passed, and the side taken there.

    `side` is "yes", "no", "absent" or "label"; with "label", `label` is the index of the label.
    """

    node: int
    side: str  # "yes", "no", "absent" or "label"
    label: int = -1


Nested: TypeAlias = tuple[Any, ...]
"""A node that contains its children instead of their indices, with a leaf in place of STAY: faster to evaluate."""


def _nested(nodes: Sequence[Node]) -> Nested:
    below: dict[int, Nested] = {STAY: tuple(make_leaf(STAY))}
    for index in reversed(range(len(nodes))):  # children come after their parents
        node = nodes[index]
        if node.test == TestKind.LEAF:
            below[index] = tuple(node)
            continue
        branches = tuple(below[child] for child in node.branches)
        test, feature, low, high, yes, no, absent, _ = node
        below[index] = (int(test), feature, low, high, below[yes], below[no], below[absent], branches)
    return below[0]


@dataclass(frozen=True, slots=True)
class Tree:
    """A decision tree, which maps a feature vector to the index of the next state.

    Parameters
    ----------
    nodes
        The nodes. The first one is the root; children come after their parents.
    """

    nodes: tuple[Node, ...]
    _nested: Nested = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_nested", _nested(self.nodes))

    def __repr__(self) -> str:
        leaves = sum(node.test == TestKind.LEAF for node in self.nodes)
        return format_repr(self, f"of depth {self.depth}", format_number_of(leaves, "leaf", "leaves"))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the nodes alone, because the nested form may be deeper than Python's recursion limit."""
        return _make_tree, (self.nodes,)

    def decide(self, values: Sequence[float]) -> int:
        """Return the next state for a feature vector.

        Parameters
        ----------
        values
            One number per feature; NaN or an infinite one means absent, and a label is given by its index. Further
            values are ignored.

        Returns
        -------
        int
            Index of the next state, or STAY (-1) to keep the current one because no example was like this.

        Raises
        ------
        KindError
            If a value is missing, is no number, or is not the index of a label where the tree needs one.
        """
        node = self._nested
        try:
            while True:
                test, feature, low, high, yes, no, absent, branches = node
                if test == 0:
                    return yes  # type: ignore[no-any-return]
                x = values[feature]
                if test == 1:  # most are: no more is compared here than is needed to know that x is finite
                    if x < high:
                        node = yes if x >= -1.7976931348623157e308 else absent
                    else:
                        node = no if x <= 1.7976931348623157e308 else absent
                elif not -1.7976931348623157e308 <= x <= 1.7976931348623157e308:
                    node = yes if test == 3 else absent
                elif test == 4:
                    node = branches[int(x)]
                elif test == 3:
                    node = no
                elif low <= high:
                    node = yes if low <= x < high else no
                else:
                    node = yes if x >= low or x < high else no
        except _NO_VECTOR:  # tried only once it failed: every tick of every robot decides
            raise _explain_failure(self.nodes, values) from None

    def path(self, values: Sequence[float]) -> tuple[tuple[PathStep, ...], int]:
        """Return the tests that a feature vector passes, and the leaf it reaches.

        Parameters
        ----------
        values
            One number per feature; NaN or an infinite one means absent, and a label is given by its index. Further
            values are ignored.

        Returns
        -------
        tuple[tuple[PathStep, ...], int]
            The steps from the root, and the index of the leaf's node, or STAY (-1) if the path ends without a leaf.

        Raises
        ------
        KindError
            If a value is missing, is no number, or is not the index of a label where the tree needs one.
        """
        steps = []
        index = 0
        try:
            while index >= 0 and self.nodes[index].test != TestKind.LEAF:
                node = self.nodes[index]
                step = _step(index, node, values[node.feature])
                steps.append(step)
                index = get_child(node, step)
        except _NO_VECTOR:
            raise _explain_failure(self.nodes, values) from None
        return tuple(steps), index

    def leaves(self) -> Iterator[tuple[tuple[PathStep, ...], int]]:
        """Yield all leaves, each with the steps that lead to it.

        Yields
        ------
        tuple[tuple[PathStep, ...], int]
            The steps from the root, and the index of the leaf's node; depth first, "yes" before "no", labels in
            order.
        """
        waiting: list[tuple[int, tuple[PathStep, ...]]] = [(0, ())]  # no recursion: noise grows trees deep
        while waiting:
            index, steps = waiting.pop()
            node = self.nodes[index]
            if node.test == TestKind.LEAF:
                yield steps, index
                continue
            below = [(get_child(node, step), (*steps, step)) for step in _sides(index, node)]
            waiting.extend(reversed([each for each in below if each[0] != STAY]))

    @property
    def depth(self) -> int:
        """The number of tests on the longest path from root to leaf; 0 for a single leaf."""
        deepest = [0] * len(self.nodes)
        for index, node in enumerate(self.nodes):  # children come after their parents
            for following in (
                (node.yes, node.no, node.absent, *node.branches) if node.test != TestKind.LEAF else ()
            ):
                if following != STAY:
                    deepest[following] = deepest[index] + 1
        return max(deepest)

    def plot(
        self,
        ax: Axes | None = None,
        *,
        features: Sequence[BoundFeature] = (),
        states: Sequence[str] = (),
        vectors: Sequence[Sequence[float]] = (),
    ) -> Axes:
        """Plot the tests from left to right, with the next states at the ends.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw into. None: in a new figure.
        features
            The features of the automaton, which name and format the values. None given: they are numbered.
        states
            The names of the automaton's states. None given: they are numbered.
        vectors
            Feature vectors that stay on their sides when thresholds are rounded, such as those of the examples.

        Returns
        -------
        Axes
            The axes.
        """
        settings = {"features": features, "states": states, "vectors": vectors}
        return call_plot("tree_plot:plot_tree", self, ax, **settings)


_NO_VECTOR = (LookupError, TypeError, ValueError, OverflowError)
"""The errors that evaluating a tree raises if a value is missing or is no number."""


def _explain_failure(nodes: Sequence[Node], values: Sequence[float]) -> KindError:
    """Make the error that says which value of a feature vector a tree could not use."""
    tests = {node.feature: node for node in nodes if node.test != TestKind.LEAF}
    if isinstance(values, Mapping) or not hasattr(values, "__len__"):
        return _wrong(f"it is {values!r:.60}", "give a list of numbers")
    if len(values) <= max(tests):
        problem = f"it has {len(values)} values, and the tree asks for number {max(tests) + 1}"
        return _wrong(problem, "give one for each feature")
    for feature, node in sorted(tests.items()):
        if not isinstance(values[feature], Real):
            return _wrong(_value(feature, values), "give a number, or NaN if it is absent")
        labels = len(node.branches)
        if node.test == TestKind.LABEL and not (
            not isfinite(values[feature]) or 0 <= values[feature] < labels
        ):
            return _wrong(_value(feature, values), f"give the index of one of {labels} labels")
    return _wrong(f"it is {values!r:.60}", "give a list of numbers")


def _value(feature: int, values: Sequence[float]) -> str:
    return f"value {feature + 1} is {values[feature]!r:.60}"


def _wrong(problem: str, remedy: str) -> KindError:
    return KindError(where="feature vector", problem=problem, remedy=remedy)


def _make_tree(nodes: Sequence[Node]) -> Tree:
    """Build an unpickled tree, with the `nan` object of `math` for unused thresholds so that nodes compare equal."""
    return Tree(
        tuple(
            node._replace(
                low=nan if isnan(node.low) else node.low, high=nan if isnan(node.high) else node.high
            )
            for node in nodes
        )
    )


def get_child(node: Node, step: PathStep) -> int:
    """Return the index of the node to which a step leads, or STAY."""
    if step.side == "label":
        return node.branches[step.label]
    return {"yes": node.yes, "no": node.no, "absent": node.absent}[step.side]


def _step(index: int, node: Node, x: float) -> PathStep:
    if not -LARGEST <= x <= LARGEST:
        return PathStep(index, "yes" if node.test == TestKind.ABSENT else "absent")
    if node.test == TestKind.LABEL:
        return PathStep(index, "label", int(x))
    if node.test == TestKind.BELOW:
        inside = x < node.high
    elif node.test == TestKind.ARC:
        inside = is_in_arc(x, node.low, node.high)
    else:
        inside = False
    return PathStep(index, "yes" if inside else "no")


def _sides(index: int, node: Node) -> Iterator[PathStep]:
    if node.test == TestKind.LABEL:
        yield from (PathStep(index, "label", label) for label in range(len(node.branches)))
        if node.absent not in node.branches:
            yield PathStep(index, "absent")
        return
    yield PathStep(index, "yes")
    yield PathStep(index, "no")


def is_in_arc(x: float, low: float, high: float) -> bool:
    """Return whether x lies on the arc from `low` (included) up to `high`; if low > high it crosses the seam at 0."""
    return low <= x < high if low <= high else x >= low or x < high
