"""Runs of controllers, programs and teams in simulated worlds until each world has finished or reached its limit."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.analysis.behavior_run import find_raised_by_all, find_raised_members, find_raised_times
from understudy.analysis.outcomes import Outcomes
from understudy.errors import SettingError
from understudy.model.features import Percept, ReadingKey
from understudy.model.kinds import Column
from understudy.runtime.body import Commands
from understudy.runtime.engine.engine import Engine
from understudy.runtime.program import Program
from understudy.runtime.team.team import Team
from understudy.sim.world import World

DecideCommands: TypeAlias = Callable[[Percept], Commands]
Progress: TypeAlias = Callable[[int, int], None]
"""A function that is called with the number of completed worlds and their total.

An exception that it raises ends the evaluation.
"""


def skip_progress(through: int, worlds: int) -> None:
    """Ignore a report of progress."""


TICKS_AT_ONCE = 200
"""The number of ticks simulated between two checks of which worlds have finished."""
TICKS_BETWEEN_READINGS = 10
"""The number of ticks simulated between two checks if something is read where a single robot raises a flag."""
AtEnd: TypeAlias = Callable[[NDArray[np.bool_]], None]
"""A function that is called with the worlds [B] that have just finished or reached their limit."""
Look: TypeAlias = Callable[[NDArray[np.bool_]], None]
"""A function that is called at every check with the agents of each world that have raised the flag [B, n]."""


def measure_outcomes(
    world: World,
    decide: DecideCommands,
    keys: Sequence[ReadingKey],
    *,
    limit_s: float | Column,
    progress: Progress = skip_progress,
) -> Outcomes:
    """Run a controller until each world has reached its goal or its limit (s, one for all or a column [B]).

    A world that is finished runs on, without being recorded, until all worlds are.
    """

    def advance(ticks: int) -> None:
        for _ in range(ticks):
            world.act(decide(world.sense(keys)))

    return measure_worlds(world, advance, lambda: world.finished_s, limit_s, at_once=1, progress=progress)


def measure_program_outcomes(
    world: World,
    program: Program,
    *,
    limit_s: float | Column,
    flag: str | None = None,
    progress: Progress = skip_progress,
    look: Look | None = None,
) -> Outcomes:
    """Run one program on all robots until each world has finished or reached its time limit.

    The limit is in s, one for all worlds or a column [B]. With a flag, `look` is called after each tick, or with a
    single robot, which stays where it has raised the flag, after TICKS_BETWEEN_READINGS.

    With a `flag`, a world is finished once all its robots have raised it, whatever its goal; otherwise once its goal
    is reached. Many ticks are simulated at once if the whole program can be compiled. Reset the worlds before further
    use: they may have stopped at different ticks, each soon after it finished.
    """
    engine = Engine.from_program(world, program)
    plan = engine.plan()

    def advance(ticks: int) -> None:
        if plan is not None:
            ended = None if flag is None else ~np.isnan(finished_s())
            world.advance(plan, ticks, until_finished=flag is None, ended=ended)
        else:
            for _ in range(ticks):
                engine.tick()

    def finished_s() -> Column:
        if flag is None:
            return world.finished_s
        last: Column = find_raised_times(engine, flag, worlds=world.worlds).max(axis=1)  # of all its robots
        return last

    def look_at_raised() -> None:
        if look is not None and flag is not None:
            look(engine.find_raised(flag).reshape(world.worlds, -1))

    at_once = TICKS_AT_ONCE if look is None else TICKS_BETWEEN_READINGS if world.robots == 1 else 1
    return measure_worlds(
        world,
        advance,
        finished_s,
        limit_s,
        at_once=1 if plan is None else at_once,
        progress=progress,
        look=look_at_raised,
    )


def measure_team_outcomes(
    team: Team,
    sorts: Collection[str],
    *,
    limit_s: float | Column,
    flag: str | None = None,
    progress: Progress = skip_progress,
    look: Look | None = None,
) -> Outcomes:
    """Run a simulated team until each world has finished or reached its limit (s, one for all or a column [B]).

    With a `flag`, a world is finished once all agents of the given `sorts` have raised it, and `look` is called after
    each tick; otherwise once its goal is reached.
    """
    world = team.ground
    if not isinstance(world, World):
        raise TypeError("a team of real robots")
    raised_s = np.full(world.worlds, np.nan)

    def advance(ticks: int) -> None:
        for _ in range(ticks):
            team.tick()
            if flag is not None:
                raised = np.isnan(raised_s) & find_raised_by_all(team, sorts, flag, world.worlds)
                raised_s[raised] = world.time_s

    def finished_s() -> Column:
        return world.finished_s if flag is None else raised_s

    def look_at_raised() -> None:
        if look is not None and flag is not None:
            look(find_raised_members(team, sorts, flag, world.worlds))

    return measure_worlds(
        world, advance, finished_s, limit_s, at_once=1, progress=progress, look=look_at_raised
    )


def measure_worlds(
    world: World,
    advance: Callable[[int], None],
    finished_s: Callable[[], Column],
    limit_s: float | Column,
    *,
    at_once: int,
    progress: Progress,
    at_end: AtEnd | None = None,
    look: Callable[[], None] = lambda: None,
) -> Outcomes:
    """Let simulated worlds advance until each has finished or reached its limit (s, one for all or a column [B]).

    `finished_s` returns when each world finished [B], s, NaN if it has not yet. At most `at_once` ticks are run between
    two calls of it and of `look`. `at_end` is called with the worlds [B] that have just ended.
    """
    limits = np.broadcast_to(np.asarray(limit_s, np.float64), (world.worlds,)).copy()
    if not (np.isfinite(limits) & (limits >= 0)).all():
        raise SettingError(where="measure", setting="limit_s", problem="is not a time", remedy="give seconds")
    last = np.floor(limits / world.tick_s + 1e-9).astype(np.int64)  # each world's last tick
    seconds, delivered, gathered = np.full(world.worlds, np.nan), world.delivered, world.gathered
    running = np.ones(world.worlds, np.bool_)
    tick = 0
    while True:
        look()
        finished = finished_s()
        through = running & (~np.isnan(finished) | (tick >= last))
        seconds[through], delivered[through] = finished[through], world.delivered[through]
        gathered[through] = world.gathered[through]
        if at_end is not None and through.any():
            at_end(through)
        running &= ~through
        progress(world.worlds - int(running.sum()), world.worlds)
        if not running.any():
            return Outcomes(seconds, limits, delivered, gathered)
        ticks = min(at_once, int(last[running].min()) - tick)
        advance(ticks)
        tick += ticks
