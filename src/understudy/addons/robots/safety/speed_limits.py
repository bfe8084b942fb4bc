"""Limits on the speeds and accelerations of every command of any behavior; stops are not limited."""

from __future__ import annotations

from math import isnan
from typing import TypeAlias

from understudy.addons.robots.robot_file import MotionLimits

Speeds: TypeAlias = tuple[float, float]
"""Forward speed (m/s) and counter-clockwise turning (rad/s)."""
STILL: Speeds = (0.0, 0.0)


def limit_speeds(limits: MotionLimits, wanted: Speeds, *, last: Speeds, elapsed_s: float) -> Speeds:
    """Clip speeds to the limits, and their change from `last` (the speeds sent last) to acceleration × `elapsed_s`.

    `elapsed_s` is the time since the command before, s. NaN counts as 0: the robot slows down as fast as its
    acceleration limit allows. Infinite speeds are clipped. The guard sends its stops without this limit.
    """
    return (
        _toward(wanted[0], last[0], limits.speed_m_s, limits.acceleration_m_s2, elapsed_s),
        _toward(wanted[1], last[1], limits.turn_rad_s, limits.turn_acceleration_rad_s2, elapsed_s),
    )


def _toward(wanted: float, last: float, most: float, acceleration: float | None, elapsed_s: float) -> float:
    want = 0.0 if isnan(wanted) else max(-most, min(most, wanted))
    if acceleration is None:
        return want
    step = acceleration * elapsed_s
    return max(last - step, min(last + step, want))
