"""Kernels that search the best split of a node of a decision tree.

Scores are integers so that they are exact and never depend on the order of examples: c log2 c comes from a table
in fixed point (`UNIT` is one bit), sums of it are updated while a cut moves, and ratios are compared in steps of
1e-9.
"""

from math import floor, isnan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.jit.decorators import njit_inner

inner = njit_inner()

Ints = NDArray[np.int64]
Indices = NDArray[Any]
"""Unsigned numbers of 32 bits: compiled code need not ask whether they are negative, and half the memory is read."""
Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

UNIT = 2.0**36
STEPS = 1e9
LINE, CIRCLE, LABELS = 0, 1, 2
LEAF, BELOW, ARC, ABSENT, LABEL = 0, 1, 2, 3, 4
DEFAULT, SHOWN, WATCHED = 0, 1, 2
NOTHING = MIXED = -1
# The best split so far: what splits are compared by, highest first, and then the rest of it.
FLAGS, RATIO, GAIN, GAP, FEATURE, ABSENCE, FIRST, SECOND, HEAVY, TEST, SIDE = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10
# What a search is about: outcome, weight and group of each example; of the node, by outcome, the weight of
# its examples, how many press-made ones, and how many of these that are no defaults; which outcomes are flags; the
# table; are there watched ones; must press-made ones gain; the best.
Search = tuple[Ints, Ints, Ints, Ints, Ints, Ints, Bools, Ints, bool, bool, Ints]


@inner
def keep_if_better(
    best: Ints, gain: int, split: int, total: int, gap: int, feature: int, test: int, first: int, second: int,
    side: int, heavy: int, flags: int,
) -> None:  # fmt: skip
    """Keep a candidate split in `best` if it beats the best so far.

    Compared are in turn: how well it tells the flags apart, gain ratio, gain, width of the gap, declared order of
    features, the test for absence before others of the feature, lower cuts, and the weight of the side that absent
    values join.
    """
    ratio = int(floor(gain / split * STEPS + 0.5))  # noqa: RUF046
    if flags < best[FLAGS] or (flags == best[FLAGS] and ratio < best[RATIO]):
        return
    bits = int(floor(gain / UNIT / total * STEPS + 0.5))  # noqa: RUF046
    new = (flags, ratio, bits, gap, -feature, int(test == ABSENT), -first, -second, heavy)
    if new > (best[0], best[1], best[2], best[3], best[4], best[5], best[6], best[7], best[8]):
        for index in range(9):
            best[index] = new[index]
        best[TEST], best[SIDE] = test, side


@inner
def is_alone(counts: Ints, here: Ints, flags: Bools, flag: int) -> bool:
    """Return whether a branch has exactly the examples that lead to a flag, or exactly all others.

    `flag` is the index of the flag, or NOTHING for all flags together.
    """
    flagged = others = flagged_here = others_here = 0
    for k in range(len(counts)):
        if k == flag or (flag == NOTHING and flags[k]):
            flagged += counts[k]
            flagged_here += here[k]
        else:
            others += counts[k]
            others_here += here[k]
    if flagged == 0 or others == 0:
        return False
    return (flagged_here == flagged and others_here == 0) or (flagged_here == 0 and others_here == others)


@inner
def tell_flags_apart(
    pressed: Ints, branch_pressed: Ints, directed: Ints, branch_directed: Ints, flags: Bools
) -> int:
    """Return how well a branch separates flags from all else: 4 for all press-made examples, 3 without defaults, or 0.

    For a single one of several flags it is 2 and 1. Of the node and of the branch, by outcome: `pressed` and
    `branch_pressed` are the press-made examples, `directed` and `branch_directed` those that are no defaults.
    """
    if is_alone(pressed, branch_pressed, flags, NOTHING):
        return 4
    if is_alone(directed, branch_directed, flags, NOTHING):
        return 3
    best = 0
    for k in range(len(flags)):
        if flags[k] and best < 2 and is_alone(pressed, branch_pressed, flags, k):
            best = 2
        if flags[k] and best < 1 and is_alone(directed, branch_directed, flags, k):
            best = 1
    return best


@inner
def splits_presses(gain: int, here: int, there: int, need_gain: bool) -> bool:
    """Return whether a split separates press-made examples: some on either side, with a gain if `need_gain`."""
    if here == 0 or there == 0:
        return False
    return not need_gain or gain / UNIT / (here + there) * STEPS >= 0.5


