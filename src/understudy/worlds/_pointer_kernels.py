"""Reaching into memory from kernels: a record of an array, given where the array lies.

A kernel that is handed dozens of arrays spends its time passing them on. So kernels are given one CONTEXT that says
where every array lies; whoever fills it in keeps the arrays alive for as long as the call lasts.
"""

from typing import Any

from numba import (  # type: ignore[attr-defined]
    carray,
    njit,
    types,
)
from numba.extending import intrinsic

from understudy.worlds.records import CLASS, DISC, MOVE, OBJECT, PUSH, ROBOT, SEGMENT, TYPE


def _record(typing: Any, address: Any, index: Any, dtype: Any) -> Any:
    """Record `index` of the array of this dtype that lies at an address; nothing checks the bounds."""
    record = dtype.dtype

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        size = context.get_constant(types.intp, record.size)
        place = builder.add(args[0], builder.mul(args[1], size))
        return builder.inttoptr(place, context.get_value_type(record))

    return record(types.int64, types.int64, dtype), build


at: Any = intrinsic(_record)
"""at(address, index, dtype): record `index` of the array of this dtype that lies there."""


@njit(error_model="numpy")
def robot_at(c: Any, row: int) -> Any:
    """ROBOT `row`."""
    return at(c.robots, row, ROBOT)


@njit(error_model="numpy")
def type_at(c: Any, index: int) -> Any:
    """TYPE `index`."""
    return at(c.types, index, TYPE)


@njit(error_model="numpy")
def class_at(c: Any, index: int) -> Any:
    """CLASS `index`."""
    return at(c.classes, index, CLASS)


@njit(error_model="numpy")
def object_at(c: Any, world: int, slot: int) -> Any:
    """The OBJECT in a slot of a world."""
    return at(c.objects, world * c.object_count + slot, OBJECT)


@njit(error_model="numpy")
def disc_at(c: Any, world: int, index: int) -> Any:
    """DISC `index` of a world."""
    return at(c.discs, world * c.disc_count + index, DISC)


@njit(error_model="numpy")
def segment_at(c: Any, world: int, index: int) -> Any:
    """SEGMENT `index` of a world."""
    return at(c.segments, world * c.segment_count + index, SEGMENT)


@njit(error_model="numpy")
def move_at(c: Any, world: int, row: int) -> Any:
    """The MOVE of a robot; there is room for those of one world."""
    return at(c.moves, row - world * c.count, MOVE)


@njit(error_model="numpy")
def push_at(c: Any, slot: int) -> Any:
    """The PUSH of the object in a slot."""
    return at(c.pushes, slot, PUSH)


def _void(typing: Any, address: Any) -> Any:
    """An address as a pointer, for `carray`."""

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.inttoptr(args[0], context.get_value_type(types.voidptr))

    return types.voidptr(types.int64), build


_pointer: Any = intrinsic(_void)


@njit(error_model="numpy")
def array_at(address: int, count: int, dtype: Any) -> Any:
    """The array of so many records of this dtype that lies at an address."""
    return carray(_pointer(address), count, dtype)
