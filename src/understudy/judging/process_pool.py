"""Work that is shared among processes of this computer, which compute in one thread each."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from contextlib import closing, contextmanager
from itertools import chain, islice
from threading import Thread
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor

Result = TypeVar("Result")

STARTUP_S = 4.0
"""The time that processes must save to be started, s: each imports what this one has, and loads compiled kernels."""
LOADING_S = 2.0
"""The time of a first call that may go into loading compiled kernels, and so tells nothing of later ones, s."""


def count_cores() -> int:
    """Count the processor cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def saves_time(left_s: float, jobs: int) -> bool:
    """Return whether work that takes a time here, s, takes less with so many processes, their start included."""
    return jobs > 1 and left_s * (1 - 1 / jobs) > STARTUP_S


def share_calls(
    calls: Iterable[Callable[[], Result]], *, jobs: int, estimate_left_s: Callable[[], float]
) -> Generator[tuple[int, Future[Result]], None, None]:
    """Run functions here while what is left is short, and then in processes; yield each as it ends.

    There are never more processes than cores.

    Parameters
    ----------
    calls
        The functions, as `run_calls` takes them.
    jobs
        The largest number of processes.
    estimate_left_s
        Estimates the time that the functions that are left would take here, s; called for each one before it runs, when
        the caller of this function has seen all results before.

    Yields
    ------
    tuple[int, Future[Result]]
        The number of a function, from 0, and what returns its result or raises its error.
    """
    jobs, left = min(jobs, count_cores()), iter(calls)
    for number, call in enumerate(left):
        if saves_time(estimate_left_s(), jobs):
            with closing(run_calls(chain([call], left), jobs=jobs)) as completed:
                for after, future in completed:
                    yield number + after, future
            return
        yield number, _finish(call)


def run_calls(
    calls: Iterable[Callable[[], Result]], *, jobs: int
) -> Generator[tuple[int, Future[Result]], None, None]:
    """Run functions in processes, and yield each as it ends; with a single job, here and one after the other.

    On an error of the caller the processes are ended, and what has not started is cancelled.

    Parameters
    ----------
    calls
        The functions. For several jobs each can be sent to another process. The next one is taken only when a process
        will soon be free, so that it may depend on former results.
    jobs
        The number of processes.

    Yields
    ------
    tuple[int, Future[Result]]
        The number of a function, from 0, and what returns its result or raises its error.
    """
    if jobs <= 1:
        for number, call in enumerate(calls):
            yield number, _finish(call)
        return
    with open_process_pool(jobs) as pool:
        left, begun = enumerate(calls), dict[Future[Result], int]()
        while True:
            for number, call in islice(left, jobs + 1 - len(begun)):
                begun[_submit(pool, call)] = number
            if not begun:
                return
            for future in wait(begun, return_when=FIRST_COMPLETED).done:
                yield begun.pop(future), future


def _finish(call: Callable[[], Result]) -> Future[Result]:
    """Run a function here."""
    future = Future[Result]()
    try:
        future.set_result(call())
    except Exception as error:
        future.set_exception(error)
    return future


def _submit(pool: ProcessPoolExecutor, call: Callable[[], Result]) -> Future[Result]:
    """Let a pool run a function; if a process of the pool has ended, its future has that error."""
    try:
        return pool.submit(call)
    except BrokenExecutor as error:
        future = Future[Result]()
        future.set_exception(error)
        return future


@contextmanager
def open_process_pool(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of single-threaded processes; on an error, they are ended, and what has not started is cancelled."""
    from concurrent.futures import ProcessPoolExecutor  # not everywhere are there processes
    from multiprocessing import get_context

    alone = {"NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    with _environment(alone):
        pool = ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=_begin_worker)
        try:
            yield pool
        except BaseException:
            processes = list(
                (getattr(pool, "_processes", None) or {}).values()
            )  # a pool shut down forgets them
            pool.shutdown(wait=False, cancel_futures=True)
            for process in processes:
                process.terminate()
            raise
        pool.shutdown()


def _begin_worker() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this process when its parent has ended, even if that was killed: nothing else would tell."""
    from multiprocessing import parent_process

    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _environment(added: Mapping[str, str]) -> Iterator[None]:
    before = {name: os.environ.get(name) for name in added}
    os.environ.update(added)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
