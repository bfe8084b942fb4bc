"""Work that is shared among processes: each result with its call, and processes that end with the program."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from math import sqrt
from pathlib import Path

import pytest
from tests.processes import end_with_tests

from understudy.judging.process_pool import run_calls

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
