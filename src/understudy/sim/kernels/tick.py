"""The kernel that Python calls: a number of ticks of some worlds - sensing, deciding, moving."""

from typing import Any

from understudy._jit_kernels import entry, inlined, inner, uint64
from understudy.kernel_cache import hash_kernel_sources
from understudy.runtime.engine._pulse_kernels import pulse
from understudy.runtime.team._squad_kernels import lead_world
from understudy.sim.kernels.barrier import BLOCK, claim, each, wait
from understudy.sim.kernels.dynamics import (
    judge,
    limit,
    limited_by_boxes,
    live,
    move_boxes,
    push,
    shift_boxes,
    transfer,
)
from understudy.sim.kernels.grid import count, find_cell, put_spot
from understudy.sim.kernels.motion import arrive, propose, slide
from understudy.sim.kernels.nearest import line_up
from understudy.sim.kernels.pulling import bring, grip, haul, keep_together, pull
from understudy.sim.kernels.sensing import sense
from understudy.sim.kernels.signals import call, line_up_callers, mean_to_call

SENSE, OBEY, RUN = 0, 1, 2

# For a kernel that is handed arrays: none is made in it, so none need be counted, and counting takes its time.
bare = entry(cache=True, nogil=True, error_model="numpy", _nrt=False)


@inlined
def intend(
    c: Any, row: int, world: int, commands: Any, which: int, cargo: Any, pulling: Any, calling: Any
) -> None:
    """What a robot means to do with its commands: drive, turn, load, unload, signal.

    It takes hold of boxes, and lets go of them, before anybody moves: of what is within reach as it was sensed.
    """
    robot, move = c.robots[uint64(row)], c.moves[uint64(row - world * c.facts.count)]
    drive, turn = commands[which, 0], commands[which, 1]
    seed, tick = c.seeds[world], c.tick[world]
    propose(robot, c.types[robot.type], drive, turn, seed, tick, move)
    if pulling is not None:
        still = drive == 0.0 and turn == 0.0
        grip(c, row, world, commands[which, 2], commands[which, 3], still)
        if robot.holding == 0:
            slide(c, row, world)
    else:
        slide(c, row, world)
    if calling is not None:
        mean_to_call(c, row, world, commands[which, 4])
    if cargo is not None:
        work = c.works[row - world * c.facts.count]
        work.still = 1 if drive == 0.0 and turn == 0.0 else 0
        work.load, work.unload = commands[which, 2], commands[which, 3]


@inlined
def sort(crew: Any, c: Any, world: int) -> None:
    """Sort the robots of a world into its grid. Of threads, each writes what is about robots of its own."""
    if not c.facts.gridded:
        return
    each(crew, c, world, find_cell)
    wait(crew)
    if crew[1] == 0:
        count(c)
    wait(crew)
    each(crew, c, world, put_spot)


@inlined
def settle(
    crew: Any, c: Any, world: int, boxes: Any, cargo: Any, living: Any, pulling: Any, calling: Any
) -> None:
    """The rest of a tick, once all robots mean to do something."""
    first, leads = world * c.facts.count, crew[1] == 0
    wait(crew)
    if calling is not None:
        each(crew, c, world, call)
        wait(crew)
    if pulling is not None:
        if leads:
            pull(c, world)
        wait(crew)
        each(crew, c, world, haul)
        wait(crew)
    each(crew, c, world, limit)
    wait(crew)
    if boxes is not None:
        if leads:
            for row in range(first, first + c.facts.count):
                push(c, row, world)
            shift_boxes(c, world)
            for row in range(first, first + c.facts.count):
                limited_by_boxes(c, row, world)
        wait(crew)
    if pulling is not None:
        if leads:
            keep_together(c, world)
        wait(crew)
    each(crew, c, world, arrive)
    wait(crew)
    if leads:
        if boxes is not None:
            move_boxes(c, world)
        if pulling is not None:
            bring(c, world)
        if cargo is not None:
            transfer(c, world)
        if living is not None:
            live(c, world)
        c.tick[world] += 1
        judge(c, world)


