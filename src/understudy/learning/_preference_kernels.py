"""Kernels of preference among the tests of a tree that separate as well as each other.

A test that tells flags apart is preferred, and one whose feature alone separates the next states in few pieces.
"""

from math import isnan

import numpy as np

from understudy.jit.decorators import njit_inner
from understudy.learning._array_kernels import CIRCLE, LABELS, NOTHING, WATCHED, Bools, Floats, Ints

inner = njit_inner()

SEVERAL = -2


@inner
def is_flags_alone(counts: Ints, here: Ints, flags: Bools) -> bool:
    """Return whether a branch has exactly those examples that lead to flags, or exactly all others."""
    flagged = others = flagged_here = others_here = 0
    for k in range(len(counts)):
        if flags[k]:
            flagged += counts[k]
            flagged_here += here[k]
        else:
            others += counts[k]
            others_here += here[k]
    if flagged == 0 or others == 0:
        return False
    return (flagged_here == flagged and others_here == 0) or (flagged_here == 0 and others_here == others)


@inner
def tell_flags_apart(pressed: Ints, shown: Ints, told: Ints, said: Ints, flags: Bools) -> int:
    """Return how well a branch tells flags from all else: 2 for all press-made examples, 1 without defaults, or 0.

    Of the node and of the branch, by outcome: `pressed` and `shown` are the press-made examples, `told` and `said`
    those that are no defaults.
    """
    if is_flags_alone(pressed, shown, flags):
        return 2
    return int(is_flags_alone(told, said, flags))


@inner
def count_pieces(column: Floats, segment: Ints, y: Ints, group: Ints, form: int, flags: Bools) -> int:
    """Return in how many pieces of one outcome each a feature alone separates the press-made examples.

    Those that lead to flags are left out. Along a line or circle, neighboring values of one outcome are one piece. A
    value, a label or absence that has several outcomes counts once for each.
    """
    pieces, before, opening, position = 0, NOTHING, NOTHING, 0
    there = np.zeros(len(flags), np.bool_)
    while position < len(segment):
        value, count, last = column[segment[position]], 0, NOTHING
        there[:] = False
        away = isnan(value)
        if away and form == CIRCLE and pieces > 1 and before == opening and before >= 0:
            pieces -= 1  # the seam is no boundary
            opening = SEVERAL
        while position < len(segment) and (away or column[segment[position]] == value):
            outcome = y[segment[position]]
            if group[segment[position]] != WATCHED and not flags[outcome] and not there[outcome]:
                there[outcome] = True
                count, last = count + 1, outcome
            position += 1
        if count == 0:
            continue
        if away or form == LABELS or count > 1:
            pieces += count
            before = SEVERAL
        else:
            pieces += last != before
            before = last
        opening = before if opening == NOTHING else opening
    if form == CIRCLE and pieces > 1 and before == opening and before >= 0:
        pieces -= 1
    return pieces
