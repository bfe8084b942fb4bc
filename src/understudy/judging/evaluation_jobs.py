"""The worlds of an evaluation, shared among processes of this computer or the jobs of an executor."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future, as_completed
from contextlib import AbstractContextManager, closing, nullcontext
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol

from understudy.errors import SettingError, UnderstudyError
from understudy.judging.evaluation import Evaluation, join_evaluations
from understudy.judging.evaluation_task import EvaluationFailed, EvaluationTask
from understudy.judging.process_pool import LOADING_S, count_cores, saves_time, share_calls
from understudy.judging.rollout import Progress, skip_progress
from understudy.judging.world_run import format_exception, name_value
from understudy.sim.scenario.schema import Scenario

PARTS_PER_PROCESS = 4
"""The number of jobs for each process, so that none waits long for the others and progress is seen."""

MOST_TRIED = 8
"""The number of worlds that are tried together to learn what more of them cost."""


class Job(Protocol):
    """What an executor returns for a job."""

    def result(self) -> Any:
        """Wait for the job and return its result, or raise its error."""
        ...


class Executor(Protocol):
    """A runner of functions elsewhere: an executor of `concurrent.futures`, of submitit, or the like."""

    def submit(self, function: Callable[[], Any], /) -> Job:
        """Let a function run.

        Parameters
        ----------
        function
            A function without arguments, which can be pickled if what it was made with can.

        Returns
        -------
        Job
            The job.
        """
        ...


class PreemptibleJob(ABC):
    """A job that a scheduler of a cluster runs again after it was preempted."""

    @abstractmethod
    def __call__(self) -> Any:
        """Run the job."""

    def checkpoint(self) -> Any:
        """Return the job that submitit's scheduler is to run after this one was preempted: the same one."""
        from submitit.helpers import DelayedSubmission

        return DelayedSubmission(self)


@dataclass(frozen=True)
class EvaluationJob(PreemptibleJob):
    """Some worlds of an evaluation, as plain data that a process or a computer of a cluster receives."""

    task: EvaluationTask
    seeds: tuple[int, ...]

    def __call__(self) -> Evaluation:
        """Run the worlds."""
        return self.task.run(self.seeds, skip_progress)


def run_in_jobs(
    task: EvaluationTask,
    seeds: Sequence[int],
    *,
    jobs: int,
    executor: Executor | None,
    progress: Progress,
    clock: Callable[[], float] | None = None,
) -> Evaluation:
    """Run a task in one world per seed in processes, or in the jobs of an executor; return the results in order.

    There are never more processes than cores, and none where the worlds that are left will take less time without.
    `clock` tells how long worlds take, s. By default, it counts the processor time of worlds of scenarios, which other
    programs do not make longer; bodies of one's own may wait for something, which counts too.

    Raises SettingError for what cannot be sent to a process, and EvaluationFailed, with the results of all other
    worlds, if a job fails.
    """
    if executor is not None:
        parts = [EvaluationJob(task, part) for part in divide(seeds, jobs)]
        progress(0, len(seeds))
        return _collect(parts, _iterate_completed(_submit(executor, parts)), len(seeds), progress)
    check_pickling(task)
    progress(0, len(seeds))
    trial = _Trial(task, seeds, min(jobs, count_cores()), clock)
    calls = share_calls(trial.divide(), jobs=jobs, estimate_left_s=lambda: trial.left_s)
    with closing(calls) as completed:
        return _collect(trial.parts, completed, len(seeds), progress)


class _Trial:
    """The worlds of an evaluation in parts, of which the first tell how long the others take."""

    def __init__(
        self, task: EvaluationTask, seeds: Sequence[int], jobs: int, clock: Callable[[], float] | None
    ) -> None:
        self._task, self._left, self._jobs = task, seeds, jobs
        self._clock = clock or (time.thread_time if isinstance(task.world, Scenario) else time.perf_counter)
        self.parts: list[EvaluationJob] = []
        self.left_s = 0.0
        """How long the worlds that are left would take here, s; 0 until that is known."""

    def divide(self) -> Iterator[EvaluationJob]:
        """Yield all worlds in parts; each is measured until the next one is asked for.

        The first world loads what is compiled, so that its time tells nothing. Worlds of a scenario run side by side,
        and many of them may take hardly longer than one. So if the time of the second world says that the rest takes
        long, several are tried together, and what each of them adds is what counts.
        """
        yield from self._measure(1)
        each_s = alone_s = yield from self._measure(1)
        if isinstance(self._task.world, Scenario) and self._saves_time(alone_s):
            many = min(MOST_TRIED, max(2, int(LOADING_S / alone_s)), len(self._left))
            together_s = yield from self._measure(many)
            each_s = max(0.0, together_s - alone_s) / max(1, many - 1)
        if not self._left:
            return
        parts = self._jobs * PARTS_PER_PROCESS if self._saves_time(each_s) else 1
        self.left_s = each_s * len(self._left)
        for part in divide(self._left, parts):
            yield self._add(part)

    def _saves_time(self, each_s: float) -> bool:
        """Return whether processes save time if each world takes a time, s."""
        return saves_time(each_s * len(self._left), self._jobs)

    def _measure(self, worlds: int) -> Generator[EvaluationJob, None, float]:
        """Yield a part of some worlds, if there are any left; return how long it took, s."""
        part, self._left = self._left[:worlds], self._left[worlds:]
        before = self._clock()
        if part:
            yield self._add(part)
        return self._clock() - before

    def _add(self, seeds: Sequence[int]) -> EvaluationJob:
        self.parts.append(EvaluationJob(self._task, tuple(seeds)))
        return self.parts[-1]


