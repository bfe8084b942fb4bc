"""The same results from any number of processes and from executors, and what was computed when one of them fails."""

from __future__ import annotations

from collections.abc import Callable, Generator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import submitit
from submitit.helpers import DelayedSubmission
from tests.analysis.own_bodies import LIBRARY, Carts, divide_by_seed, make_cart_but_the_third, measure_way

from understudy.judging import evaluation_jobs
from understudy.judging.evaluate import evaluate, make_evaluation_task
from understudy.judging.evaluation import Evaluation
from understudy.judging.evaluation_jobs import EvaluationJob, divide
from understudy.judging.evaluation_task import EvaluationFailed
from understudy.judging.rollout import skip_progress

SEEDS = range(6)
OPTIONS: dict[str, Any] = {
    "limit_s": 4.0,
    "metrics": {"far": "far", "way": measure_way, "one": divide_by_seed},
    "record": ["far"],
}


def evaluate_carts(**options: Any) -> Evaluation:
    return evaluate(LIBRARY, "approach", Carts, SEEDS, **OPTIONS, **options)


def assert_same(found: Evaluation, expected: Evaluation) -> None:
    assert found.columns.keys() == expected.columns.keys()
    for name, column in expected.columns.items():
        assert np.array_equal(found.columns[name], column, equal_nan=name != "success"), name
    assert found.problems == expected.problems
    assert found.seeds == expected.seeds


@pytest.mark.long
def test_two_processes_find_what_one_does(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evaluation_jobs, "TRIAL_S", 0.0)
    monkeypatch.setattr(evaluation_jobs, "STARTUP_S", -1.0)
    calls = list[tuple[int, int]]()
    expected = evaluate_carts()
    assert 0 < expected.success < 1
    assert len(expected.problems) == 1
    found = evaluate_carts(jobs=2, progress=lambda done, total: calls.append((done, total)))
    assert_same(found, expected)
    assert calls == [(done, 6) for done in range(7)]


SHARED = [  # seconds of the first worlds and of each other one, worlds, jobs, cores; processes, worlds here
    (0.5, 0.02, 200, 8, 8, 1, 200),  # short: no process is started
    (3.0, 0.02, 200, 8, 8, 1, 200),  # kernels are loaded at first: no sign that the work is long
    (0.5, 1.0, 200, 8, 4, 4, 4),  # long: no more processes than cores
    (0.5, 1.0, 200, 2, 8, 2, 4),
    (0.5, 1.0, 200, 8, 1, 1, 200),  # a single core
    (0.5, 1.0, 5, 8, 8, 1, 5),
]


@pytest.mark.parametrize(("first_s", "each_s", "worlds", "jobs", "cores", "processes", "here"), SHARED)
def test_processes_are_started_only_where_they_save_time(
    first_s: float,
    each_s: float,
    worlds: int,
    jobs: int,
    cores: int,
    processes: int,
    here: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now_s, most, ran_here = 0.0, 0, 0

    def run_at_once(
        calls: list[EvaluationJob], *, jobs: int
    ) -> Generator[tuple[int, Future[Any]], None, None]:
        nonlocal now_s, most, ran_here
        most = max(most, jobs)
        for number, call in enumerate(calls):
            now_s += first_s if not ran_here else each_s * len(call.seeds)
            ran_here += len(call.seeds) if jobs == 1 else 0
            future = Future[Any]()
            future.set_result(call())
            yield number, future

    monkeypatch.setattr(evaluation_jobs, "run_calls", run_at_once)
    monkeypatch.setattr(evaluation_jobs, "count_cores", lambda: cores)
    task = make_evaluation_task(LIBRARY, "approach", Carts, limit_s=0.5)
    found = evaluation_jobs.run_in_jobs(
        task, range(worlds), jobs=jobs, executor=None, progress=skip_progress, clock=lambda: now_s
    )
    assert found.seeds == tuple(range(worlds))
    assert (most, ran_here) == (processes, here)


@pytest.mark.parametrize("jobs", [1, 4, 20])
def test_an_executor_finds_the_same(jobs: int) -> None:
    with ThreadPoolExecutor(2) as executor:
        assert_same(evaluate_carts(jobs=jobs, executor=executor), evaluate_carts())


@pytest.mark.long
def test_submitits_executor_finds_the_same(tmp_path: Path) -> None:
    executor = submitit.AutoExecutor(folder=tmp_path, cluster="local")
    assert_same(evaluate_carts(jobs=2, executor=executor), evaluate_carts())


def test_a_preempted_job_is_put_into_the_queue_again() -> None:
    task = make_evaluation_task(LIBRARY, "approach", Carts, limit_s=4.0)
    job = EvaluationJob(task, (1, 2))
    again = job.checkpoint()
    assert isinstance(again, DelayedSubmission)
    assert again.function is job
    assert job().seeds == (1, 2)


def test_the_worlds_of_other_jobs_are_kept_when_one_fails() -> None:
    """Also those before the failure in the job that fails."""
    given: dict[str, Any] = {"limit_s": 4.0, "jobs": 2}
    problem = "the world of seed 3 ended with RuntimeError: no cart is left; `part`"
    with ThreadPoolExecutor(2) as executor, pytest.raises(EvaluationFailed, match=problem) as found:
        evaluate(LIBRARY, "approach", make_cart_but_the_third, range(1, 7), executor=executor, **given)
    assert found.value.part is not None
    assert found.value.part.seeds == (1, 2, 4, 5, 6)


class Broken:
    """An executor that takes no job, or only those before the second."""

    def __init__(self, taken: int) -> None:
        self.taken = taken

    def submit(self, function: Callable[[], Any]) -> Any:
        if self.taken == 0:
            raise ConnectionError("the scheduler\ndoes not answer")
        return _Failed(function, fails=isinstance(function, EvaluationJob) and 0 not in function.seeds)


class _Failed:
    def __init__(self, function: Callable[[], Any], *, fails: bool) -> None:
        self.function, self.fails = function, fails

    def result(self) -> Any:
        if self.fails:
            raise RuntimeError("out of memory\non node 7")
        return self.function()


def test_an_executor_that_takes_no_job() -> None:
    problem = "^the executor took no job: ConnectionError: the scheduler does not answer$"
    with pytest.raises(EvaluationFailed, match=problem) as found:
        evaluate_carts(executor=Broken(0))
    assert found.value.part is None


def test_a_job_that_fails() -> None:
    problem = (
        r"^the job of seeds 3 to 5 failed: RuntimeError: out of memory on node 7; `part` of this error has"
    )
    with pytest.raises(EvaluationFailed, match=problem) as found:
        evaluate_carts(executor=Broken(9), jobs=2)
    assert found.value.part is not None
    assert found.value.part.seeds == (0, 1, 2)


DIVISIONS = [
    (range(5), 2, [(0, 1), (2, 3, 4)]),
    (range(2), 5, [(0,), (1,)]),
    (range(3), 1, [(0, 1, 2)]),
]


@pytest.mark.parametrize(("seeds", "parts", "expected"), DIVISIONS)
def test_seeds_are_divided_in_order(seeds: range, parts: int, expected: list[tuple[int, ...]]) -> None:
    assert divide(seeds, parts) == expected
