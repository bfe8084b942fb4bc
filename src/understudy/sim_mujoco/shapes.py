"""Shapes that models are put together from: what is solid, what is only looked at, at which height cameras are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, sin
from typing import Any

from understudy.sim_mujoco.materials import Rgb
from understudy.sim_mujoco.optional import import_mujoco

WALLS, OBSTACLES, ROBOTS, LOOKS, UNSEEN, ROLLING = range(6)
"""Groups of geoms: what sonar hears as such; what is only looked at; solid obstacles, and what rolls, not drawn."""
FLOORED, SOLID = 1, 2
"""What meets the floor, and what meets everything else."""

EYE_M = 0.55
"""The height of cameras, and of the middle of what they are to see, m."""
AWAY_M = -10.0
"""Where objects wait that are not there: under the floor."""
GRIP = 1.0
"""Friction of wheels on the floor."""

DARK, FLOOR, SKY = Rgb(0.13, 0.13, 0.14), Rgb(0.74, 0.73, 0.70), Rgb(0.88, 0.90, 0.92)
WALL = Rgb(0.80, 0.79, 0.77)

SOLIDLY: Mapping[str, Any] = {"contype": SOLID, "conaffinity": SOLID, "friction": [0.1, 0.005, 0.0001]}
"""Robots slide along what is solid, as in the 2-D world."""
SHOWN: Mapping[str, Any] = {"contype": 0, "conaffinity": 0, "mass": 0.0, "group": LOOKS}


def add_ellipsoid(
    body: Any, radius: float, half: float, color: Rgb, *, opaque: float = 1.0, eye: float = EYE_M
) -> None:
    """Colored on all sides, its middle at eye height, or above the floor where it is larger."""
    middle = [0.0, 0.0, max(eye, half)]
    add_visual_geom(
        body, import_mujoco().mjtGeom.mjGEOM_ELLIPSOID, middle, [radius, radius, half], color, opaque
    )


def add_pole(body: Any, high: float) -> None:
    """A slim dark pole up to this height, m, if there is any."""
    if high > 0:
        add_visual_geom(
            body, import_mujoco().mjtGeom.mjGEOM_CYLINDER, [0, 0, high / 2], [0.018, high / 2, 0.0], DARK
        )


def add_visual_geom(
    body: Any,
    shape: Any,
    pos: Sequence[float],
    size: Sequence[float],
    color: Rgb,
    opaque: float = 1.0,
    **more: Any,
) -> None:
    """Something that is only looked at."""
    body.add_geom(type=shape, pos=list(pos), size=list(size), rgba=make_rgba(color, opaque), **SHOWN, **more)


def make_rgba(color: Rgb, opaque: float = 1.0) -> list[float]:
    """A color as MuJoCo has it."""
    return [*color, opaque]


def make_yaw_quaternion(angle: float) -> list[float]:
    """The quaternion of a turn about the vertical."""
    return [cos(angle / 2), 0.0, 0.0, sin(angle / 2)]
