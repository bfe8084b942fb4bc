"""Pictures of physics: the whole arena from above, in its corner what a robot's camera sees, blobs framed."""

from __future__ import annotations

from math import hypot
from pathlib import Path
from typing import Any

import numpy as np

from understudy.addons.bridges.mujoco.body import MujocoBody
from understudy.addons.bridges.mujoco.model import build_model
from understudy.addons.bridges.mujoco.optional import import_mujoco
from understudy.addons.bridges.mujoco.shapes import AWAY_M
from understudy.addons.bridges.mujoco.world import Renderer
from understudy.addons.robots.camera.blobs import Image

SIZE_PX = (1000, 560)
FINER = 2
"""So many times larger it is drawn, and made smaller again: edges are smoother."""
DOWN_DEG, AROUND_DEG = 34.0, 78.0
INSET, EDGE_PX = 0.27, 3
"""How wide the camera's picture is, a share of the whole; its white edge."""


def render_overview(body: MujocoBody, *, world: int = 0) -> Image:
    """A world of a body from above [H, W, 3], with shadows."""
    view, (width, height) = body.view(world), SIZE_PX
    built = build_model(body.scenario, view, fine=True)
    data = import_mujoco().MjData(built.model)
    data.mocap_pos[:] = (0.0, 0.0, AWAY_M)
    for slot, x, y in zip(view.objects.slot, view.objects.x, view.objects.y, strict=True):
        if slot < len(built.movable) and built.movable[slot] >= 0:
            data.mocap_pos[built.movable[slot]] = (x, y, 0.0)
    import_mujoco().mj_forward(built.model, data)
    away_m = 0.8 * hypot(view.width, view.height)
    image = Renderer(built.model, fine=True).overview(
        data, at=(0.57 * view.width, 0.5 * view.height, 0.0), away_m=away_m, down_deg=DOWN_DEG,
        around_deg=AROUND_DEG, width_px=FINER * width, height_px=FINER * height,
    )  # fmt: skip
    smaller: Image = image.reshape(height, FINER, width, FINER, 3).mean(axis=(1, 3)).astype(np.uint8)
    return smaller


def render_with_camera_inset(body: MujocoBody, agent: int = 0) -> Image:
    """The same, and in its upper right corner what a robot's camera sees, if it has one."""
    image, seen = render_overview(body, world=agent // body.robots), body.image(agent)
    if seen is None:
        return image
    from PIL import Image as Pictures

    framed = Pictures.fromarray(seen)
    wide = round(INSET * image.shape[1])
    inset = np.asarray(
        framed.resize((wide, round(wide * seen.shape[0] / seen.shape[1])), Pictures.Resampling.NEAREST)
    )
    tall = inset.shape[0]
    image[: tall + EDGE_PX, -wide - EDGE_PX :] = 255
    image[:tall, -wide:] = inset
    return image


def save_png(image: Image, path: Path) -> None:
    """As PNG, in few colors: small enough for documents."""
    from PIL import Image as Pictures

    picture: Any = Pictures.fromarray(image).quantize(256, dither=Pictures.Dither.NONE)
    picture.save(path, optimize=True)
