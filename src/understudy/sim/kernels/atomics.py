"""What threads inside kernels need of the processor: to change a number at once for all, and to see it as it is now."""

import sys
from typing import Any

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

let_others_run = types.ExternalFunction(
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


add_at_once: Any = intrinsic(_at_once)


def _now(typing: Any, array: Any, index: Any) -> Any:
    """An element of an array as it is now, whichever thread wrote it."""

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = signature.args[0]
        made = context.make_array(kind)(context, builder, args[0])
        place = cgutils.get_item_pointer(context, builder, kind, made, [args[1]])  # type: ignore[no-untyped-call]
        return builder.load_atomic(place, "acquire", 8)

    return types.int64(array, types.intp), build


read_now: Any = intrinsic(_now)
