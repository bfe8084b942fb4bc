"""Decorators of kernels, which run compiled, compiled with bounds checks, or as plain Python.

See `understudy.kernel_cache.read_kernel_mode` for the mode.
"""

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from understudy._plain_kernels import make_plain, make_plain_records, run_on_plain_arrays, wrap_64_bits
from understudy.kernel_cache import CHECKED, PYTHON, make_checked_cache_path, read_kernel_mode

F = TypeVar("F", bound=Callable[..., Any])

MODE = read_kernel_mode()

# Most kernels are called by other kernels only. For these neither machine code is made nor what Python needs to call
# them: both take long, and the second would unpack all arrays of a world.
LINKED: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

if MODE == PYTHON:
    int64: Any = int
    uint64: Any = wrap_64_bits
    prange: Any = range
    blank: Any = make_plain_records
else:
    import numba

    from understudy._linked_kernels import LinkedCompiler

    LINKED["pipeline_class"] = LinkedCompiler

    int64, uint64, prange = numba.int64, numba.uint64, numba.prange

    @numba.njit
    def blank(count: Any, dtype: Any) -> Any:
        """Make an array of `count` records of a type, all zeros."""
        return np.zeros(count, dtype)

    if MODE == CHECKED:  # Numba's cache would take a kernel without checks for one with them
        numba.config.CACHE_DIR = make_checked_cache_path(numba.config.CACHE_DIR)  # type: ignore[attr-defined]

__all__ = [
    "MODE",
    "blank",
    "inlined",
    "inner",
    "int64",
    "limit_threads",
    "njit",
    "njit_entry",
    "njit_inner",
    "prange",
    "uint64",
]


def njit(**options: Any) -> Callable[[F], F]:
    """Compile a kernel with Numba and these options; in plain Python mode leave it unchanged."""

    def made(function: F) -> F:
        if MODE == PYTHON:
            return function
        kernel: F = numba.njit(**options, boundscheck=MODE == CHECKED)(function)
        return kernel

    return made


def njit_entry(**options: Any) -> Callable[[F], F]:
    """Compile a kernel that Python calls with records; in plain Python mode convert its arguments by `make_plain`."""

    def made(function: F) -> F:
        return run_on_plain_arrays(function) if MODE == PYTHON else njit(**options)(function)

    return made


def njit_inner(**options: Any) -> Callable[[F], F]:
    """Compile a kernel that only other kernels call."""
    return njit(**options, **LINKED)


inner = njit_inner(error_model="numpy")
inlined = njit_inner(error_model="numpy", forceinline=True)


def convert_for_kernels(arrays: Any) -> Any:
    """Convert arrays that are passed to kernels repeatedly, if the mode needs it."""
    return make_plain(arrays) if MODE == PYTHON else arrays


def limit_threads(threads: int) -> int:
    """Set the number of threads that `prange` uses; return the number before."""
    if MODE == PYTHON:
        return threads
    before = int(numba.get_num_threads())
    numba.set_num_threads(threads)
    return before
