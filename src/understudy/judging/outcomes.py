"""Outcomes of worlds: in which a behavior succeeded and when, as monitors of its runs measure them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Self

import numpy as np
from numpy.typing import NDArray

from understudy.judging.behavior_run import BehaviorRun
from understudy.judging.rollout import (
    TICKS_AT_ONCE,
    Instant,
    Monitor,
    Progress,
    roll_out,
    skip_progress,
)
from understudy.model.value_kinds import Column


@dataclass(frozen=True)
class WorldColumns:
    """The base of results of N worlds, whose fields are columns of shape [N]."""

    def select(self, rows: Sequence[int] | NDArray[np.intp]) -> Self:
        """Return the results of some worlds, given their rows."""
        return type(self)(*(getattr(self, each.name)[list(rows)] for each in fields(self)))

    @classmethod
    def concatenate(cls, parts: Sequence[Self]) -> Self:
        """Join the results of several batches, in order."""
        return cls(*(np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(cls)))


@dataclass(frozen=True)
class Outcomes(WorldColumns):
    """The results of N worlds, as columns of shape [N]."""

    seconds: Column
    """Time to finish, in s. NaN if the limit came first."""
    limit_s: Column
    """Time limit of each world, in s."""
    delivered: NDArray[np.int64]
    """Units of food delivered within that time."""
    gathered: NDArray[np.int64]
    """Boxes gathered within that time."""

    @property
    def finished(self) -> NDArray[np.bool_]:
        """True for each world [N] that finished in time."""
        return ~np.isnan(self.seconds)

    @property
    def success(self) -> float:
        """The share of worlds that finished in time."""
        return float(self.finished.mean())

    @property
    def spent_s(self) -> Column:
        """Time until each world finished or reached its limit [N], in s."""
        return np.where(self.finished, self.seconds, self.limit_s)

    @property
    def food_per_s(self) -> Column:
        """Food delivered per second until the world finished or reached its limit [N]; NaN if no time passed."""
        spent = self.spent_s
        rate: Column = np.divide(self.delivered, spent, out=np.full(len(spent), np.nan), where=spent > 0)
        return rate


class SuccessMonitor(Monitor, ABC):
    """Observer that decides which worlds succeed, and ends those of which that is known.

    Parameters
    ----------
    run
        The behavior in B worlds.
    stride
        The number of ticks between two looks.
    to_goal
        Whether worlds also end where they reach the scenario's goal.
    """

    def __init__(self, run: BehaviorRun, *, stride: int = 1, to_goal: bool = False) -> None:
        super().__init__(run.worlds, stride=stride)
        self.to_goal, self._world = to_goal, run.world
        self._delivered, self._gathered = np.zeros((2, run.worlds), np.int64)

    def end(self, ended: NDArray[np.bool_]) -> None:
        """Note the food and boxes of worlds that have just ended."""
        if self._world is not None:
            self._delivered[ended] = self._world.delivered[ended]
            self._gathered[ended] = self._world.gathered[ended]

    def make_outcomes(self, limit_s: float | Column) -> Outcomes:
        """Make the outcomes of all worlds after the last tick, with the limit of each, s."""
        limits = np.broadcast_to(np.asarray(limit_s, np.float64), self.over.shape).copy()
        return Outcomes(self.find_success_s(limits), limits, self._delivered, self._gathered)

    @abstractmethod
    def find_success_s(self, limits: Column) -> Column:
        """Return how long each world took to succeed [B], s, given its limit; NaN where it has not."""


class EventMonitor(SuccessMonitor):
    """Observer that ends each world when it has succeeded, and notes when that was.

    Parameters
    ----------
    run
        The behavior in B worlds.
    find_s
        Returns when each world succeeded [B], s since the run began; NaN where it has not.
    stride
        The number of ticks between two looks: 1 if a success is seen only when it happens.
    to_goal
        Whether worlds also end where they reach the scenario's goal.
    """

    def __init__(
        self, run: BehaviorRun, find_s: Callable[[], Column], *, stride: int = 1, to_goal: bool = False
    ) -> None:
        super().__init__(run, stride=stride, to_goal=to_goal)
        self._find = find_s
        self.seconds = np.full(run.worlds, np.nan)
        """When each world succeeded [B], s; NaN where it has not in time."""

    def look(self, now: Instant) -> None:
        """Note which worlds have succeeded."""
        times = self._find()
        new = now.running & ~np.isnan(times)
        self.seconds[new] = times[new]
        self.over |= new

    def find_success_s(self, limits: Column) -> Column:
        """Return when each world succeeded [B], s; NaN where it has not."""
        return self.seconds


def monitor_goal(run: BehaviorRun) -> EventMonitor:
    """Make what ends a world when it has reached its scenario's goal."""
    world = run.get_world()
    stride = TICKS_AT_ONCE if run.is_fused else 1
    return EventMonitor(run, lambda: world.finished_s, stride=stride, to_goal=True)


def monitor_flag(run: BehaviorRun, flag: str, *, stride: int = TICKS_AT_ONCE) -> EventMonitor:
    """Make what ends a world when all agents that run the behavior have raised a flag.

    Parameters
    ----------
    run
        The behavior in B worlds.
    flag
        Name of the flag.
    stride
        The number of ticks between two looks, where it is known later when a flag was raised; else each tick is.

    Returns
    -------
    EventMonitor
        The monitor.
    """
    if run.knows_times:
        stride = stride if run.is_fused else 1
        return EventMonitor(run, lambda: run.find_raised_s(flag).max(axis=1), stride=stride)
    return monitor_condition(run, lambda: run.find_raised(flag))


def monitor_condition(run: BehaviorRun, is_reached: Callable[[], NDArray[np.bool_]]) -> EventMonitor:
    """Make what ends a world when a condition, which is asked after each tick, holds there for the first time."""
    return EventMonitor(run, lambda: np.where(is_reached(), run.time_s, np.nan))


def measure_success(
    run: BehaviorRun,
    limit_s: float | Column,
    *,
    flag: str | None = None,
    progress: Progress = skip_progress,
) -> Outcomes:
    """Run worlds until each has reached its scenario's goal, or until all have raised a `flag`.

    Parameters
    ----------
    run
        The behavior in B worlds, before the first tick.
    limit_s
        The time limit, s, one for all worlds or a column [B].
    flag
        The flag that counts as success. None: the goal does.
    progress
        Function called repeatedly with the number of completed worlds and their total; an exception that it raises
        ends the runs.

    Returns
    -------
    Outcomes
        The results.
    """
    success = monitor_goal(run) if flag is None else monitor_flag(run, flag)
    roll_out(run, [success], limit_s, to_goal=success.to_goal, progress=progress)
    return success.make_outcomes(limit_s)