@inner
def sum_counts(counts: Ints) -> int:
    """Return the sum of counts."""
    total = 0
    for count in counts:
        total += count
    return total


@inner
def count_outcomes(
    segment: Ints, y: Ints, weight: Ints, group: Ints, weights: Ints, presses: Ints, directed: Ints
) -> None:
    """Add a segment's examples, by outcome, to `weights`, to `presses` if press-made, and to `directed` if shown."""
    for example in segment:
        weights[y[example]] += weight[example]
        if group[example] != WATCHED:
            presses[y[example]] += 1
        if group[example] == SHOWN:
            directed[y[example]] += 1


@inner
def compute_split_gain(table: Ints, all_: Ints, part: Ints) -> int:
    """Return the sum of c log2 c over outcomes for a part of the examples and for the rest, less that for all."""
    total = 0
    for k in range(len(all_)):
        total += table[part[k]] + table[all_[k] - part[k]] - table[all_[k]]
    return total


@inner
def score_branches(
    weights: Ints,
    branch_pressed: Ints,
    branch_directed: Ints,
    feature: int,
    test: int,
    side: int,
    about: Search,
) -> None:
    """Compute the gain of a split into branches, and keep the split in `about`'s best if it beats the best so far.

    `weights`, `branch_pressed` and `branch_directed` [branches, outcomes] are the weights of the examples in each
    branch, and the numbers of press-made ones and of those that are no defaults.
    """
    _, _, _, total, pressed, directed, flags, table, watched, need_gain, best = about
    presses, branches, apart = sum_counts(pressed), 0, 0
    gain = split = table[sum_counts(total)]
    press_gain = table[presses]
    for k in range(len(total)):
        gain -= table[total[k]]
        press_gain -= table[pressed[k]]
    for branch in range(len(weights)):
        here, some = table[sum_counts(weights[branch])], sum_counts(branch_pressed[branch])
        split -= here
        gain -= here
        press_gain -= table[some]
        branches += some > 0
        apart = max(
            apart, tell_flags_apart(pressed, branch_pressed[branch], directed, branch_directed[branch], flags)
        )
        for k in range(len(total)):
            gain += table[weights[branch, k]]
            press_gain += table[branch_pressed[branch, k]]
    if not watched or splits_presses(press_gain, presses, branches - 1, need_gain):
        heavy = sum_counts(weights[side])
        keep_if_better(
            best, gain, split, sum_counts(total), int(STEPS), feature, test, 0, 0, side, heavy, apart
        )  # fmt: skip


@inner
def try_absence_split(segment: Ints, present: int, feature: int, about: Search) -> None:
    """Try the test whether a feature is absent, which holds for the segment's examples from `present` on."""
    y, weight, group, total, _, _, _, _, _, _, _ = about
    weights, branch_pressed, branch_directed = np.zeros((3, 2, len(total)), np.int64)
    count_outcomes(segment[present:], y, weight, group, weights[0], branch_pressed[0], branch_directed[0])
    count_outcomes(segment[:present], y, weight, group, weights[1], branch_pressed[1], branch_directed[1])
    score_branches(weights, branch_pressed, branch_directed, feature, ABSENT, 0, about)


@inner
def try_label_split(
    column: Floats, segment: Ints, present: int, labels: int, feature: int, about: Search
) -> None:
    """Try a split with one branch per label; absent values join each branch that has examples in turn."""
    y, weight, group, total, _, _, _, _, _, _, _ = about
    for joined in range(labels):
        weights, branch_pressed, branch_directed = np.zeros((3, labels, len(total)), np.int64)
        for position in range(present):
            label = int(column[segment[position]])
            here = segment[position : position + 1]
            count_outcomes(
                here, y, weight, group, weights[label], branch_pressed[label], branch_directed[label]
            )
        if present == len(segment) or sum_counts(weights[joined]) > 0:
            away = segment[present:]
            count_outcomes(
                away, y, weight, group, weights[joined], branch_pressed[joined], branch_directed[joined]
            )
            score_branches(weights, branch_pressed, branch_directed, feature, LABEL, joined, about)
        if present == len(segment):
            break


@inner
def find_class(example: int, y: Ints, group: Ints, has_flags: bool) -> int:
    """Return a number for the outcome of an example and, with flags, whether it is a default."""
    return int(2 * y[example] + (has_flags and group[example] == DEFAULT))


