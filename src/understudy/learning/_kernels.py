"""Growing a decision tree from arrays: the searching and the splitting, nothing of names or errors.

Scores are integers so that they are exact and never depend on the order of examples: c log2 c comes from a table
in fixed point (`UNIT` a bit), sums of it are updated while a cut slides, and ratios are compared in steps of 1e-9.

`order` [F, n] lists the examples by rising value of each feature, absent ones last; every node of the tree is the
same range start:stop of each row, and splitting reorders the rows within it, keeping them sorted.
"""

from math import floor, isnan

import numpy as np
from numba import njit
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

UNIT = 2.0**36
STEPS = 1e9
LINE, CIRCLE, LABELS = 0, 1, 2
LEAF, BELOW, ARC, ABSENT, LABEL = 0, 1, 2, 3, 4
DEFAULT, SHOWN, WATCHED = 0, 1, 2
NOTHING = -1
RATIO, GAIN, GAP, FEATURE, TEST, FIRST, SECOND, SIDE, HEAVY = 0, 1, 2, 3, 4, 5, 6, 7, 8  # of the best split
MIXED = -1

# Columns of a node. SORT and the next say of each end of a cut: 1 the default is above it, -1 below, 0 neither.
KIND, OF, YES, NO, AWAY, BRANCH, START, STOP, SORT = 0, 1, 2, 3, 4, 5, 6, 7, 8

Examples = tuple[Ints, Ints, Ints]  # outcome, weight and group of each
Counts = tuple[Ints, Ints]  # of a node, by outcome: weights of all its examples, number of press-made ones
Rules = tuple[
    Ints, bool, bool
]  # the table of c log2 c; are there watched examples; must a split gain on the others


@njit(cache=True)
def consider(
    best: Ints, gain: int, split: int, total: int, gap: int, feature: int, test: int, first: int, second: int,
    side: int, heavy: int,
) -> None:  # fmt: skip
    """Keep a candidate if it beats the best so far: ratio, gain, gap, declared order, lowest cut, heavier side.

    Of one feature, "is it absent?" comes before its other questions.
    """
    ratio = int(floor(gain / split * STEPS + 0.5))
    if ratio < best[RATIO]:
        return
    bits = int(floor(gain / UNIT / total * STEPS + 0.5))
    new = (ratio, bits, gap, -feature, int(test == ABSENT), -first, -second, heavy)
    old = (
        best[RATIO], best[GAIN], best[GAP], -best[FEATURE], int(best[TEST] == ABSENT), -best[FIRST], -best[SECOND],
        best[HEAVY],
    )  # fmt: skip
    if new > old:
        best[RATIO], best[GAIN], best[GAP], best[FEATURE], best[TEST] = ratio, bits, gap, feature, test
        best[FIRST], best[SECOND], best[SIDE], best[HEAVY] = first, second, side, heavy


@njit(cache=True)
def tells_apart(gain: int, here: int, there: int, need_gain: bool) -> bool:
    """Whether a split tells press-made examples apart: with gain on them, or at least some on either side."""
    if here == 0 or there == 0:
        return False
    return not need_gain or gain / UNIT / (here + there) * STEPS >= 0.5


@njit(cache=True)
def added(counts: Ints) -> int:
    """The sum of counts."""
    total = 0
    for count in counts:
        total += count
    return total


@njit(cache=True)
def tally(segment: Ints, examples: Examples, weights: Ints, presses: Ints) -> None:
    """Add a segment's examples to counts by outcome."""
    y, weight, group = examples
    for example in segment:
        weights[y[example]] += weight[example]
        if group[example] != WATCHED:
            presses[y[example]] += 1


@njit(cache=True)
def twice(table: Ints, all_: Ints, part: Ints) -> int:
    """The sum of c log2 c over outcomes, for a part of the examples and for the rest, less that for all."""
    total = 0
    for k in range(len(all_)):
        total += table[part[k]] + table[all_[k] - part[k]] - table[all_[k]]
    return total


@njit(cache=True)
def consider_branches(
    weights: Ints, shown: Ints, feature: int, test: int, side: int, counts: Counts, rules: Rules, best: Ints
) -> None:
    """Consider a split into several branches, given weights and numbers of press-made examples by outcome."""
    total, pressed = counts
    table, watched, need_gain = rules
    presses, branches = added(pressed), 0
    gain = split = table[added(total)]
    press_gain = table[presses]
    for k in range(len(total)):
        gain -= table[total[k]]
        press_gain -= table[pressed[k]]
    for branch in range(len(weights)):
        here, some = table[added(weights[branch])], added(shown[branch])
        split -= here
        gain -= here
        press_gain -= table[some]
        branches += some > 0
        for k in range(len(total)):
            gain += table[weights[branch, k]]
            press_gain += table[shown[branch, k]]
    if not watched or tells_apart(press_gain, presses, branches - 1, need_gain):
        heavy = added(weights[side])
        consider(best, gain, split, added(total), int(STEPS), feature, test, 0, 0, side, heavy)


