"""Many ticks in one go: over worlds side by side, or over the robots of one large world, in one thread or several.

What comes out is the same bit by bit, whatever the threads: random draws are keyed, and no sum depends on the order
in which robots are looked at.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.runtime.body import FusedPlan
from understudy.runtime.tables import Stacks
from understudy.worlds import _kernels
from understudy.worlds.grids import Grid, Near, Scratch, grid_for, scratch_for
from understudy.worlds.plans import Plan
from understudy.worlds.state import Rules, State

ALONE = 2000
"""Robots up to which one thread is quicker than several."""

SORTED = 1000
"""Robots in a world from which on they are kept in the order of their places while many ticks go by."""

ROBOT_TICKS = 2_000_000
"""After about so many, Python gets to look whether someone has interrupted."""

MOST_TICKS = 100


class Features(NamedTuple):
    """What there is in a scenario that takes time in every tick."""

    boxes: bool
    cargo: bool
    living: bool


class Stage(NamedTuple):
    """The worlds that are to advance."""

    state: State
    rules: Rules
    near: Near
    features: Features


def advance(
    stage: Stage, sensing: Plan, fused: FusedPlan, ticks: int, threads: int | None, *, until_finished: bool = False
) -> None:
    """Advance all worlds so many ticks; a world ends early once it is finished where `until_finished`."""
    rows, worlds = len(stage.state.robots), len(stage.state.seeds)
    if threads is None:
        threads = 1 if rows < ALONE else os.cpu_count() or 1
    threads = min(threads, max(worlds, rows // 64), 64)
    if worlds >= threads:
        _side_by_side(stage, sensing, fused, ticks, threads, until_finished=until_finished)
    else:
        for world in range(worlds):
            _together(stage, sensing, fused, ticks, threads, world, until_finished=until_finished)


def _chunks(ticks: int, rows: int) -> list[int]:
    """Ticks at a time, so that none takes long."""
    most = max(1, min(MOST_TICKS, ROBOT_TICKS // max(1, rows)))
    return [min(most, ticks - begun) for begun in range(0, ticks, most)]


def _run(pool: ThreadPoolExecutor | None, parts: int, work: Callable[[int], None]) -> None:
    """Do all parts of the work, in threads where there are several."""
    if pool is None:
        for part in range(parts):
            work(part)
    else:
        for done in [pool.submit(work, part) for part in range(parts)]:
            done.result()


def _pool(threads: int) -> ThreadPoolExecutor | None:
    return ThreadPoolExecutor(threads) if threads > 1 else None


def _side_by_side(
    stage: Stage, sensing: Plan, fused: FusedPlan, ticks: int, threads: int, *, until_finished: bool
) -> None:
    """Every thread has worlds of its own, and none waits for another."""
    state, rules = stage.state, stage.rules
    worlds = len(state.seeds)
    if worlds == 1 and rules.robots >= SORTED:
        _together(stage, sensing, fused, ticks, 1, 0, until_finished=until_finished)
        return
    rooms = [(grid_for(rules), scratch_for(state, rules, sensing)) for _ in range(threads)]
    commands = _padded(fused.commands)
    pool = _pool(threads)
    try:
        for chunk in _chunks(ticks, len(state.robots)):

            def work(part: int, chunk: int = chunk) -> None:
                grid, scratch = rooms[part]
                first, end = worlds * part // threads, worlds * (part + 1) // threads
                _kernels.advance(
                    first, end, 0, 1, chunk, until_finished, sensing, state, rules, grid, stage.near, scratch,
                    stage.features, fused.tables, fused.stacks, commands, fused.running,
                )  # fmt: skip

            _run(pool, threads, work)
    finally:
        if pool is not None:
            pool.shutdown()


def _together(
    stage: Stage, sensing: Plan, fused: FusedPlan, ticks: int, threads: int, world: int, *, until_finished: bool
) -> None:
    """All threads work on one world, each on a share of its robots, and wait for each other in every tick.

    The robots of a large world are put in the order of their places meanwhile, so that those who look at each
    other are side by side in memory too.
    """
    state, rules = stage.state, stage.rules
    grid = grid_for(rules)
    scratch = scratch_for(state, rules, sensing)
    rooms = [scratch, *(scratch_for(state, rules, sensing, beside=scratch) for _ in range(threads - 1))]
    commands = _padded(fused.commands)
    pool = _pool(threads)
    try:
        for chunk in _chunks(ticks, rules.robots):
            rows = np.arange(world * rules.robots, (world + 1) * rules.robots)
            if rules.robots >= SORTED and chunk > 1:
                rows = rows[order_of_places(state, rules, grid, world)]
            there = _Sorted(state, fused, rows, world)

            def work(part: int, chunk: int = chunk, there: _Sorted = there) -> None:
                _kernels.advance(
                    0, 1, part, threads, chunk, until_finished, sensing, there.state, rules, grid,
                    there.near(stage.near, world), rooms[part], stage.features, fused.tables, there.stacks,
                    commands, there.running,
                )  # fmt: skip

            _run(pool, threads, work)
            there.put_back()
    finally:
        if pool is not None:
            pool.shutdown()


def order_of_places(state: State, rules: Rules, grid: Grid, world: int) -> NDArray[np.intp]:
    """The robots of a world in the order of the grid's cells."""
    robots = state.robots[world * rules.robots : (world + 1) * rules.robots]
    column = np.clip((robots["x"] / grid.cell).astype(np.int64), 0, grid.columns - 1)
    line = np.clip((robots["y"] / grid.cell).astype(np.int64), 0, grid.lines - 1)
    order: NDArray[np.intp] = np.argsort(line * grid.columns + column, kind="stable")
    return order


class _Sorted:
    """One world's arrays with its robots in another order, to be put back afterwards."""

    def __init__(self, state: State, fused: FusedPlan, rows: NDArray[np.intp], world: int) -> None:
        self.rows, self._fused, self._from = rows, fused, state
        one = slice(world, world + 1)
        self.state = State(
            robots=state.robots[rows],
            objects=state.objects[one],
            discs=state.discs[one],
            segments=state.segments[one],
            seeds=state.seeds[one],
            tick=state.tick[one],
            finished=state.finished[one],
            memory=state.memory[rows],
        )
        self.stacks = Stacks(*(array[rows] for array in fused.stacks))
        self.running = fused.running[rows]

    def near(self, near: Near, world: int) -> Near:
        """The lists of this world alone."""
        cells = near.columns * near.lines
        return near._replace(start=near.start[world * cells : (world + 1) * cells + 1])

    def put_back(self) -> None:
        """The robots as they are now, in their own order."""
        self._from.robots[self.rows] = self.state.robots
        self._from.memory[self.rows] = self.state.memory
        for array, changed in zip(self._fused.stacks, self.stacks, strict=True):
            array[self.rows] = changed
        self._fused.running[self.rows] = self.running


def _padded(commands: NDArray[np.float64]) -> NDArray[np.float64]:
    """Commands with a column for each of drive, turn, load and unload."""
    padded = np.zeros((len(commands), 4))
    padded[:, : commands.shape[1]] = commands
    return padded


def room(stage: Stage, sensing: Plan) -> tuple[Grid, Scratch]:
    """A grid and scratch for one thread."""
    return grid_for(stage.rules), scratch_for(stage.state, stage.rules, sensing)
