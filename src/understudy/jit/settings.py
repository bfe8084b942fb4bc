"""Settings of kernels: the mode in which they run, and the parts of them that worlds get."""

import gc
import os
from collections.abc import Iterator
from contextlib import contextmanager

from understudy.errors import SettingError

MODE = "UNDERSTUDY_KERNELS"
AUTO, COMPILED, CHECKED, PYTHON = "auto", "compiled", "checked", "python"
"""The modes in which kernels run.

`auto` runs them as plain Python until they are compiled, which happens in another process. `compiled` compiles them
when they are first called, `checked` too, with bounds checks; `python` never does.

Checked kernels raise IndexError for an index beyond an array's end. Plain Python also refuses an index below 0, which
the others count from the array's end.
"""

PARTS = "UNDERSTUDY_KERNEL_PARTS"
OWN_PARTS, ALL_PARTS = "own", "all"
"""The parts of kernels that are compiled for a world: those that it uses; or all, once for all worlds."""


def read_kernel_mode() -> str:
    """Return the mode of kernels in this process, from the environment variable UNDERSTUDY_KERNELS; else AUTO."""
    return _read_choice(MODE, AUTO, COMPILED, CHECKED, PYTHON)


def compile_on_first_call() -> None:
    """Let kernels be compiled when they are first called, in this process and those that it starts.

    It is for measurements, and must come before the first kernel runs. A mode that the user named stays.
    """
    os.environ.setdefault(MODE, COMPILED)


def read_kernel_parts() -> str:
    """Return the parts to compile, from the environment variable UNDERSTUDY_KERNEL_PARTS; else OWN_PARTS."""
    return _read_choice(PARTS, OWN_PARTS, ALL_PARTS)


def _read_choice(setting: str, *choices: str) -> str:
    """Return the value of an environment variable, or the first choice if it is not set."""
    chosen = os.environ.get(setting) or choices[0]
    if chosen not in choices:
        remedy = f"give one of {', '.join(choices)}"
        raise SettingError(where="environment", setting=setting, problem=f"is {chosen!r}", remedy=remedy)
    return chosen


@contextmanager
def pause_garbage_collection() -> Iterator[None]:
    """Pause the garbage collector while kernels are compiled, where it takes a tenth of the time and finds nothing."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()
