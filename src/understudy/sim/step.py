"""Run many ticks at once: several worlds in parallel, or the robots of one large world, in one or several threads.

The results are equal bit by bit for any number of threads: random draws are keyed, and no sum depends on the order of
robots.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.jit.settings import CHECKED, COMPILED, read_kernel_mode
from understudy.runtime.body import FusedPlan
from understudy.runtime.engine.compiler import compile_programs
from understudy.runtime.engine.tables import Stacks, Tables
from understudy.runtime.link import IDLE_PROGRAM
from understudy.sim.kernel_context import MOST_THREADS, KernelContext, KernelWorlds, make_thread_scratch
from understudy.sim.kernels import tick
from understudy.sim.kit import COLUMNS
from understudy.sim.layout.neighbor_grid import RobotGrid, StaticNeighbors, make_robot_grid
from understudy.sim.sensing.sense_plan import SensePlan
from understudy.sim.state import WorldParams, WorldState

ALONE = 2000
"""The number of robots up to which one thread is faster than several."""

SORTED = 1000
"""The number of robots in a world from which on they are sorted by place while many ticks run."""

ROBOT_TICKS = 5_000_000
"""The number of robot ticks between which Python can react to an interruption."""

MOST_TICKS = 100

PARTS = 7
"""The number of optional parts of the kernel; see `find_world_contents`."""

UNCOMPILED_ROBOT_TICKS = 100
"""The number of robot ticks in plain Python, some 20 ms, after which compiled code may take over."""


def advance_worlds(
    context: KernelContext,
    kernel_worlds: KernelWorlds,
    sensing: SensePlan,
    fused: FusedPlan,
    ticks: int,
    threads: int | None,
    *,
    until_finished: bool = False,
) -> None:
    """Advance all worlds by a number of ticks; with `until_finished` a world stops when it reaches its goal.

    The commands of the plan are a table with columns `COLUMNS`. `threads` None chooses their number; the first uses the
    `context` that is given.
    """
    rows, worlds = len(kernel_worlds.state.robots), len(kernel_worlds.state.seeds)
    ticks -= _advance_uncompiled(context, kernel_worlds, fused, ticks, until_finished=until_finished)
    if threads is None:
        threads = 1 if rows < ALONE else os.cpu_count() or 1
    threads = min(threads, max(worlds, rows // 64), MOST_THREADS)
    if fused.lead is not None and kernel_worlds.rules.robots < ALONE:
        threads = min(threads, worlds)  # to wait for each other twice more a tick pays in large worlds only
    if worlds >= threads:
        _side_by_side(context, kernel_worlds, sensing, fused, ticks, threads, until_finished=until_finished)
    else:
        for world in range(worlds):
            _together(kernel_worlds, sensing, fused, ticks, threads, world, until_finished=until_finished)


def _advance_uncompiled(
    context: KernelContext, worlds: KernelWorlds, fused: FusedPlan, ticks: int, *, until_finished: bool
) -> int:
    """Advance all worlds in one thread until the kernel is compiled; return by how many ticks.

    Several threads would gain nothing in plain Python, and could not wait for each other.
    """
    if read_kernel_mode() in (COMPILED, CHECKED):
        return 0
    count, done = len(worlds.state.seeds), 0
    portion = max(1, UNCOMPILED_ROBOT_TICKS // max(1, len(worlds.state.robots)))
    while done < ticks and not _is_compiled(context, fused):
        ticks_now = min(portion, ticks - done)
        run_worlds(
            context, fused.tables, fused.stacks, fused.commands, fused.running, first=0, end=count,
            ticks=ticks_now, until_finished=until_finished, led=fused.lead,
        )  # fmt: skip
        done += ticks_now
    return done


def _chunks(ticks: int, rows: int) -> list[int]:
    """Split ticks into portions that each take a short time."""
    most = max(1, min(MOST_TICKS, ROBOT_TICKS // max(1, rows)))
    return [min(most, ticks - begun) for begun in range(0, ticks, most)]


def _run(pool: ThreadPoolExecutor, parts: int, work: Callable[[int], None]) -> None:
    """Run all parts of the work: the first in this thread, the others in those of the pool."""
    others: list[Future[None]] = []
    try:
        others.extend(pool.submit(work, part) for part in range(1, parts))
    finally:  # if interrupted, too: parts that have begun wait for the others
        others += [pool.submit(work, part) for part in range(1 + len(others), parts)]
        work(0)
        for other in others:
            other.result()


def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max(1, threads - 1))


def _side_by_side(
    context: KernelContext,
    kernel_worlds: KernelWorlds,
    sensing: SensePlan,
    fused: FusedPlan,
    ticks: int,
    threads: int,
    *,
    until_finished: bool,
) -> None:
    """Advance worlds in parallel, each thread with worlds of its own, without waiting for each other."""
    state, rules = kernel_worlds.state, kernel_worlds.rules
    worlds = len(state.seeds)
    if worlds == 1 and rules.robots >= SORTED and fused.lead is None:
        _together(kernel_worlds, sensing, fused, ticks, 1, 0, until_finished=until_finished)
        return
    contexts = [context] + [
        KernelContext(kernel_worlds, sensing, make_thread_scratch(kernel_worlds, make_robot_grid(rules)))
        for _ in range(1, threads)
    ]
    with _pool(threads) as pool:
        for chunk in _chunks(ticks, len(state.robots)):

            def work(part: int, chunk: int = chunk) -> None:
                first, end = worlds * part // threads, worlds * (part + 1) // threads
                run_worlds(
                    contexts[part], fused.tables, fused.stacks, fused.commands, fused.running, first=first, end=end,
                    ticks=chunk, until_finished=until_finished, led=fused.lead,
                )  # fmt: skip

            _run(pool, threads, work)


def _together(
    worlds: KernelWorlds,
    sensing: SensePlan,
    fused: FusedPlan,
    ticks: int,
    threads: int,
    world: int,
    *,
    until_finished: bool,
) -> None:
    """Advance one world with all threads, each for a share of the robots, waiting for each other in every tick.

    In a large world the robots are sorted by place meanwhile, so that neighbors are adjacent in memory too. Robots
    with coordinators are not, because coordinators refer to them by their rows.
    """
    if fused.lead is not None:
        _led_together(worlds, sensing, fused, ticks, threads, world, until_finished=until_finished)
        return
    rules = worlds.rules
    grid = make_robot_grid(rules)
    with _pool(threads) as pool:
        for chunk in _chunks(ticks, rules.robots):
            order = np.arange(rules.robots)
            if rules.robots >= SORTED and chunk > 1:
                order = sort_by_cell(worlds.state, rules, grid, world)
            there = _SpatialOrder(worlds, fused, order, world)
            room = make_thread_scratch(there.worlds, grid)
            contexts = [KernelContext(there.worlds, sensing, room) for _ in range(threads)]

            def work(
                part: int,
                chunk: int = chunk,
                there: _SpatialOrder = there,
                contexts: list[KernelContext] = contexts,
            ) -> None:
                run_worlds(
                    contexts[part], fused.tables, there.stacks, fused.commands, there.running, first=0, end=1,
                    part=part, parts=threads, ticks=chunk, until_finished=until_finished,
                )  # fmt: skip

            try:
                _run(pool, threads, work)
            finally:  # if interrupted, too: objects and clock have gone on
                there.restore_order()


def _led_together(
    worlds: KernelWorlds,
    sensing: SensePlan,
    fused: FusedPlan,
    ticks: int,
    threads: int,
    world: int,
    *,
    until_finished: bool,
) -> None:
    """Advance one world with all threads, like `_together`, for robots with coordinators."""
    room = make_thread_scratch(worlds, make_robot_grid(worlds.rules))
    contexts = [KernelContext(worlds, sensing, room) for _ in range(threads)]
    with _pool(threads) as pool:
        for chunk in _chunks(ticks, worlds.rules.robots):

            def work(part: int, chunk: int = chunk) -> None:
                run_worlds(
                    contexts[part], fused.tables, fused.stacks, fused.commands, fused.running, first=world,
                    end=world + 1, part=part, parts=threads, ticks=chunk, until_finished=until_finished,
                    led=fused.lead,
                )  # fmt: skip

            _run(pool, threads, work)


def sort_by_cell(state: WorldState, rules: WorldParams, grid: RobotGrid, world: int) -> NDArray[np.intp]:
    """Return the order of a world's robots by cells of the grid."""
    robots = state.robots[world * rules.robots : (world + 1) * rules.robots]
    column = np.clip(robots["x"] / grid.cell, 0, grid.columns - 1).astype(np.uint16)
    line = np.clip(robots["y"] / grid.cell, 0, grid.lines - 1).astype(np.uint16)
    by_column = np.argsort(column, kind="stable")  # numbers of 16 bits are sorted without comparing them
    order: NDArray[np.intp] = by_column[np.argsort(line[by_column], kind="stable")]
    return order


