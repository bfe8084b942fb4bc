"""OpenCV, which only cameras need: imported when one is used, or one sentence that says how to install it."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from types import ModuleType

from understudy.errors import SettingError


@cache
def opencv() -> ModuleType:
    """The module `cv2`, on one thread; SettingError where it is not installed.

    Threads gain nothing on images this small, and waiting for them made one of a hundred images take ten times as long.
    """
    try:
        cv = import_module("cv2")
    except ImportError as missing:
        raise SettingError(
            where="camera",
            setting="images",
            problem="need OpenCV, which is not installed",
            remedy="pip install 'understudy[camera]'",
        ) from missing
    cv.setNumThreads(1)
    return cv
