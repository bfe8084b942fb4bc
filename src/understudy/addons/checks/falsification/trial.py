"""Runs in given worlds, with their robustness: how far each run was from failing, or how badly it failed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.addons.checks.falsification.joint_worlds import Trial, group_alike, lay_out_each
from understudy.judging.behavior_run import BehaviorRun, ProgramRun
from understudy.judging.evaluation_task import EvaluationTask
from understudy.judging.outcomes import WorldColumns, monitor_flag, monitor_goal
from understudy.judging.properties.goal_progress import ProgressMonitor
from understudy.judging.rollout import Instant, Monitor, roll_out
from understudy.model.describe import format_value
from understudy.model.value_kinds import Column
from understudy.sim.scenario.schema import Scenario
from understudy.sim.world import World

WORLDS_AT_ONCE = 1_900
"""The number of worlds that run side by side: so few that each process simulates them in one thread."""

TICKS_AT_ONCE = 50
"""The number of ticks between two looks at the progress of all worlds."""

LOOKS = 20
"""The number of last looks at which the states of runs that have not ended are noted."""

LEAST_BADNESS = 1e-3
"""The distance from 0 of the robustness of a run that failed at the very end."""


@dataclass(frozen=True)
class TrialResults(WorldColumns):
    """The results of n runs, as columns [n]."""

    robustness: Column
    """The distance from failing: above 0 to 1 for success, nearer to 0 the closer the limit; below 0 for failure."""
    failed_s: Column
    """The time at which it was clear that the run had failed, s; NaN if it did not fail."""
    progress_s: Column
    """The time of the last progress towards the goal, s."""

    last_states: NDArray[np.object_]
    """The names of the innermost states in the last moments of each run that failed, a frozenset; empty otherwise."""

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Which of the runs failed [n]."""
        return np.asarray(self.robustness < 0)

    def __len__(self) -> int:
        return len(self.robustness)


@dataclass(frozen=True, slots=True)
class WrongMoment:
    """The moment at which the run of a failing world went wrong.

    Parameters
    ----------
    tick
        The number of ticks before it.
    label
        Its name, for pictures.
    sentence
        What happened then.
    """

    tick: int
    label: str
    sentence: str


Measure: TypeAlias = Callable[[Sequence[Trial]], TrialResults]
"""A function that runs a behavior in the given worlds and returns the results in the same order."""


@dataclass(frozen=True)
class TrialMeasure(ABC):
    """Runs of a behavior in given worlds, and how they are judged.

    Parameters
    ----------
    task
        The behavior and its criteria. Its world is not used.
    limit_s
        The time limit, s. None: that of each scenario.
    """

    task: EvaluationTask
    limit_s: float | None = None
    is_cause_later: ClassVar[bool]
    """True if the decision that explains a failure is the first after the run went wrong; else the last before it."""

    def __call__(self, trials: Sequence[Trial]) -> TrialResults:
        """Run the behavior in the given worlds, as many side by side as differ only in places and amounts."""
        parts: list[tuple[list[int], TrialResults]] = []
        for rows in group_alike(trials):
            for first in range(0, len(rows), WORLDS_AT_ONCE):
                some = rows[first : first + WORLDS_AT_ONCE]
                parts.append((some, self.run_together([trials[row] for row in some])))
        order = np.argsort([row for rows, _ in parts for row in rows])
        return TrialResults.concatenate([part for _, part in parts]).select(order)

    @property
    def name_in_file(self) -> str | None:
        """The name of the property in the library's file by which runs are judged; None if they are otherwise."""
        return None

    def get_limit(self, scenario: Scenario) -> float:
        """Return the time limit in a scenario, s."""
        return scenario.limit_s if self.limit_s is None else self.limit_s

    def start(self, trials: Sequence[Trial]) -> BehaviorRun:
        """Start the behavior in new worlds that differ only in places and amounts, before the first tick."""
        run = self.task.make_run(trials[0].scenario, [trial.seed for trial in trials])
        lay_out_each(run.get_world(), trials)
        return run

    @abstractmethod
    def run_together(self, trials: Sequence[Trial]) -> TrialResults:
        """Run the behavior in worlds that differ only in places and amounts."""

    @abstractmethod
    def find_wrong_moment(self, trial: Trial, *, until_s: float) -> WrongMoment:
        """Find the moment, until a time (s), at which the run of a failing world went wrong, by running it again."""

    def choose_robot(self, trial: Trial, wrong: int) -> int:
        """Choose the robot to explain in a failing world that went wrong at a tick.

        It is the one that begins farthest from the goal's target if all have to be there, else the first.
        """
        world, goal = World(trial.scenario, [trial.seed]), trial.scenario.goal
        if goal is None or goal.target is None or not goal.all:
            return 0
        view = world.view()
        rows = view.objects.kind == view.names.classes.index(goal.target)
        if not rows.any():
            return 0
        x, y = view.objects.x[rows], view.objects.y[rows]
        apart = np.hypot(view.robots.x[:, None] - x, view.robots.y[:, None] - y).min(axis=1)
        return int(apart.argmax())


