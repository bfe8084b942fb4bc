"""Whether cameras can be rendered here: tests that need it are skipped where not, but never in CI."""

from __future__ import annotations

import os
from importlib.util import find_spec

import pytest

if find_spec("mujoco") is None:  # not imported yet: how it draws is decided then
    pytest.skip("needs the extra mujoco", allow_module_level=True)

from understudy.physics.looking import MOST_PX
from understudy.physics.mujoco import NoDrawing, drawing


def _draws() -> bool:
    try:
        drawing(*MOST_PX)
    except NoDrawing:
        return False
    return True


draws = pytest.mark.skipif(
    "CI" not in os.environ and not _draws(), reason="needs EGL (Debian: libegl1 libgl1-mesa-dri)"
)
