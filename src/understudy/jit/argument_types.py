"""Descriptions of kernels' arguments, which hold what compiled code depends on: types and memory layouts."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, NamedTuple

import numpy as np


class ArrayType(NamedTuple):
    """The type of an array: of which elements, how many dimensions, and how it lies in memory ("C", "F" or "A")."""

    dtype: Any
    ndim: int
    layout: str
    writeable: bool


class RecordType(NamedTuple):
    """The type of a single record."""

    dtype: Any


class TupleType(NamedTuple):
    """The type of a tuple, or of a named tuple of a class."""

    of: type | None
    items: tuple[Hashable, ...]


def describe_types(value: Any) -> Hashable:
    """Describe the type of an argument; any other than an array, record or tuple stands for its own type."""
    if isinstance(value, np.ndarray):
        flags = value.flags
        layout = "C" if flags.c_contiguous else "F" if flags.f_contiguous else "A"
        return ArrayType(value.dtype, value.ndim, layout, flags.writeable)
    if isinstance(value, np.void):
        return RecordType(value.dtype)
    if isinstance(value, tuple):
        return TupleType(
            type(value) if hasattr(value, "_fields") else None, tuple(map(describe_types, value))
        )
    return None if value is None else type(value)(0)


def make_example(described: Any) -> Any:
    """Make an argument of a described type."""
    if isinstance(described, ArrayType):
        array = np.zeros(
            (4,) * described.ndim, described.dtype, order="F" if described.layout == "F" else "C"
        )
        if described.layout == "A":
            array = array[(slice(None, None, 2),) * described.ndim]
        array.flags.writeable = described.writeable
        return array
    if isinstance(described, RecordType):
        return np.zeros(1, described.dtype)[0]
    if isinstance(described, TupleType):
        items = tuple(map(make_example, described.items))
        return items if described.of is None else described.of(*items)
    return described
