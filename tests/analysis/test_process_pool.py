"""Work that is shared among processes: each result with its call, and processes that end with the program."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from functools import partial
from math import sqrt
from pathlib import Path

import pytest
from tests.processes import end_with_tests

from understudy.judging import process_pool
from understudy.judging.process_pool import run_calls, share_calls

KILLED = """
import os, signal
from understudy.judging.process_pool import open_process_pool
with open_process_pool(2) as pool:
    print(pool.submit(os.getpid).result(), flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="kills with SIGKILL")
def test_workers_end_with_a_killed_program() -> None:
    """They have the standard output that is read here, so that it ends only with the last of them."""
    path = str(Path(__file__).parents[2] / "src")
    done = subprocess.run(
        end_with_tests([sys.executable, "-c", KILLED]),
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == -signal.SIGKILL, done.stderr
    assert int(done.stdout) > 0


@pytest.mark.parametrize("jobs", [1, 2])
def test_each_call_has_its_result_or_its_error(jobs: int) -> None:
    results = dict(run_calls([partial(sqrt, number) for number in (4.0, -1.0, 9.0)], jobs=jobs))
    assert (results[0].result(), results[2].result()) == (2.0, 3.0)
    with pytest.raises(ValueError, match="math domain error"):
        results[1].result()


@pytest.mark.parametrize(("jobs", "begun"), [(1, 1), (2, 3)])
def test_a_call_is_taken_when_a_process_will_be_free(jobs: int, begun: int) -> None:
    """In processes one more is begun than there are, so that none of them waits."""
    taken = 0

    def list_calls() -> Iterator[partial[float]]:
        nonlocal taken
        for number in range(10):
            taken += 1
            yield partial(sqrt, number)

    for ended, _ in enumerate(run_calls(list_calls(), jobs=jobs)):
        assert ended < taken <= min(10, ended + begun)


LEFT = [  # what each of six calls leaves to do, s, itself included; jobs, cores; the calls in processes
    ((0.0, 3.0, 2.0, 1.0, 0.5, 0.2), 8, 8, 0),
    ((0.0, 60.0, 50.0, 40.0, 30.0, 20.0), 8, 8, 5),
    ((0.0, 4.0, 3.0, 30.0, 20.0, 10.0), 2, 8, 3),  # a slow sort of calls comes late
    (
        (0.0, 7.9, 6.0, 5.0, 3.0, 2.0),
        2,
        8,
        0,
    ),  # two processes save half of it, which is less than their start
    ((0.0, 8.1, 6.0, 5.0, 3.0, 2.0), 2, 8, 5),
    ((0.0, 60.0, 50.0, 40.0, 30.0, 20.0), 8, 1, 0),
    ((0.0, 60.0, 50.0, 40.0, 30.0, 20.0), 1, 8, 0),
]


@pytest.mark.parametrize(("left_s", "jobs", "cores", "shared"), LEFT)
def test_calls_run_here_while_what_is_left_is_short(
    left_s: tuple[float, ...], jobs: int, cores: int, shared: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    sent = list[int]()

    def run_elsewhere(
        calls: Iterable[Callable[[], float]], *, jobs: int
    ) -> Iterator[tuple[int, Future[float]]]:
        sent.append(jobs)
        yield from run_calls(calls, jobs=1)
        sent.extend([jobs] * (shared - 1))

    monkeypatch.setattr(process_pool, "run_calls", run_elsewhere)
    monkeypatch.setattr(process_pool, "count_cores", lambda: cores)
    estimates, asked, seen = iter(left_s), list[int](), list[tuple[int, float]]()

    def estimate_left_s() -> float:
        asked.append(len(seen))
        return next(estimates)

    calls = [partial(sqrt, number * number) for number in range(6)]
    for number, future in share_calls(calls, jobs=jobs, estimate_left_s=estimate_left_s):
        seen.append((number, future.result()))
    assert seen == [(number, number) for number in range(6)]
    assert sent == [min(jobs, cores)] * shared
    assert asked == list(range(len(asked)))  # each time after all results before were seen
    assert len(asked) == 6 - max(0, shared - 1)
