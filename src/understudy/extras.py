"""Optional dependencies: how each extra is installed, and the error where one is missing."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from types import ModuleType

from understudy.errors import UnderstudyError

DISTRIBUTION = "understudy-robots"
"""The name on package indexes; `understudy` there is somebody else's. Every install command is made from it."""


def format_install_command(extra: str) -> str:
    """Return the command that installs an extra, such as `pip install 'understudy-robots[ros2]'`."""
    return f"pip install '{DISTRIBUTION}[{extra}]'"


class ExtraMissing(UnderstudyError, json_type="ExtraMissing"):
    """Something needs an extra that is not installed."""

    def __init__(self, *, what: str, extra: str) -> None:
        self.what, self.extra = what, extra
        super().__init__(f"{what} needs an extra that is not installed: {format_install_command(extra)}")


@cache
def import_opencv() -> ModuleType:
    """Import OpenCV, on one thread; ExtraMissing where it is not installed.

    Threads gain nothing on images this small, and waiting for them made one of a hundred images take ten times as long.
    """
    try:
        cv = import_module("cv2")
    except ImportError:
        raise ExtraMissing(what="a camera", extra="camera") from None
    cv.setNumThreads(1)
    return cv
