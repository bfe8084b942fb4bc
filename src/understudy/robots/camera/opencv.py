"""OpenCV, which only cameras need: imported when one is used, or one sentence that says how to install it."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from types import ModuleType

from understudy.robots.ros.transport import ExtraMissing


@cache
def import_opencv() -> ModuleType:
    """The module `cv2`, on one thread; ExtraMissing where it is not installed.

    Threads gain nothing on images this small, and waiting for them made one of a hundred images take ten times as long.
    """
    try:
        cv = import_module("cv2")
    except ImportError:
        raise ExtraMissing(what="a camera", extra="camera") from None
    cv.setNumThreads(1)
    return cv