@dataclass(frozen=True)
class GoalMeasure(TrialMeasure):
    """Runs of a behavior until it reaches its goal, the scenario's or its own flag, or the time limit.

    The robustness of a run that reached the goal is the share of the limit that was left. Otherwise it is minus the
    share of the goal that was missing: of food to deliver, boxes to gather or distance to a target. A run went wrong
    where its progress ended.

    A flag counts only where it was shown. A run in which it was raised elsewhere went wrong there; its robustness is
    -d / (1 + d) for the distance d from what was shown, in the unit of that reading.
    """

    is_cause_later = True

    def find_wrong_moment(self, trial: Trial, *, until_s: float) -> WrongMoment:
        """Find the moment at which progress ended, or the tick before the flag was raised elsewhere than shown."""
        if (elsewhere := self._find_elsewhere(trial)) is not None:
            raised_s, where = elsewhere
            tick = round(raised_s / trial.scenario.tick_s) - 1
            return WrongMoment(
                tick, f"{self.task.criteria.flag} elsewhere", f"At {raised_s:.1f} s it was {where}."
            )
        run = self.start([trial])
        progress = ProgressMonitor(run, stride=1)
        roll_out(run, [progress], until_s)
        last_s = float(progress.last_s[0])
        sentence = (
            f"From {last_s:.1f} s on there was no more progress."
            if last_s
            else "There was never any progress."
        )
        return WrongMoment(round(last_s / run.body.tick_s), "last progress", sentence)

    def run_together(self, trials: Sequence[Trial]) -> TrialResults:
        """Run the behavior in worlds that differ only in places and amounts, many ticks at once."""
        run, scenario = self.start(trials), trials[0].scenario
        flag, tick_s = self.task.criteria.flag, scenario.tick_s
        limit_s = self.get_limit(scenario)
        success = monitor_goal(run) if flag is None else monitor_flag(run, flag, stride=TICKS_AT_ONCE)
        progress, states = ProgressMonitor(run), _LastStates(run, limit_s)
        roll_out(run, [success, progress, states], limit_s, to_goal=flag is None)
        reached_s = success.seconds
        reached = ~np.isnan(reached_s)
        missing = np.maximum(1.0 - progress.best, LEAST_BADNESS)
        gap = np.where(reached, self._measure_gap(run), 0.0)
        agrees, elsewhere = reached & (gap == 0), reached & (gap > 0)
        missing[elsewhere] = np.maximum(1.0 - 1.0 / (1.0 + gap[elsewhere]), LEAST_BADNESS)
        ended_s = np.where(elsewhere, reached_s, limit_s)
        wrong_s = np.where(elsewhere, reached_s - tick_s, progress.last_s)
        return TrialResults(
            robustness=np.where(agrees, (limit_s - np.nan_to_num(reached_s)) / limit_s, -missing),
            failed_s=np.where(agrees, np.nan, ended_s),
            progress_s=np.where(agrees, reached_s, wrong_s),
            last_states=states.list_sets(np.asarray(~reached)),
        )

    def _measure_gap(self, run: BehaviorRun) -> Column:
        """Measure how far each world is now from where the flag was shown [B]; 0 where that is not known."""
        shown_range = self.task.criteria.shown
        if shown_range is None:
            return np.zeros(run.body.worlds if isinstance(run.body, World) else 1)
        values = run.find_reading(str(shown_range.feature)).read()
        gap = np.where(
            shown_range.contains(values), 0.0, np.maximum(shown_range.measure_gap(values), LEAST_BADNESS)
        )
        farthest: Column = gap.max(axis=1)
        return farthest

    def _find_elsewhere(self, trial: Trial) -> tuple[float, str] | None:
        """Find when the flag was raised elsewhere than shown, s, and describe where; None if it was not."""
        flag, shown_range = self.task.criteria.flag, self.task.criteria.shown
        if flag is None or shown_range is None:
            return None
        run = self.start([trial])
        success = monitor_flag(run, flag, stride=1)
        roll_out(run, [success], self.get_limit(trial.scenario))
        values = run.find_reading(str(shown_range.feature)).read()[0]
        away = values[~shown_range.contains(values)]
        if np.isnan(success.seconds[0]) or not len(away):
            return None
        at = format_value(shown_range.feature, float(away[0]))
        return float(success.seconds[0]), (
            f"{flag} where {shown_range.feature} was {at}, shown at {shown_range.describe()}"
        )


class _LastStates(Monitor):
    """The innermost states of the robots of all running worlds, at the last LOOKS looks before the limit."""

    def __init__(self, run: BehaviorRun, limit_s: float) -> None:
        super().__init__(run.worlds, stride=TICKS_AT_ONCE)
        self._run, self._last = run, int(run.count_ticks_left(np.array([limit_s]))[0])
        self._seen: dict[int, set[str]] = {}

    def look(self, now: Instant) -> None:
        """Add the present states to what was seen of each world."""
        run = self._run
        if not now.tick or self._last - now.tick >= LOOKS * TICKS_AT_ONCE:
            return
        robots, paths = run.get_world().robots, None if run.team is None else run.team.paths
        for world in np.flatnonzero(now.running).tolist():
            for row in range(world * robots, (world + 1) * robots):
                path = (
                    run.engine.path(row)
                    if paths is None and isinstance(run, ProgramRun)
                    else (paths or [()])[row]
                )
                self._seen.setdefault(world, set()).update(path[-1:])

    def list_sets(self, failed: NDArray[np.bool_]) -> NDArray[np.object_]:
        """Return what was seen of each world that failed, a set; empty for others."""
        sets = np.empty(len(failed), np.object_)
        for world, each in enumerate(failed.tolist()):
            sets[world] = frozenset(self._seen.get(world, ()) if each else ())
        return sets
