"""Whether counts differ by chance alone, and which of many comparisons remain."""

from __future__ import annotations

from collections.abc import Sequence
from math import comb


def shares_differ(first: Sequence[bool], second: Sequence[bool]) -> float:
    """Two-sided p that two groups have one share (Fisher's exact test: the tables that are no likelier)."""
    n, m = len(first), len(second)
    having = sum(first) + sum(second)
    ways = [comb(n, k) * comb(m, having - k) for k in range(having + 1)]
    return sum(way for way in ways if way <= ways[sum(first)]) / sum(ways)


def pairs_differ(first: Sequence[bool], second: Sequence[bool]) -> float:
    """Two-sided p that pairs differ to either side alike (McNemar's test, exact)."""
    won = sum(now and not before for before, now in zip(first, second, strict=True))
    lost = sum(before and not now for before, now in zip(first, second, strict=True))
    as_rare = sum(comb(won + lost, k) for k in range(min(won, lost) + 1))
    return min(1.0, 2.0 * as_rare / (1 << (won + lost)))


def remaining(chances: Sequence[float], level: float = 0.05) -> list[bool]:
    """Which of these p remain where all of them together shall mislead in 5 % at most (Holm 1979)."""
    remain = [False] * len(chances)
    for passed, k in enumerate(sorted(range(len(chances)), key=lambda k: chances[k])):
        if chances[k] > level / (len(chances) - passed):
            break
        remain[k] = True
    return remain
