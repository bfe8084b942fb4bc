"""A barrier at which threads wait for each other inside kernels, many times a second, without Python."""

import sys
from typing import Any

from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

SPINS = 2000  # then it lets others run, since the one it waits for may need the core
GENERATION = 8  # so far apart that counting and waiting do not share a cache line

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


@njit(error_model="numpy")
def wait(barrier: Any, parts: int) -> None:
    """Wait until all parts have come here; `barrier` is zeros, int64 [16], shared by them."""
    if parts == 1:
        return
    generation = _add(barrier, GENERATION, 0)
    if _add(barrier, 0, 1) == parts - 1:
        _add(barrier, 0, -parts)
        _add(barrier, GENERATION, 1)
        return
    spins = 0
    while _add(barrier, GENERATION, 0) == generation:
        spins += 1
        if spins > SPINS:
            _let_others_run()
