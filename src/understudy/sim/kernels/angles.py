"""Kernels of angles with polynomials of their own: faster than a math library, and equal on all machines."""

import math
from typing import Any

import numpy as np

from understudy.jit.decorators import inlined

TAU = 2.0 * math.pi
# What a double leaves of each of these.
PI_REST, HALF_PI_REST, QUARTER_PI_REST = 1.2246467991473532e-16, 6.123233995736766e-17, 3.061616997868383e-17
# Half of pi in two parts, the first with few digits, so that a few turns of it are exact.
HALF_PI_HIGH, HALF_PI_LOW = 1.5707963267341256, 6.077100506506192e-11
EIGHTH = math.tan(math.pi / 8.0)


@inlined
def wrap_angle(angle: float) -> Any:
    """Return an angle (rad) wrapped into [0, tau)."""
    angle -= TAU * float(np.floor(angle * (1.0 / TAU)))
    angle += TAU if angle < 0.0 else 0.0  # rounding may have left it a hair outside, on either side
    return angle - TAU if angle >= TAU else angle


@inlined
def compute_angle(y: float, x: float) -> Any:
    """Return the angle (rad, in [-pi, pi]) of the direction (x, y), equal to atan2 within 2 ulp; NaN if both are 0."""
    aside, along = abs(y), abs(x)
    steep = aside > along
    least, most = (along, aside) if steep else (aside, along)
    wide = least > EIGHTH * most  # then measured from the diagonal
    t = ((least - most) if wide else least) / ((least + most) if wide else most)
    u = t * t
    v = u * u
    # atan(t) / t - 1 over u, for |t| up to tan(pi / 8) to 7e-18 of t: interpolated at Chebyshev nodes.
    series = (
        (-0.3333333333333333 + 0.19999999999995516 * u)
        + (-0.14285714284665682 + 0.11111111015187018 * u) * v
        + (
            (-0.0909090457530649 + 0.07692183125376892 * u)
            + (-0.06664510525508936 + 0.05858140904866328 * u) * v
            + ((-0.050854078345894844 + 0.03923044778479309 * u) + -0.019175404711104935 * v) * (v * v)
        )
        * (v * v)
    )
    angle = t + t * u * series
    angle = 0.25 * math.pi + (angle + QUARTER_PI_REST) if wide else angle
    angle = 0.5 * math.pi - (angle - HALF_PI_REST) if steep else angle
    angle = math.pi - (angle - PI_REST) if x < 0.0 else angle
    return math.copysign(angle, y)


@inlined
def compute_cosine_and_sine(angle: float) -> Any:
    """Return the cosine and sine of an angle (rad, at most some thousand turns), with error up to 1.2e-16."""
    quarters = float(np.floor(angle * (2.0 / math.pi) + 0.5))
    rest = (angle - quarters * HALF_PI_HIGH) - quarters * HALF_PI_LOW  # in [-pi / 4, pi / 4]
    u = rest * rest
    v = u * u
    odd = (
        (-0.16666666666666666 + 0.008333333333330946 * u)
        + (-0.0001984126983675497 + 2.755731610068303e-06 * u) * v
        + (-2.5051131455427946e-08 + 1.591810123027412e-10 * u) * (v * v)
    )
    even = (
        (0.041666666666666664 + -0.0013888888888887395 * u)
        + (2.4801587298763433e-05 + -2.7557317270560326e-07 * u) * v
        + (2.0876146024689747e-09 + -1.1382614868556325e-11 * u) * (v * v)
    )
    sine, cosine = rest + rest * u * odd, 1.0 - (0.5 * u - v * even)
    quarter = int(quarters) & 3
    if quarter & 1:
        cosine, sine = sine, cosine
    return -cosine if quarter == 1 or quarter == 2 else cosine, -sine if quarter >= 2 else sine


@inlined
def cache_heading_vector(robot: Any) -> None:
    """Store the cosine and sine of a robot's heading in its record if the heading changed since the last call."""
    if robot.aim != robot.heading:
        robot.aim = robot.heading
        robot.cosine, robot.sine = compute_cosine_and_sine(robot.heading)
