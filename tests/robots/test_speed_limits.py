"""Limits of speeds, by hand: what is asked for, what came before, how long ago, what may be."""

from __future__ import annotations

from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from understudy.addons.robots.robot_file import MotionLimits
from understudy.addons.robots.safety.speed_limits import Speeds, limit_speeds

FAST = MotionLimits(speed_m_s=0.5, turn_rad_s=1.0)
SLOW = MotionLimits(speed_m_s=0.5, turn_rad_s=1.0, acceleration_m_s2=1.0, turn_acceleration_rad_s2=2.0)
ROWS: list[tuple[MotionLimits, Speeds, Speeds, float, Speeds]] = [
    (FAST, (0.3, -0.4), (0.0, 0.0), 0.1, (0.3, -0.4)),
    (FAST, (2.0, -3.0), (0.0, 0.0), 0.1, (0.5, -1.0)),
    (SLOW, (0.3, 0.5), (0.0, 0.0), 0.1, (0.1, 0.2)),
    (SLOW, (-0.5, 0.0), (0.5, 0.1), 0.1, (0.4, 0.0)),
    (SLOW, (0.05, 0.1), (0.0, 0.0), 0.1, (0.05, 0.1)),
    (FAST, (nan, nan), (0.5, 1.0), 0.1, (0.0, 0.0)),
    (SLOW, (nan, -inf), (0.5, 0.0), 0.1, (0.4, -0.2)),
]
numbers = st.floats(-1e6, 1e6)


@pytest.mark.parametrize(("limits", "asked", "last", "elapsed_s", "speeds"), ROWS)
def test_speeds_within_limits(
    limits: MotionLimits, asked: Speeds, last: Speeds, elapsed_s: float, speeds: Speeds
) -> None:
    assert limit_speeds(limits, asked, last=last, elapsed_s=elapsed_s) == pytest.approx(speeds)


@given(numbers, numbers, st.floats(-0.5, 0.5), st.floats(-1, 1), st.floats(0, 0.2))
def test_no_speed_is_above_its_limit_nor_reached_too_fast(
    drive: float, turn: float, speed: float, turning: float, elapsed_s: float
) -> None:
    now = limit_speeds(SLOW, (drive, turn), last=(speed, turning), elapsed_s=elapsed_s)
    assert abs(now[0]) <= 0.5
    assert abs(now[1]) <= 1.0
    assert abs(now[0] - speed) <= 1.0 * elapsed_s + 1e-9
    assert abs(now[1] - turning) <= 2.0 * elapsed_s + 1e-9
