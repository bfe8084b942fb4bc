"""Compile kernels that another process asks for on standard input: `python -m understudy.jit.compiler_process`."""

from __future__ import annotations

import pickle
import sys
from contextlib import suppress
from functools import reduce
from importlib import import_module
from typing import Any, BinaryIO

from understudy.jit.settings import pause_garbage_collection


def compile_requests(requests: BinaryIO, answers: BinaryIO) -> None:
    """Compile what is asked for until there are no more requests; answer with compiled code, or why there is none."""
    while True:
        try:
            module, name, types = pickle.load(requests)
        except EOFError:
            return
        answer: bytes | str
        try:
            answer = compile_kernel(reduce(getattr, name.split("."), import_module(module)), types)
        except Exception as error:
            answer = f"{name}: {type(error).__name__}: {' '.join(str(error).split())}"
        pickle.dump(answer, answers)
        answers.flush()


def compile_kernel(kernel: Any, types: Any) -> bytes:
    """Compile a kernel for arguments of these types, into a file unless there is one; return its content."""
    from understudy.jit.dispatchers import infer_signature, make_dispatcher

    dispatcher = make_dispatcher(kernel.function)
    signature = infer_signature(dispatcher, types)
    with pause_garbage_collection():
        dispatcher.compile(signature)
    content: bytes = dispatcher._cache.contents[signature]
    return content


if __name__ == "__main__":
    with suppress(BrokenPipeError, KeyboardInterrupt):  # the process that asked has ended
        compile_requests(sys.stdin.buffer, sys.stdout.buffer)