def divide(seeds: Sequence[int], parts: int) -> list[tuple[int, ...]]:
    """Divide seeds into `parts` parts of about equal length, in order; fewer if there are not enough."""
    parts = min(parts, len(seeds))
    ends = [len(seeds) * number // parts for number in range(parts + 1)]
    return [tuple(seeds[first:last]) for first, last in pairwise(ends)]


def _submit(executor: Executor, parts: Sequence[EvaluationJob]) -> list[Job]:
    batch: Callable[[], AbstractContextManager[Any]] = getattr(executor, "batch", nullcontext)
    try:
        with batch():  # submitit makes one job array of it
            return [executor.submit(part) for part in parts]
    except Exception as error:
        raise EvaluationFailed(problem=f"the executor took no job: {format_exception(error)}") from error


def _collect(
    parts: Sequence[EvaluationJob], completed: Iterable[tuple[int, Job]], worlds: int, progress: Progress
) -> Evaluation:
    """Wait for all jobs and join their results; raise the error of the first that failed."""
    results: dict[int, Evaluation] = {}
    errors: dict[int, Exception] = {}
    through = 0
    for number, job in completed:
        try:
            results[number] = job.result()
        except Exception as error:  # the executor's, or that of the job
            errors[number] = error
            if isinstance(error, EvaluationFailed) and error.part is not None:
                results[number] = error.part
        through += len(parts[number].seeds)
        progress(through, worlds)
    done = [results[number] for number in sorted(results)]
    if not errors:
        return join_evaluations(done)
    number = min(errors)
    cause = errors[number]
    if isinstance(cause, UnderstudyError) and not isinstance(cause, EvaluationFailed) and not done:
        raise cause
    raise EvaluationFailed(
        problem=_describe(cause, parts[number].seeds), part=join_evaluations(done) if done else None
    ) from cause


def _iterate_completed(jobs: Sequence[Job]) -> Iterator[tuple[int, Job]]:
    """Yield jobs with their numbers: as they end if they are futures, otherwise in order."""
    futures = {job: number for number, job in enumerate(jobs) if isinstance(job, Future)}
    if len(futures) < len(jobs):
        yield from enumerate(jobs)
        return
    for future in as_completed(futures):
        yield futures[future], future


LAST_LINES = 3
"""The number of lines of a failed job's errors that are repeated."""


def _describe(error: Exception, seeds: Sequence[int]) -> str:
    """Return one sentence about a job that failed."""
    if isinstance(error, EvaluationFailed):
        return error.problem
    which = f"the job of seeds {seeds[0]} to {seeds[-1]} failed"
    if _is_process_gone(error):
        return (
            f"{which}: its process ended; a program that starts processes runs its main part under "
            'if __name__ == "__main__":'
        )
    problem = str(error) if isinstance(error, UnderstudyError) else format_exception(error, last=LAST_LINES)
    return f"{which}: {problem}"


def _is_process_gone(error: Exception) -> bool:
    if not isinstance(error, BrokenExecutor):
        return False
    from concurrent.futures.process import BrokenProcessPool  # not everywhere are there processes

    return isinstance(error, BrokenProcessPool)


def check_pickling(task: EvaluationTask) -> None:
    """Refuse, with SettingError, a function or library that cannot be sent to another process."""
    from multiprocessing.reduction import ForkingPickler  # not everywhere are there processes

    parts: dict[str, Any] = {"library": task.libraries}
    if not isinstance(task.world, Scenario):
        parts["world"] = task.world
    functions = {"goal": task.criteria.goal}
    functions |= {f"metric {name!r}": value for name, value in task.criteria.metrics.items()}
    functions |= {f"record {name!r}": value for name, value in task.criteria.record.items()}
    for setting, value in (parts | functions).items():
        try:
            ForkingPickler.dumps(value)
        except Exception as error:
            called = f"{name_value(value)} " if callable(value) else ""
            raise SettingError(
                where="evaluation",
                setting=setting,
                problem=f"{called}cannot be sent to another process ({format_exception(error)})",
                remedy="define functions at the top level of a module, or leave out jobs=",
            ) from error