@inner
def find_cut_gaps(
    column: Floats, segment: Ints, y: Ints, group: Ints, watched: bool, has_flags: bool
) -> Ints:  # fmt: skip
    """Return the last position before each gap worth cutting between values; the gap across the seam comes last.

    If all examples are press-made, a cut between two values with one and the same outcome is never the best,
    because gain is convex there and split information concave; such gaps are left out. With flags, both values must
    also have defaults only or none, since a cut may tell flags apart but for defaults.
    """
    gaps, count, start, stop = np.empty(len(segment), np.int64), 0, 0, 0
    before = opening = MIXED
    value = column[segment[0]]
    while start < len(segment):
        outcome, following = find_class(segment[start], y, group, has_flags), value
        stop = start + 1
        while stop < len(segment):
            following = column[segment[stop]]
            if following != value:
                break
            if find_class(segment[stop], y, group, has_flags) != outcome:
                outcome = MIXED
            stop += 1
        if start == 0:
            opening = outcome
        elif watched or outcome == MIXED or outcome != before:
            gaps[count] = start - 1
            count += 1
        start, before, value = stop, outcome, following
    if watched or before == MIXED or before != opening:
        gaps[count] = len(segment) - 1
        count += 1
    return gaps[:count]


@inner
def measure_gap_width(column: Floats, segment: Ints, position: int, period: float) -> float:
    """Return the distance from the value at a position to the next one, round the circle after the last."""
    value = float(column[segment[position]])
    if position + 1 < len(segment):
        return float(column[segment[position + 1]]) - value
    return period - value + float(column[segment[0]])


@inner
def is_inner_arc(column: Floats, segment: Ints, first: int, second: int, period: float) -> bool:
    """Return whether the arc from the gap after `first` to the gap after `second` is at most half the circle."""
    start = float(column[segment[first]]) + measure_gap_width(column, segment, first, period) * 0.5
    stop = float(column[segment[second]]) + measure_gap_width(column, segment, second, period) * 0.5
    return floor((stop - start) / period * STEPS + 0.5) <= floor(STEPS * 0.5)


@inner
def try_cuts(
    column: Floats, segment: Ints, present: int, arcs: bool, extent: float, feature: int, about: Search
) -> None:
    """Try every threshold, or every arc of an angle between two gaps, with absent values on either side of it.

    A threshold is treated as an arc that starts before all values.
    """
    y, weight, group, total, pressed, directed, flags, table, watched, need_gain, best = about
    values, away = segment[:present], segment[present:]
    has_flags = False
    for flag in flags:
        has_flags |= flag
    gaps = find_cut_gaps(column, values, y, group, watched, has_flags)
    width = np.empty(len(gaps), np.int64)
    for g in range(len(gaps)):
        if arcs:
            wide = measure_gap_width(column, values, gaps[g], extent)
        else:
            wide = column[values[(gaps[g] + 1) % present]] * 0.5 - column[values[gaps[g]]] * 0.5
        width[g] = int(floor(wide / extent * STEPS + 0.5))  # noqa: RUF046
    within, inside_counts, inside_directed = np.zeros_like(total), np.zeros_like(total), np.zeros_like(total)
    n, presses, apart = sum_counts(total), sum_counts(pressed), 0
    for example in away:
        apart += weight[example]
    for side in range(2 if apart > 0 else 1):
        for first in range(len(gaps) if arcs else 1):
            within[:] = 0
            inside_counts[:] = 0
            inside_directed[:] = 0
            if side == 0:
                count_outcomes(away, y, weight, group, within, inside_counts, inside_directed)
            inside, inside_pressed = sum_counts(within), sum_counts(inside_counts)
            gained, press_gained = (
                compute_split_gain(table, total, within),
                compute_split_gain(table, pressed, inside_counts),
            )
            position = gaps[first] + 1 if arcs else 0
            for second in range(first + 1 if arcs else 0, len(gaps)):
                while position <= gaps[second]:
                    example = segment[position]
                    k, w = y[example], weight[example]
                    c, rest = within[k], total[k] - within[k]
                    gained += table[c + w] - table[c] + table[rest - w] - table[rest]
                    within[k] = c + w
                    inside += w
                    inside_directed[k] += group[example] == SHOWN
                    if group[example] != WATCHED:
                        c, rest = inside_counts[k], pressed[k] - inside_counts[k]
                        press_gained += table[c + 1] - table[c] + table[rest - 1] - table[rest]
                        inside_counts[k] = c + 1
                        inside_pressed += 1
                    position += 1
                if position == present and not arcs:
                    break  # all values are below a cut across the seam
                split = table[n] - table[inside] - table[n - inside]
                gain = gained + split
                told_apart = (
                    0 if arcs else tell_flags_apart(pressed, inside_counts, directed, inside_directed, flags)
                )
                if told_apart < best[FLAGS] or (
                    told_apart == best[FLAGS] and gain * STEPS < (best[RATIO] - 1.0) * split
                ):
                    continue
                if watched:
                    others = presses - inside_pressed
                    press_gain = press_gained + table[presses] - table[inside_pressed] - table[others]
                    if not splits_presses(press_gain, inside_pressed, others, need_gain):
                        continue
                start, heavy = gaps[first] if arcs else -1, 0
                if apart > 0:  # the weight of the side that absent values join; a tie: the lower or the inner
                    inner = not arcs or is_inner_arc(column, values, start, gaps[second], extent)
                    joined = inside - apart if side == 0 else n - inside - apart
                    heavy = 2 * joined + (inner == (side == 0))
                gap = min(width[first], width[second]) if arcs else width[second]
                test = ARC if arcs else BELOW
                keep_if_better(
                    best, gain, split, n, gap, feature, test, start, gaps[second], side, heavy, told_apart
                )  # fmt: skip


