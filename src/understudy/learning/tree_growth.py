"""Growing of decision trees from arrays: checks and conversions around the kernels."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from math import nan

import numpy as np
from numpy.typing import NDArray

from understudy.errors import DefinitionError
from understudy.learning import _growth_kernels, _split_kernels
from understudy.learning.thresholds import Gap, compute_arc, compute_threshold, vote
from understudy.model.tree import STAY, Node, TestKind, Tree, make_leaf
from understudy.model.value_kinds import Categorical, Continuous, Kind, Toroidal

MOST_WEIGHT = 1_500_000
"""The largest weight of one state's examples for which the integer scores do not overflow.

An example weighs 1; if there are watched ones, they weigh 1 and press-made ones 10.
"""

LONG = 20_000
"""The number of values from which waiting for the compiler takes less time than growing the tree as plain Python."""

FORMS = {Categorical: _split_kernels.LABELS, Toroidal: _split_kernels.CIRCLE}


def grow_tree(
    values: NDArray[np.float64],
    outcomes: NDArray[np.int64],
    groups: NDArray[np.int64],
    kinds: Sequence[Kind],
    *,
    states: int,
    current: int = STAY,
    midpoints: bool = False,
    flags: Sequence[int] = (),
    silence: bool = False,
) -> Tree:
    """Grow the decision tree of feature vectors [n, F] with indices of next states [n] and groups [n].

    A group is 0 for a default, 1 for a directive or confirmation, 2 for a watched example; at least one example
    must be press-made. `current` is the index of the state itself, which wins ties (STAY: none does). If any
    example is watched, thresholds are midpoints. `flags` are the indices of the states that are told apart first.
    With `silence`, watched stays beyond all presses for a decision limit it.
    """
    count, width = values.shape
    watched = bool((groups == _split_kernels.WATCHED).any())
    weight = 10 * count if watched else count
    if weight > MOST_WEIGHT:
        raise DefinitionError(
            what="lesson",
            problem=f"one state has {count} examples",
            remedy=f"keep at most {MOST_WEIGHT // 10 if watched else MOST_WEIGHT}",
        )
    columns = np.zeros((max(width, 1), count))  # no features: one that says nothing, and no zero has a sign
    columns[:width] += values.T
    form, extent = np.zeros(len(columns), np.int64), np.ones(len(columns))
    for index, kind in enumerate(kinds):
        form[index] = FORMS.get(type(kind), _split_kernels.LINE)
        extent[index] = _extent(kind, columns[index])
    order = np.argsort(columns, axis=1).astype(np.uint32)
    apart = np.zeros(states, np.bool_)
    apart[list(flags)] = True
    quiet = current if silence else STAY
    grow = _growth_kernels.grow_nodes
    nodes, cuts = (grow if columns.size < LONG else grow.run_long)(
        columns, order, form, extent, outcomes, groups, states, quiet, watched, apart, _table(weight)
    )
    ballots = outcomes, groups, order[0]
    return Tree(_nodes(nodes, cuts, ballots, kinds, current, midpoints=midpoints or watched))


def compile_tree_kernels() -> None:
    """Compile the kernels or load them from the cache, so that no later call has to wait for this (seconds)."""
    two = np.arange(2)
    grow_tree(two.reshape(2, 1).astype(np.float64), two, two, [Continuous()], states=2)


SAME = 1e-9
"""The relative difference below which values count as equal, since rounding alone may cause it."""


def _extent(kind: Kind, column: NDArray[np.float64]) -> float:
    if isinstance(kind, Toroidal):
        return kind.period
    if isinstance(kind, Categorical):
        return float(len(kind.labels))
    lowest, highest = np.fmin.reduce(column), np.fmax.reduce(column)
    half = float(highest / 2 - lowest / 2)  # halved first: the difference may overflow
    size = float(max(abs(lowest), abs(highest))) if half > 0 else 1.0
    return half if half > SAME * size else size


def _table(weight: int) -> NDArray[np.int64]:
    return _table_of_bits(max(10, weight.bit_length()))


@cache
def _table_of_bits(bits: int) -> NDArray[np.int64]:
    """Compute c log2 c for c below 2**bits, in the kernel's fixed-point format."""
    c = np.arange(1, min(1 << bits, MOST_WEIGHT + 1), dtype=np.float64)
    table: NDArray[np.int64] = np.zeros(len(c) + 1, np.int64)
    table[1:] = np.rint(c * np.log2(c) * _split_kernels.UNIT)
    return table


def _nodes(
    nodes: NDArray[np.int64],
    cuts: NDArray[np.float64],
    ballots: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]],
    kinds: Sequence[Kind],
    current: int,
    *,
    midpoints: bool,
) -> tuple[Node, ...]:
    """Convert the kernel's rows to nodes, with thresholds placed in their gaps and leaves decided by vote."""
    rows = nodes.tolist()
    outcomes, groups, order = ballots
    children = {
        (row[_growth_kernels.PARENT], row[_growth_kernels.WHICH]): index for index, row in enumerate(rows)
    }
    built: list[Node] = []
    for index, (
        (test, feature, outcome, away, _, _, start, stop, first_default, second_default),
        gaps,
    ) in enumerate(zip(rows, cuts.tolist(), strict=True)):
        if test == TestKind.LEAF:
            if outcome == STAY:
                here = order[start:stop]
                ballot = zip(outcomes[here].tolist(), groups[here].tolist(), strict=True)
                outcome = vote(ballot, current=current)
            built.append(make_leaf(outcome))
            continue
        kind = kinds[feature]
        absent = children.get((index, away), STAY) if away >= 0 else STAY
        if isinstance(kind, Categorical) and test == TestKind.LABEL:
            branches = tuple(children.get((index, label), STAY) for label in range(len(kind.labels)))
            built.append(Node(TestKind.LABEL, feature, absent=absent, branches=branches))
            continue
        low = high = nan
        first = Gap(gaps[0], gaps[1], first_default)
        if test == TestKind.BELOW:
            high = compute_threshold(first, midpoints=midpoints)
        elif isinstance(kind, Toroidal) and test == TestKind.ARC:
            low, high = compute_arc(
                first, Gap(gaps[2], gaps[3], second_default), kind.period, midpoints=midpoints
            )
        else:
            absent = STAY  # "is it absent?" sends them to yes
        yes, no = children.get((index, 0), STAY), children.get((index, 1), STAY)
        built.append(Node(test, feature, low, high, yes, no, absent))
    return tuple(built)
