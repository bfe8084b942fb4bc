"""Parts of an experiment as jobs of a cluster's scheduler, through submitit.

A job that is preempted is put into the queue again, and goes on with the rows that it has stored.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from understudy.errors import UnderstudyError
from understudy.extras import ExtraMissing
from understudy_lab.results import RowCache
from understudy_lab.runner import Part, run
from understudy_lab.study import StudyPlan, find_experiment

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
class PartJob:
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

    def checkpoint(self) -> Any:
        """Return the job that the scheduler is to run after this one was preempted: the same one."""
        from submitit.helpers import DelayedSubmission

        return DelayedSubmission(self)


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
