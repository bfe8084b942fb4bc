"""Whether cameras can be rendered here: tests that need it are skipped where not, but never in CI."""

from __future__ import annotations

import os

import pytest

pytest.importorskip("mujoco", reason="needs the extra mujoco")

from understudy.addons.bridges.mujoco.optional import RenderingUnavailable, make_gl_context
from understudy.addons.bridges.mujoco.world import MOST_PX


def _draws() -> bool:
    try:
        make_gl_context(*MOST_PX)
    except RenderingUnavailable:
        return False
    return True


draws = pytest.mark.skipif(
    "CI" not in os.environ and not _draws(), reason="needs EGL (Debian: libegl1 libopengl0 libgl1-mesa-dri)"
)
