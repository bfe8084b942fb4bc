"""Runs of what was taught in new worlds: where it works, and where and when it goes wrong.

In each world runs what the session runs: one agent is trained, the others do what they do there. A behavior works where
the goal that a person has chosen for it holds. Without one, a behavior with a flag works where the trained agent raises
it in time at values that agree with what was shown; any other where the scenario's goal is reached in time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from understudy.addons.checks.falsification.session_setup import CoordinatorRun, SessionSetup
from understudy.judging.baseline import LENIENCE, find_baseline, measure_baseline
from understudy.judging.behavior_run import BehaviorRun, ProgramRun
from understudy.judging.criteria import TICKS_BETWEEN_READINGS, judge_runs
from understudy.judging.evaluate import find_flags, make_evaluation_task
from understudy.judging.outcomes import monitor_flag
from understudy.judging.properties.goal_progress import ProgressMonitor
from understudy.judging.properties.monitor import monitor_property
from understudy.judging.properties.offered_goals import find_behavior_success
from understudy.judging.raised_range import find_shown_goal
from understudy.judging.rollout import Instant, Monitor, Progress, roll_out, skip_progress
from understudy.learning.shown_ranges import ShownRange
from understudy.model.describe import format_value
from understudy.model.library import Library
from understudy.model.property import Property
from understudy.model.value_kinds import Categorical, Column

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
    raised
        The values at which the flag was raised where it works, in no order; none if it counts wherever it is raised.
    """

    works: NDArray[np.bool_]
    seconds: Column
    mistakes: tuple[Mistake, ...]
    raised: Column = field(default_factory=lambda: np.empty(0))


class JudgedWorlds(Protocol):
    """Worlds in which a behavior can be run and judged."""

    def run(
        self,
        library: Library,
        behavior: str,
        binding: Mapping[str, str],
        *,
        progress: Progress = skip_progress,
    ) -> NewWorldsResult:
        """Run a behavior in these worlds; an exception that `progress` raises ends the runs."""
        ...


@dataclass(frozen=True)
class NewWorlds:
    """New worlds in which a behavior is run as a session runs it.

    Parameters
    ----------
    setup
        Who is trained where, and what the others do.
    seeds
        The seed of each world.
    shown
        Where a flag counts. None: where the presses for it in the behavior's own lesson have most in common.
    """

    setup: SessionSetup
    seeds: Sequence[int]
    shown: ShownRange | None = None

    @cached_property
    def limits_s(self) -> float | Column:
        """The time in which a behavior has to reach the scenario's goal, s, for all worlds or each [K].

        It is three times what the scenario's baseline takes, if there is one; the scenario's limit if other agents
        idle, with which the baseline cannot be compared.
        """
        scenario = self.setup.scenario
        baseline = None if self.setup.idle_agents else find_baseline(scenario)
        if baseline is None:
            return scenario.limit_s
        limits: Column = LENIENCE * measure_baseline(baseline, self.seeds).spent_s
        return limits

    def run(
        self,
        library: Library,
        behavior: str,
        binding: Mapping[str, str],
        *,
        observe: Callable[[BehaviorRun], Sequence[Monitor]] = lambda run: (),
        progress: Progress = skip_progress,
    ) -> NewWorldsResult:
        """Run a behavior in these worlds.

        Parameters
        ----------
        library
            The library of the trained agent.
        behavior
            Name of the behavior.
        binding
            The target of each parameter.
        observe
            Makes further observers of the run.
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
        success = find_behavior_success(library, behavior)
        if isinstance(success, Property):
            return self._run_goal(library, behavior, binding, success, observe, progress)
        if success is not None:
            shown = self.shown or find_shown_goal(library, behavior, success)
            run = self.setup.start(self.seeds, library, behavior, binding)
            # A robot with a flag stays where it is, and can be read later, unless others move. A coordinator's members
            # get another order, and no longer report the same.
            step = 1 if self.setup.do_others_move and shown is not None else TICKS_BETWEEN_READINGS
            return _run_to_flag(run, binding, success, shown, step, also=observe(run), progress=progress)
        task = make_evaluation_task(library, behavior, self.setup.scenario, binding=binding)
        run = self.setup.start(self.seeds, library, behavior, binding)
        judged = judge_runs(
            run, self.seeds, task.criteria, self.limits_s, also=observe(run), progress=progress
        )
        outcomes = judged.outcomes
        failed = [self.seeds[row] for row in np.flatnonzero(~outcomes.finished)[:MOST_TIMED].tolist()]
        ended = self._find_end_of_progress(failed, library, behavior, binding, float(outcomes.limit_s.max()))
        why = "there is no more progress, and the goal of the world is not reached in time"
        mistakes = [Mistake(seed, binding, wrong_s, why) for seed, wrong_s in zip(failed, ended, strict=True)]
        return NewWorldsResult(outcomes.finished, outcomes.seconds, tuple(mistakes))

    def _find_end_of_progress(
        self,
        seeds: Sequence[int],
        library: Library,
        behavior: str,
        binding: Mapping[str, str],
        limit_s: float,
    ) -> list[float]:
        """Find when progress towards the scenario's goal ended in each of some failing worlds, s."""
        if not seeds:
            return []
        run = self.setup.start(seeds, library, behavior, binding)
        progress = ProgressMonitor(run)
        roll_out(run, [progress], limit_s, to_goal=True)
        ended: list[float] = progress.last_s.tolist()
        return ended

    def _run_goal(
        self,
        library: Library,
        behavior: str,
        binding: Mapping[str, str],
        goal: Property,
        observe: Callable[[BehaviorRun], Sequence[Monitor]],
        progress: Progress,
    ) -> NewWorldsResult:
        """Run worlds until it is known whether a chosen goal holds."""
        run = self.setup.start(self.seeds, library, behavior, binding)
        flags = find_flags(library, behavior)
        outcomes = monitor_property(goal, run, flags, also=observe(run), progress=progress)
        limit_s = goal.seconds if goal.is_timed else goal.start.limit_s
        limit_s = self.setup.scenario.limit_s if limit_s is None else limit_s
        seconds = np.where(np.isnan(outcomes.reached_s), limit_s, outcomes.reached_s)
        why = f"this does not hold: it {goal.name}" if goal.name else f"this does not hold: {goal.claim}"
        mistakes = [
            Mistake(self.seeds[row], binding, float(outcomes.failed_s[row]), why)
            for row in np.flatnonzero(~outcomes.held).tolist()
        ]
        return NewWorldsResult(outcomes.held, np.where(outcomes.held, seconds, np.nan), tuple(mistakes))