class _SpatialOrder:
    """The arrays of one world with its robots in another order, which `restore_order` undoes."""

    def __init__(self, worlds: KernelWorlds, fused: FusedPlan, order: NDArray[np.intp], world: int) -> None:
        state, stacks, robots = worlds.state, fused.stacks, len(order)
        self._order = order
        one, own = slice(world, world + 1), slice(world * robots, (world + 1) * robots)
        self._from = [each[own] for each in (state.robots, state.memory, *stacks, fused.running)]
        self._now = [_taken(each, order) for each in self._from]
        mine, memory, root, current, entered, kept_memory, self.running = self._now
        self.state = WorldState(
            robots=mine,
            objects=state.objects[one],
            discs=state.discs[one],
            segments=state.segments[one],
            seeds=state.seeds[one],
            tick=state.tick[one],
            finished=state.finished[one],
            memory=memory,
        )
        self.stacks = Stacks(root, current, entered, kept_memory)
        cells = worlds.near.columns * worlds.near.lines
        near: StaticNeighbors = worlds.near._replace(
            start=worlds.near.start[world * cells : (world + 1) * cells + 1]
        )
        fails = worlds.fails[own][order]
        self.worlds = KernelWorlds(self.state, worlds.rules, near, worlds.has, worlds.ended[one], fails)

    def restore_order(self) -> None:
        """Copy the robots as they are now back to their original rows."""
        back = np.empty_like(self._order)
        back[self._order] = np.arange(len(back))
        for there, now in zip(self._from, self._now, strict=True):
            there[:] = _taken(now, back)


