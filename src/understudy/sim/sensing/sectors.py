"""Sectors of directions around a robot, prepared so that measuring in one needs no trigonometry."""

from __future__ import annotations

from math import cos, pi, sin, tau
from typing import Any

import numpy as np
from numpy.typing import NDArray

BEAM, NARROW, WIDE, FULL = 0, 1, 2, 3
"""One direction; less than half a circle; half a circle or more; all of it."""

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
"""Directions (rad) nearer to each other than this are one, so that 360 degrees are a full circle."""


def make_sector(from_rad: float, to_rad: float) -> np.void:
    """The SECTOR counter-clockwise from one angle (rad, robot frame) to another; both edges are part of it.

    A beam where both are one direction, unless `to_rad` is a full circle or more ahead of `from_rad`.
    """
    turn = (to_rad - from_rad) % tau
    if to_rad - from_rad >= tau - _SAME:
        span = FULL
    elif turn <= _SAME or turn >= tau - _SAME:
        span = BEAM
    else:
        span = NARROW if turn < pi - _SAME else WIDE
    rows: NDArray[Any] = np.zeros(1, SECTOR)
    rows[0] = cos(from_rad), sin(from_rad), cos(to_rad), sin(to_rad), span
    row: np.void = rows[0]
    return row
