"""Runs of what was taught in new worlds: where it works, and where and when it goes wrong.

A behavior works where the goal that a person has chosen for it holds. Without one, a behavior with a flag works where
it raises the flag in time at values that agree with what was shown; any other where the goal of the scenario is reached
as soon as in an evaluation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from understudy.analysis.baseline import LENIENCE, find_baseline, measure_baseline
from understudy.analysis.behavior_run import ProgramRun
from understudy.analysis.evaluate import find_flags, find_success_flag, make_evaluation_task
from understudy.analysis.goal_runs import run_many_ticks
from understudy.analysis.measurement import TICKS_BETWEEN_READINGS, Progress, skip_progress
from understudy.analysis.raised_range import find_shown_goal
from understudy.falsification.joint_worlds import Trial
from understudy.falsification.trial import GoalMeasure
from understudy.learning.shown_ranges import ShownRange
from understudy.model.describe import format_value
from understudy.model.kinds import Column
from understudy.model.library import Library
from understudy.model.property import Property
from understudy.properties.monitor import monitor_property
from understudy.properties.offered_goals import find_chosen_goal
from understudy.runtime.program import link
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World

LONGEST_RUN_S = 120.0
"""The longest time that a behavior with a flag is given, s."""
MOST_TIMED = 4
"""In how many worlds it is found when a behavior without a flag went wrong, for which each is run again."""
NEARER = 0.02
"""The share of the way to where a flag was shown by which a robot has to come nearer to make progress."""


@dataclass(frozen=True, slots=True)
class Mistake:
    """A world in which a behavior does not do what it was taught for.

    Parameters
    ----------
    seed
        The seed of the world.
    binding
        The target of each parameter.
    wrong_s
        When it went wrong, s: when it raised its flag elsewhere, or when it came no nearer.
    why
        What happened, in words.
    """

    seed: int
    binding: Mapping[str, str]
    wrong_s: float
    why: str


@dataclass(frozen=True)
class NewWorldsResult:
    """The results of a behavior in K new worlds.

    Parameters
    ----------
    works
        In which worlds it does what it was taught for [K].
    seconds
        How long that took [K], s; NaN where it does not.
    mistakes
        The worlds in which it does not, in order; without a flag, the first MOST_TIMED of them.
    """

    works: NDArray[np.bool_]
    seconds: Column
    mistakes: tuple[Mistake, ...]


@dataclass(frozen=True)
class NewWorlds:
    """New worlds of a scenario, in which a behavior is run.

    Parameters
    ----------
    scenario
        The scenario.
    seeds
        The seed of each world.
    limits
        How long a behavior may take to reach the scenario's goal if that is its goal, s, for all or each [K].
    """

    scenario: Scenario
    seeds: Sequence[int]
    limits: float | Column

    @classmethod
    def from_seeds(cls, scenario: Scenario, seeds: Sequence[int], *, own_goal: bool) -> Self:
        """Make the worlds of some seeds; without a goal of its own, the baseline sets the limits if there is one."""
        baseline = None if own_goal else find_baseline(scenario)
        if baseline is None:
            return cls(scenario, seeds, scenario.limit_s)
        expert = measure_baseline(baseline, seeds)
        return cls(scenario, seeds, LENIENCE * np.where(expert.finished, expert.seconds, expert.limit_s))

    def run(
        self,
        library: Library,
        behavior: str,
        binding: Mapping[str, str],
        *,
        progress: Progress = skip_progress,
    ) -> NewWorldsResult:
        """Run a behavior in these worlds.

        Parameters
        ----------
        library
            The library, whose behavior all robots run.
        behavior
            Name of the behavior.
        binding
            The target of each parameter.
        progress
            Function called repeatedly with the number of completed worlds and their total; an exception that it raises
            ends the runs.

        Returns
        -------
        NewWorldsResult
            The results.

        Raises
        ------
        SettingError
            If the behavior has no goal of its own, and the scenario none.
        UnboundParameter
            If a parameter is not bound to a target.
        """
        goal = find_chosen_goal(library, behavior)
        if goal is not None:
            return self._run_goal(library, behavior, binding, goal, progress)
        flag = find_success_flag(library, behavior)
        if flag is not None:
            shown = find_shown_goal(library, behavior, flag)
            world = World(self.scenario, self.seeds)
            run = ProgramRun(world, link(library, behavior, binding), library, binding, worlds=world.worlds)
            return _run_to_flag(run, world, binding, flag, shown, progress)
        task = make_evaluation_task(library, behavior, self.scenario, binding=binding)
        world = World(self.scenario, self.seeds)
        part = run_many_ticks(world, task.program, library, binding, task.criteria, self.limits, progress)
        failed = np.flatnonzero(~part.outcomes.finished)[:MOST_TIMED].tolist()
        measure = GoalMeasure(task, float(part.outcomes.limit_s.max()))
        ended = [measure([Trial(self.scenario, self.seeds[row])]).progress_s[0] for row in failed]
        why = "there is no more progress, and the goal of the world is not reached in time"
        mistakes = [
            Mistake(self.seeds[row], binding, float(wrong_s), why)
            for row, wrong_s in zip(failed, ended, strict=True)
        ]
        return NewWorldsResult(part.outcomes.finished, part.outcomes.seconds, tuple(mistakes))

    def _run_goal(
        self,
        library: Library,
        behavior: str,
        binding: Mapping[str, str],
        goal: Property,
        progress: Progress,
    ) -> NewWorldsResult:
        """Run worlds until it is known whether a chosen goal holds."""
        world = World(self.scenario, self.seeds)
        run = ProgramRun(world, link(library, behavior, binding), library, binding, worlds=world.worlds)
        flags = find_flags(library, behavior)
        outcomes = monitor_property(goal, run, flags, progress=progress)
        limit_s = goal.seconds if goal.is_timed else goal.start.limit_s
        seconds = np.where(np.isnan(outcomes.reached_s), limit_s or self.scenario.limit_s, outcomes.reached_s)
        why = f"this does not hold: it {goal.name}" if goal.name else f"this does not hold: {goal.claim}"
        mistakes = [
            Mistake(self.seeds[row], binding, float(outcomes.failed_s[row]), why)
            for row in np.flatnonzero(~outcomes.held).tolist()
        ]
        return NewWorldsResult(outcomes.held, np.where(outcomes.held, seconds, np.nan), tuple(mistakes))


def has_own_goal(library: Library, behavior: str) -> bool:
    """Return whether a behavior has a goal of its own, so that the scenario's does not count."""
    chosen = find_chosen_goal(library, behavior) is not None
    return chosen or find_success_flag(library, behavior) is not None


