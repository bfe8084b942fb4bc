"""What holds after every behavior: no speed above its limit, none reached faster than accelerations allow."""

from __future__ import annotations

from math import isnan
from typing import TypeAlias

from understudy.robots.robot_file import MotionLimits

Speeds: TypeAlias = tuple[float, float]
"""Driving, m/s, and turning to the left, rad/s."""
STILL: Speeds = (0.0, 0.0)


def limit_speeds(limits: MotionLimits, asked: Speeds, *, last: Speeds, elapsed_s: float) -> Speeds:
    """The speeds asked for, within the limits, and no further from the last ones than they can get in that time.

    What is no number asks for rest.
    """
    return (
        _toward(asked[0], last[0], limits.speed_m_s, limits.acceleration_m_s2, elapsed_s),
        _toward(asked[1], last[1], limits.turn_rad_s, limits.turn_acceleration_rad_s2, elapsed_s),
    )


def _toward(asked: float, last: float, most: float, acceleration: float | None, elapsed_s: float) -> float:
    want = 0.0 if isnan(asked) else max(-most, min(most, asked))
    if acceleration is None:
        return want
    step = acceleration * elapsed_s
    return max(last - step, min(last + step, want))
