"""Kernels that grow a decision tree from arrays: each node is split in the best way, and its examples sorted.

`order` [F, n] lists the examples by rising value of each feature, absent ones last. Every node of the tree is the
same range start:stop of each row; splitting a node reorders the rows within its range and keeps them sorted.
"""

import numpy as np

from understudy.jit.decorators import njit_entry, njit_inner
from understudy.learning._split_kernels import (
    ABSENT,
    ARC,
    BELOW,
    DEFAULT,
    FEATURE,
    FIRST,
    LABEL,
    LEAF,
    NOTHING,
    RATIO,
    SECOND,
    SIDE,
    TEST,
    WATCHED,
    Bools,
    Floats,
    Indices,
    Ints,
    count_outcomes,
    count_present,
    find_best_split,
    is_inner_arc,
    sum_counts,
)

inner = njit_inner()

# Columns of a node. AWAY: the child that absent values join. DEFAULT_SIDE and the next: of either end of a cut,
# whether the default is above it (1), below it (-1), or neither.
KIND, OF, OUTCOME, AWAY, PARENT, WHICH, START, STOP, DEFAULT_SIDE = 0, 1, 2, 3, 4, 5, 6, 7, 8
ENOUGH_STAYS = 4
"""How many watched stays limit a decision, if they lie beyond all presses for it."""


@inner
def is_default_value(column: Floats, segment: Ints, value: float, group: Ints) -> bool:
    """Return whether all examples of the node with this value are defaults."""
    others = 0
    for example in segment:
        others += column[example] == value and group[example] != DEFAULT
    return others == 0


@inner
def partition_rows(order: Indices, side: Ints, sizes: Ints, buffer: Indices) -> None:
    """Reorder the examples in every row by child, keeping each child's examples sorted."""
    if len(sizes) == 2:
        for row in order:
            first = second = 0
            for example in row:  # without a branch, which would be guessed wrong for every other example
                child = side[example]
                row[first] = example
                buffer[second] = example
                first += 1 - child
                second += child
            for position in range(second):
                row[first + position] = buffer[position]
        return
    offsets = np.empty(len(sizes), np.int64)
    for row in order:
        at = 0
        for child in range(len(sizes)):
            offsets[child] = at
            at += sizes[child]
        for example in row:
            child = side[example]
            buffer[offsets[child]] = example
            offsets[child] += 1
        for position in range(len(row)):
            row[position] = buffer[position]


@inner
def assign_to_children(
    column: Floats, segment: Ints, group: Ints, test: int, first: int, second: int, absent: int, flip: bool,
    side: Ints,
) -> int:  # fmt: skip
    """Write the child of each example to `side`; return the child of absent values.

    It is NOTHING if no press-made example has the value absent, because watched examples never decide.
    """
    present, presses = count_present(column, segment), 0
    absent = 1 - absent if flip else absent
    for position in range(len(segment)):
        if position >= present:
            child = absent
            presses += group[segment[position]] != WATCHED
        elif test == LABEL:
            child = int(column[segment[position]])
        elif test == ABSENT:
            child = 1
        else:
            child = int((first < position <= second) == flip)
        side[segment[position]] = child
    return absent if presses > 0 else NOTHING


@inner
def count_stays(column: Floats, segment: Ints, y: Ints, group: Ints, quiet: int, top: bool) -> int:
    """Count the examples with the lowest values, or at the `top` the highest, that only watched stays have."""
    present, stays = count_present(column, segment), 0
    while stays < present:
        example = segment[present - 1 - stays] if top else segment[stays]
        if group[example] != WATCHED or y[example] != quiet:
            break
        stays += 1
    while 0 < stays < present:
        last, following = (present - stays, present - stays - 1) if top else (stays - 1, stays)
        if column[segment[last]] != column[segment[following]]:
            break
        stays -= 1
    return stays if stays < present else 0


@inner
def find_quiet_side(
    columns: Floats, here: Ints, y: Ints, group: Ints, quiet: int, tested: Bools, best: Ints
) -> None:
    """Write the threshold that cuts most watched stays, and nothing else, off a node into `best`, if it cuts enough."""
    most = ENOUGH_STAYS - 1
    for feature in range(len(columns)):
        for side in range(2 if tested[feature] else 0):
            column, segment = columns[feature], here[feature]
            stays = count_stays(column, segment, y, group, quiet, side == 1)
            if stays > most:
                most = stays
                last = stays - 1 if side == 0 else count_present(column, segment) - stays - 1
                best[RATIO], best[FEATURE], best[TEST] = 0, -feature, BELOW
                best[FIRST], best[SECOND], best[SIDE] = 1, -last, 1 - side


