"""Functions with which threads in kernels share the robots of one world and wait for each other, without Python."""

from typing import Any

from understudy.jit.decorators import add_at_once, inlined, inner, let_others_run, read_now

BLOCK = 32  # robots that are taken together
SPINS = 2000
APART = 8  # so far apart that what is counted does not share a cache line
GENERATION, CLAIMED = APART, 2 * APART


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
