"""What kernels of several subjects need of a robot."""

from typing import Any

from understudy._jit_kernels import njit
from understudy.sim.kernels.angles import cosine_and_sine


@njit(error_model="numpy", forceinline=True)
def face(robot: Any) -> None:
    """Have the cosine and sine of a robot's heading at hand: most drive straight on, or stand."""
    if robot.aim != robot.heading:
        robot.aim = robot.heading
        robot.cosine, robot.sine = cosine_and_sine(robot.heading)
