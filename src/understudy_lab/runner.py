"""Execution of an experiment: its tasks run in parallel, and each row is stored as soon as it is computed.

Parts of an experiment each run every n-th task, as jobs of their own, and then their rows are gathered. Rows of a part
are in a file of their own, so that jobs on several computers need nothing but a common folder. Jobs of a cluster's
scheduler are submitted through submitit. One that is preempted is put into the queue again, and goes on with the rows
that it has stored.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Self, TypeAlias

import msgspec

from understudy.errors import SettingError, UnderstudyError
from understudy.extras import ExtraMissing
from understudy.judging.evaluation_jobs import PreemptibleJob
from understudy.judging.process_pool import run_calls
from understudy_lab.results import RowCache
from understudy_lab.study import Row, Study, StudyPlan, Task, find_experiment

Progress: TypeAlias = Callable[[int, int], None]
"""A function that receives the number of finished tasks and of all tasks."""


WRITTEN = re.compile(r"([1-9]\d*)/([1-9]\d*)")
FILE = re.compile(r"rows-(\d+)-of-(\d+)\.jsonl")
MOST_NAMED = 8
"""The largest number of unfinished parts that an error names."""


class PartsUnfinished(UnderstudyError, json_type="PartsUnfinished"):
    """Rows of an experiment are missing when its parts are gathered."""

    def __init__(self, *, problem: str) -> None:
        self.problem = problem
        super().__init__(problem)


@dataclass(frozen=True, order=True)
class Part:
    """One of the parts of an experiment; `number` counts from 1."""

    number: int
    of: int

    @classmethod
    def parse(cls, text: str) -> Self:
        """Read a part such as `2/3`.

        Parameters
        ----------
        text
            The number of the part, and the number of parts.

        Returns
        -------
        Part
            The part.

        Raises
        ------
        SettingError
            If the text does not name one of the parts.
        """
        match = WRITTEN.fullmatch(text)
        if match is None or int(match[1]) > int(match[2]):
            raise SettingError(
                where="understudy experiment",
                setting="--part",
                problem=f"is {text!r:.40}",
                remedy="give the number of the part and the number of parts, such as 1/3",
            )
        return cls(int(match[1]), int(match[2]))

    def __str__(self) -> str:
        return f"{self.number}/{self.of}"

    @property
    def file_name(self) -> str:
        """The name of the file with the rows of this part."""
        return f"rows-{self.number}-of-{self.of}.jsonl"

    def select(self, tasks: Sequence[Task]) -> Sequence[Task]:
        """Return the tasks of this part: every n-th one."""
        return tasks[self.number - 1 :: self.of]


def run(
    experiment: Study,
    plan: StudyPlan,
    kept: RowCache,
    *,
    part: Part | None = None,
    jobs: int = 1,
    progress: Progress = lambda done, total: None,
) -> list[Row]:
    """Run all tasks of a plan, or of one part of it, that are not stored yet; return the rows in their order."""
    tasks = experiment.tasks(plan) if part is None else part.select(experiment.tasks(plan))
    left = [task for task in tasks if task not in kept]
    done = len(tasks) - len(left)
    progress(done, len(tasks))
    jobs = 1 if experiment.in_real_time else min(jobs, len(left))
    calls: list[Callable[[], Row]] = [
        partial(_work, experiment.name, task) if jobs > 1 else partial(row_of, experiment, task)
        for task in left
    ]
    for _, job in run_calls(calls, jobs=jobs):
        kept.keep(job.result())
        done += 1
        progress(done, len(tasks))
    return [kept[task] for task in tasks]


def gather(experiment: Study, plan: StudyPlan, folder: Path) -> RowCache:
    """Gather the rows of all parts in a folder into one file, in the order of the tasks.

    Parameters
    ----------
    experiment
        The experiment.
    plan
        The plan of the parts.
    folder
        The folder of the parts.

    Returns
    -------
    RowCache
        All rows. Their file is the one of a run without parts, byte for byte.

    Raises
    ------
    PartsUnfinished
        If a row is missing, or was written by another version of the program. Nothing is changed.
    """
    parts = list_parts(folder)
    sources = [RowCache(experiment.name, folder, part.file_name, change=False) for part in parts]
    sources.append(RowCache(experiment.name, folder, change=False))
    tasks = experiment.tasks(plan)
    missing = {number for number, task in enumerate(tasks) if not any(task in source for source in sources)}
    if missing:
        raise PartsUnfinished(problem=_describe_missing(experiment, folder, parts, missing, len(tasks)))
    rows = [next(source[task] for source in sources if task in source) for task in tasks]
    cache = RowCache(experiment.name, folder)
    cache.replace(rows)
    return cache


def list_parts(folder: Path) -> list[Part]:
    """List the parts of which a folder has rows."""
    matches = (FILE.fullmatch(path.name) for path in folder.glob("rows-*.jsonl"))
    return sorted(Part(int(each[1]), int(each[2])) for each in matches if each is not None)


def _describe_missing(
    experiment: Study, folder: Path, parts: Sequence[Part], missing: set[int], total: int
) -> str:
    sentence = f"{len(missing)} of {total} tasks of {experiment.name} have no result in {folder}"
    if not parts:
        return f"{sentence}, which has no part: run understudy experiment {experiment.name} --part 1/N first"
    of = max(part.of for part in parts)
    unfinished = sorted({1 + number % of for number in missing})
    named = ", ".join(f"{number}/{of}" for number in unfinished[:MOST_NAMED])
    more = f" and {len(unfinished) - MOST_NAMED} more" if len(unfinished) > MOST_NAMED else ""
    return f"{sentence}: run --part {named}{more} again; it goes on where it was"


JOBS = "jobs"
"""The folder, within the experiment's, of the files that the scheduler and its jobs write."""
LAST_LINES = 3
"""The number of lines of a failed job's errors that are repeated."""


