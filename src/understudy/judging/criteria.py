"""Criteria of success and metrics of runs, and the results of runs by them.

Where goals and metrics are named, many worlds run side by side. Functions are given the run of a single world. The
results are the same.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError, UnknownName
from understudy.judging.behavior_run import BehaviorRun, ProgramRun
from understudy.judging.named_reading import YES, check_yes_or_no
from understudy.judging.outcomes import (
    Outcomes,
    SuccessMonitor,
    monitor_condition,
    monitor_flag,
    monitor_goal,
)
from understudy.judging.raised_range import RaisedRange, RaisedReader
from understudy.judging.rollout import TICKS_AT_ONCE, Monitor, Progress, roll_out, skip_progress
from understudy.judging.world_run import (
    ABSENT,
    Goal,
    Metric,
    SuccessRule,
    TickRecorder,
    WorldRun,
    average,
    compute_metric,
    describe_problem,
    format_exception,
    name_value,
)
from understudy.learning.shown_ranges import ShownRange
from understudy.model.value_kinds import Column
from understudy.sim.world import World

TICKS_BETWEEN_READINGS = 10
"""The number of ticks between two looks where a single robot raises a flag, at which something is read."""


@dataclass(frozen=True)
class Criteria:
    """The criteria by which runs succeed, and the values that are measured in them.

    Parameters
    ----------
    goal
        When a world has finished. None: when it has reached the scenario's goal.
    flags
        The flags that the behavior can raise; a goal of such a name is the flag.
    metrics
        What is computed at the end of each world, by name.
    record
        What is recorded in each tick, by name.
    shown
        At which values of a feature the flag that is the goal was pressed; they are compared with those at which it is
        raised. None: nothing is compared.
    """

    goal: Goal | None
    flags: frozenset[str]
    metrics: Mapping[str, Metric]
    record: Mapping[str, Metric]
    shown: ShownRange | None = None

    @property
    def are_names(self) -> bool:
        """Whether there are only names, no functions, so that worlds can run side by side."""
        judged = [*([] if self.goal is None else [self.goal]), *self.metrics.values()]
        return not self.record and all(isinstance(each, str | SuccessRule) for each in judged)

    @property
    def flag(self) -> str | None:
        """The flag that counts as success."""
        return self.goal if isinstance(self.goal, str) and self.goal in self.flags else None

    @property
    def are_plain(self) -> bool:
        """Whether nothing is to be read from the runs but the scenario's goal or a flag."""
        judged = self.goal is None or self.flag is not None
        return judged and not self.metrics and not self.record


@dataclass(frozen=True)
class JudgedRuns:
    """The results of n worlds: outcomes, metrics by name [n], a sentence for each absent one, and raised flags."""

    outcomes: Outcomes
    metrics: Mapping[str, Column] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
    raised: RaisedRange | None = None


def judge_runs(
    run: BehaviorRun,
    seeds: Sequence[int],
    criteria: Criteria,
    limit_s: float | Column,
    *,
    also: Sequence[Monitor] = (),
    progress: Progress = skip_progress,
) -> JudgedRuns:
    """Run worlds until each has succeeded or reached its limit, and measure them.

    Parameters
    ----------
    run
        The behavior in B worlds before the first tick; in a single one if there are functions among the criteria.
    seeds
        The seed of each world.
    criteria
        What counts as success, and what is measured.
    limit_s
        The time limit, s, one for all worlds or a column [B].
    also
        Further observers of the worlds, which look first.
    progress
        Function called repeatedly with the number of completed worlds and their total; an exception that it raises
        ends the runs.

    Returns
    -------
    JudgedRuns
        The results.

    Raises
    ------
    UnknownName
        If neither the kit nor the body has something that the criteria name.
    SettingError
        If a goal is no question of yes or no, or its function raises an error.
    """
    alone = None if criteria.are_names else WorldRun(run, seeds[0], float(np.max(limit_s)))
    recorder = None if alone is None or not criteria.record else TickRecorder(alone, criteria.record)
    values = _EndValues(run, {name: each for name, each in criteria.metrics.items() if isinstance(each, str)})
    reader = make_raised_reader(run, criteria)
    success = _make_monitor(run, criteria, alone, stride=None if reader is None else reader.stride)
    monitors: list[Monitor | None] = [*also, recorder, reader, success, values]
    chosen = [each for each in monitors if each is not None]
    roll_out(run, chosen, limit_s, to_goal=success.to_goal, progress=progress)
    outcomes = success.make_outcomes(limit_s)
    metrics, problems = dict[str, Column](), list[tuple[int, str]]()
    if alone is not None:
        alone.finished = bool(outcomes.finished[0])
        alone.recorded = {} if recorder is None else recorder.rows
    for name, metric in criteria.metrics.items():
        why: str | None = ABSENT
        if alone is None or isinstance(metric, str):
            metrics[name] = values.columns[name]
        else:
            value, why = compute_metric(alone, metric)
            metrics[name] = np.array([value])
        problems += [
            (row, describe_problem(seeds[row], name, str(why)))
            for row in np.flatnonzero(np.isnan(metrics[name])).tolist()
        ]
    sentences = tuple(text for _, text in sorted(problems, key=lambda each: each[0]))
    return JudgedRuns(
        outcomes, metrics, sentences, None if reader is None else reader.finish(outcomes.finished)
    )