@inner
def try_plain_thresholds(
    column: Floats, segment: Ints, present: int, extent: float, feature: int, about: Search
) -> None:
    """Try every threshold as `try_cuts` does, in one pass, where all examples are press-made and no state is a flag."""
    y, _, _, total, _, _, _, table, _, _, best = about
    n, absent = sum_counts(total), len(segment) - present
    below = np.empty_like(total)
    for side in range(2 if absent > 0 else 1):
        below[:] = 0
        if side == 0:
            for example in segment[present:]:
                below[y[example]] += 1
        gained = compute_split_gain(table, total, below)
        joined = absent if side == 0 else 0
        before, opened, start, gained_before = MIXED, MIXED, 0, gained
        value = column[segment[0]]
        for position in range(present + 1):
            example = segment[min(position, present - 1)]
            following = column[example]
            if following != value or position == present:
                # The examples from `start` on have one value: the cut below them is judged now that they are known.
                if start > 0 and (opened == MIXED or opened != before):
                    inside = start + joined
                    split = table[n] - table[inside] - table[n - inside]
                    gain = gained_before + split
                    if best[FLAGS] <= 0 and gain * STEPS >= (best[RATIO] - 1.0) * split:
                        wide = value * 0.5 - column[segment[start - 1]] * 0.5
                        gap, heavy = int(floor(wide / extent * STEPS + 0.5)), 0  # noqa: RUF046
                        if absent > 0:
                            heavy = 2 * (start if side == 0 else present - start) + (side == 0)
                        keep_if_better(
                            best, gain, split, n, gap, feature, BELOW, -1, start - 1, side, heavy, 0
                        )
                if position == present:
                    break
                before, opened, start, gained_before, value = opened, y[example], position, gained, following
            k = y[example]
            if position == 0:
                opened = k
            elif k != opened:
                opened = MIXED
            count, rest = below[k], total[k] - below[k]
            gained += table[count + 1] - table[count] + table[rest - 1] - table[rest]
            below[k] = count + 1


@inner
def count_present(column: Floats, segment: Ints) -> int:
    """Return the number of a segment's examples whose value is present; absent ones come last."""
    present = len(segment)
    while present > 0 and isnan(column[segment[present - 1]]):
        present -= 1
    return present


@inner
def find_best_split(columns: Floats, order: Ints, form: Ints, extent: Floats, about: Search) -> None:
    """Write the best split of a node into the last element of `about`; its RATIO stays negative if there is none."""
    plain = not about[8]
    for flag in about[6]:
        plain &= not flag
    for feature in range(len(columns)):
        column, segment, wide = columns[feature], order[feature], extent[feature]
        present = count_present(column, segment)
        if 0 < present < len(segment):
            try_absence_split(segment, present, feature, about)
        if present == 0 or column[segment[0]] == column[segment[present - 1]]:
            continue
        if form[feature] == LABELS:
            try_label_split(column, segment, present, int(wide), feature, about)
        elif plain and form[feature] == LINE:
            try_plain_thresholds(column, segment, present, wide, feature, about)
        else:
            try_cuts(column, segment, present, form[feature] == CIRCLE, wide, feature, about)