@njit(cache=True)
def search_absence(
    segment: Ints, present: int, feature: int, examples: Examples, counts: Counts, rules: Rules, best: Ints
) -> None:
    """Try "is it absent?": the examples from `present` on are."""
    weights, shown = np.zeros((2, len(counts[0])), np.int64), np.zeros((2, len(counts[0])), np.int64)
    tally(segment[present:], examples, weights[0], shown[0])
    tally(segment[:present], examples, weights[1], shown[1])
    consider_branches(weights, shown, feature, ABSENT, 0, counts, rules, best)


@njit(cache=True)
def search_labels(
    column: Floats, segment: Ints, present: int, labels: int, feature: int, examples: Examples, counts: Counts,
    rules: Rules, best: Ints,
) -> None:  # fmt: skip
    """Try a branch for each label, absent values joining each of those shown here in turn."""
    weights, shown = (
        np.empty((labels, len(counts[0])), np.int64),
        np.empty((labels, len(counts[0])), np.int64),
    )
    for joined in range(labels):
        weights[:] = 0
        shown[:] = 0
        for position in range(present):
            label = int(column[segment[position]])
            tally(segment[position : position + 1], examples, weights[label], shown[label])
        if added(weights[joined]) > 0:
            tally(segment[present:], examples, weights[joined], shown[joined])
            consider_branches(weights, shown, feature, LABEL, joined, counts, rules, best)
        if present == len(segment):
            break


@njit(cache=True)
def gaps_of(column: Floats, segment: Ints, y: Ints, watched: bool) -> Ints:
    """The last position before each gap worth cutting between values; the gap across the seam comes last.

    Where all is press-made, a cut between two values that lead to one and the same outcome is always beaten by
    one beside it (gain is convex there and split information concave), so it is not worth scoring.
    """
    gaps, kept, start, stop = np.empty(len(segment), np.int64), 0, 0, 0
    before = opening = MIXED
    value = column[segment[0]]
    while start < len(segment):
        outcome, following = y[segment[start]], value
        stop = start + 1
        while stop < len(segment):
            following = column[segment[stop]]
            if following != value:
                break
            if y[segment[stop]] != outcome:
                outcome = MIXED
            stop += 1
        if start == 0:
            opening = outcome
        elif watched or outcome == MIXED or outcome != before:
            gaps[kept] = start - 1
            kept += 1
        start, before, value = stop, outcome, following
    if watched or before == MIXED or before != opening:
        gaps[kept] = len(segment) - 1
        kept += 1
    return gaps[:kept]


@njit(cache=True)
def gap_width(column: Floats, segment: Ints, position: int, period: float) -> float:
    """How far it is from the value at a position to the next one round the circle."""
    value = column[segment[position]]
    if position + 1 < len(segment):
        return column[segment[position + 1]] - value
    return period - value + column[segment[0]]


@njit(cache=True)
def is_inner(column: Floats, segment: Ints, first: int, second: int, period: float) -> bool:
    """Whether the arc from the gap after `first` to the gap after `second`, middle to middle, is the narrower."""
    start = column[segment[first]] + gap_width(column, segment, first, period) * 0.5
    stop = column[segment[second]] + gap_width(column, segment, second, period) * 0.5
    return floor((stop - start) / period * STEPS + 0.5) <= floor(STEPS * 0.5)


