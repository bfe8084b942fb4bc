"""Compilation of kernels that only other kernels call: into LLVM code, which becomes machine code in their callers.

By default Numba optimizes each kernel and makes machine code of it, together with all kernels that it calls, before
it does the same for the caller. That takes longer than everything else that it does.
"""

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder


class LinkedLibrary(JITCodeLibrary):
    """LLVM code that is linked into the code of callers."""

    @property
    def codegen(self) -> Any:
        """Return this library itself: Numba calls `set_env` on it."""
        return self

    def set_env(self, name: str, env: Any) -> None:
        """Do nothing, since only machine code has an environment."""

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0, which stands for a function that Python cannot call."""
        self._ensure_finalized()
        return 0

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True


class LinkedCompiler(CompilerBase):
    """Numba's compiler, with a `LinkedLibrary` as its result."""

    def define_pipelines(self) -> list[Any]:
        """Return Numba's own passes."""
        state: Any = self.state
        library_class: Any = LinkedLibrary
        state.library = library_class(state.targetctx.codegen(), state.func_id.func_qualname)
        passes: Any = DefaultPassBuilder.define_nopython_pipeline
        return [passes(state)]


FOR_LINKED: dict[str, Any] = {
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "pipeline_class": LinkedCompiler,
}
"""The options of Numba for kernels that only other kernels call."""
