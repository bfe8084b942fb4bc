"""Cameras in physics: the scene drawn from a robot's eye, as pixels, or from above, for pictures."""

from __future__ import annotations

from typing import Any

import numpy as np

from understudy.robots.camera.blobs import Image
from understudy.sim_mujoco.optional import RenderingUnavailable, import_mujoco, make_gl_context
from understudy.sim_mujoco.shapes import ROLLING, UNSEEN

MOST_PX = (2560, 1920)
"""The largest picture that is drawn."""


class Renderer:
    """Draws a model; in the thread that draws first. `fine` with shadows. NoDrawing where nothing can be drawn."""

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
        self._option, self._eye = lib.MjvOption(), lib.MjvCamera()
        self._option.geomgroup[:] = 1
        self._option.geomgroup[[UNSEEN, ROLLING]] = 0

    def image(self, data: Any, camera: int, width_px: int, height_px: int) -> Image:
        """What a camera of the model sees [H, W, 3]."""
        self._eye.type, self._eye.fixedcamid = import_mujoco().mjtCamera.mjCAMERA_FIXED, camera
        return self._drawn(data, width_px, height_px)

    def overview(self, data: Any, *, at: tuple[float, float, float], away_m: float, down_deg: float,
                 around_deg: float, width_px: int, height_px: int) -> Image:  # fmt: skip
        """The scene from outside: looking at a point from so far, so steeply down, and from which side."""
        self._eye.type, self._eye.lookat[:] = import_mujoco().mjtCamera.mjCAMERA_FREE, at
        self._eye.distance, self._eye.elevation, self._eye.azimuth = away_m, -down_deg, around_deg
        return self._drawn(data, width_px, height_px)

    def _drawn(self, data: Any, width_px: int, height_px: int) -> Image:
        lib = import_mujoco()
        self._on.make_current()
        lib.mjr_setBuffer(lib.mjtFramebuffer.mjFB_OFFSCREEN, self._context)  # others draw, too
        frame, image = lib.MjrRect(0, 0, width_px, height_px), np.empty((height_px, width_px, 3), np.uint8)
        every = lib.mjtCatBit.mjCAT_ALL
        lib.mjv_updateScene(self._model, data, self._option, None, self._eye, every, self._scene)
        lib.mjr_render(frame, self._scene, self._context)
        lib.mjr_readPixels(image, None, frame, self._context)
        return np.ascontiguousarray(image[::-1])