class JobFailed(UnderstudyError, json_type="JobFailed"):
    """A cluster that cannot be used, or a job that ended without having finished its part."""

    exit_code = 1

    def __init__(self, *, problem: str) -> None:
        self.problem = problem
        super().__init__(problem)


@dataclass(frozen=True)
class PartJob(PreemptibleJob):
    """One part of an experiment, as plain data that a job receives."""

    experiment: str
    plan: StudyPlan
    part: Part
    folder: Path

    def __call__(self) -> int:
        """Run what is left of the part, and return the number of its rows."""
        from understudy.jit.settings import compile_on_first_call

        compile_on_first_call()
        kept = RowCache(self.experiment, self.folder, self.part.file_name)
        return len(run(find_experiment(self.experiment), self.plan, kept, part=self.part))


def run_on_cluster(
    experiment: str,
    plan: StudyPlan,
    folder: Path,
    *,
    cluster: str,
    parts: int,
    parameters: Mapping[str, Any] | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> None:
    """Run an experiment as jobs of a cluster, one for each part, and wait for them.

    Parameters
    ----------
    experiment
        The name of the experiment.
    plan
        What is run of it.
    folder
        The folder of the results, which all computers of the cluster can reach.
    cluster
        `slurm`, or `local` for processes of this computer.
    parts
        The number of jobs.
    parameters
        Parameters of submitit's executor, such as `timeout_min` or `slurm_partition`.
    progress
        A function that receives the number of jobs that have ended and of all jobs.

    Raises
    ------
    ExtraMissing
        If submitit is not installed.
    JobFailed
        If a job failed. The rows that it and the others have stored are kept.
    """
    try:
        import submitit
    except ImportError:
        raise ExtraMissing(what="jobs on a cluster", extra="cluster") from None
    try:
        executor = submitit.AutoExecutor(folder=folder / JOBS, cluster=cluster)
        executor.update_parameters(name=f"understudy-{experiment}", **(parameters or {}))
    except (RuntimeError, ValueError, NameError, TypeError) as error:
        problem = f"{cluster}: {error}; check --cluster and --cluster-option"
        raise JobFailed(problem=problem) from error
    where = folder.absolute()
    jobs = [
        executor.submit(PartJob(experiment, plan, Part(number, parts), where))
        for number in range(1, parts + 1)
    ]
    progress(0, parts)
    for done, job in enumerate(jobs, 1):
        failed = job.exception()
        if failed is not None:
            said = " ".join(str(failed).strip().splitlines()[-LAST_LINES:])
            raise JobFailed(
                problem=f"part {done}/{parts} of {experiment} failed as job {job.job_id}: {said:.300}; "
                f"its files are in {folder / JOBS}, and the same command goes on with what is missing"
            )
        progress(done, parts)


def find_missing_modules(experiment: Study) -> dict[str, str]:
    """Return the modules that an experiment needs and that are not installed, each with the install command."""
    return {module: install for module, install in experiment.needs.items() if find_spec(module) is None}


def row_of(experiment: Study, task: Task) -> Row:
    """Run one task and return its row with the task, in the form that JSON restores."""
    row: Row = msgspec.json.decode(msgspec.json.encode({"task": task, **experiment.work(task)}))
    return row


def _work(name: str, task: Task) -> Row:
    """Run one task in a worker process, which receives only names and plain data."""
    return row_of(find_experiment(name), task)
