"""Add basic shapes to MuJoCo models: solid ones, and ones that are only visible."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, sin
from typing import Any

from understudy.addons.bridges.mujoco.materials import Rgb
from understudy.addons.bridges.mujoco.optional import import_mujoco

WALLS, OBSTACLES, ROBOTS, LOOKS, UNSEEN, ROLLING = range(6)
"""Groups of geoms: what range sensors detect, what is only visible, what is solid but not drawn, and what rolls."""
FLOORED, SOLID = 1, 2
"""Contact bits: what touches the floor, and what touches everything else."""

EYE_M = 0.55
"""The height (m) of cameras, and of the centers of the things that they detect."""
AWAY_M = -10.0
"""The height (m) at which absent objects are kept, below the floor."""
GRIP = 1.0
"""The friction coefficient of wheels on the floor."""

DARK, FLOOR, SKY = Rgb(0.13, 0.13, 0.14), Rgb(0.74, 0.73, 0.70), Rgb(0.88, 0.90, 0.92)
WALL = Rgb(0.80, 0.79, 0.77)

SOLIDLY: Mapping[str, Any] = {"contype": SOLID, "conaffinity": SOLID, "friction": [0.1, 0.005, 0.0001]}
"""Settings of solid geoms; their friction is low, so that robots slide along them as in the 2-D world."""
SHOWN: Mapping[str, Any] = {"contype": 0, "conaffinity": 0, "mass": 0.0, "group": LOOKS}


def add_ellipsoid(
    body: Any, radius: float, half: float, color: Rgb, *, opaque: float = 1.0, eye: float = EYE_M
) -> None:
    """Add a visible ellipsoid with its center at height `eye` (m), or higher if it would reach below the floor."""
    middle = [0.0, 0.0, max(eye, half)]
    add_visual_geom(
        body, import_mujoco().mjtGeom.mjGEOM_ELLIPSOID, middle, [radius, radius, half], color, opaque
    )


def add_pole(body: Any, high: float) -> None:
    """Add a thin dark pole of this height (m), if the height is above 0."""
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
    """Add a shape that is visible but touches nothing."""
    body.add_geom(type=shape, pos=list(pos), size=list(size), rgba=make_rgba(color, opaque), **SHOWN, **more)


def make_rgba(color: Rgb, opaque: float = 1.0) -> list[float]:
    """Return a color and opacity (0 to 1) as the list that MuJoCo takes."""
    return [*color, opaque]


def make_yaw_quaternion(angle: float) -> list[float]:
    """Return the quaternion (w, x, y, z) of a rotation by an angle (rad) about the vertical axis."""
    return [cos(angle / 2), 0.0, 0.0, sin(angle / 2)]
