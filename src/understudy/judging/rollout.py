"""Run a behavior in many worlds until each has ended, while monitors observe them between ticks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.judging.behavior_run import BehaviorRun
from understudy.model.value_kinds import Column

Progress: TypeAlias = Callable[[int, int], None]
"""A function that is called with the number of completed worlds and their total.

An exception that it raises ends the runs.
"""


def skip_progress(through: int, worlds: int) -> None:
    """Ignore a report of progress."""


WORLDS_AT_ONCE = 5_000
"""The largest number of worlds that are simulated together, to bound memory."""
TICKS_AT_ONCE = 200
"""The number of ticks simulated between two checks of which worlds have succeeded."""


@dataclass(slots=True)
class Instant:
    """An instant of a run of B worlds, between two ticks.

    Parameters
    ----------
    tick
        The number of ticks since the run began.
    time_s
        The time since the run began, s.
    running
        The worlds [B] that have not ended.
    """

    tick: int
    time_s: float
    running: NDArray[np.bool_]


class Monitor:
    """Observer of the B worlds of a run, which looks before the first tick, and after each `stride` ticks.

    Parameters
    ----------
    worlds
        The number of worlds.
    stride
        The number of ticks between two looks.
    """

    def __init__(self, worlds: int, *, stride: int = 1) -> None:
        self.stride = stride
        self.over = np.zeros(worlds, np.bool_)
        """The worlds [B] that end, as far as this monitor decides it."""

    def look(self, now: Instant) -> None:
        """Observe the worlds, and mark those that are `over`."""

    def end(self, ended: NDArray[np.bool_]) -> None:
        """Observe the worlds [B] that have just ended, or reached their limit, for the last time."""


def roll_out(
    run: BehaviorRun,
    monitors: Sequence[Monitor],
    limit_s: float | Column,
    *,
    to_goal: bool = False,
    progress: Progress = skip_progress,
) -> None:
    """Run worlds until each has ended or reached its time limit.

    Parameters
    ----------
    run
        The behavior in B worlds.
    monitors
        The observers of the worlds, in the order in which they look. A world ends as soon as one of them says so.
    limit_s
        The time limit, s, one for all worlds or a column [B].
    to_goal
        Whether a world also ends where it reaches the scenario's goal.
    progress
        Function called repeatedly with the number of completed worlds and their total; an exception that it raises
        ends the runs.

    Raises
    ------
    SettingError
        If the limit is not a time, or a body that is not simulated does not advance its time.
    """
    limits = np.broadcast_to(np.asarray(limit_s, np.float64), (run.worlds,))
    if not (np.isfinite(limits) & (limits >= 0)).all():
        raise SettingError(where="measure", setting="limit_s", problem="is not a time", remedy="give seconds")
    running = np.ones(run.worlds, np.bool_)
    while True:
        left = run.count_ticks_left(limits)
        last = running & (left <= 0)
        if to_goal and run.world is not None:
            last |= running & (run.world.state.finished >= 0)
        now = Instant(run.ticks, run.time_s, running & (run.time_s <= limits + 1e-9))
        for monitor in monitors:
            if last.any() or run.ticks % monitor.stride == 0:
                monitor.look(now)
                now.running &= ~monitor.over
        ended = running & (~now.running | last)
        if ended.any():
            for monitor in monitors:
                monitor.end(ended)
            running &= ~ended
        progress(run.worlds - int(running.sum()), run.worlds)
        if not running.any():
            return
        until_look = min((each.stride - run.ticks % each.stride for each in monitors), default=TICKS_AT_ONCE)
        run.advance(min(until_look, int(left[running].min())), to_goal=to_goal, ended=~running)
