"""The kernels that Python calls: sensing for all robots, a tick with given commands, and many ticks in one go."""

from typing import Any

from numba import njit

from understudy.compiling import kernel_sources
from understudy.runtime._kernels import pulse
from understudy.worlds._barrier_kernels import wait
from understudy.worlds._grid_kernels import sort
from understudy.worlds._motion_kernels import arrive, propose
from understudy.worlds._sense_kernels import sense
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


@njit(error_model="numpy")
def intend(row: int, world: int, state: Any, rules: Any, moves: Any, commands: Any) -> None:
    """What a robot means to do with its commands: drive, turn, load, unload."""
    robot, move = state.robots[row], moves[row - world * rules.robots]
    drive, turn = commands[0], commands[1]
    propose(robot, rules.types[robot.type], drive, turn, state.seeds[world], state.tick[world], move)
    move.still = 1 if drive == 0.0 and turn == 0.0 else 0
    move.load, move.unload = commands[2], commands[3]


@njit(error_model="numpy")
def settle(
    world: int, low: int, high: int, part: int, parts: int,
    state: Any, rules: Any, grid: Any, near: Any, scratch: Any, features: Any,
) -> None:  # fmt: skip
    """The rest of a tick, once all robots mean to do something: rows `low` to `high` are this part's."""
    moves = scratch.moves
    wait(scratch.barrier, parts)
    for row in range(low, high):
        limit(row, world, state, rules, grid, near, moves)
    wait(scratch.barrier, parts)
    if features.boxes:
        if part == 0:
            for row in range(world * rules.robots, (world + 1) * rules.robots):
                push(row, world, state, rules, moves, scratch.pushes)
            shift_boxes(world, state, rules, grid, near, moves, scratch.pushes)
        wait(scratch.barrier, parts)
        for row in range(low, high):
            limited_by_boxes(row, world, state, rules, moves, scratch.pushes)
        wait(scratch.barrier, parts)
    for row in range(low, high):
        arrive(state.robots[row], moves[row - world * rules.robots])
    wait(scratch.barrier, parts)
    if part == 0:
        if features.boxes:
            move_boxes(world, state, rules, scratch.pushes)
        if features.cargo:
            transfer(world, state, rules, moves)
        if features.living:
            live(world, state, rules)
        state.tick[world] += 1
        judge(world, state, rules)


def _keyed(sources: str) -> Any:
    """The kernels, kept by Numba for as long as no file of kernels changes (see `kernel_sources`)."""

    @njit(cache=True, nogil=True, error_model="numpy")
    def sense_all(
        first: int, end: int, plan: Any, state: Any, rules: Any, grid: Any, near: Any, scratch: Any, out: Any
    ) -> None:
        """The readings [N, plan.width] of all robots of the worlds from `first` up to `end`."""
        sources  # noqa: B018 - Numba keys its cache with what is closed over
        for world in range(first, end):
            sort(state.robots, world * rules.robots, grid)
            for row in range(world * rules.robots, (world + 1) * rules.robots):
                sense(row, world, plan, state, rules, grid, near, scratch, out[row], False)

    @njit(cache=True, nogil=True, error_model="numpy")
    def obey(
        first: int, end: int, kept: Any, state: Any, rules: Any, grid: Any, near: Any, scratch: Any, features: Any,
        commands: Any,
    ) -> None:  # fmt: skip
        """One tick of the worlds from `first` up to `end`, in which robots obey `commands` [N, 4]."""
        sources  # noqa: B018
        for world in range(first, end):
            low, high = world * rules.robots, (world + 1) * rules.robots
            sort(state.robots, low, grid)
            for row in range(low, high):
                if kept.width > 0:
                    sense(row, world, kept, state, rules, grid, near, scratch, scratch.row, True)
                intend(row, world, state, rules, scratch.moves, commands[row])
            settle(world, low, high, 0, 1, state, rules, grid, near, scratch, features)

    @njit(cache=True, nogil=True, error_model="numpy")
    def advance(
        first: int, end: int, part: int, parts: int, ticks: int, until_finished: bool, plan: Any, state: Any,
        rules: Any, grid: Any, near: Any, scratch: Any, features: Any, tables: Any, stacks: Any, commands: Any,
        running: Any,
    ) -> None:  # fmt: skip
        """So many ticks of the worlds from `first` up to `end`: sense, decide and act.

        Of each world this part of `parts` threads does its share of the rows; commands [B, 4] has those of every
        basic behavior. A world ends early once it is finished where `until_finished`.
        """
        sources  # noqa: B018
        for world in range(first, end):
            start = world * rules.robots
            low = start + rules.robots * part // parts
            high = start + rules.robots * (part + 1) // parts
            for _ in range(ticks):
                if until_finished and state.finished[world] >= 0:
                    break
                now = state.tick[world] * rules.tick_s
                if part == 0:
                    sort(state.robots, start, grid)
                wait(scratch.barrier, parts)
                for row in range(low, high):
                    sense(row, world, plan, state, rules, grid, near, scratch, scratch.row, True)
                    basic = pulse(row, scratch.row, now, tables, stacks)
                    running[row] = basic
                    intend(row, world, state, rules, scratch.moves, commands[basic])
                settle(world, low, high, part, parts, state, rules, grid, near, scratch, features)
                wait(scratch.barrier, parts)

    return sense_all, obey, advance


sense_all, obey, advance = _keyed(kernel_sources("worlds", "runtime"))
