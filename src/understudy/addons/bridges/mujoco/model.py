"""Build the MuJoCo model of a scenario's world: floor and walls, obstacles, movable objects, robots.

Things that cameras detect (robots, balls, intruders) carry their color as an ellipsoid at camera height, as wide as
their disc and as high as in the scenario: its outline equals that of the 2-D camera's disc at any distance, which
that of a cylinder does not (its rim comes nearer). Below it, upright cylinders stop robots and reflect sonar.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import atan2, hypot
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.addons.bridges.mujoco.materials import FILM, choose_film_color, choose_material_color
from understudy.addons.bridges.mujoco.optional import import_mujoco
from understudy.addons.bridges.mujoco.robot_model import SIDES, add_robot, find_camera
from understudy.addons.bridges.mujoco.shapes import (
    AWAY_M,
    DARK,
    EYE_M,
    FLOOR,
    FLOORED,
    GRIP,
    LOOKS,
    OBSTACLES,
    SKY,
    SOLIDLY,
    UNSEEN,
    WALL,
    WALLS,
    add_ellipsoid,
    add_pole,
    add_visual_geom,
    make_rgba,
    make_yaw_quaternion,
)  # fmt: skip
from understudy.errors import SettingError
from understudy.sim.params import get_most_count
from understudy.sim.scenario.schema import ObjectClass, Scenario
from understudy.sim.view import Floats, WorldView

TALL_M = 0.95
"""The height (m) of obstacles and walls in worlds with cameras; in the 2-D world they hide everything behind them."""
STEP_S = 0.005
"""The approximate length of a physics step, s; a tick is a whole number of steps."""
WALL_M, EDGE_M, THICK_M = 0.3, 0.1, 0.02
"""The height (m) of walls in worlds without cameras, and the thickness of outer and of inner walls."""


@dataclass(frozen=True, slots=True)
class CompiledModel:
    """A compiled model and the indices of its parts: positions and speeds, bodies, motors and cameras of robots [N].

    `qpos` and `qvel` are where a robot's position and speed begin in the state; `wheels` [N, 2] are its actuators.
    `movable` [K] is the mocap body of each object slot, -1 for slots without one.
    """

    model: Any
    qpos: NDArray[np.intp]
    qvel: NDArray[np.intp]
    bodies: NDArray[np.intp]
    wheels: NDArray[np.intp]
    cameras: NDArray[np.intp]
    movable: NDArray[np.intp]


def check_physics(scenario: Scenario) -> None:
    """Raise SettingError if a scenario has boxes to push or pull, which physics does not support."""
    where, remedy = f"scenario {scenario.name!r}", "leave it out, or stay with the 2-D world"
    problem = "is not there in physics"
    for index, thing in enumerate(scenario.objects):
        for key, there in (("pushable", thing.pushable), ("pull", thing.pull is not None)):
            if there:
                setting = f"objects[{index}].{key}"
                raise SettingError(where=where, setting=setting, problem=problem, remedy=remedy)


def build_model(scenario: Scenario, view: WorldView, *, fine: bool = False) -> CompiledModel:
    """Build the model of a world as a view shows it, with robots at their places.

    `fine` adds shadows and smooth edges, for pictures.
    """
    spec = import_mujoco().MjSpec()
    spec.option.timestep = STEP_S
    spec.option.integrator = import_mujoco().mjtIntegrator.mjINT_IMPLICITFAST
    _light(spec, view, fine=fine)
    sees = any(find_camera(kind) for kind in scenario.types.values())
    _ground(spec, view, TALL_M if sees else WALL_M)
    _obstacles(spec, view, sees=sees)
    movable = list(_objects(spec, scenario, sees=sees))
    kinds = list(scenario.types.values())
    for robot, index in enumerate(view.robots.type.tolist()):
        place = (view.robots.x[robot], view.robots.y[robot], view.robots.heading[robot])
        add_robot(spec, robot, kinds[index], place)
    model = spec.compile()
    numbers = range(len(view.robots))
    joints = [model.joint(f"robot{each}").id for each in numbers]
    return CompiledModel(
        model,
        np.array([model.jnt_qposadr[each] for each in joints], np.intp),
        np.array([model.jnt_dofadr[each] for each in joints], np.intp),
        np.array([model.body(f"robot{each}").id for each in numbers], np.intp),
        np.array([[model.actuator(f"{side}{each}").id for side in SIDES] for each in numbers], np.intp),
        np.array([model.camera(f"eye{each}").id for each in numbers], np.intp),
        np.array([-1 if each is None else model.body(each).mocapid[0] for each in movable], np.intp),
    )


def _light(spec: Any, view: WorldView, *, fine: bool) -> None:
    """Add even light, so that a color is nearly the same on all sides, and a sun for some shading."""
    sight, light = spec.visual, import_mujoco().mjtLightType.mjLIGHT_DIRECTIONAL
    spec.stat.extent, spec.stat.center = 1.0, [view.width / 2, view.height / 2, 0.0]
    sight.map.znear, sight.map.zfar = 0.02, 60.0
    sight.headlight.ambient, sight.headlight.diffuse = [0.42] * 3, [0.25] * 3
    sight.headlight.specular = [0.0] * 3
    sight.quality.offsamples, sight.quality.shadowsize = (8, 4096) if fine else (0, 0)
    sight.map.shadowclip = 0.9 * max(view.width, view.height)
    if fine:
        sight.global_.offwidth, sight.global_.offheight = 2560, 1920
    spec.worldbody.add_light(
        type=light, pos=[view.width / 2 + 7.0, view.height / 2 - 9.0, 20.0], dir=[-0.35, 0.45, -1.0],
        diffuse=[0.45] * 3, ambient=[0.0] * 3, specular=[0.05] * 3, castshadow=fine,
    )  # fmt: skip
    kinds, builtin = import_mujoco().mjtTexture, import_mujoco().mjtBuiltin
    spec.add_texture(
        name="sky", type=kinds.mjTEXTURE_SKYBOX, builtin=builtin.mjBUILTIN_GRADIENT,
        rgb1=list(SKY), rgb2=[0.97, 0.97, 0.97], width=64, height=64 * 6,
    )  # fmt: skip


def _ground(spec: Any, view: WorldView, high: float) -> None:
    """Add the floor, the outer walls, and the inner walls of height `high` (m)."""
    shapes, width, height = import_mujoco().mjtGeom, view.width, view.height
    spec.worldbody.add_geom(
        type=shapes.mjGEOM_PLANE, pos=[width / 2, height / 2, 0.0], size=[width / 2, height / 2, 1.0],
        rgba=make_rgba(FLOOR), contype=FLOORED, conaffinity=FLOORED, friction=[GRIP, 0.005, 0.0001], group=LOOKS,
    )  # fmt: skip
    corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
    lines = np.array(list(zip(corners, [*corners[1:], corners[0]], strict=True))).reshape(-1, 4)
    for line in lines:
        _wall(spec, line, thick=EDGE_M, aside=-EDGE_M / 2, high=WALL_M)
    for line in view.walls:
        _wall(spec, line, thick=THICK_M, aside=0.0, high=high)


def _wall(spec: Any, line: Floats, *, thick: float, aside: float, high: float) -> None:
    """Add a wall along a line, moved to its left by `aside` (m)."""
    x0, y0, x1, y1 = line
    length, angle = hypot(x1 - x0, y1 - y0), atan2(y1 - y0, x1 - x0)
    middle = [(x0 + x1) / 2 - aside * np.sin(angle), (y0 + y1) / 2 + aside * np.cos(angle), high / 2]
    spec.worldbody.add_geom(
        type=import_mujoco().mjtGeom.mjGEOM_BOX, pos=middle, size=[length / 2 + abs(aside), thick / 2, high / 2],
        quat=make_yaw_quaternion(angle), rgba=make_rgba(WALL), group=WALLS, **SOLIDLY,
    )  # fmt: skip


def _obstacles(spec: Any, view: WorldView, *, sees: bool) -> None:
    """Add round obstacles as cylinders, convex polygons as prisms, and the edges of other polygons as walls."""
    shapes, discs = import_mujoco().mjtGeom, view.discs
    for x, y, radius, color in zip(discs.x, discs.y, discs.radius, discs.color, strict=True):
        high = TALL_M if sees else 2.0 * radius
        spec.worldbody.add_geom(
            type=shapes.mjGEOM_CYLINDER, pos=[x, y, high / 2], size=[radius, high / 2, 0.0],
            rgba=make_rgba(choose_material_color(view.color(int(color)))), group=OBSTACLES, **SOLIDLY,
        )  # fmt: skip
    high = TALL_M if sees else WALL_M + 0.2
    for number, corners in enumerate(view.polygons):
        if not _is_convex(corners):
            for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
                _wall(spec, np.concatenate([start, end]), thick=THICK_M, aside=0.0, high=high)
            continue
        prism = np.concatenate([np.column_stack([corners, np.full(len(corners), z)]) for z in (0.0, high)])
        spec.add_mesh(name=f"prism{number}", uservert=prism.ravel().tolist())
        spec.worldbody.add_geom(
            type=shapes.mjGEOM_MESH,
            meshname=f"prism{number}",
            rgba=make_rgba(choose_material_color("brown")),
            group=OBSTACLES,
            **SOLIDLY,
        )


def _is_convex(corners: Floats) -> bool:
    sides = np.roll(corners, -1, axis=0) - corners
    after = np.roll(sides, -1, axis=0)
    turns = sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0]
    return bool((turns >= -1e-9).all() or (turns <= 1e-9).all())


def _objects(spec: Any, scenario: Scenario, *, sees: bool) -> Iterator[str | None]:
    """Add a body for each object of a world; yield its name for each slot, None for spare slots."""
    for thing in scenario.objects:
        for number in range(get_most_count(thing)):
            name = f"{thing.name}{number}"
            body = spec.worldbody.add_body(name=name, mocap=True, pos=[0.0, 0.0, AWAY_M])
            _object(body, thing, sees=sees)
            yield name
        yield from [None] * scenario.spare_objects


def _object(body: Any, thing: ObjectClass, *, sees: bool) -> None:
    shapes, radius, color = import_mujoco().mjtGeom, thing.radius, choose_material_color(thing.color)
    half = radius if thing.height is None else thing.height / 2
    if thing.solid:
        body.add_geom(
            type=shapes.mjGEOM_CYLINDER, size=[radius, EYE_M / 2, 0.0], pos=[0, 0, EYE_M / 2], group=UNSEEN,
            **SOLIDLY,
        )  # fmt: skip
    if thing.aloft:
        add_ellipsoid(body, radius, half, choose_film_color(thing.color), opaque=FILM)
    elif sees or thing.solid:
        add_visual_geom(body, shapes.mjGEOM_CYLINDER, [0, 0, 0.02], [max(0.1, 0.8 * radius), 0.02, 0.0], DARK)
        add_pole(body, EYE_M - half)
        add_ellipsoid(body, radius, half, color)
    elif thing.home or thing.amount != 0:
        add_visual_geom(body, shapes.mjGEOM_CYLINDER, [0, 0, 0.015], [radius, 0.015, 0.0], color)
    else:
        add_pole(body, 0.5)
        add_visual_geom(body, shapes.mjGEOM_BOX, [0.13, 0, 0.42], [0.13, 0.006, 0.08], color)
