"""Compiled twins of kernels: functions of the same code, in which names of kernels stand for their twins."""

from functools import cache, partial
from hashlib import sha256
from pathlib import Path
from types import FunctionType
from typing import Any

import numba

from understudy.jit.argument_types import make_example
from understudy.jit.cache import hash_kernel_sources
from understudy.jit.decorators import LINKED, OPTIONS, Kernel
from understudy.jit.intrinsics import TWINS
from understudy.jit.linked import FOR_LINKED
from understudy.jit.settings import CHECKED, read_kernel_mode
from understudy.jit.stored import StoredKernels

_scopes: dict[int, dict[str, Any]] = {}


@cache
def make_dispatcher(function: Any) -> Any:
    """Make the twin of a kernel: what Numba compiles for the types of its arguments when it is first called so."""
    return make_own_dispatcher(function)


def make_own_dispatcher(function: Any) -> Any:
    """Make another twin of a kernel, which no other caller shares: a thread may forbid the shared one to compile."""
    scope = _find_scope(function.__globals__)
    twin = FunctionType(
        function.__code__, scope, function.__name__, function.__defaults__, function.__closure__
    )
    twin.__module__, twin.__qualname__ = function.__module__, function.__qualname__
    linked = function in LINKED
    options = {**OPTIONS[function], **(FOR_LINKED if linked else {})}
    dispatcher: Any = numba.njit(**options, boundscheck=read_kernel_mode() == CHECKED)(twin)
    if not linked:
        dispatcher._cache = StoredKernels(
            f"{function.__module__}.{function.__qualname__}", _hash_source(function)
        )
        dispatcher.compile = partial(_compile_once, dispatcher)
    return dispatcher


def _compile_once(dispatcher: Any, signature: Any) -> Any:
    """Load or compile a kernel for these types; of several processes only one compiles it, and the others load it."""
    with dispatcher._cache.lock(signature, dispatcher.targetctx):
        return type(dispatcher).compile(dispatcher, signature)


def _hash_source(function: Any) -> str:
    """Hash what the compiled code of a kernel depends on: all kernels of this package, or the kernel's own file."""
    if function.__module__.startswith("understudy."):
        return hash_kernel_sources()
    file = Path(function.__code__.co_filename)
    return sha256(file.read_bytes() if file.is_file() else function.__code__.co_code).hexdigest()


def infer_signature(dispatcher: Any, types: Any) -> tuple[Any, ...]:
    """Return Numba's types for arguments that were described by `describe_types`."""
    return tuple(map(dispatcher.typeof_pyval, make_example(types)))


def _find_scope(names: dict[str, Any]) -> dict[str, Any]:
    """Return the names of a file of kernels, with twins instead of kernels."""
    if id(names) not in _scopes:
        scope = _scopes[id(names)] = dict(names)  # filled below, because kernels of a file call each other
        scope.update({name: _find_twin(value) for name, value in names.items()})
    return _scopes[id(names)]


def _find_twin(value: Any) -> Any:
    """Return the twin of a value, or the value itself if it has none."""
    if isinstance(value, Kernel):
        return make_dispatcher(value.function)
    if not isinstance(value, FunctionType):
        return value
    return make_dispatcher(value) if value in OPTIONS else TWINS.get(value, value)