def _run_to_flag(
    run: ProgramRun,
    world: World,
    binding: Mapping[str, str],
    flag: str,
    shown: ShownRange | None,
    progress: Progress,
) -> NewWorldsResult:
    """Run worlds until their robots have raised a flag, or for LONGEST_RUN_S."""
    read = None if shown is None else run.find_reading(str(shown.feature)).read
    limit_s = min(world.scenario.limit_s, LONGEST_RUN_S)
    nearest, nearest_s = np.full(world.worlds, np.inf), np.zeros(world.worlds)
    values = np.full((world.worlds, world.robots), np.nan)
    raised, first = np.zeros(world.worlds, np.bool_), np.zeros(world.worlds)
    for tick in range(TICKS_BETWEEN_READINGS, round(limit_s / world.tick_s) + 1, TICKS_BETWEEN_READINGS):
        run.advance_all(TICKS_BETWEEN_READINGS)
        if read is not None and shown is not None:
            now = read()
            values[~raised] = now[~raised]
            gap = shown.measure_gap(now).max(axis=1)
            first = gap if tick == TICKS_BETWEEN_READINGS else first
            nearer = ~raised & (gap < nearest - NEARER * first)
            nearest[nearer], nearest_s[nearer] = gap[nearer], tick * world.tick_s
        raised |= run.find_raised(flag)
        progress(int(raised.sum()), world.worlds)
        if raised.all():
            break
    times = run.find_raised_s(flag).max(axis=1)
    works: NDArray[np.bool_] = raised if shown is None else raised & shown.contains(values).all(axis=1)
    mistakes = []
    for row in np.flatnonzero(~works).tolist():
        wrong_s, why = float(nearest_s[row]), f"it comes no nearer, and is not {flag} after {limit_s:.0f} s"
        if raised[row] and shown is not None:
            at = format_value(shown.feature, float(values[row, ~shown.contains(values[row])][0]))
            wrong_s, why = (
                float(times[row]),
                f"{flag} where {shown.feature} is {at}, shown at {shown.describe()}",
            )
        mistakes.append(Mistake(world.seeds[row], binding, wrong_s, why))
    return NewWorldsResult(works, np.where(works, times, np.nan), tuple(mistakes))
