"""Decorators of kernels: functions that run as plain Python, and compiled where and once that is possible.

A kernel is imported as the plain function that its file says. `dispatchers` makes a compiled twin of it, with
the same code, and replaces it in a `Kernel`, through which Python calls it. Both compute the same, bit by bit.
"""

from collections.abc import Callable
from functools import update_wrapper
from typing import Any, Generic, ParamSpec, TypeVar

from understudy.jit.plain import (
    add_at_once,
    blank,
    int64,
    let_others_run,
    make_plain,
    prange,
    read_now,
    refer_to,
    uint64,
)
from understudy.jit.settings import AUTO, PYTHON, read_kernel_mode

P = ParamSpec("P")
R = TypeVar("R")
F = TypeVar("F", bound=Callable[..., Any])

OPTIONS: dict[Any, dict[str, Any]] = {}
"""The options of Numba for each kernel."""
LINKED: set[Any] = set()
"""The kernels that only other kernels call.

For these neither machine code is made nor what Python needs to call them: both take long.
"""

__all__ = [
    "LINKED",
    "OPTIONS",
    "Kernel",
    "add_at_once",
    "blank",
    "inlined",
    "inner",
    "int64",
    "let_others_run",
    "limit_threads",
    "njit_entry",
    "njit_inner",
    "prange",
    "read_now",
    "refer_to",
    "uint64",
]


class Kernel(Generic[P, R]):
    """A kernel that Python calls.

    In the mode `auto` it runs as plain Python until a thread of its own has compiled code of it for the types of its
    arguments.
    """

    def __init__(self, function: Callable[P, R]) -> None:
        update_wrapper(self, function)
        self.function: Callable[..., Any] = function
        self.run: Callable[..., Any] = self._choose_and_run
        """The function that a call runs: `run_plain`, a `KernelSwitch`, or compiled code."""
        self.compiling: Callable[..., Any] | None = None
        """The function that waits for the compiler, if one was called so. The one that a thread loads does not."""
        self.generalize: Callable[[tuple[Any, ...]], tuple[Any, ...]] = tuple
        """A function that converts arguments to more general types, with the same results; their code may exist
        already."""

    def __call__(self, *args: P.args, **no_names: P.kwargs) -> R:
        """Run the kernel."""
        result: R = self.run(*args)
        return result

    def is_compiled(self, *args: Any) -> bool:
        """Return whether the next call with arguments of these types runs compiled code."""
        mode = read_kernel_mode()
        if mode == AUTO:
            from understudy.jit.switch import is_switched

            return is_switched(self, args)
        return mode != PYTHON

    def run_long(self, *args: P.args, **no_names: P.kwargs) -> R:
        """Run the kernel for work that would take minutes as plain Python: compiled, once the compiler is through."""
        if read_kernel_mode() == AUTO and not self.is_compiled(*args):
            if self.compiling is None:
                from understudy.jit.dispatchers import make_own_dispatcher

                self.compiling = make_own_dispatcher(self.function)
            compiled: R = self.compiling(*args)
            return compiled
        result: R = self.run(*args)
        return result

    def run_plain(self, *args: Any) -> Any:
        """Run it as plain Python, which refuses an index below 0 or beyond an array's end."""
        return self.function(*map(make_plain, args))

    def _choose_and_run(self, *args: Any) -> Any:
        """Choose how to run, by the mode of kernels, and run."""
        mode = read_kernel_mode()
        if mode == PYTHON:
            self.run = self.run_plain
        elif mode == AUTO:
            from understudy.jit.switch import KernelSwitch

            self.run = KernelSwitch(self)
        else:
            from understudy.jit.dispatchers import make_dispatcher

            self.run = make_dispatcher(self.function)
        return self.run(*args)


def njit_entry(**options: Any) -> Callable[[Callable[P, R]], Kernel[P, R]]:
    """Declare a kernel that Python calls, with these options of Numba."""

    def declare(function: Callable[P, R]) -> Kernel[P, R]:
        OPTIONS[function] = options
        return Kernel(function)

    return declare


def njit_inner(**options: Any) -> Callable[[F], F]:
    """Declare a kernel that only other kernels call; Python calls it as a plain function."""

    def declare(function: F) -> F:
        OPTIONS[function] = options
        LINKED.add(function)
        return function

    return declare


inner = njit_inner(error_model="numpy")
inlined = njit_inner(error_model="numpy", forceinline=True)


def limit_threads(threads: int) -> int:
    """Set the number of threads that `prange` uses; return the number before."""
    if read_kernel_mode() == PYTHON:
        return threads
    import numba

    before = int(numba.get_num_threads())
    numba.set_num_threads(threads)
    return before