@njit(cache=True)
def search_cuts(
    column: Floats, segment: Ints, present: int, test: int, extent: float, feature: int, examples: Examples,
    counts: Counts, rules: Rules, best: Ints,
) -> None:  # fmt: skip
    """Try every threshold, or every arc between two gaps; absent values on either side of it.

    What lies below a threshold is what lies within an arc that starts before all values.
    """
    y, weight, group = examples
    total, pressed = counts
    table, watched, need_gain = rules
    values, away = segment[:present], segment[present:]
    arcs = test == ARC
    gaps = gaps_of(column, values, y, watched)
    if not arcs and len(gaps) > 0 and gaps[-1] == present - 1:
        gaps = gaps[:-1]
    width = np.empty(len(gaps), np.int64)
    for g in range(len(gaps)):
        lower = column[segment[gaps[g]]]
        wide = (
            gap_width(column, values, gaps[g], extent)
            if arcs
            else column[segment[gaps[g] + 1]] * 0.5 - lower * 0.5
        )
        width[g] = int(floor(wide / extent * STEPS + 0.5))
    within, shown = np.zeros_like(total), np.zeros_like(total)
    n, presses = added(total), added(pressed)
    for side in range(2 if len(away) > 0 else 1):
        for first in range(len(gaps) if arcs else 1):
            within[:] = 0
            shown[:] = 0
            if side == 0:
                tally(away, examples, within, shown)
            inside, inside_pressed = added(within), added(shown)
            with_away = inside
            gained, press_gained = twice(table, total, within), twice(table, pressed, shown)
            position = gaps[first] + 1 if arcs else 0
            for second in range(first + 1 if arcs else 0, len(gaps)):
                while position <= gaps[second]:
                    example = segment[position]
                    k, w = y[example], weight[example]
                    c, rest = within[k], total[k] - within[k]
                    gained += table[c + w] - table[c] + table[rest - w] - table[rest]
                    within[k] = c + w
                    inside += w
                    if watched and group[example] != WATCHED:
                        c, rest = shown[k], pressed[k] - shown[k]
                        press_gained += table[c + 1] - table[c] + table[rest - 1] - table[rest]
                        shown[k] = c + 1
                        inside_pressed += 1
                    position += 1
                split = table[n] - table[inside] - table[n - inside]
                gain = gained + split
                if gain * STEPS < (best[RATIO] - 1.0) * split:
                    continue
                if watched:
                    others = presses - inside_pressed
                    press_gain = press_gained + table[presses] - table[inside_pressed] - table[others]
                    if not tells_apart(press_gain, inside_pressed, others, need_gain):
                        continue
                gap, heavy = width[second], 0
                if len(away) > 0:  # weight of the side that absent values join; a tie: the lower or the inner
                    plain = inside - with_away
                    joined = plain
                    if side == 1:
                        joined = n - plain
                        for example in away:
                            joined -= weight[example]
                    inner = is_inner(column, values, gaps[first], gaps[second], extent) if arcs else True
                    heavy = 2 * joined + (inner == (side == 0))
                if arcs:
                    gap = min(gap, width[first])
                    consider(best, gain, split, n, gap, feature, test, gaps[first], gaps[second], side, heavy)
                else:
                    consider(best, gain, split, n, gap, feature, test, gaps[second], 0, side, heavy)


@njit(cache=True)
def is_default(column: Floats, segment: Ints, value: float, group: Ints) -> bool:
    """Whether all examples in the node that have this value are defaults."""
    for example in segment:
        if column[example] == value and group[example] != DEFAULT:
            return False
    return True


@njit(cache=True)
def how_many_present(column: Floats, segment: Ints) -> int:
    """How many of a segment's examples have the reading; those without come last."""
    low, high = 0, len(segment)
    if not isnan(column[segment[high - 1]]):
        return high
    while low < high:
        middle = (low + high) // 2
        if isnan(column[segment[middle]]):
            high = middle
        else:
            low = middle + 1
    return low


@njit(cache=True)
def search(
    columns: Floats, order: Ints, start: int, stop: int, form: Ints, extent: Floats, examples: Examples,
    counts: Counts, rules: Rules, best: Ints,
) -> None:  # fmt: skip
    """The best split of a node into `best`; its RATIO stays negative where nothing can be told apart."""
    best[:] = NOTHING
    for feature in range(len(columns)):
        column, segment = columns[feature], order[feature, start:stop]
        present = how_many_present(column, segment)
        if 0 < present < stop - start:
            search_absence(segment, present, feature, examples, counts, rules, best)
        if present == 0 or column[segment[0]] == column[segment[present - 1]]:
            continue
        if form[feature] == LABELS:
            labels = int(extent[feature])
            search_labels(column, segment, present, labels, feature, examples, counts, rules, best)
        else:
            test = BELOW if form[feature] == LINE else ARC
            search_cuts(
                column, segment, present, test, extent[feature], feature, examples, counts, rules, best
            )


@njit(cache=True)
def part(
    order: Ints, start: int, stop: int, side: Ints, sizes: Ints, kept: Ints, sorted_already: int
) -> None:
    """Reorder every row's start:stop so that the children follow one another, each still sorted."""
    offsets = np.empty(len(sizes), np.int64)
    for feature in range(len(order)):
        if feature == sorted_already:
            continue
        at = 0
        for child in range(len(sizes)):
            offsets[child] = at
            at += sizes[child]
        row = order[feature]
        for position in range(start, stop):
            example = row[position]
            child = side[example]
            kept[offsets[child]] = example
            offsets[child] += 1
        for position in range(start, stop):
            row[position] = kept[position - start]


@njit(cache=True)
def send(
    column: Floats, segment: Ints, present: int, best: Ints, flipped: bool, side: Ints, group: Ints,
    sizes: Ints, presses: Ints,
) -> None:  # fmt: skip
    """Say of each example of a node which child it goes to, and count the children's examples."""
    test, first, second, absent = best[TEST], best[FIRST], best[SECOND], best[SIDE]
    for position in range(len(segment)):
        example = segment[position]
        if position >= present:
            child = absent
        elif test == BELOW:
            child = int(position > first)
        elif test == ARC:
            child = int(position <= first or position > second)
        else:
            child = 1 if test == ABSENT else int(column[example])
        if flipped:
            child = 1 - child
        side[example] = child
        sizes[child] += 1
        presses[child] += group[example] != WATCHED


