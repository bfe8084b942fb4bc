"""Compiled kernels in files, as Numba's dispatchers save and load them, and the processors they are shipped for."""

import logging
import pickle
import platform
import sys
import sysconfig
from collections.abc import Iterator, Mapping, Set
from contextlib import contextmanager
from hashlib import sha256
from types import MappingProxyType
from typing import Any, NamedTuple

import llvmlite
import numba
from numba.core import config
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.compiler_lock import global_compiler_lock
from numba.core.serialize import dumps

from understudy.jit.cache import lock_kernel, read_kernel, write_kernel
from understudy.jit.settings import CHECKED, COMPILED, read_kernel_mode


class ProcessorKind(NamedTuple):
    """A kind of processors: its name in LLVM, and the features that a processor must have to run code for it."""

    name: str
    features: tuple[str, ...]


_AVX2 = ProcessorKind(
    "x86-64-v3",
    (
        "avx",
        "avx2",
        "bmi",
        "bmi2",
        "cx16",
        "f16c",
        "fma",
        "lzcnt",
        "movbe",
        "popcnt",
        "sahf",
        "sse4.2",
        "ssse3",
    ),
)
PROCESSOR_KINDS: Mapping[str, ProcessorKind] = MappingProxyType(
    {
        "x86_64": _AVX2,
        "AMD64": _AVX2,
        "aarch64": ProcessorKind("generic", ()),
        "arm64": ProcessorKind("apple-m1" if platform.system() == "Darwin" else "generic", ()),
    }
)
"""The kind for which kernels are shipped, by the name of the machine."""


def find_processor_kind(features: Set[str], machine: str = "") -> ProcessorKind | None:
    """Return the kind of processors whose code a processor with these features can run; None if there is none."""
    kind = PROCESSOR_KINDS.get(machine or platform.machine())
    return kind if kind is not None and features >= set(kind.features) else None


OPTIMIZED = 3
"""The optimization level of kernels, unless NUMBA_OPT names another."""


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

    @contextmanager
    def lock(self, sig: Any, target_context: Any) -> Iterator[None]:
        """Hold a lock while the kernel is compiled for these types, unless it is there, so that others wait for it."""
        if not self.compiles or next(self._find_contents(sig, target_context), None) is not None:
            yield
            return
        _, processor, features = target_context.codegen().magic_tuple()
        with (
            global_compiler_lock,
            lock_kernel(self._make_key(sig, processor, features)),
        ):  # always in this order
            yield

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled kernel for these types, or None if there is none."""
        target_context.refresh()
        for content in self._find_contents(sig, target_context):
            try:
                loaded = CompileResult._rebuild(target_context, *pickle.loads(content))
            except Exception:  # a damaged file can raise any error, and is of no use
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
        _, processor, features = data.codegen.magic_tuple()
        write_kernel(self._make_key(sig, processor, features), self.contents[sig])

    def _find_contents(self, sig: Any, target_context: Any) -> Iterator[bytes]:
        """Yield what is in memory, in the file for this very processor, and in that for its kind."""
        if sig in self.contents:
            yield self.contents[sig]
        _, processor, features = target_context.codegen().magic_tuple()
        shipped = find_processor_kind({each[1:] for each in features.split(",") if each.startswith("+")})
        for kind in ((processor, features), *(() if shipped is None else [(shipped.name, "")])):
            content = read_kernel(self._make_key(sig, *kind))
            if content is not None:
                yield content

    def enable(self) -> None:
        """Do nothing: files are always used."""

    def disable(self) -> None:
        """Do nothing: files are always used."""

    def flush(self) -> None:
        """Do nothing: files are deleted by age."""

    def _make_key(self, sig: Any, processor: str, features: str) -> str:
        """Hash all that a compiled kernel depends on: sources, types, mode, compilers, Python, system and processor."""
        level = vars(config)["OPT"]
        parts = (
            self._name,
            self._source,
            "; ".join(map(str, sig)),
            CHECKED if read_kernel_mode() == CHECKED else COMPILED,
            numba.__version__,
            llvmlite.__version__,
            str(sys.implementation.cache_tag),
            sysconfig.get_platform(),
            processor,
            features,
            *([] if level == OPTIMIZED else [f"optimized {level}"]),
        )
        return sha256("\n".join(parts).encode()).hexdigest()
