"""Reaching into memory from kernels: a record of an array, given where the array lies.

A kernel that is handed dozens of arrays spends its time passing them on. So kernels are given one CONTEXT that says
where every array lies; whoever fills it in keeps the arrays alive for as long as the call lasts.
"""

from typing import Any

from numba import njit, types
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array

from understudy.sim.kernels.angles import cosine_and_sine
from understudy.sim.kernels.dtypes import CLASS, DISC, MOVE, OBJECT, PULL, PUSH, ROBOT, SEGMENT, TYPE, WORK


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


@njit(error_model="numpy", forceinline=True)
def robot_at(c: Any, row: int) -> Any:
    """ROBOT `row`."""
    return at(c.robots, row, ROBOT)


@njit(error_model="numpy", forceinline=True)
def face(robot: Any) -> None:
    """Have the cosine and sine of a robot's heading at hand: most drive straight on, or stand."""
    if robot.aim != robot.heading:
        robot.aim = robot.heading
        robot.cosine, robot.sine = cosine_and_sine(robot.heading)


@njit(error_model="numpy", forceinline=True)
def type_at(c: Any, index: int) -> Any:
    """TYPE `index`."""
    return at(c.types, index, TYPE)


@njit(error_model="numpy", forceinline=True)
def class_at(c: Any, index: int) -> Any:
    """CLASS `index`."""
    return at(c.classes, index, CLASS)


@njit(error_model="numpy", forceinline=True)
def object_at(c: Any, world: int, slot: int) -> Any:
    """The OBJECT in a slot of a world."""
    return at(c.objects, world * c.object_count + slot, OBJECT)


@njit(error_model="numpy", forceinline=True)
def disc_at(c: Any, world: int, index: int) -> Any:
    """DISC `index` of a world."""
    return at(c.discs, world * c.disc_count + index, DISC)


@njit(error_model="numpy", forceinline=True)
def segment_at(c: Any, world: int, index: int) -> Any:
    """SEGMENT `index` of a world."""
    return at(c.segments, world * c.segment_count + index, SEGMENT)


@njit(error_model="numpy", forceinline=True)
def move_at(c: Any, world: int, row: int) -> Any:
    """The MOVE of a robot; there is room for those of one world."""
    return at(c.moves, row - world * c.count, MOVE)


@njit(error_model="numpy", forceinline=True)
def work_at(c: Any, index: int) -> Any:
    """The WORK of a robot, counted within its world."""
    return at(c.works, index, WORK)


@njit(error_model="numpy", forceinline=True)
def push_at(c: Any, slot: int) -> Any:
    """The PUSH of the object in a slot."""
    return at(c.pushes, slot, PUSH)


@njit(error_model="numpy", forceinline=True)
def pull_at(c: Any, slot: int) -> Any:
    """The PULL of the object in a slot."""
    return at(c.pulls, slot, PULL)


def _index(typing: Any, address: Any, index: Any) -> Any:
    """Number `index` of the array of whole numbers, 32 bits wide, that lies at an address."""

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        size = context.get_constant(types.intp, 4)
        place = builder.add(args[0], builder.mul(args[1], size))
        narrow = context.get_value_type(types.int32)
        found = builder.load(builder.inttoptr(place, narrow.as_pointer()))
        return builder.sext(found, context.get_value_type(types.int64))

    return types.int64(types.int64, types.int64), build


index_at: Any = intrinsic(_index)
"""index_at(address, index): that number, 64 bits wide as all others in kernels."""


def _array(typing: Any, address: Any, count: Any, dtype: Any) -> Any:
    """The array of `count` records of this dtype that lies at an address."""
    kind = types.Array(dtype.dtype, 1, "C")

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        made = make_array(kind)(context, builder)  # type: ignore[no-untyped-call]
        size = context.get_constant(types.intp, context.get_abi_sizeof(context.get_data_type(kind.dtype)))
        data = builder.inttoptr(args[0], made.data.type)
        shape = {"shape": [args[1]], "strides": [size]}
        populate_array(made, data=data, itemsize=size, meminfo=None, **shape)  # type: ignore[no-untyped-call]
        return made._getvalue()

    return kind(types.int64, types.int64, dtype), build


array_at: Any = intrinsic(_array)
"""array_at(address, count, dtype): the array of so many records of this dtype that lies there."""
