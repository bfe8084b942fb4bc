"""MuJoCo, which only physics needs: imported when a world is made of it, and drawing without a screen."""

from __future__ import annotations

import os
from functools import cache
from importlib import import_module
from typing import Any

from understudy.errors import UnderstudyError
from understudy.robots.transport import ExtraMissing


class NoDrawing(UnderstudyError):
    """Cameras cannot be rendered on this machine."""

    def __init__(self, *, problem: str) -> None:
        self.problem = problem
        super().__init__(
            f"cameras cannot be rendered here: {problem}; install EGL (Debian: libegl1 libgl1-mesa-dri), "
            "or choose another way to draw with MUJOCO_GL"
        )


@cache
def mujoco() -> Any:
    """The module `mujoco`; ExtraMissing where it is not installed. It draws with EGL, unless MUJOCO_GL says how."""
    os.environ.setdefault("MUJOCO_GL", "egl")
    try:
        return import_module("mujoco")
    except ImportError:
        raise ExtraMissing(what="a world in simulated physics", extra="mujoco") from None


@cache
def drawing(width_px: int, height_px: int) -> Any:
    """What draws pictures up to this size, current in this thread; NoDrawing where there is none."""
    try:
        lib = mujoco()
        # Asked for by name: who imported MuJoCo before us left it to choose a way that needs a screen.
        found = import_module("mujoco.egl") if os.environ["MUJOCO_GL"].lower() == "egl" else lib
        context = found.GLContext(width_px, height_px)
        context.make_current()
    except Exception as error:  # what it raises depends on what is missing
        raise NoDrawing(
            problem=f"{error.__class__.__name__}: {error}" if str(error) else str(error)
        ) from error
    return context
