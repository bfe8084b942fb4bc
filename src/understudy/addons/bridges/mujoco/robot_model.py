"""Add a robot to a MuJoCo model: a round chassis on two driven wheels and two casters, its colors, its camera."""

from __future__ import annotations

from math import atan, degrees, radians, tan
from typing import Any

from understudy.addons.bridges.mujoco.materials import choose_material_color
from understudy.addons.bridges.mujoco.optional import import_mujoco
from understudy.addons.bridges.mujoco.shapes import (
    DARK,
    EYE_M,
    FLOORED,
    GRIP,
    LOOKS,
    ROBOTS,
    ROLLING,
    SKY,
    SOLIDLY,
    add_ellipsoid,
    add_visual_geom,
    make_rgba,
    make_yaw_quaternion,
)  # fmt: skip
from understudy.sim.scenario.schema import Camera, RobotType

KG_PER_M2, SLOW_S, PULL = 225.0, 0.1, 0.6
"""A robot's mass per square of its radius (a Pioneer 3-DX of 0.2 m has 9 kg); the time (s) in which wheels follow a
command; their largest pull, as a share of the robot's weight.
"""
WHEEL, TRACK, CASTER = 0.4, 0.75, 0.25
"""The radius of wheels, their distance from the center, and the radius of casters, as shares of the robot's radius."""
SIDES = ("left", "right")


def scale_to_commands(robot_type: RobotType, speed_m_s: float, turn_rad_s: float) -> tuple[float, float]:
    """Convert speeds (m/s, rad/s) to commands, shares of the type's greatest speeds; 0 if the type cannot move so."""
    turning = radians(robot_type.turning_deg)
    return (speed_m_s / robot_type.speed if robot_type.speed else 0.0), (
        turn_rad_s / turning if turning else 0.0
    )


def find_camera(robot_type: RobotType) -> Camera | None:
    """Return the first camera of a type of robots; None if it has none."""
    return next((each for each in robot_type.sensors if isinstance(each, Camera)), None)


def add_robot(spec: Any, number: int, robot_type: RobotType, place: tuple[float, float, float]) -> None:
    """Add a robot at (x, y, heading) to a model: chassis, wheels and casters, its visible body and camera."""
    shapes, radius = import_mujoco().mjtGeom, robot_type.radius
    wheel, caster, mass = WHEEL * radius, CASTER * radius, KG_PER_M2 * radius**2
    body = spec.worldbody.add_body(
        name=f"robot{number}", pos=[*place[:2], 0.0], quat=make_yaw_quaternion(place[2])
    )
    body.add_freejoint(name=f"robot{number}")
    low, high = 0.3 * radius, 1.1 * radius
    solid = SOLIDLY if robot_type.collides else {"contype": 0, "conaffinity": 0}
    body.add_geom(
        type=shapes.mjGEOM_CYLINDER, pos=[0, 0, (low + high) / 2], size=[radius, (high - low) / 2, 0.0],
        mass=0.8 * mass, rgba=make_rgba(DARK), group=ROBOTS, **solid,
    )  # fmt: skip
    for side in (1.0, -1.0):
        body.add_geom(
            type=shapes.mjGEOM_SPHERE, pos=[side * 0.7 * radius, 0, caster], size=[caster, 0, 0], mass=0.01 * mass,
            contype=FLOORED, conaffinity=FLOORED, condim=1, priority=1, rgba=make_rgba(DARK), group=LOOKS,
        )  # fmt: skip
    pull = PULL * mass * 9.81 * wheel / 2
    for name, side in zip(SIDES, (1.0, -1.0), strict=True):
        hub = body.add_body(pos=[0, side * TRACK * radius, wheel])
        hub.add_joint(name=f"{name}{number}", axis=[0, 1, 0], armature=1e-4)
        # It rolls on a ball, which has one point on the floor; what is seen of it is a wheel.
        hub.add_geom(
            type=shapes.mjGEOM_SPHERE, size=[wheel, 0, 0], mass=0.09 * mass, contype=FLOORED, conaffinity=FLOORED,
            friction=[GRIP, 0.005, 0.0001], group=ROLLING,
        )  # fmt: skip
        add_visual_geom(
            hub,
            shapes.mjGEOM_CYLINDER,
            [0, 0, 0],
            [wheel, 0.1 * radius, 0],
            DARK,
            quat=[0.7071, 0.7071, 0, 0],
        )
        motor = spec.add_actuator(name=f"{name}{number}", target=f"{name}{number}", forcerange=[-pull, pull])
        motor.trntype = import_mujoco().mjtTrn.mjTRN_JOINT
        motor.set_to_velocity(kv=mass * wheel**2 / (2.0 * SLOW_S))
    _worn(body, robot_type, high)
    _eye(body, number, find_camera(robot_type))


def _worn(body: Any, robot_type: RobotType, high: float) -> None:
    """Add the colored body by which other robots' cameras detect a robot, and a mark of its front."""
    shapes, radius = import_mujoco().mjtGeom, robot_type.radius
    if find_camera(robot_type) is not None:
        half = radius if robot_type.height is None else robot_type.height / 2
        add_visual_geom(body, shapes.mjGEOM_CYLINDER, [0, 0, EYE_M / 2], [0.018, EYE_M / 2, 0.0], DARK)
        if robot_type.color is not None:
            add_ellipsoid(body, radius, half, choose_material_color(robot_type.color))
    else:
        add_visual_geom(
            body,
            shapes.mjGEOM_CYLINDER,
            [0, 0, high + 0.004],
            [0.92 * radius, 0.004, 0],
            choose_material_color(robot_type.color or "red"),
        )
    add_visual_geom(
        body, shapes.mjGEOM_BOX, [0.72 * radius, 0, high + 0.01], [0.2 * radius, 0.06 * radius, 0.008], SKY
    )


def _eye(body: Any, number: int, camera: Camera | None) -> None:
    """Add a camera above the robot's center that looks ahead, like that of the 2-D world.

    Its own ellipsoid does not hide the view, because ellipsoids are not visible from inside.
    """
    settings = camera or Camera()
    half = settings.height_px / settings.width_px * tan(radians(settings.view_deg) / 2)
    mounted = body.add_camera(name=f"eye{number}", pos=[0, 0, EYE_M], fovy=2.0 * degrees(atan(half)))
    mounted.quat = [0.5, 0.5, -0.5, -0.5]
