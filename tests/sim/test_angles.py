"""Our own angle functions, against NumPy's and against what must hold of them exactly."""

from __future__ import annotations

from math import atan2, cos, inf, isnan, nextafter, pi, sin, tau, ulp

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from understudy.sim.kernels.angles import compute_angle, compute_cosine_and_sine, wrap_angle

LENGTHS = st.floats(1e-6, 1e6) | st.floats(-1e6, -1e-6)


@settings(deadline=None)  # the first call compiles
@given(LENGTHS, LENGTHS)
def test_the_angle_of_a_direction(y: float, x: float) -> None:
    expected = atan2(y, x)
    assert abs(compute_angle(y, x) - expected) <= 2 * ulp(expected)


@pytest.mark.parametrize(
    ("y", "x", "angle"),
    [(0.0, 1.0, 0.0), (1.0, 0.0, pi / 2), (0.0, -1.0, pi), (-1.0, 0.0, -pi / 2), (2.0, 2.0, pi / 4)],
)
def test_along_axes_and_diagonals_it_is_exact(y: float, x: float, angle: float) -> None:
    assert compute_angle(y, x) == angle


@settings(deadline=None)  # the first call compiles
@given(st.floats(-1e4, 1e4))
def test_cosine_and_sine(angle: float) -> None:
    cosine, sine = compute_cosine_and_sine(angle)
    assert cosine == pytest.approx(cos(angle), abs=1.5e-16)
    assert sine == pytest.approx(sin(angle), abs=1.5e-16)


@settings(deadline=None)  # the first call compiles
@given(st.floats(-1e6, 1e6))
def test_wrapped_is_on_the_circle_at_the_same_place(angle: float) -> None:
    around = wrap_angle(angle)
    assert 0.0 <= around < tau
    assert abs(np.exp(1j * around) - np.exp(1j * angle)) < 1e-9


@pytest.mark.parametrize(
    ("angle", "around"),
    [
        (0.0, 0.0),
        (1.25, 1.25),
        (tau, 0.0),
        (-1.0, tau - 1.0),
        (-1e-20, 0.0),  # a hair before the circle's end, which no double is near enough to
        (nextafter(tau, 0.0), nextafter(tau, 0.0)),
        (-tau, 0.0),
    ],
)
def test_wrapped_near_the_ends(angle: float, around: float) -> None:
    assert wrap_angle(angle) == around


def test_what_is_absent_stays_absent() -> None:
    assert isnan(wrap_angle(float("nan")))
    assert isnan(wrap_angle(inf))