class _EndValues(Monitor):
    """The values of readings at the end of each world, averaged over its agents."""

    def __init__(self, run: BehaviorRun, names: Mapping[str, str]) -> None:
        super().__init__(run.worlds, stride=TICKS_AT_ONCE)
        self._readings = {name: run.find_reading(text) for name, text in names.items()}
        self.columns = {name: np.full(run.worlds, np.nan) for name in names}
        """The values by name [B]; NaN where absent."""

    def end(self, ended: NDArray[np.bool_]) -> None:
        """Read the values of worlds that have just ended."""
        for name, reading in self._readings.items():
            self.columns[name][ended] = [average(row) for row in reading.read()[ended]]


def make_raised_reader(run: BehaviorRun, criteria: Criteria) -> RaisedReader | None:
    """Make what reads where a flag is raised, if it is known where it was shown.

    A single robot with a flag stays where it is, and can be read later if nothing else is to be read.
    """
    if criteria.shown is None or criteria.flag is None:
        return None
    single = isinstance(run, ProgramRun) and isinstance(run.body, World) and run.body.robots == 1
    stride = TICKS_BETWEEN_READINGS if single and run.is_fused and criteria.are_plain else 1
    return RaisedReader(
        run, criteria.flag, criteria.shown, is_alone=single and criteria.are_plain, stride=stride
    )


def _make_monitor(
    run: BehaviorRun, criteria: Criteria, alone: WorldRun | None, *, stride: int | None
) -> SuccessMonitor:
    """Make what ends a world when it has succeeded."""
    goal = criteria.goal
    if goal is None:
        return monitor_goal(run)
    if criteria.flag is not None and criteria.are_plain:
        return (
            monitor_flag(run, criteria.flag)
            if stride is None
            else monitor_flag(run, criteria.flag, stride=stride)
        )
    if isinstance(goal, SuccessRule):
        return goal.make_monitor(run, criteria.flags)
    if isinstance(goal, str):
        return monitor_condition(run, find_goal(run, goal, criteria.flags))
    if alone is None:
        raise TypeError("a goal that is a function needs the run of a single world")
    function, world = goal, alone
    return monitor_condition(run, lambda: np.array([_ask(function, world)]))


def find_goal(run: BehaviorRun, goal: str, flags: frozenset[str]) -> Callable[[], NDArray[np.bool_]]:
    """Return a function that tells in which worlds [B] a goal given by its name is reached now: by all its agents."""
    if goal in flags:
        return partial(run.find_raised, goal)
    try:
        reading = run.find_reading(goal)
    except UnknownName as error:
        if error.what == "target":
            raise
        names = [*sorted(flags), *error.known]
        raise UnknownName(
            what="flag, feature or reading", name=error.name, where=error.where, known=names
        ) from None
    check_yes_or_no(reading.reading, where="evaluation")

    def is_reached() -> NDArray[np.bool_]:
        reached: NDArray[np.bool_] = (reading.read() == YES).all(axis=1)
        return reached

    return is_reached


def _ask(goal: Callable[[WorldRun], Any], run: WorldRun) -> bool:
    """Return what a user's function says of a run; SettingError if it raises an error."""
    try:
        return bool(np.all(goal(run)))
    except Exception as error:
        raise SettingError(
            where=f"the world of seed {run.seed}",
            setting=f"goal {name_value(goal)}",
            problem=f"raised {format_exception(error)} after {run.seconds:.1f} s",
            remedy="let it return whether the run has succeeded",
        ) from error
