"""The same results from any number of processes and from executors, and what was computed when one of them fails."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import submitit
from submitit.helpers import DelayedSubmission
from tests.analysis.own_bodies import LIBRARY, Carts, divide_by_seed, make_cart_but_the_third, measure_way

from understudy.judging import evaluation_jobs, process_pool
from understudy.judging.evaluate import evaluate, make_evaluation_task
from understudy.judging.evaluation import Evaluation
from understudy.judging.evaluation_jobs import EvaluationJob, divide
from understudy.judging.evaluation_task import EvaluationFailed
from understudy.judging.rollout import skip_progress
from understudy.sim.catalog import find_scenario

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
    monkeypatch.setattr(process_pool, "STARTUP_S", -1.0)
    calls = list[tuple[int, int]]()
    expected = evaluate_carts()
    assert 0 < expected.success < 1
    assert len(expected.problems) == 1
    found = evaluate_carts(jobs=2, progress=lambda done, total: calls.append((done, total)))
    assert_same(found, expected)
    assert calls == [(done, 6) for done in range(7)]


SIDE_BY_SIDE, ONE_BY_ONE = True, False
SHARED = [  # sort; seconds to load, of a part, of a world; worlds, jobs, cores; processes, worlds here
    (ONE_BY_ONE, 0.5, 0.0, 0.02, 200, 8, 8, 1, 200),  # short: no process is started
    (
        ONE_BY_ONE,
        3.0,
        0.0,
        0.02,
        200,
        8,
        8,
        1,
        200,
    ),  # kernels are loaded at first: no sign that the work is long
    (ONE_BY_ONE, 0.5, 0.0, 1.0, 200, 8, 4, 4, 2),  # long: no more processes than cores
    (ONE_BY_ONE, 0.5, 0.0, 1.0, 200, 2, 8, 2, 2),
    (ONE_BY_ONE, 0.5, 0.0, 1.0, 200, 8, 1, 1, 200),  # a single core
    (ONE_BY_ONE, 0.5, 0.0, 1.0, 5, 8, 8, 1, 5),
    (ONE_BY_ONE, 0.5, 0.0, 1.0, 1, 8, 8, 1, 1),
    (SIDE_BY_SIDE, 1.0, 0.15, 0.002, 200, 8, 8, 1, 200),  # one takes 0.152 s, all take 0.55 s
    (SIDE_BY_SIDE, 4.0, 0.6, 0.008, 200, 8, 8, 1, 200),  # the same on a slow machine
    (SIDE_BY_SIDE, 1.0, 0.9, 0.0, 200, 8, 8, 1, 200),
    (SIDE_BY_SIDE, 1.0, 0.15, 0.1, 200, 8, 8, 8, 10),  # two worlds, and then eight together
    (SIDE_BY_SIDE, 1.0, 0.0, 9.0, 200, 8, 8, 8, 4),  # two worlds, and then two together
    (SIDE_BY_SIDE, 1.0, 0.0, 9.0, 3, 8, 8, 1, 3),
]


@pytest.mark.parametrize(
    ("sort", "load_s", "part_s", "each_s", "worlds", "jobs", "cores", "processes", "here"), SHARED
)
def test_processes_are_started_only_where_they_save_time(
    sort: bool,
    load_s: float,
    part_s: float,
    each_s: float,
    worlds: int,
    jobs: int,
    cores: int,
    processes: int,
    here: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now_s, most, ran = 0.0, 1, list[int]()
    carts = make_evaluation_task(LIBRARY, "approach", Carts, limit_s=0.5)

    def run_part(job: EvaluationJob) -> Evaluation:
        nonlocal now_s
        now_s += part_s + each_s * len(job.seeds) + (0.0 if ran else load_s)
        ran.append(len(job.seeds) if most == 1 else 0)
        return carts.run(job.seeds, skip_progress)

    def run_at_once(
        calls: Iterable[Callable[[], Any]], *, jobs: int
    ) -> Generator[tuple[int, Future[Any]], None, None]:
        nonlocal most
        most = jobs
        for number, call in enumerate(calls):
            future = Future[Any]()
            future.set_result(call())
            yield number, future

    monkeypatch.setattr(EvaluationJob, "__call__", run_part)
    monkeypatch.setattr(process_pool, "run_calls", run_at_once)
    for module in (process_pool, evaluation_jobs):
        monkeypatch.setattr(module, "count_cores", lambda: cores)
    task = replace(carts, world=find_scenario("forage")) if sort is SIDE_BY_SIDE else carts
    found = evaluation_jobs.run_in_jobs(
        task, range(worlds), jobs=jobs, executor=None, progress=skip_progress, clock=lambda: now_s
    )
    assert found.seeds == tuple(range(worlds))
    assert (most, sum(ran)) == (processes, here)


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
