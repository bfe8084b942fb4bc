"""Evaluation of a behavior in many worlds: success, time to finish, and metrics of one's own.

A behavior that can raise the flag `done`, or a single other one, is finished when it raises it; any other when the
scenario's goal is reached. A goal of one's own replaces both.

A world that has a baseline has a time limit of three times the baseline's time; any other has the scenario's limit.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import Any

from understudy.errors import SettingError
from understudy.judging.criteria import Criteria
from understudy.judging.evaluation import RESULTS, Evaluation
from understudy.judging.evaluation_jobs import Executor, run_in_jobs
from understudy.judging.evaluation_task import EvaluationTask, MakeBody
from understudy.judging.raised_range import find_shown_goal
from understudy.judging.rollout import Progress, skip_progress
from understudy.judging.world_run import Goal, Metric
from understudy.model.automaton import USUAL_FLAGS
from understudy.model.binding import NOTHING_BOUND
from understudy.model.library import Library
from understudy.runtime.link import link
from understudy.sim.catalog import find_scenario
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import Libraries, find_behavior_sort, list_running_sorts

SUCCESS_FLAG, FAILURE_FLAG = USUAL_FLAGS


def evaluate(
    library: Library | Libraries,
    behavior: str,
    world: Scenario | Path | str | MakeBody,
    seeds: Sequence[int],
    *,
    binding: Mapping[str, str] = NOTHING_BOUND,
    goal: Goal | None = None,
    metrics: Mapping[str, Metric] | Sequence[str] = (),
    record: Mapping[str, Metric] | Sequence[str] = (),
    limit_s: float | None = None,
    jobs: int = 1,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Evaluation:
    """Evaluate a behavior in one world per seed: of robots, of a team, or of a body of one's own.

    A behavior that can raise the flag `done` succeeds if all robots raise it in time, any other if the scenario's
    goal is reached in time. A `goal` replaces both. If the scenario's goal counts and the scenario has a baseline, the
    limit is three times the baseline's time; otherwise it is the scenario's.

    Parameters
    ----------
    library
        The library, whose behavior all robots run; or for a team the library of each sort of agents, as
        `collect_libraries` returns it.
    behavior
        Name of the basic behavior or automaton to evaluate. In a team, the sort of agents that it was taught to runs
        it: coordinators before robots; SORT/BEHAVIOR names the sort. Agents below a coordinator follow its orders.
    world
        The scenario, or its name or path; or a function that makes a `Body`, given a seed. A body that has a method
        `close` is closed at the end of its run.
    seeds
        Seeds of the worlds, at least one.
    binding
        Name of a target by parameter of the behavior.
    goal
        When a world has succeeded: the name of a flag of the behavior; the name of a feature or reading that is yes or
        no, such as "at_station" or "seen(ball)", and has to be yes for all agents that have it; a function of the
        `WorldRun` that is called before the first tick and after each one; or a rule for worlds of a scenario, such as
        a `PropertyRule`. None: as above.
    metrics
        What is measured at the end of each world, by name: the name of a feature or reading, of which the last value is
        taken, averaged over the agents that have it; or a function of the `WorldRun` that returns a number. A list of
        names stands for itself.
    record
        What is recorded before the first tick and after each one for functions among the metrics, by name: the name of
        a feature or reading, or a function of the `WorldRun` that returns numbers. They find it in `recorded`.
    limit_s
        The time limit of each world, s. None: the one above; a body of one's own needs one.
    jobs
        The number of processes, or with an `executor` the number of jobs that it is given. The results do not depend on
        it.
    executor
        What runs the jobs: an executor of `concurrent.futures` or submitit, or anything else with their `submit`.
        None: processes of this computer.
    progress
        Function called repeatedly with the number of completed worlds and their total; an exception that it raises
        ends the evaluation. None: no reports.

    Returns
    -------
    Evaluation
        The results by world, and those of the baseline if there is one. A metric that raises an error or gives no
        number is NaN in that world, and one of `Evaluation.problems`.

    Raises
    ------
    SettingError
        If `seeds` is empty or no list, neither a goal nor the flag `done` defines success, a setting is not valid, or a
        function cannot be sent to other processes.
    UnknownName
        If there is no such behavior, scenario, sort of agents, flag or reading.
    UnboundParameter
        If a parameter of the behavior is not bound to a target.
    FileError
        If `world` is the path of a file that cannot be read or is no scenario.
    EvaluationFailed
        If a body, a goal or a job fails. Its `part` has the results of the worlds before.
    """
    where = world if isinstance(world, Scenario) or callable(world) else find_scenario(world)
    seeds = _read_seeds(seeds)
    jobs = _read_jobs(jobs)
    task = make_evaluation_task(
        library, behavior, where, binding=binding, goal=goal, metrics=metrics, record=record, limit_s=limit_s
    )
    task.check_names(seeds[0])
    report = progress or skip_progress
    if executor is None and jobs == 1:
        return task.run(seeds, report)
    return run_in_jobs(task, seeds, jobs=jobs, executor=executor, progress=report)


def make_evaluation_task(
    library: Library | Libraries,
    behavior: str,
    world: Scenario | MakeBody,
    *,
    binding: Mapping[str, str] = NOTHING_BOUND,
    goal: Goal | None = None,
    metrics: Mapping[str, Metric] | Sequence[str] = (),
    record: Mapping[str, Metric] | Sequence[str] = (),
    limit_s: float | None = None,
) -> EvaluationTask:
    """Make the task of an evaluation; refuse invalid arguments before anything runs."""
    libraries, sort, behavior, own = find_runners(library, behavior, world)
    link(own, behavior, binding)
    flags = find_flags(own, behavior)
    judged = find_success_flag(own, behavior) if goal is None else goal
    if judged is None and not (isinstance(world, Scenario) and world.goal is not None):
        raise _no_goal(world)
    if limit_s is None and not isinstance(world, Scenario):
        raise _wrong("limit_s", "is missing for a body of your own", "give the time limit in s")
    if limit_s is not None and not (isfinite(limit_s) and limit_s >= 0):
        raise _wrong("limit_s", f"is {limit_s}", "give a time in s")
    measured = _read_names(metrics, "metrics")
    for name in measured:
        if name in RESULTS:
            raise _wrong(f"metric {name!r}", "has the name of another result", "give it another name")
    criteria = Criteria(judged, flags, measured, _read_names(record, "record"))
    criteria = replace(criteria, shown=find_shown_goal(own, behavior, criteria.flag))
    return EvaluationTask(libraries, sort, behavior, world, dict(binding), criteria, limit_s)


def find_runners(
    libraries: Library | Libraries, behavior: str, world: Scenario | MakeBody
) -> tuple[Library | Libraries, str | None, str, Library]:
    """Return the libraries, the sort that runs a behavior, and its name and library; no sort if all robots run it."""
    if isinstance(libraries, Library):
        return libraries, None, behavior, libraries
    if not isinstance(world, Scenario):
        raise _wrong("library", "is that of a team", "a body of your own takes one library")
    sort = find_behavior_sort(libraries, behavior)
    behavior, own = behavior.removeprefix(f"{sort}/"), libraries[sort]
    sorts = list_running_sorts(libraries, sort, behavior)
    if set(sorts) == set(world.types) and all(libraries[each] is own for each in sorts):
        return own, None, behavior, own
    return dict(libraries), sort, behavior, own


def _read_names(names: object, setting: str) -> dict[str, Metric]:
    if isinstance(names, str) or not isinstance(names, Mapping | Sequence):
        raise _wrong(setting, f"are {names!r:.60}", 'give names and what they mean: {"food": "food_stored"}')
    meanings: dict[str, Any] = dict(names) if isinstance(names, Mapping) else {name: name for name in names}
    for name, value in meanings.items():
        if not (isinstance(value, str) or callable(value)):
            remedy = "give the name of a reading, or a function of the run"
            raise _wrong(f"{setting} {name!r:.60}", f"is {value!r:.60}", remedy)
    return meanings


def _read_jobs(jobs: object) -> int:
    if not (isinstance(jobs, int) and jobs >= 1):
        raise _wrong("jobs", f"is {jobs!r:.60}", "give the number of processes, at least 1")
    return jobs


def _wrong(setting: str, problem: str, remedy: str) -> SettingError:
    return SettingError(where="evaluation", setting=setting, problem=problem, remedy=remedy)


def _no_goal(world: Scenario | MakeBody) -> SettingError:
    if not isinstance(world, Scenario):
        return _wrong("goal", "is missing", "name a flag or a reading that is yes or no, or give a function")
    return SettingError(
        where=f"scenario {world.name!r}",
        setting="goal",
        problem="is missing, and a run cannot be evaluated without it",
        remedy="give it a [goal], name one in the evaluation, or watch it with understudy run",
    )


def _read_seeds(seeds: Sequence[int]) -> list[int]:
    try:
        seeds = list(seeds)
    except TypeError:  # one number, say
        raise _wrong(
            "seeds", f"are {seeds!r:.60}", "give a list of whole numbers, one for each world: [5]"
        ) from None
    if not seeds:
        raise _wrong("seeds", "are none", "give at least one")
    return seeds


def find_flags(library: Library, behavior: str) -> frozenset[str]:
    """Return the flags that a behavior can raise."""
    taught = library.taught.get(behavior)
    return frozenset() if taught is None else frozenset(taught.automaton.flags)


def find_success_flag(library: Library, behavior: str) -> str | None:
    """Return the flag by which a behavior is judged: `done`, or else its only one besides `failed`.

    None if it has no such flag, and the scenario's goal counts.
    """
    return choose_success_flag(find_flags(library, behavior))


def choose_success_flag(flags: Collection[str]) -> str | None:
    """Return `done` if it is among these flags, or else the only one besides `failed`; None if there is none."""
    goals = set(flags) & {SUCCESS_FLAG} or set(flags) - {FAILURE_FLAG}
    return next(iter(goals)) if len(goals) == 1 else None
