"""Kill a process between two operations on files, as kill -9 may at any moment, but the same in every run."""

from __future__ import annotations

import os
import sys
from signal import SIGKILL

MODULES = ("posix", "nt", "io", "_io", "fcntl")
"""The modules of the functions and methods that work with files."""


def kill_self_after(operations: int) -> None:
    """Kill this process at the beginning or end of an operation on files that follows so many of them."""
    left = operations

    def count(_: object, event: str, called: object) -> None:
        nonlocal left
        if not event.startswith("c_"):
            return
        kind = type(getattr(called, "__self__", None)).__module__
        if kind in MODULES or getattr(called, "__module__", None) in MODULES:
            left -= 1
            if left < 0:
                os.kill(os.getpid(), SIGKILL)

    sys.setprofile(count)
