"""Switch kernels of a running process from plain Python to compiled code, which another process compiles.

A thread loads what is in the files of compiled kernels, and asks a child process for what is not.
"""

from __future__ import annotations

import atexit
import logging
import os
import pickle
import queue
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Hashable
from contextlib import suppress
from time import perf_counter
from typing import Any, NamedTuple

from understudy.jit.argument_types import describe_types, make_example
from understudy.jit.decorators import Kernel
from understudy.jit.settings import COMPILED, MODE

PATIENCE_S = 0.25
"""The time that a kernel runs as plain Python before compiled code of it is wanted, so that short work loads none."""

SWITCH_S = 0.0002
"""The time in s after which a busy thread lets the loader continue, which reads hundreds of files of Numba's. With
Python's own 0.005 it would take twenty times as long as alone."""


class Request(NamedTuple):
    """The wish for compiled code of a kernel for arguments of described types, and the answer to it."""

    switch: KernelSwitch
    types: Any
    answer: bytes | str | None = None
    """The compiled code; or why there is none; or None if it was not asked for yet."""


class KernelSwitch:
    """Run a kernel as plain Python, and want compiled code of it when that has taken long enough."""

    def __init__(self, kernel: Kernel[..., Any]) -> None:
        self.kernel = kernel
        self.general: dict[Hashable, Callable[..., Any]] = {}
        """Compiled code for more general arguments, by the types of arguments for which there is none yet."""
        self._spent_s = 0.0

    def __call__(self, *args: Any) -> Any:
        """Run the kernel as plain Python, or with arguments for which it is compiled."""
        if self.general and (general := self.general.get(describe_types(args))):
            return general(*self.kernel.generalize(args))
        begun = perf_counter()
        result = self.kernel.run_plain(*args)
        self._spent_s += perf_counter() - begun
        if self._spent_s > PATIENCE_S:
            _start_loader().want(self, describe_types(args))
        return result


_switched: dict[Kernel[..., Any], set[Hashable]] = {}
"""The types of arguments for which compiled code of a kernel is there."""


def is_switched(kernel: Kernel[..., Any], args: Any) -> bool:
    """Return whether compiled code of a kernel is there for arguments of these types."""
    return kernel in _switched and describe_types(args) in _switched[kernel]


def is_compiling() -> bool:
    """Return whether kernels are being compiled, so that this process runs them as plain Python until then."""
    compiler = None if _the_loader is None else _the_loader.compiler
    return compiler is not None and compiler.is_busy


class KernelLoader(threading.Thread):
    """A thread that loads compiled kernels, and has them compiled."""

    def __init__(self) -> None:
        super().__init__(name="kernel loader", daemon=True)
        self.requests: queue.SimpleQueue[Request | None] = queue.SimpleQueue()
        self.compiler: KernelCompiler | None = None
        self._wanted: set[tuple[KernelSwitch, Hashable]] = set()

    def want(self, switch: KernelSwitch, types: Hashable) -> None:
        """Request compiled code of a kernel for arguments of these types, once."""
        if (switch, types) not in self._wanted:
            self._wanted.add((switch, types))
            self.requests.put(Request(switch, types))

    def run(self) -> None:
        """Serve requests until the process ends."""
        while (request := self.requests.get()) is not None:
            before = sys.getswitchinterval()
            sys.setswitchinterval(SWITCH_S)
            try:
                self._serve(request)
            except Exception as error:
                _warn(f"{type(error).__name__}: {error}")
            finally:
                sys.setswitchinterval(before)

    def stop(self) -> None:
        """End after what is being done, because a process must not end while its thread imports."""
        self.requests.put(None)
        self.join()
        if self.compiler is not None:
            self.compiler.close()

    def _serve(self, request: Request) -> None:
        """Load compiled code, or ask for it."""
        from understudy.jit.dispatchers import infer_signature, make_dispatcher
        from understudy.jit.stored import KernelMissing

        switch, types, answer = request
        if isinstance(answer, str):
            _warn(answer)
            return
        kernel = switch.kernel
        dispatcher = make_dispatcher(kernel.function)
        dispatcher._cache.compiles = False
        dispatcher._compile_for_args = lambda *args: switch
        signature = infer_signature(dispatcher, types)
        if answer is not None:
            dispatcher._cache.contents[signature] = answer
        try:
            dispatcher.compile(signature)
        except KernelMissing:
            if answer is not None:
                raise
            self._load_general(request, dispatcher)
            if self.compiler is None or not self.compiler.runs:
                self.compiler = KernelCompiler(self.requests.put)
            self.compiler.ask(request)
        else:
            _switched.setdefault(kernel, set()).add(types)
            kernel.run = dispatcher

    def _load_general(self, request: Request, dispatcher: Any) -> None:
        """Load compiled code for more general arguments, if it is there."""
        from understudy.jit.dispatchers import infer_signature
        from understudy.jit.stored import KernelMissing

        switch, types = request.switch, request.types
        general = describe_types(switch.kernel.generalize(make_example(types)))
        with suppress(KernelMissing):
            dispatcher.compile(infer_signature(dispatcher, general))
            switch.general[types] = dispatcher
            _switched.setdefault(switch.kernel, set()).add(types)


