"""Import the optional package MuJoCo when physics needs it, and make contexts for rendering without a screen."""

from __future__ import annotations

import os
from functools import cache
from importlib import import_module
from typing import Any

from understudy.errors import UnderstudyError
from understudy.extras import ExtraMissing


class RenderingUnavailable(UnderstudyError, json_type="NoDrawing"):
    """Cameras cannot be rendered on this machine."""

    def __init__(self, *, problem: str) -> None:
        self.problem = problem
        super().__init__(
            f"cameras cannot be rendered here: {problem}; install EGL (Debian: libegl1 libopengl0 libgl1-mesa-dri), "
            "or choose another way to draw with MUJOCO_GL"
        )


WAYS = ("egl", "osmesa", "glfw")
"""The ways in which MuJoCo can render; the first needs no screen and is the default unless MUJOCO_GL names another."""


@cache
def import_mujoco() -> Any:
    """Return the module `mujoco`; raise ExtraMissing if it is not installed."""
    try:
        return import_module("mujoco")
    except ImportError:
        raise ExtraMissing(what="a world in simulated physics", extra="mujoco") from None
    except Exception as error:  # it looks at MUJOCO_GL at once, and fails as that does
        raise RenderingUnavailable(problem=_said(error)) from error


@cache
def make_gl_context(width_px: int, height_px: int) -> Any:
    """Return an OpenGL context for images up to this size, current in this thread.

    RenderingUnavailable if this machine cannot render.
    """
    import_mujoco()
    wanted = os.environ.get("MUJOCO_GL", "").lower()
    try:
        context = import_module(f"mujoco.{wanted if wanted in WAYS else WAYS[0]}").GLContext(
            width_px, height_px
        )
        context.make_current()
    except Exception as error:  # what it raises depends on what is missing
        raise RenderingUnavailable(problem=_said(error)) from error
    return context


def _said(error: Exception) -> str:
    return f"{error.__class__.__name__}: {error}" if str(error) else error.__class__.__name__
