"""The kernel that Python calls: a number of ticks of some worlds - sensing, deciding, moving."""

from typing import Any

from numba import njit

from understudy.compiling import kernel_sources
from understudy.runtime._kernels import pulse
from understudy.worlds._barrier_kernels import wait
from understudy.worlds._grid_kernels import sort
from understudy.worlds._motion_kernels import arrive, propose, slide
from understudy.worlds._pointer_kernels import at, move_at, robot_at, type_at, work_at
from understudy.worlds._sense_kernels import line_up, sense
from understudy.worlds._step_kernels import (
    judge,
    limit,
    limited_by_boxes,
    live,
    move_boxes,
    push,
    shift_boxes,
    transfer,
)
from understudy.worlds.records import WHOLE

SENSE, OBEY, RUN = 0, 1, 2
BLOCK = 64

# For a kernel that is handed arrays: none is made in it, so none need be counted, and counting takes its time. Spelled
# so because Numba declares no type for _nrt.
bare: Any = njit(cache=True, nogil=True, error_model="numpy", _nrt=False)  # type: ignore[call-overload]


@njit(error_model="numpy", forceinline=True)
def intend(c: Any, row: int, world: int, commands: Any, which: int, cargo: Any) -> None:
    """What a robot means to do with its commands: drive, turn, load, unload."""
    robot, move = robot_at(c, row), move_at(c, world, row)
    drive, turn = commands[which, 0], commands[which, 1]
    seed, tick = at(c.seeds, world, WHOLE).v, at(c.tick, world, WHOLE).v
    propose(robot, type_at(c, robot.type), drive, turn, seed, tick, move)
    slide(c, row, world)
    if cargo is not None:
        work = work_at(c, row - world * c.count)
        work.still = 1 if drive == 0.0 and turn == 0.0 else 0
        work.load, work.unload = commands[which, 2], commands[which, 3]


@njit(error_model="numpy", forceinline=True)
def settle(
    c: Any,
    world: int,
    low: int,
    high: int,
    part: int,
    parts: int,
    barrier: Any,
    boxes: Any,
    cargo: Any,
    living: Any,
) -> None:
    """The rest of a tick, once all robots mean to do something: rows `low` to `high` are this part's."""
    wait(barrier, parts)
    for row in range(low, high):
        limit(c, row, world)
    wait(barrier, parts)
    if boxes is not None:
        if part == 0:
            for row in range(world * c.count, (world + 1) * c.count):
                push(c, row, world)
            shift_boxes(c, world)
        wait(barrier, parts)
        for row in range(low, high):
            limited_by_boxes(c, row, world)
        wait(barrier, parts)
    for row in range(low, high):
        arrive(c, row, world)
    wait(barrier, parts)
    if part == 0:
        if boxes is not None:
            move_boxes(c, world)
        if cargo is not None:
            transfer(c, world)
        if living is not None:
            live(c, world)
        at(c.tick, world, WHOLE).v += 1
        judge(c, world)


def _keyed(sources: str) -> Any:
    """The kernel, kept by Numba for as long as no file of kernels changes (see `kernel_sources`)."""

    @bare  # type: ignore[untyped-decorator]
    def advance(
        contexts: Any, mode: int, first: int, end: int, part: int, parts: int, barrier: Any, ticks: int,
        until_finished: bool, values: Any, tables: Any, stacks: Any, commands: Any, running: Any, out: Any,
        camera: Any, ranging: Any, boxes: Any, cargo: Any, living: Any,
    ) -> None:  # fmt: skip
        """So many ticks of the worlds from `first` up to `end`.

        SENSE only senses, to `out` [N, F]. OBEY does one tick with `commands` [N, 4]. RUN senses, decides with
        `tables` and `stacks`, and does a row of `commands` [B, 4], which `running` [N] says; `values` are the
        context's `rows`. Of each world this part of `parts` threads does its share of the rows. A world ends early
        once finished where `until_finished`. What a scenario does without is None - cameras, sonars and bumpers,
        boxes, cargo, objects that come, go or walk - and the kernel is compiled without it.
        """
        sources  # noqa: B018 - Numba keys its cache with what is closed over
        c = contexts[0]
        for world in range(first, end):
            start = world * c.count
            low, high = start + c.count * part // parts, start + c.count * (part + 1) // parts
            for turn in range(ticks):
                sorted_since = turn % c.keep
                if part == 0 and sorted_since == 0:
                    sort(c, start)
                wait(barrier, parts)
                if until_finished and at(c.finished, world, WHOLE).v >= 0:
                    break
                c.drift = sorted_since * c.most_step
                now = at(c.tick, world, WHOLE).v * c.tick_s
                if c.lines_up:
                    line_up(c, world)
                for begin in range(low, high, BLOCK):
                    end_of_block = min(begin + BLOCK, high)
                    sense(c, begin, end_of_block, world, mode != SENSE, camera, ranging)
                    for row in range(begin, end_of_block):
                        if mode == SENSE:
                            for column in range(out.shape[1]):
                                out[row, column] = values[row - begin, column]
                        elif mode == OBEY:
                            intend(c, row, world, commands, row, cargo)
                        else:
                            running[row] = pulse(row, values[row - begin], now, tables, stacks)
                    if mode == RUN:
                        for row in range(begin, end_of_block):
                            intend(c, row, world, commands, running[row], cargo)
                if mode != SENSE:
                    settle(c, world, low, high, part, parts, barrier, boxes, cargo, living)

    return advance


advance = _keyed(kernel_sources("worlds", "runtime"))