@njit(cache=True)
def grow(
    columns: Floats, order: Ints, form: Ints, extent: Floats, y: Ints, group: Ints, outcomes: int, watched: bool,
    table: Ints,
) -> tuple[Ints, Floats, Ints]:  # fmt: skip
    """A tree: nodes, the values on either side of each of their cuts, and the children of multiway nodes.

    `form` says what each feature is, `extent` its range, period or number of labels. Nodes are numbered depth
    first. At the end, a leaf's examples are those from START to STOP of order[0].
    """
    n = len(y)
    nodes = np.full((2 * n, 10), NOTHING, np.int64)
    cuts = np.full((2 * n, 4), np.nan)
    branches, branched = np.empty(16, np.int64), 0
    waiting = np.empty((n + 1, 4), np.int64)  # start, stop, parent, which child of it
    waiting[0, 0], waiting[0, 1], waiting[0, 2], waiting[0, 3] = 0, n, NOTHING, 0
    depth, count = 1, 0
    weight = np.ones(n, np.int64)
    if watched:
        weight[group != WATCHED] = 10
    side, kept = np.empty(n, np.int64), np.empty(n, np.int64)
    total, pressed = np.empty(outcomes, np.int64), np.empty(outcomes, np.int64)
    best, examples = np.empty(9, np.int64), (y, weight, group)
    while depth > 0:
        depth -= 1
        start, stop, parent, which = (
            waiting[depth, 0],
            waiting[depth, 1],
            waiting[depth, 2],
            waiting[depth, 3],
        )
        node, count = count, count + 1
        if parent >= 0:
            if nodes[parent, KIND] == LABEL:
                branches[nodes[parent, BRANCH] + which] = node
            else:
                nodes[parent, YES + which] = node
            if nodes[parent, AWAY] == -2 - which:  # absent values were sent to this child
                nodes[parent, AWAY] = node
        nodes[node, START], nodes[node, STOP] = start, stop
        total[:] = 0
        pressed[:] = 0
        tally(order[0, start:stop], examples, total, pressed)
        best[:] = NOTHING
        presses_here = added(pressed)
        for k in range(outcomes):
            if pressed[k] == presses_here:
                nodes[node, YES] = k
        if nodes[node, YES] == NOTHING:
            for attempt in range(2 if watched else 1):
                rules = (table, watched, attempt == 0)
                if best[RATIO] < 0:
                    search(columns, order, start, stop, form, extent, examples, (total, pressed), rules, best)
        if best[RATIO] < 0:
            nodes[node, KIND] = LEAF
            continue
        feature, test = best[FEATURE], best[TEST]
        column, segment = columns[feature], order[feature, start:stop]
        present = how_many_present(column, segment)
        first, second, children, flipped = best[FIRST], best[SECOND], 2, False
        if test == ARC and not is_inner(column, segment[:present], first, second, extent[feature]):
            first, second, flipped = second, first, True
        for end in range(2 if test == ARC else int(test == BELOW)):
            position = second if end else first
            after = (position + 1) % present
            lower, upper = column[segment[position]], column[segment[after]]
            cuts[node, 2 * end], cuts[node, 2 * end + 1] = lower, upper
            nodes[node, SORT + end] = int(is_default(column, segment, upper, group)) - int(
                is_default(column, segment, lower, group)
            )
        if test == LABEL:
            children = int(extent[feature])
            if branched + children > len(branches):
                longer = np.empty(2 * len(branches) + children, np.int64)
                for branch in range(branched):
                    longer[branch] = branches[branch]
                branches = longer
            nodes[node, BRANCH] = branched
            branches[branched : branched + children] = NOTHING
            branched += children
        nodes[node, KIND], nodes[node, OF] = test, feature
        sizes, presses = np.zeros(children, np.int64), np.zeros(children, np.int64)
        send(column, segment, present, best, flipped, side, group, sizes, presses)
        if present < stop - start and test != ABSENT:
            nodes[node, AWAY] = -2 - side[segment[present]]
        part(
            order,
            start,
            stop,
            side,
            sizes,
            kept,
            feature if test == BELOW and present == stop - start else -1,
        )
        at = stop
        for child in range(children - 1, -1, -1):
            if presses[child] > 0:
                waiting[depth, 0], waiting[depth, 1] = at - sizes[child], at
                waiting[depth, 2], waiting[depth, 3] = node, child
                depth += 1
            elif nodes[node, AWAY] == -2 - child:
                nodes[node, AWAY] = NOTHING
            at -= sizes[child]
    return nodes[:count], cuts[:count], branches[:branched]
