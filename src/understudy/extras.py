"""Optional dependencies: the command that installs each extra, and the error raised if one is missing."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from types import ModuleType

from understudy.errors import UnderstudyError

DISTRIBUTION = "understudy-robots"
"""The name of this project on package indexes, where `understudy` is a different project."""


def format_install_command(extra: str) -> str:
    """Return the command that installs an extra, such as `pip install 'understudy-robots[ros2]'`."""
    return f"pip install '{DISTRIBUTION}[{extra}]'"


class ExtraMissing(UnderstudyError, json_type="ExtraMissing"):
    """A feature that needs an optional dependency (an extra) which is not installed."""

    def __init__(self, *, what: str, extra: str) -> None:
        self.what, self.extra = what, extra
        super().__init__(f"{what} needs an extra that is not installed: {format_install_command(extra)}")


@cache
def import_opencv() -> ModuleType:
    """Import OpenCV and limit it to one thread; raise ExtraMissing if it is not installed.

    With more threads, small images are processed no faster, and one image in a hundred took ten times as long.
    """
    try:
        cv = import_module("cv2")
    except ImportError:
        raise ExtraMissing(what="a camera", extra="camera") from None
    cv.setNumThreads(1)
    return cv


@cache
def import_narwhals() -> ModuleType:
    """Import narwhals, through which data frames of Polars, pandas and pyarrow are made and read."""
    try:
        return import_module("narwhals")
    except ImportError:
        raise ExtraMissing(what="a data frame", extra="frames") from None


@cache
def import_cma() -> ModuleType:
    """Import cma, which has the evolution strategy CMA-ES; raise ExtraMissing if it is not installed."""
    try:
        return import_module("cma")
    except ImportError:
        raise ExtraMissing(what="a directed search for failing worlds", extra="falsify") from None
