"""Sectors of directions around a robot: prepared for measuring without trigonometry, and summaries of beams.

The summaries are plain Python functions, which kernels compile and which the scans of real robots use, too.
"""

from __future__ import annotations

from math import nan, pi, sqrt, tau
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.sim.kernels.angles import compute_cosine_and_sine

BEAM, NARROW, WIDE, FULL = 0, 1, 2, 3
"""The spans of sectors: one direction; less than half a circle; half a circle or more; a full circle."""

SECTOR = np.dtype(
    [
        ("from_x", "f8"),  # unit vectors of both edges in the robot frame: x forward, y left
        ("from_y", "f8"),
        ("to_x", "f8"),
        ("to_y", "f8"),
        ("span", "i4"),  # BEAM, NARROW, WIDE or FULL
    ],
    align=True,
)

_SAME = 1e-9
"""The angle (rad) below which two directions count as equal, so that 360 degrees are a full circle."""


def make_sector(from_rad: float, to_rad: float) -> np.void:
    """Make the SECTOR counter-clockwise from one angle (rad, robot frame) to another, both edges included.

    It is a beam if both are one direction, unless `to_rad` is a full circle or more ahead of `from_rad`.
    """
    turn = (to_rad - from_rad) % tau
    if to_rad - from_rad >= tau - _SAME:
        span = FULL
    elif turn <= _SAME or turn >= tau - _SAME:
        span = BEAM
    else:
        span = NARROW if turn < pi - _SAME else WIDE
    rows: NDArray[Any] = np.zeros(1, SECTOR)
    rows[0] = *compute_cosine_and_sine(from_rad), *compute_cosine_and_sine(to_rad), span
    row: np.void = rows[0]
    return row


def find_nearest_beam(far: Any, first: int, count: int, beams: int) -> int:
    """Find which of `count` beams from `first` on, modulo `beams`, has the shortest distance in `far`.

    Return -1 if all are NaN, and the first of equal distances.
    """
    best = -1
    for k in range(count):
        beam = (first + k) % beams
        if far[beam] == far[beam] and (best < 0 or far[beam] < far[best]):
            best = beam
    return best


def measure_widest_opening(
    far: Any, first: int, count: int, beams: int, spacing: float, rim: float, clear: float
) -> float:
    """Return the width (m) of the widest opening in a sector: neighboring beams that all reach at least `clear`.

    The width is the distance between the returns on both sides of the opening. If the sector ends there, or the beam
    beside it has no reading, the opening ends on its own outermost beam, at `clear`. The beams are `count` from
    `first` on, modulo `beams`, and `spacing` (rad) apart; `far` and `clear` (m) are from the rim, which is `rim` (m)
    from the sensor. The result is 0 if no beam reaches that far, and the sum of both distances for half a circle or
    more.
    """
    # Between the last beam and the first there may be a gap, or they may be beside each other.
    ring = count == beams and abs(spacing * beams - tau) < spacing / 2.0
    start = 0
    while ring and start < count and far[(first + start) % beams] >= clear:
        start += 1
    if ring and start == count:
        return 2.0 * (rim + clear)
    widest, opened = 0.0, -1
    for k in range(start, start + count + 1):
        there = ring or k < start + count
        distance = far[(first + k) % beams] if there else nan
        if k < start + count and distance >= clear:
            opened = k if opened < 0 else opened
        elif opened >= 0:
            steps = k - opened + 1
            before = far[(first + opened - 1) % beams] if ring or opened > start else nan
            if before != before:
                before, steps = clear, steps - 1
            if distance != distance:
                distance, steps = clear, steps - 1
            a, b = before + rim, distance + rim
            across, _ = compute_cosine_and_sine(min(steps * spacing, pi))
            widest = max(widest, sqrt(max(0.0, a * a + b * b - 2.0 * a * b * across)))
            opened = -1
    return widest
