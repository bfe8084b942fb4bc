"""Work beside the world of a session, so that the world goes on while it is done: in threads, where there are any."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass
from threading import Thread
from typing import ParamSpec, TypeAlias, TypeVar

from understudy.errors import SessionError

P = ParamSpec("P")
T = TypeVar("T")
MOST = 32
"""The number of actions that are done at the same time."""
NO_RUNS = "worlds cannot be run beside this one here"

Begin: TypeAlias = Callable[[Callable[[], None]], None]
"""A function that begins some work, which may go on in another thread."""


@dataclass(frozen=True, slots=True)
class Beside:
    """Where the work beside the world of a session is done.

    Attributes
    ----------
    in_turn
        Runs what takes longer than a tick may, one after the other.
    at_once
        Runs actions, several at the same time.
    begin
        Begins a run that may take minutes; None where the world would have to wait for it.
    has_processes
        Whether other processes can be started, too.
    """

    in_turn: Executor
    at_once: Executor
    begin: Begin | None
    has_processes: bool = True

    def check_runs(self) -> None:
        """Raise SessionError where the world would have to wait for a run that may take minutes."""
        if self.begin is None:
            raise SessionError(NO_RUNS)

    def begin_run(self, run: Callable[[], None]) -> None:
        """Begin a run that may take minutes; SessionError where the world would have to wait for it."""
        self.check_runs()
        if self.begin is not None:
            self.begin(run)

    def close(self) -> None:
        """Cancel what waits for its turn."""
        self.in_turn.shutdown(wait=False, cancel_futures=True)


def begin_in_thread(work: Callable[[], None]) -> None:
    """Begin some work in a thread of its own, which ends with the program."""
    Thread(target=work, daemon=True).start()


def make_threads() -> Beside:
    """Make threads that do the work beside a session; none is started before it has something to do."""
    at_once = ThreadPoolExecutor(MOST, thread_name_prefix="action")
    return Beside(ThreadPoolExecutor(1), at_once, begin_in_thread)


class ImmediateExecutor(Executor):
    """Does each piece of work at once, where there are no threads."""

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Do the work, and return its result or its error."""
        future = Future[T]()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


def make_immediate() -> Beside:
    """Make what does short work at once, and refuses long runs: for a program without threads and processes."""
    executor = ImmediateExecutor()
    return Beside(executor, executor, None, has_processes=False)
