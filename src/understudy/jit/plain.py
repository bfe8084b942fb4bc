"""Arrays for kernels that run as plain Python: records with attributes, Python's own numbers, and bounds checks.

NumPy's arrays do not fit: their records have no attributes, their numbers are slow one by one and do not wrap or
divide as compiled ones do, and an index below 0 counts from the end.
"""

import ctypes
from functools import lru_cache
from typing import Any

import numpy as np

NUMBERS: dict[str, Any] = {
    "float64": ctypes.c_double,
    "int64": ctypes.c_int64,
    "int32": ctypes.c_int32,
    "uint32": ctypes.c_uint32,
    "bool": ctypes.c_bool,
}


COMPOUND = (tuple, slice)
"""The types of indices that select several dimensions or elements."""


class Plain:
    """An array of numbers or records that shares its memory with a NumPy array of the same shape.

    An element is a Python number, or a record whose fields are attributes; writing to these changes the array.
    """

    __slots__ = ("_array", "_items", "shape")

    def __init__(self, array: Any) -> None:
        self._array = array
        self.shape: tuple[int, ...] = array.shape
        self._items: Any = None
        if array.ndim == 1 and array.flags.c_contiguous:
            self._items = (element_type(array.dtype) * array.size).from_address(array.ctypes.data)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, index: Any) -> Any:
        if self._items is not None and type(index) not in COMPOUND:
            if index < 0:
                raise IndexError(f"index {index} is out of bounds for an array of shape {self.shape}")
            return self._items[index]
        element = self._array[self._allowed(index)]
        return Plain(element) if isinstance(element, np.ndarray) else element.item()

    def __setitem__(self, index: Any, value: Any) -> None:
        if self._items is not None and type(index) not in COMPOUND:
            if index < 0:
                raise IndexError(f"index {index} is out of bounds for an array of shape {self.shape}")
            self._items[index] = value
        else:
            self._array[self._allowed(index)] = value

    def __eq__(self, other: object) -> bool:
        """Refuse to compare arrays, which Python would do by identity."""
        raise TypeError("kernels compare elements, not arrays")

    __hash__ = None  # type: ignore[assignment]

    def _allowed(self, index: Any) -> Any:
        """Return an index unchanged; raise IndexError if any part of it is below 0."""
        for part in index if isinstance(index, tuple) else (index,):
            for bound in (part.start, part.stop) if isinstance(part, slice) else (part,):
                if bound is not None and bound < 0:
                    raise IndexError(f"index {index} is out of bounds for an array of shape {self.shape}")
        return index


@lru_cache
def element_type(dtype: np.dtype[Any]) -> Any:
    """Make the C type that has the same layout in memory as an element of an array."""
    if dtype.subdtype is not None:
        of, shape = dtype.subdtype
        return element_type(of) * shape[0]
    if dtype.fields is None:
        return NUMBERS[dtype.name]
    fields = [(name, element_type(dtype.fields[name][0])) for name in dtype.names or ()]
    structure = type("Record", (ctypes.Structure,), {"_fields_": fields})
    if ctypes.sizeof(structure) != dtype.itemsize or any(
        getattr(structure, name).offset != dtype.fields[name][1] for name, _ in fields
    ):
        raise TypeError(f"records of {dtype} do not lie in memory as those of C do")
    return structure


def make_plain(value: Any) -> Any:
    """Convert a value for kernels in plain Python: arrays in it become `Plain`, and a single record a copy of it."""
    if isinstance(value, np.ndarray):
        return Plain(value)
    if isinstance(value, np.void):
        return element_type(value.dtype).from_buffer_copy(value.tobytes())
    if isinstance(value, tuple):
        parts = map(make_plain, value)
        return type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return value.item() if isinstance(value, np.generic) else value


# What follows has a compiled twin of another meaning for Numba (see `intrinsics`).


def int64(number: Any) -> int:
    """Return a number as a whole number of 64 bits."""
    return int(number)


def uint64(word: Any) -> int:
    """Return the lowest 64 bits of a whole number, because sums and products of 64-bit words wrap."""
    return int(word) & 0xFFFFFFFFFFFFFFFF


def prange(*bounds: int) -> range:
    """Return a range, whose steps several threads share once compiled."""
    return range(*bounds)


def blank(count: int, dtype: Any) -> Any:
    """Make an array of `count` records of a type, all zeros."""
    return Plain(np.zeros(count, dtype))


def refer_to(values: Any) -> Any:
    """Return a named tuple; compiled, a reference to it."""
    return values


def add_at_once(array: Any, index: int, value: int) -> Any:
    """Add to an element of an array, atomically, and return what it was before."""
    array[index] += value
    return array[index] - value


def read_now(array: Any, index: int) -> Any:
    """Return an element of an array as it is in memory now, whichever thread wrote it."""
    return array[index]


def let_others_run() -> None:
    """Give the processor to another thread; plain kernels run in one thread."""
