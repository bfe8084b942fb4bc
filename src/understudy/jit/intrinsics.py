"""Functions that kernels call and Numba compiles specially: twins of the functions in `plain`.

Numba passes a tuple as all numbers in it, some 300 for the arrays of a world, at every call of every kernel. Most of
the code that it makes would do nothing else. So kernels pass a reference to the tuple.
"""

import sys
from hashlib import sha256
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.imputils import impl_ret_borrowed
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, lower_getattr_generic, register_model

from understudy.jit.plain import add_at_once, blank, int64, let_others_run, prange, read_now, refer_to, uint64


class Reference(types.Type):
    """The type of a reference to a named tuple."""

    def __init__(self, referred: types.NamedTuple) -> None:
        self.referred = referred
        # Numba names compiled functions by the names of their types: no two references may share one.
        super().__init__(name=f"Reference({sha256(referred.name.encode()).hexdigest()[:16]})")

    @property
    def key(self) -> Any:
        """Return what distinguishes this type from others."""
        return self.referred


@register_model(Reference)
class ReferenceModel(models.PrimitiveModel):
    """How a reference is stored: as a pointer."""

    def __init__(self, manager: Any, of: Reference) -> None:
        super().__init__(manager, of, ir.PointerType(manager.lookup(of.referred).get_value_type()))


@infer_getattr
class ReferenceAttributes(AttributeTemplate):
    """The types of a reference's attributes."""

    key = Reference

    def generic_resolve(self, of: Reference, name: str) -> Any:  # type: ignore[override]
        """Return the type of an attribute, or None if there is none of this name."""
        fields = of.referred.fields
        return of.referred[fields.index(name)] if name in fields else None


@lower_getattr_generic(Reference)
def load_attribute(context: Any, builder: Any, of: Reference, reference: Any, name: str) -> Any:
    """Emit code that loads an attribute."""
    index = of.referred.fields.index(name)
    loaded = builder.load(cgutils.gep_inbounds(builder, reference, 0, index))
    return impl_ret_borrowed(context, builder, of.referred[index], loaded)


@intrinsic
def emit_reference(typing: Any, values: Any) -> Any:
    """Return a reference to a named tuple, valid until the calling kernel returns."""

    def store(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return cgutils.alloca_once_value(builder, arguments[0])

    return Reference(values)(values), store


@numba.njit
def make_zeroed_records(count: Any, dtype: Any) -> Any:
    """Make an array of `count` records of a type, all zeros."""
    return np.zeros(count, dtype)


@intrinsic
def emit_atomic_add(typing: Any, array: Any, index: Any, value: Any) -> Any:
    """Add to an element of an array, atomically, and return what it was before."""

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = signature.args[0]
        numba_array = context.make_array(kind)(context, builder, args[0])
        place = cgutils.get_item_pointer(context, builder, kind, numba_array, [args[1]])
        return builder.atomic_rmw("add", place, args[2], "seq_cst")

    return types.int64(array, types.intp, types.int64), build


@intrinsic
def emit_atomic_load(typing: Any, array: Any, index: Any) -> Any:
    """Return an element of an array as it is now, whichever thread wrote it."""

    def build(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = signature.args[0]
        numba_array = context.make_array(kind)(context, builder, args[0])
        place = cgutils.get_item_pointer(context, builder, kind, numba_array, [args[1]])
        return builder.load_atomic(place, "acquire", 8)

    return types.int64(array, types.intp), build


yield_thread = types.ExternalFunction(
    "SwitchToThread" if sys.platform == "win32" else "sched_yield", types.int32()
)

TWINS: dict[Any, Any] = {
    int64: numba.int64,
    uint64: numba.uint64,
    prange: numba.prange,
    blank: make_zeroed_records,
    refer_to: emit_reference,
    add_at_once: emit_atomic_add,
    read_now: emit_atomic_load,
    let_others_run: yield_thread,
}
"""The function that Numba compiles in place of each plain function."""