class KernelCompiler:
    """A child process that compiles kernels into files, one after the other."""

    def __init__(self, report: Callable[[Request], None]) -> None:
        self.runs = True
        self._report = report
        self._asked: deque[Request] = deque()
        self._process = subprocess.Popen(
            [sys.executable, "-m", "understudy.jit.compiler_process"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, MODE: COMPILED, "PYTHONPATH": os.pathsep.join(sys.path)},
        )
        self._requests: Any = self._process.stdin
        self._answers: Any = self._process.stdout
        self._listener = threading.Thread(target=self._listen, name="kernel compiler", daemon=True)
        self._listener.start()

    @property
    def is_busy(self) -> bool:
        """Whether a kernel that was asked for is not compiled yet."""
        return self.runs and bool(self._asked)

    def ask(self, request: Request) -> None:
        """Ask for compiled code."""
        self._asked.append(request)
        function = request.switch.kernel.function
        try:
            pickle.dump((function.__module__, function.__qualname__, request.types), self._requests)
            self._requests.flush()
        except (OSError, ValueError):  # the process has ended, and `_listen` may have ended, too
            self.runs = False
            self._report_rest()

    def close(self) -> None:
        """Ask for no more; what is being compiled is still finished and written, even after this process has ended."""
        with suppress(OSError):
            self._requests.close()

    def wait(self) -> None:
        """Wait until the process has ended."""
        self._listener.join()

    def _listen(self) -> None:
        """Report each answer; report for all that is left when the process ends that there is none."""
        try:
            while True:
                answer = pickle.load(self._answers)
                self._report(self._asked.popleft()._replace(answer=answer))
        except (EOFError, OSError, pickle.UnpicklingError):
            self.runs = False
            self.close()
            self._answers.close()
            self._process.wait()
            self._report_rest()

    def _report_rest(self) -> None:
        """Report for all that is left that there is no compiled code."""
        with suppress(IndexError):  # two threads may do this
            while True:
                self._report(
                    self._asked.popleft()._replace(answer="the process that compiles them has ended")
                )


_the_loader: KernelLoader | None = None
_starting = threading.Lock()


def _start_loader() -> KernelLoader:
    """Return the loader of this process, started."""
    global _the_loader
    with _starting:
        if _the_loader is None:
            _the_loader = KernelLoader()
            _the_loader.start()
            atexit.register(_the_loader.stop)
        return _the_loader


def _forget_loader() -> None:
    """Let a process that was forked start a loader of its own: threads are not copied."""
    global _the_loader, _starting
    _the_loader, _starting = None, threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_loader)


def _warn(problem: str) -> None:
    """Warn that kernels stay uncompiled."""
    logging.getLogger(__name__).warning("Kernels run uncompiled, which is slower: %s", problem)
