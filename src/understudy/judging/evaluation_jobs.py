"""The worlds of an evaluation, shared among processes of this computer or the jobs of an executor."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future, as_completed
from contextlib import AbstractContextManager, closing, nullcontext
from dataclasses import dataclass
from itertools import pairwise
from time import perf_counter
from typing import Any, Protocol

from understudy.errors import SettingError, UnderstudyError
from understudy.judging.evaluation import Evaluation, join_evaluations
from understudy.judging.evaluation_task import EvaluationFailed, EvaluationTask
from understudy.judging.process_pool import count_cores, run_calls
from understudy.judging.rollout import Progress, skip_progress
from understudy.judging.world_run import format_exception, name_value
from understudy.sim.scenario.schema import Scenario

PARTS_PER_PROCESS = 4
"""The number of jobs for each process, so that none waits long for the others and progress is seen."""

TRIAL_S = 2.0
"""The time after which the speed of this process is believed, s: at first it loads compiled kernels."""
STARTUP_S = 4.0
"""The time that processes must save to be started, s: each imports what this one has, and loads compiled kernels."""


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
    clock: Callable[[], float] = perf_counter,
) -> Evaluation:
    """Run a task in one world per seed in processes, or in the jobs of an executor; return the results in order.

    There are never more processes than cores, and none where the worlds that are left will take less time without.

    Raises SettingError for what cannot be sent to a process, and EvaluationFailed, with the results of all other
    worlds, if a job fails.
    """
    if executor is not None:
        parts = [EvaluationJob(task, part) for part in divide(seeds, jobs)]
        progress(0, len(seeds))
        return _collect(parts, _iterate_completed(_submit(executor, parts)), len(seeds), progress)
    check_pickling(task)
    parts = []
    progress(0, len(seeds))
    with closing(_run_here_or_in_processes(task, seeds, jobs, parts, clock)) as completed:
        return _collect(parts, completed, len(seeds), progress)


def _run_here_or_in_processes(
    task: EvaluationTask,
    seeds: Sequence[int],
    jobs: int,
    parts: list[EvaluationJob],
    clock: Callable[[], float],
) -> Generator[tuple[int, Job], None, None]:
    """Run some worlds here, and the rest in processes where that is faster; yield each part's number and result.

    The parts are added to `parts`: two worlds first, then twice as many each time. The very first world takes longer
    than others, since it loads what is compiled.
    """
    begun, jobs = clock(), min(jobs, count_cores())
    while len(parts) < 2 or clock() - begun < TRIAL_S:
        many = 2 ** max(0, len(parts) - 1)
        part, seeds, before = seeds[:many], seeds[many:], clock()
        yield from _run_part(EvaluationJob(task, tuple(part)), parts)
        left_s = (clock() - before) / len(part) * len(seeds)
        if left_s * (1 - 1 / jobs) <= STARTUP_S:
            if seeds:
                yield from _run_part(EvaluationJob(task, tuple(seeds)), parts)
            return
    first = len(parts)
    parts += [EvaluationJob(task, part) for part in divide(seeds, jobs * PARTS_PER_PROCESS)]
    with closing(run_calls(parts[first:], jobs=jobs)) as completed:
        for number, job in completed:
            yield first + number, job


def _run_part(part: EvaluationJob, parts: list[EvaluationJob]) -> Iterator[tuple[int, Job]]:
    """Run a part here."""
    parts.append(part)
    for _, job in run_calls([part], jobs=1):
        yield len(parts) - 1, job


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
