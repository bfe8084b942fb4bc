"""Monitors: whether a property holds in runs of a behavior, when it failed, and how near to failing each run came.

Many worlds are watched side by side. What only concerns the scenario's goal or a flag is watched many ticks at once.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.judging.behavior_run import BehaviorRun
from understudy.judging.outcomes import SuccessMonitor, WorldColumns
from understudy.judging.properties.condition import ClauseTest, Condition, parse_condition
from understudy.judging.properties.contradictions import check_condition
from understudy.judging.properties.goal_progress import GoalProgress
from understudy.judging.properties.margins import NEXT_TO_NOTHING, Margin, bind_condition
from understudy.judging.rollout import TICKS_AT_ONCE, Instant, Monitor, Progress, roll_out, skip_progress
from understudy.judging.world_run import SuccessRule
from understudy.model.property import Property, PropertyKind, StoredMoment
from understudy.model.value_kinds import Column
from understudy.sim.scenario.schema import Scenario

LOOK_S = 1.0
"""How often progress toward a goal is looked at, s."""


@dataclass(frozen=True)
class PropertyOutcomes(WorldColumns):
    """The results of a property in B runs, as columns [B]."""

    failed_s: Column
    """When the property failed, s since the start of the run; NaN where it held."""
    reached_s: Column
    """When the condition of an "always" property held, s since the start of the run; NaN where it did not in time, and
    for other kinds."""
    robustness: Column
    """How far the run was from the other result, from -1 to 1: negative where the property failed."""

    @property
    def held(self) -> NDArray[np.bool_]:
        """True for each run in which the property held [B]."""
        return np.isnan(self.failed_s)


def monitor_property(
    subject: Property,
    run: BehaviorRun,
    flags: Collection[str],
    *,
    limit_s: float | None = None,
    also: Sequence[Monitor] = (),
    progress: Progress = skip_progress,
) -> PropertyOutcomes:
    """Run a behavior from the present moment on, until it is known in every world whether a property holds.

    Parameters
    ----------
    subject
        The property. Where its runs start is not looked at, except that runs from a stored moment, and those of a
        chosen goal, which has no seeds, do not end where the scenario's goal is reached.
    run
        The behavior in B worlds.
    flags
        Names of the flags that the behavior can raise.
    limit_s
        The longest run, s. None: that of the property, or the scenario's. An "always" property needs none: its time
        is the limit.
    also
        Further observers of the worlds, which look before that of the property.
    progress
        Function called repeatedly with the number of completed worlds and their total.

    Returns
    -------
    PropertyOutcomes
        The results. The robustness of "never" is minus the largest margin of its condition over all ticks and agents
        (see `margins`). That of "always" is (T - t) / T if the condition held after t of T seconds; if not, it is minus
        the share of the goal that is left, or for another condition its largest margin. That of "never longer" and
        "progress" is (T - t) / T for the longest time t; a run ends at the tick in which it fails.

    Raises
    ------
    UnknownName
        If the scenario, the robots or the behavior do not have something that the property names.
    SettingError
        If a unit does not fit, or the property needs a goal and the scenario has none.
    """
    watch = make_watch(subject, run, flags)
    world = run.world
    if limit_s is None or subject.kind is PropertyKind.ALWAYS:
        limit_s = find_longest_run(subject)
    if limit_s is None and world is not None:
        limit_s = world.scenario.limit_s
    if limit_s is None:
        raise SettingError(
            where="property", setting="limit_s", problem="is missing", remedy="give the longest run in s"
        )
    roll_out(run, [*also, watch], limit_s, to_goal=watch.to_goal, progress=progress)
    return watch.judge()


def find_longest_run(subject: Property) -> float | None:
    """Find the longest run of a property, s; None if it leaves that to the scenario."""
    if subject.kind is PropertyKind.ALWAYS:
        return subject.seconds
    return None if isinstance(subject.start, StoredMoment) else subject.start.limit_s


def make_watch(subject: Property, run: BehaviorRun, flags: Collection[str]) -> Watch:
    """Make the observer of a property during a run; see `monitor_property` for the errors."""
    seconds = 0.0 if subject.seconds is None else subject.seconds
    start, always = subject.start, subject.kind is PropertyKind.ALWAYS
    to_goal = not isinstance(start, StoredMoment) and bool(start.seeds) and not always
    if subject.kind is PropertyKind.PROGRESS:
        return ProgressWatch(run, seconds, to_goal=to_goal)
    condition = parse_condition(subject.what)
    check_condition(subject.kind, condition)
    margin = bind_condition(condition, run, flags)
    if subject.kind is PropertyKind.NEVER_LONGER:
        return DurationWatch(run, margin, seconds, to_goal=to_goal)
    if run.knows_times and run.is_fused and (flag := find_flag(condition)) is not None:
        return FlagWatch(run, flag, seconds, to_goal=to_goal, wanted=subject.kind is PropertyKind.ALWAYS)
    if subject.kind is PropertyKind.ALWAYS and is_goal(condition):
        return GoalWatch(run, seconds)
    if subject.kind is PropertyKind.ALWAYS:
        return EventWatch(run, margin, seconds)
    return NeverWatch(run, margin, to_goal=to_goal)


def find_flag(condition: Condition) -> str | None:
    """Return the flag if a condition is only that it is raised, else None."""
    clause = condition.single
    raised = clause is not None and clause.comparison is ClauseTest.RAISED and not clause.negated
    return clause.subject if clause is not None and raised else None


def is_goal(condition: Condition) -> bool:
    """Return whether a condition is that the goal of the scenario is reached."""
    clause = condition.single
    return clause is not None and clause.comparison is ClauseTest.REACHED and not clause.negated


class Watch(SuccessMonitor, ABC):
    """Observer of a property in B worlds, which decides which of them succeed by it.

    `failed` and `reached` are the ticks [B] at which the property failed, or what it demands was reached; -1 before.
    `over` are the worlds [B] about which nothing more can be learned. With `to_goal`, runs end at the scenario's goal.
    """

    def __init__(self, run: BehaviorRun, *, to_goal: bool, stride: int = 1) -> None:
        super().__init__(run, stride=stride, to_goal=to_goal)
        self.run, self.worlds, self.tick_s = run, run.worlds, run.body.tick_s
        self.failed, self.reached = np.full(self.worlds, -1), np.full(self.worlds, -1)

    @abstractmethod
    def finish(self, last: int) -> NDArray[np.float64]:
        """Decide what is open after the last tick; return the robustness [B]."""

    def judge(self) -> PropertyOutcomes:
        """Make the outcomes of the property after the last tick."""
        robustness = self.finish(self.run.ticks)
        failed, reached = (
            np.where(each >= 0, each * self.tick_s, np.nan) for each in (self.failed, self.reached)
        )
        size = np.maximum(np.abs(robustness), NEXT_TO_NOTHING)
        return PropertyOutcomes(failed, reached, np.where(self.failed >= 0, -size, size))

    def find_success_s(self, limits: Column) -> Column:
        """Return how long each world took to succeed [B], s: until what is demanded is reached, or else the limit."""
        outcomes = self.judge()
        took = np.where(np.isnan(outcomes.reached_s), limits, outcomes.reached_s)
        return np.where(outcomes.held, took, np.nan)


@dataclass(frozen=True)
class PropertyRule(SuccessRule):
    """Success of a behavior as a property that holds.

    Parameters
    ----------
    subject
        The property. Where its runs start is not used, but for the longest run.
    """

    subject: Property

    @property
    def name(self) -> str:
        """The name of the property, or its claim."""
        return self.subject.name or self.subject.claim

    def find_limit(self, scenario: Scenario) -> float:
        """Return the longest run in a scenario, s."""
        limit_s = find_longest_run(self.subject)
        return scenario.limit_s if limit_s is None else limit_s

    def make_monitor(self, run: BehaviorRun, flags: Collection[str]) -> SuccessMonitor:
        """Make what decides whether the property holds in the worlds of a run."""
        return make_watch(self.subject, run, flags)


class NeverWatch(Watch):
    """Watch a condition that must never hold, for any agent."""

    def __init__(self, run: BehaviorRun, margin: Margin, *, to_goal: bool) -> None:
        super().__init__(run, to_goal=to_goal)
        self._margin, self._worst = margin, np.full(self.worlds, -1.0)

    def look(self, now: Instant) -> None:
        """Observe the worlds."""
        largest = self._margin().max(axis=1, initial=-1.0)
        running = now.running
        self._worst[running] = np.maximum(self._worst, largest)[running]
        self.failed[running & (largest > 0)] = now.tick
        self.over |= largest > 0

    def finish(self, last: int) -> NDArray[np.float64]:
        """Return the robustness [B]."""
        return -self._worst


class TimedWatch(Watch):
    """A watch of a property that demands that something is reached within a time."""

    def __init__(self, run: BehaviorRun, seconds: float, *, to_goal: bool, stride: int = 1) -> None:
        super().__init__(run, to_goal=to_goal, stride=stride)
        self._seconds = seconds

    def fail_late(self, last: int, missed: Column) -> NDArray[np.float64]:
        """Let worlds fail in which nothing was reached; return the robustness [B], that of failures being `missed`."""
        late = self.reached < 0
        self.failed[late] = last
        return np.where(late, missed, (self._seconds - self.reached * self.tick_s) / self._seconds)


class EventWatch(TimedWatch):
    """Watch a condition that must hold within a time, for all agents at once."""

    def __init__(self, run: BehaviorRun, margin: Margin, seconds: float) -> None:
        super().__init__(run, seconds, to_goal=False)
        self._margin, self._best = margin, np.full(self.worlds, -1.0)

    def look(self, now: Instant) -> None:
        """Observe the worlds."""
        least = self._margin().min(axis=1, initial=1.0)
        self._best = np.maximum(self._best, least)
        self.reached[now.running & (least > 0)] = now.tick
        self.over |= least > 0

    def finish(self, last: int) -> NDArray[np.float64]:
        """Let worlds fail in which it has not held; return the robustness [B]."""
        return self.fail_late(last, self._best)


class GoalWatch(TimedWatch):
    """Watch that the goal of the scenario is reached within a time, many ticks at once."""

    def __init__(self, run: BehaviorRun, seconds: float) -> None:
        super().__init__(run, seconds, to_goal=True, stride=TICKS_AT_ONCE if run.is_fused else 1)
        self._left = GoalProgress(run.world)
        self._first = self._left.world.state.tick.copy()

    def look(self, now: Instant) -> None:
        """Observe the worlds."""
        finished = self._left.world.state.finished
        new = now.running & (finished >= 0)
        self.reached[new] = np.maximum(finished - self._first, 0)[new]
        self.over |= new

    def finish(self, last: int) -> NDArray[np.float64]:
        """Let worlds fail that have not reached the goal; return the robustness [B]."""
        return self.fail_late(last, -self._left.share_left())


class FlagWatch(TimedWatch):
    """Watch whether a flag is raised, many ticks at once: by all agents within a time if `wanted`, or never by any."""

    def __init__(self, run: BehaviorRun, flag: str, seconds: float, *, to_goal: bool, wanted: bool) -> None:
        super().__init__(run, seconds, to_goal=to_goal, stride=TICKS_AT_ONCE)
        self._flag, self._wanted = flag, wanted

    def look(self, now: Instant) -> None:
        """Observe the worlds."""
        times = self.run.find_raised_s(self._flag)
        when = times.max(axis=1) if self._wanted else np.fmin.reduce(times, axis=1)
        new = now.running & ~np.isnan(when)
        noted = self.reached if self._wanted else self.failed
        noted[new] = np.rint(when[new] / self.tick_s)
        self.over |= new

    def finish(self, last: int) -> NDArray[np.float64]:
        """Let worlds fail without a wanted flag; return the robustness [B]."""
        if self._wanted:
            return self.fail_late(last, np.full(self.worlds, -1.0))
        return np.ones(self.worlds)


class LastingWatch(Watch):
    """An observer in each world of a condition that must not hold longer than a given time."""

    def __init__(self, run: BehaviorRun, seconds: float, *, to_goal: bool, stride: int = 1) -> None:
        super().__init__(run, to_goal=to_goal, stride=stride)
        self._seconds, self._longest = seconds, np.zeros(self.worlds)

    def note_duration(self, lasted: Column, now: Instant) -> None:
        """Note how long it has lasted in each world [B], s, and let worlds fail in which it was too long."""
        running = now.running
        self._longest[running] = np.maximum(self._longest, lasted)[running]
        late = running & (lasted > self._seconds + 1e-9)
        self.failed[late] = now.tick
        self.over |= late

    def finish(self, last: int) -> NDArray[np.float64]:
        """Return the robustness [B]."""
        return (self._seconds - self._longest) / self._seconds


class DurationWatch(LastingWatch):
    """Watch a condition that must hold for no longer than a time without a break, for any agent."""

    def __init__(self, run: BehaviorRun, margin: Margin, seconds: float, *, to_goal: bool) -> None:
        super().__init__(run, seconds, to_goal=to_goal)
        self._margin = margin
        self._since: NDArray[np.float64] | None = None

    def look(self, now: Instant) -> None:
        """Observe the worlds."""
        holds = self._margin() > 0
        if self._since is None:
            self._since = np.full(holds.shape, np.nan)
        self._since = np.where(holds, np.where(np.isnan(self._since), now.tick, self._since), np.nan)
        lasted: Column = np.nan_to_num(now.tick - self._since).max(axis=1, initial=0.0) * self.tick_s
        self.note_duration(lasted, now)


class ProgressWatch(LastingWatch):
    """Watch the time in which the scenario's goal comes no nearer, once a second."""

    def __init__(self, run: BehaviorRun, seconds: float, *, to_goal: bool) -> None:
        super().__init__(run, seconds, to_goal=to_goal, stride=max(1, round(LOOK_S / run.body.tick_s)))
        self._goal = GoalProgress(run.world)
        self._least, self._since = self._goal.measure_remainder(), np.zeros(self.worlds, np.int64)

    def look(self, now: Instant) -> None:
        """Observe the worlds."""
        left = self._goal.measure_remainder()
        nearer = left <= self._least - self._goal.step
        self._least[nearer], self._since[nearer | (left <= 0)] = left[nearer], now.tick
        self.note_duration((now.tick - self._since).astype(np.float64) * self.tick_s, now)