@inner
def follow(
    crew: Any, c: Any, world: int, now: float, values: Any, tables: Any, stacks: Any, commands: Any, running: Any,
    led: Any, camera: Any, ranging: Any, cargo: Any, pulling: Any, calling: Any,
) -> None:  # fmt: skip
    """Robots sense, their coordinators decide, and then they do. Of threads, the first decides for all coordinators."""
    bands, leads = led
    sensed, there = bands[0][2], bands[0][3]
    start, blocks = world * c.facts.count, (c.facts.count + BLOCK - 1) // BLOCK
    block = claim(crew, blocks, -1)
    while block >= 0:
        low, high = start + block * BLOCK, start + min(c.facts.count, (block + 1) * BLOCK)
        sense(c, low, high, world, True, camera, ranging, calling)
        for row in range(low, high):
            there[row] = not c.robots[row].frozen
            for column in range(sensed.shape[1]):
                sensed[row, column] = values[row - low, column]
        block = claim(crew, blocks, block)
    wait(crew)
    if crew[1] == 0:
        lead_world(world, now, bands, leads)
    wait(crew)
    block = claim(crew, blocks, -1)
    while block >= 0:
        for row in range(start + block * BLOCK, start + min(c.facts.count, (block + 1) * BLOCK)):
            running[row] = pulse(row, sensed[row], now, tables, stacks)
            intend(c, row, world, commands, running[row], cargo, pulling, calling)
        block = claim(crew, blocks, block)


def _keyed(sources: str) -> Any:
    """The kernel, kept by Numba for as long as no file of kernels changes (see `hash_kernel_sources`)."""

    @bare
    def advance(
        c: Any, mode: int, first: int, end: int, part: int, parts: int, barrier: Any, ticks: int,
        until_finished: bool, values: Any, tables: Any, stacks: Any, commands: Any, running: Any, out: Any, led: Any,
        camera: Any, ranging: Any, boxes: Any, cargo: Any, living: Any, pulling: Any, calling: Any,
    ) -> None:  # fmt: skip
        """So many ticks of the worlds from `first` up to `end`.

        SENSE only senses, to `out` [N, F]. OBEY does one tick with `commands` [N, 5]. RUN senses, decides with
        `tables` and `stacks`, and does a row of `commands` [B, 5], which `running` [N] says; `values` are the
        context's `rows`. Of each world this part of `parts` threads does its share; coordinators lead as `led` says
        (bands and leads of `_lead_kernels`). A world ends early once finished where `until_finished`.
        What a scenario does without is None - cameras, sonars and bumpers, boxes to push, cargo, objects that come,
        go or walk, boxes to pull, signals - and the kernel is compiled without it.
        """
        sources  # noqa: B018 - Numba keys its cache with what is closed over
        for world in range(first, end):
            start, crew = world * c.facts.count, (barrier, part, parts)
            blocks = (c.facts.count + BLOCK - 1) // BLOCK
            for turn in range(ticks):
                wait(crew)
                if until_finished and c.finished[world] >= 0:
                    break
                c.facts.drift = (turn % c.facts.keep) * c.facts.most_step
                if turn % c.facts.keep == 0:
                    sort(crew, c, world)
                    wait(crew)
                now = c.tick[world] * c.facts.tick_s
                if c.facts.lines_up:
                    line_up(c, world)
                if calling is not None:
                    line_up_callers(c, world)
                if led is not None:
                    follow(
                        crew, c, world, now, values, tables, stacks, commands, running, led, camera, ranging, cargo,
                        pulling, calling,
                    )  # fmt: skip
                block = claim(crew, blocks, -1) if led is None else -1
                while block >= 0:
                    low, high = start + block * BLOCK, start + min(c.facts.count, (block + 1) * BLOCK)
                    sense(c, low, high, world, mode != SENSE, camera, ranging, calling)
                    for row in range(low, high):
                        if mode == SENSE:
                            for column in range(out.shape[1]):
                                out[row, column] = values[row - low, column]
                        elif mode == OBEY:
                            intend(c, row, world, commands, row, cargo, pulling, calling)
                        else:
                            running[row] = pulse(row, values[row - low], now, tables, stacks)
                    if mode == RUN:
                        for row in range(low, high):
                            intend(c, row, world, commands, running[row], cargo, pulling, calling)
                    block = claim(crew, blocks, block)
                if mode != SENSE:
                    settle(crew, c, world, boxes, cargo, living, pulling, calling)

    return advance


advance = _keyed(hash_kernel_sources())
