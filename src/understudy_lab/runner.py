"""Execution of an experiment: its tasks run in parallel, and each row is stored as soon as it is computed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from importlib.util import find_spec
from typing import TypeAlias

import msgspec

from understudy.judging.process_pool import run_calls
from understudy_lab.row_cache import RowCache
from understudy_lab.study import Row, Study, StudyPlan, Task, find_experiment

Progress: TypeAlias = Callable[[int, int], None]
"""A function that receives the number of finished tasks and of all tasks."""


def run(
    experiment: Study,
    plan: StudyPlan,
    kept: RowCache,
    *,
    jobs: int = 1,
    progress: Progress = lambda done, total: None,
) -> list[Row]:
    """Run all tasks of a plan that are not stored yet, and return the rows in the order of the tasks."""
    return run_tasks(experiment, experiment.tasks(plan), kept, jobs=jobs, progress=progress)


def run_tasks(
    experiment: Study,
    tasks: Sequence[Task],
    kept: RowCache,
    *,
    jobs: int = 1,
    progress: Progress = lambda done, total: None,
) -> list[Row]:
    """Run tasks of an experiment that are not stored yet, and return the rows in the order of the tasks."""
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