class _Approach(Monitor):
    """Observer of the value at which each agent raises a flag, and how near it was before to where that was shown."""

    def __init__(self, run: BehaviorRun, shown: ShownRange, *, stride: int) -> None:
        super().__init__(run.worlds, stride=stride)
        self._shown = shown
        self._read = run.find_reading(str(shown.feature)).read
        self._before = self._read()
        self.values = np.full((run.worlds, 1), np.nan)
        """The values [B, 1] when the flag was raised, or at last."""
        self.nearest_s = np.zeros(run.worlds)
        """When each world came nearest [B], s."""
        self._nearest, self._first = np.full((2, run.worlds), np.inf)

    def look(self, now: Instant) -> None:
        """Read the values on which agents have decided: where each tick is looked at, those before it."""
        values = self._read()
        decided_on = self._before if self.stride == 1 else values
        self._before = values
        if now.tick == 0:
            return
        self.values[now.running] = decided_on[now.running]
        gap = self._shown.measure_gap(decided_on).max(axis=1)
        self._first = np.where(np.isinf(self._first), gap, self._first)  # it may be absent for a while
        nearer = now.running & (gap + NEARER * self._first < self._nearest)
        self._nearest[nearer], self.nearest_s[nearer] = gap[nearer], now.time_s


def _run_to_flag(
    run: ProgramRun | CoordinatorRun,
    binding: Mapping[str, str],
    flag: str,
    shown: ShownRange | None,
    step: int,
    *,
    also: Sequence[Monitor],
    progress: Progress,
) -> NewWorldsResult:
    """Run worlds until the trained agent of each has raised a flag, or for LONGEST_RUN_S; look at each `step` ticks."""
    world = run.get_world()
    limit_s = min(world.scenario.limit_s, LONGEST_RUN_S)
    approach = None if shown is None else _Approach(run, shown, stride=step)
    success = monitor_flag(run, flag, stride=step)
    monitors: list[Monitor] = [success] if approach is None else [approach, success]
    roll_out(run, [*also, *monitors], limit_s, progress=progress)
    times = success.seconds
    raised = works = ~np.isnan(times)
    if shown is not None and approach is not None:
        works = raised & shown.contains(approach.values).all(axis=1)
    measured = shown is not None and not isinstance(shown.feature.kind, Categorical)
    no_nearer = "it comes no nearer, and " if measured else "it "
    mistakes = []
    for row in np.flatnonzero(~works).tolist():
        wrong_s, why = 0.0, f"{no_nearer}is not {flag} after {limit_s:.0f} s"
        if shown is not None and approach is not None:
            wrong_s, values = float(approach.nearest_s[row]), approach.values[row]
            if raised[row]:
                at = format_value(shown.feature, float(values[~shown.contains(values)][0]))
                wrong_s, why = (
                    float(times[row]),
                    f"{flag} where {shown.feature} is {at}, shown at {shown.describe()}",
                )
        mistakes.append(Mistake(world.seeds[row], binding, wrong_s, why))
    at_flags = np.empty(0) if approach is None else approach.values[works].ravel()
    return NewWorldsResult(works, np.where(works, times, np.nan), tuple(mistakes), at_flags)
