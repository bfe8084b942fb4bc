"""Kinds of processors for which compiled kernels are shipped: what all but old processors can do."""

import platform
from collections.abc import Mapping, Set
from types import MappingProxyType
from typing import NamedTuple


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
