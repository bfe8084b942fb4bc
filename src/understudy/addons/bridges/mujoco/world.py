"""One world in MuJoCo: its robots drive, its objects are set to their places, its cameras render images."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, sin, tau
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.addons.bridges.mujoco.model import STEP_S, build_model
from understudy.addons.bridges.mujoco.optional import RenderingUnavailable, import_mujoco, make_gl_context
from understudy.addons.bridges.mujoco.robot_model import TRACK, WHEEL
from understudy.addons.bridges.mujoco.shapes import AWAY_M, ROLLING, UNSEEN
from understudy.addons.robots.camera.blobs import Image
from understudy.sim.scenario.schema import Camera, Scenario
from understudy.sim.view import WorldView

FREE = 7
"""The number of values in a robot's position: x, y, z and a quaternion."""
MOST_PX = (2560, 1920)
"""The size of the largest image that can be rendered, pixels."""


class BodyPose(NamedTuple):
    """A robot's place (m), heading (rad in [0, tau)), forward speed (m/s) and turning speed (rad/s, left positive)."""

    x: float
    y: float
    heading: float
    speed: float
    turning: float


class Renderer:
    """A renderer of a model's images, with shadows if `fine`; RenderingUnavailable if rendering is not possible.

    It works only in the thread that created the first renderer.
    """

    def __init__(self, model: Any, *, fine: bool = False) -> None:
        self._model, self._on = model, make_gl_context(*MOST_PX)
        lib = import_mujoco()
        self._on.make_current()
        self._scene = lib.MjvScene(model, maxgeom=2000)
        try:
            self._context = lib.MjrContext(model, lib.mjtFontScale.mjFONTSCALE_100)
        except (
            lib.FatalError
        ) as error:  # a way to draw that is there, but draws nothing, such as one without a screen
            raise RenderingUnavailable(problem=str(error).partition(",")[0]) from error
        for flag in (lib.mjtRndFlag.mjRND_SHADOW, lib.mjtRndFlag.mjRND_REFLECTION):
            self._scene.flags[flag] = fine
        self._option, self._camera = lib.MjvOption(), lib.MjvCamera()
        self._option.geomgroup[:] = 1
        self._option.geomgroup[[UNSEEN, ROLLING]] = 0

    def image(self, data: Any, camera: int, width_px: int, height_px: int) -> Image:
        """Render the image of a camera of the model [H, W, 3]."""
        self._camera.type, self._camera.fixedcamid = import_mujoco().mjtCamera.mjCAMERA_FIXED, camera
        return self._drawn(data, width_px, height_px)

    def overview(self, data: Any, *, at: tuple[float, float, float], away_m: float, down_deg: float,
                 around_deg: float, width_px: int, height_px: int) -> Image:  # fmt: skip
        """Render the scene [H, W, 3] from outside: towards a point, at a distance, downward angle and azimuth (deg)."""
        self._camera.type, self._camera.lookat[:] = import_mujoco().mjtCamera.mjCAMERA_FREE, at
        self._camera.distance, self._camera.elevation, self._camera.azimuth = away_m, -down_deg, around_deg
        return self._drawn(data, width_px, height_px)

    def _drawn(self, data: Any, width_px: int, height_px: int) -> Image:
        lib = import_mujoco()
        self._on.make_current()
        lib.mjr_setBuffer(lib.mjtFramebuffer.mjFB_OFFSCREEN, self._context)  # others draw, too
        frame, image = lib.MjrRect(0, 0, width_px, height_px), np.empty((height_px, width_px, 3), np.uint8)
        every = lib.mjtCatBit.mjCAT_ALL
        lib.mjv_updateScene(self._model, data, self._option, None, self._camera, every, self._scene)
        lib.mjr_render(frame, self._scene, self._context)
        lib.mjr_readPixels(image, None, frame, self._context)
        return np.ascontiguousarray(image[::-1])


