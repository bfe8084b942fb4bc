"""Confidence intervals."""

from __future__ import annotations

from math import sqrt

Z95 = 1.959964


def interval_of_share(count: int, of: int) -> tuple[float, float]:
    """Compute the 95 % score interval of the share `count` / `of` (Wilson 1927, without continuity correction)."""
    if of == 0:
        return 0.0, 1.0
    share, square = count / of, Z95 * Z95 / of
    middle = (share + square / 2) / (1 + square)
    half = Z95 * sqrt(share * (1 - share) / of + square / (4 * of)) / (1 + square)
    return max(0.0, middle - half), min(1.0, middle + half)