@njit_entry()
def grow_nodes(
    columns: Floats, order: Indices, form: Ints, extent: Floats, y: Ints, group: Ints, outcomes: int, quiet: int,
    watched: bool, flags: Bools, table: Ints,
) -> tuple[Ints, Floats]:  # fmt: skip
    """Grow a tree; return its nodes, and the values on either side of both ends of their cuts.

    `form` is LINE, CIRCLE or LABELS for each feature; `extent` its range, period or number of labels. `quiet` is the
    outcome of watched examples that limit decisions (NOTHING: none do), `flags` are the outcomes that are told apart
    first. Nodes are numbered depth first. A leaf's examples are those from START to STOP of order[0] when this returns.
    """
    n = len(y)
    nodes, cuts = np.full((2 * n, 10), NOTHING, np.int64), np.full((2 * n, 4), np.nan)
    waiting = np.empty((n + 1, 4), np.int64)  # start, stop, parent, which child of it
    waiting[0, 0], waiting[0, 1], waiting[0, 2], waiting[0, 3] = 0, n, NOTHING, NOTHING
    depth, count = 1, 0
    weight = np.ones(n, np.int64)
    for example in range(n):
        if watched and group[example] != WATCHED:
            weight[example] = 10
    side, buffer = np.empty(n, np.int64), np.empty(n, np.uint32)
    total, pressed, directed = np.empty((3, outcomes), np.int64)
    best, tested = np.empty(11, np.int64), np.zeros(len(columns), np.bool_)
    while depth > 0:
        depth -= 1
        start, stop = waiting[depth, 0], waiting[depth, 1]
        node, count, here = count, count + 1, order[:, start:stop]
        nodes[node, PARENT], nodes[node, WHICH] = waiting[depth, 2], waiting[depth, 3]
        nodes[node, START], nodes[node, STOP] = start, stop
        total[:] = 0
        pressed[:] = 0
        directed[:] = 0
        count_outcomes(here[0], y, weight, group, total, pressed, directed)
        presses = sum_counts(pressed)
        for k in range(outcomes):
            if pressed[k] == presses:
                nodes[node, OUTCOME] = k
        if presses == 0:  # it is beyond the limit that silence has set
            nodes[node, OUTCOME] = quiet
        best[:] = NOTHING
        for attempt in range(2 if watched else 1):
            if nodes[node, OUTCOME] == NOTHING and best[RATIO] < 0:
                about = (
                    y,
                    weight,
                    group,
                    total,
                    pressed,
                    directed,
                    flags,
                    table,
                    watched,
                    attempt == 0,
                    best,
                )
                find_best_split(columns, here, form, extent, about)
        decided = nodes[node, OUTCOME]
        if watched and quiet != NOTHING and decided not in (NOTHING, quiet) and not flags[decided]:
            tested[:] = False
            above = nodes[node, PARENT]
            while above != NOTHING:
                tested[nodes[above, OF]] |= nodes[above, KIND] == BELOW
                above = nodes[above, PARENT]
            find_quiet_side(columns, here, y, group, quiet, tested, best)
        if best[RATIO] < 0:
            nodes[node, KIND] = LEAF
            continue
        feature, test, first, second = -best[FEATURE], best[TEST], -best[FIRST], -best[SECOND]
        column, segment, children = columns[feature], here[feature], 2
        present = count_present(column, segment)
        values = segment[:present]
        flip = test == ARC and not is_inner_arc(column, values, first, second, extent[feature])
        if test in (BELOW, ARC):
            for end in range(2):
                position = second if (end == 1) != (flip or test == BELOW) else first  # -1: before all values
                lower, upper = column[values[position % present]], column[values[(position + 1) % present]]
                cuts[node, 2 * end], cuts[node, 2 * end + 1] = lower, upper
                nodes[node, DEFAULT_SIDE + end] = is_default_value(column, segment, upper, group)
                nodes[node, DEFAULT_SIDE + end] -= is_default_value(column, segment, lower, group)
        elif test == LABEL:
            children = int(extent[feature])
        nodes[node, KIND], nodes[node, OF] = test, feature
        nodes[node, AWAY] = assign_to_children(
            column, segment, group, test, first, second, best[SIDE], flip, side
        )
        sizes, presses_of = np.zeros(children, np.int64), np.zeros(children, np.int64)
        for example in here[0]:
            sizes[side[example]] += 1
            presses_of[side[example]] += group[example] != WATCHED
        partition_rows(here, side, sizes, buffer)
        at = stop
        for child in range(children - 1, -1, -1):
            if presses_of[child] > 0 or (decided != NOTHING and sizes[child] > 0):
                waiting[depth, 0], waiting[depth, 1] = at - sizes[child], at
                waiting[depth, 2], waiting[depth, 3] = node, child
                depth += 1
            at -= sizes[child]
    return nodes[:count], cuts[:count]