def _taken(rows: NDArray[Any], order: NDArray[np.intp]) -> NDArray[Any]:
    """Return the rows of an array in this order, copied as blocks of bytes: field by field takes ten times as long."""
    if rows.size == 0:
        return rows.copy()
    lumps = np.ascontiguousarray(rows).view(np.dtype((np.void, rows.dtype.itemsize)))
    taken: NDArray[Any] = np.take(lumps, order, axis=0).view(rows.dtype)
    return taken


NOTHING = (np.zeros((0, len(COLUMNS))), np.zeros(0, np.int32), np.zeros((0, 0)))


def run_worlds(
    context: KernelContext, tables: Tables, stacks: Stacks, commands: NDArray[np.float64],
    running: NDArray[np.int32], *,
    first: int, end: int, ticks: int, part: int = 0, parts: int = 1, until_finished: bool = False, led: Any = None,
) -> None:  # fmt: skip
    """Sense, decide and act in the worlds from `first` up to `end` for a number of ticks."""
    tick.run_ticks(
        context.arrays, tick.RUN, first, end, part, parts, context.room.barrier, ticks, until_finished,
        context.rows, tuple(tables), tuple(stacks), commands, running, NOTHING[2], led, *context.has,
    )  # fmt: skip


def _is_compiled(context: KernelContext, fused: FusedPlan) -> bool:
    """Return whether `run_worlds` runs compiled code for this context and plan."""
    return tick.run_ticks.is_compiled(
        context.arrays, tick.RUN, 0, 1, 0, 1, context.room.barrier, 1, False, context.rows, tuple(fused.tables),
        tuple(fused.stacks), fused.commands, fused.running, NOTHING[2], fused.lead, *context.has,
    )  # fmt: skip


def _add_all_parts(arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return the arguments of the kernel with every optional part, of which there may be nothing in the world."""
    return *arguments[:-PARTS], *(True,) * PARTS


tick.run_ticks.generalize = _add_all_parts


def sense_worlds(context: KernelContext, worlds: int, out: NDArray[np.float64]) -> None:
    """Write the readings [B*N, F] of all robots to `out`."""
    tick.run_ticks(
        context.arrays, tick.SENSE, 0, worlds, 0, 1, context.room.barrier, 1, False,
        context.rows, NO_TABLES, NO_STACKS, NOTHING[0], NOTHING[1], out, None, *context.has,
    )  # fmt: skip


def apply_commands(context: KernelContext, worlds: int, commands: NDArray[np.float64]) -> None:
    """Advance all worlds by one tick with commands [B*N, 5]."""
    tick.run_ticks(
        context.arrays, tick.OBEY, 0, worlds, 0, 1, context.room.barrier, 1, False,
        context.rows, NO_TABLES, NO_STACKS, commands, NOTHING[1], NOTHING[2], None, *context.has,
    )  # fmt: skip


NO_TABLES = tuple(compile_programs([IDLE_PROGRAM]).tables)
NO_STACKS = tuple(compile_programs([IDLE_PROGRAM]).stacks())
