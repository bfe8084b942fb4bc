"""Compiled kernels in files, as Numba's dispatchers save and load them."""

import logging
import pickle
import platform
import sys
from functools import cache
from hashlib import sha256
from typing import Any

import llvmlite
import numba
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from understudy.jit.cache import read_kernel, write_kernel
from understudy.jit.settings import CHECKED, COMPILED, read_kernel_mode


class KernelMissing(Exception):
    """No compiled code of a kernel is there for the types of its arguments."""


class StoredKernels(_Cache):
    """The files of one kernel, one for each combination of types."""

    def __init__(self, name: str, source: str) -> None:
        self._name, self._source = name, source
        self.compiles = True
        """Whether the dispatcher may compile; if not, it raises `KernelMissing` where it would."""
        self.contents: dict[Any, bytes] = {}
        """The contents of files that were loaded or written, by types; one that is put here is loaded from memory."""

    @property
    def cache_path(self) -> str:
        """Return the name, which Numba only shows."""
        return self._name

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled kernel for these types, or None if there is none."""
        target_context.refresh()
        content = self.contents.get(sig) or read_kernel(self._make_key(sig, target_context))
        if content is not None:
            try:
                loaded = CompileResult._rebuild(target_context, *pickle.loads(content))
            except Exception:  # whatever a file can do to these: it is of no use
                logging.getLogger(__name__).debug("%s cannot be loaded", self._name, exc_info=True)
            else:
                self.contents[sig] = content
                return loaded
        if not self.compiles:
            raise KernelMissing(self._name)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write a compiled kernel."""
        self.contents[sig] = dumps(data._reduce())
        write_kernel(self._make_key(sig, data.target_context), self.contents[sig])

    def enable(self) -> None:
        """Do nothing: files are always used."""

    def disable(self) -> None:
        """Do nothing: files are always used."""

    def flush(self) -> None:
        """Do nothing: files are deleted by age."""

    def _make_key(self, sig: Any, target_context: Any) -> str:
        """Hash all that a compiled kernel depends on."""
        types = "; ".join(map(str, sig))
        return sha256(
            "\n".join((self._name, self._source, types, *_list_versions(target_context))).encode()
        ).hexdigest()


@cache
def _list_versions(target_context: Any) -> tuple[str, ...]:
    """List what all compiled kernels depend on: mode, compilers, Python and processor."""
    return (
        CHECKED if read_kernel_mode() == CHECKED else COMPILED,
        numba.__version__,
        llvmlite.__version__,
        str(sys.implementation.cache_tag),
        platform.machine(),
        repr(target_context.codegen().magic_tuple()),
    )
