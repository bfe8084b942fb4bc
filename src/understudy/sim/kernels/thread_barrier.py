"""Functions with which threads in kernels share the robots of one world and wait for each other, without Python."""

import sys
from typing import Any

from understudy._jit_kernels import MODE, inlined, inner
from understudy.kernel_cache import PYTHON

BLOCK = 32  # robots that are taken together
SPINS = 2000
APART = 8  # so far apart that what is counted does not share a cache line
GENERATION, CLAIMED = APART, 2 * APART

if MODE == PYTHON:  # in which one thread does all

    def add_at_once(array: Any, index: int, value: int) -> Any:
        """Add to an element, and return what it was before."""
        array[index] += value
        return array[index] - value

    def read_now(array: Any, index: int) -> Any:
        """Return an element as it is in memory now."""
        return array[index]

    def let_others_run() -> None:
        """Do nothing: there is one thread."""

else:
    from numba import types
    from numba.core import cgutils
    from numba.extending import intrinsic

    let_others_run = types.ExternalFunction(  # type: ignore[assignment]
        "SwitchToThread" if sys.platform == "win32" else "sched_yield", types.int32()
    )

    @intrinsic
    def add_at_once(typing: Any, array: Any, index: Any, value: Any) -> Any:
        """Add to an element of an array, atomically, and return what it was before."""

        def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            kind = signature.args[0]
            made = context.make_array(kind)(context, builder, args[0])
            place = cgutils.get_item_pointer(context, builder, kind, made, [args[1]])  # type: ignore[no-untyped-call]
            return builder.atomic_rmw("add", place, args[2], "seq_cst")

        return types.int64(array, types.intp, types.int64), build

    @intrinsic
    def read_now(typing: Any, array: Any, index: Any) -> Any:
        """Return an element of an array as it is now, whichever thread wrote it."""

        def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            kind = signature.args[0]
            made = context.make_array(kind)(context, builder, args[0])
            place = cgutils.get_item_pointer(context, builder, kind, made, [args[1]])  # type: ignore[no-untyped-call]
            return builder.load_atomic(place, "acquire", 8)

        return types.int64(array, types.intp), build


@inner
def wait_at_barrier(crew: Any) -> None:
    """Wait until all threads of a crew (barrier, part, parts) have called this.

    `barrier` is a shared array of zeros (`make_thread_scratch` in `sim.kernel_context`); this thread is number `part`
    of `parts`.
    """
    barrier, _, parts = crew
    if parts == 1:
        return
    generation = read_now(barrier, GENERATION)
    if add_at_once(barrier, 0, 1) == parts - 1:
        add_at_once(barrier, 0, -parts)
        for part in range(parts):
            barrier[CLAIMED + APART * part] = 0
        add_at_once(barrier, GENERATION, 1)
        return
    spins = 0
    while read_now(barrier, GENERATION) == generation:
        spins += 1
        if spins > SPINS:
            let_others_run()


@inlined
def claim_block(crew: Any, blocks: int, before: int) -> Any:
    """Return the next block of robots for this thread, -1 if all are taken; `before` is its last block, at first -1.

    A thread takes the blocks of its own share first, then those that other threads have left. `wait_at_barrier` makes
    all blocks available again.
    """
    barrier, part, parts = crew
    if parts == 1:
        return before + 1 if before + 1 < blocks else -1
    for turn in range(parts):
        of = (part + turn) % parts
        block = blocks * of // parts + add_at_once(barrier, CLAIMED + APART * of, 1)
        if block < blocks * (of + 1) // parts:
            return block
    return -1


@inlined
def run_for_each_robot(crew: Any, c: Any, world: int, work: Any) -> None:
    """Call `work(c, row, world)` for all robots of a world, shared among the threads of a crew."""
    first, blocks = world * c.facts.count, (c.facts.count + BLOCK - 1) // BLOCK
    block = claim_block(crew, blocks, -1)
    while block >= 0:
        for row in range(first + block * BLOCK, first + min(c.facts.count, (block + 1) * BLOCK)):
            work(c, row, world)
        block = claim_block(crew, blocks, block)