class MujocoWorld:
    """A world in physics, built from a view of the 2-D world."""

    def __init__(self, scenario: Scenario, view: WorldView) -> None:
        self.built = build_model(scenario, view)
        self.model, self.data = self.built.model, import_mujoco().MjData(self.built.model)
        kinds = list(scenario.types.values())
        self.kinds = [kinds[index] for index in view.robots.type.tolist()]
        self._steps = max(1, round(scenario.tick_s / STEP_S))
        self.model.opt.timestep = scenario.tick_s / self._steps
        self._touching = self.model.geom_contype.copy(), self.model.geom_conaffinity.copy()
        self._lifted: list[int] = []
        self._looking: Renderer | None = None
        self.place_objects(view)
        import_mujoco().mj_forward(self.model, self.data)

    def place_objects(self, view: WorldView) -> None:
        """Move all objects to their places in a view; absent objects go below the floor."""
        self.data.mocap_pos[:] = (0.0, 0.0, AWAY_M)
        for slot, x, y in zip(view.objects.slot, view.objects.x, view.objects.y, strict=True):
            if slot < len(self.built.movable) and (body := self.built.movable[slot]) >= 0:
                self.data.mocap_pos[body] = (x, y, 0.0)

    def lift(self, robots: Sequence[int]) -> None:
        """Let robots touch nothing from now on, and all others touch what is solid."""
        if list(robots) == self._lifted:
            return
        self._lifted = list(robots)
        self.model.geom_contype[:], self.model.geom_conaffinity[:] = self._touching
        lifted = np.isin(self.model.body_rootid[self.model.geom_bodyid], self.built.bodies[self._lifted])
        self.model.geom_contype[lifted] = self.model.geom_conaffinity[lifted] = 0

    def drive(self, speeds: NDArray[np.float64]) -> None:
        """Advance by one tick with commanded speeds [N, 2] of the robots: m/s forward, rad/s to the left."""
        for robot, (ahead, turning) in enumerate(speeds.tolist()):
            radius = self.kinds[robot].radius
            side = turning * TRACK * radius
            left, right = self.built.wheels[robot]
            self.data.ctrl[left] = (ahead - side) / (WHEEL * radius)
            self.data.ctrl[right] = (ahead + side) / (WHEEL * radius)
        import_mujoco().mj_step(self.model, self.data, self._steps)
        self.settle()

    def settle(self) -> None:
        """Update positions of bodies, cameras and lights after a change of the state."""
        lib = import_mujoco()
        lib.mj_kinematics(self.model, self.data)
        lib.mj_camlight(self.model, self.data)

    def pose(self, robot: int) -> BodyPose:
        """Return a robot's place and speeds."""
        at, fast = self.built.qpos[robot], self.built.qvel[robot]
        x, y, _, w, i, j, k = self.data.qpos[at : at + FREE].tolist()
        along_x, along_y, _, _, _, turning = self.data.qvel[fast : fast + FREE - 1].tolist()
        heading = atan2(2.0 * (w * k + i * j), 1.0 - 2.0 * (j * j + k * k))
        speed = along_x * cos(heading) + along_y * sin(heading)
        return BodyPose(x, y, heading % tau % tau, speed, turning)

    def place(self, robot: int, x: float, y: float, heading: float) -> None:
        """Move a robot to a place (m) and heading (rad), at rest."""
        at, fast = self.built.qpos[robot], self.built.qvel[robot]
        self.data.qpos[at : at + FREE] = (x, y, 0.0, cos(heading / 2), 0.0, 0.0, sin(heading / 2))
        self.data.qvel[fast : fast + FREE + 1] = 0.0
        self.settle()

    def set_pose(self, robot: int, pose: BodyPose) -> None:
        """Move a robot to a pose with its speeds, and set its wheels rolling accordingly."""
        height = float(self.data.qpos[self.built.qpos[robot] + 2])
        self.place(robot, pose.x, pose.y, pose.heading)
        at, fast = self.built.qpos[robot], self.built.qvel[robot]
        self.data.qpos[at + 2] = height
        velocity = (
            pose.speed * cos(pose.heading),
            pose.speed * sin(pose.heading),
            0.0,
            0.0,
            0.0,
            pose.turning,
        )
        self.data.qvel[fast : fast + FREE - 1] = velocity
        radius = self.kinds[robot].radius
        side = pose.turning * TRACK * radius
        rolling = ((pose.speed - side) / (WHEEL * radius), (pose.speed + side) / (WHEEL * radius))
        self.data.qvel[fast + FREE - 1 : fast + FREE + 1] = rolling

    def image(self, robot: int, camera: Camera) -> Image:
        """Render the image of a robot's camera [H, W, 3]."""
        if self._looking is None:
            self._looking = Renderer(self.model)
        return self._looking.image(
            self.data, int(self.built.cameras[robot]), camera.width_px, camera.height_px
        )

    @property
    def state(self) -> NDArray[np.float64]:
        """The complete physical state, for `restore`."""
        lib = import_mujoco()
        size = lib.mj_stateSize(self.model, lib.mjtState.mjSTATE_INTEGRATION)
        state = np.empty(size)
        lib.mj_getState(self.model, self.data, state, lib.mjtState.mjSTATE_INTEGRATION)
        return state

    def restore(self, state: NDArray[np.float64]) -> None:
        """Set the physical state to an earlier one."""
        lib: Any = import_mujoco()
        lib.mj_setState(self.model, self.data, state, lib.mjtState.mjSTATE_INTEGRATION)
        self.settle()
