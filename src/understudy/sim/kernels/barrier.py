"""Threads that work on one world inside kernels: how they share its robots, and wait for each other, without Python."""

import sys
from typing import Any

from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

BLOCK = 32  # robots that are taken together
SPINS = 2000
APART = 8  # so far apart that what is counted does not share a cache line
GENERATION, CLAIMED = APART, 2 * APART

_let_others_run = types.ExternalFunction(
    "SwitchToThread" if sys.platform == "win32" else "sched_yield", types.int32()
)


def _at_once(typing: Any, array: Any, index: Any, value: Any) -> Any:
    """Add to an element of an array at once for all threads; what it was before."""

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = signature.args[0]
        made = context.make_array(kind)(context, builder, args[0])
        place = cgutils.get_item_pointer(context, builder, kind, made, [args[1]])  # type: ignore[no-untyped-call]
        return builder.atomic_rmw("add", place, args[2], "seq_cst")

    return types.int64(array, types.intp, types.int64), build


_add: Any = intrinsic(_at_once)


def _now(typing: Any, array: Any, index: Any) -> Any:
    """An element of an array as it is now, whichever thread wrote it."""

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = signature.args[0]
        made = context.make_array(kind)(context, builder, args[0])
        place = cgutils.get_item_pointer(context, builder, kind, made, [args[1]])  # type: ignore[no-untyped-call]
        return builder.load_atomic(place, "acquire", 8)

    return types.int64(array, types.intp), build


_read: Any = intrinsic(_now)


@njit(error_model="numpy")
def wait(crew: Any) -> None:
    """Wait until all of a crew (barrier, part, parts) have come here.

    `barrier` is zeros, shared by them (`contexts.shared`); this thread is number `part` of `parts`.
    """
    barrier, _, parts = crew
    if parts == 1:
        return
    generation = _read(barrier, GENERATION)
    if _add(barrier, 0, 1) == parts - 1:
        _add(barrier, 0, -parts)
        for part in range(parts):
            barrier[CLAIMED + APART * part] = 0
        _add(barrier, GENERATION, 1)
        return
    spins = 0
    while _read(barrier, GENERATION) == generation:
        spins += 1
        if spins > SPINS:
            _let_others_run()


@njit(error_model="numpy", forceinline=True)
def claim(crew: Any, blocks: int, before: int) -> Any:
    """The next block that is this thread's, after the one `before` (at first -1); -1 where all are taken.

    A thread begins with its own share of the blocks, and then helps the others with theirs. After `wait` all are free.
    """
    barrier, part, parts = crew
    if parts == 1:
        return before + 1 if before + 1 < blocks else -1
    for turn in range(parts):
        of = (part + turn) % parts
        block = blocks * of // parts + _add(barrier, CLAIMED + APART * of, 1)
        if block < blocks * (of + 1) // parts:
            return block
    return -1


@njit(error_model="numpy", forceinline=True)
def each(crew: Any, c: Any, world: int, work: Any) -> None:
    """Have `work(c, row, world)` done for all robots of a world."""
    first, blocks = world * c.count, (c.count + BLOCK - 1) // BLOCK
    block = claim(crew, blocks, -1)
    while block >= 0:
        for row in range(first + block * BLOCK, first + min(c.count, (block + 1) * BLOCK)):
            work(c, row, world)
        block = claim(crew, blocks, block)
