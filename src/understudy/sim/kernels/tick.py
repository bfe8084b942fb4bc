"""The kernel that Python calls to advance worlds by ticks: sensing, deciding and moving."""

from typing import Any

from understudy.jit.decorators import inlined, inner, njit_entry, refer_to, uint64
from understudy.runtime.engine._pulse_kernels import pulse_agent
from understudy.runtime.team._squad_kernels import run_world_coordinators
from understudy.sim.kernels.collisions import move_robot, propose_step, slide_along_walls
from understudy.sim.kernels.dynamics import (
    add_push,
    freeze_failing_robots,
    limit_by_boxes,
    limit_robot_step,
    move_pushed_boxes,
    plan_pushed_boxes,
    record_goal_tick,
    transfer_cargo,
    update_objects,
)
from understudy.sim.kernels.grid import count_cells, note_robot_cell, place_in_spot
from understudy.sim.kernels.nearest import gather_object_places
from understudy.sim.kernels.pulling import (
    follow_pulled_box,
    grip_box,
    limit_pulled_boxes,
    move_pulled_boxes,
    plan_pulled_boxes,
)
from understudy.sim.kernels.sensing import sense_robots
from understudy.sim.kernels.signals import list_signalers, plan_signal, raise_signal
from understudy.sim.kernels.thread_barrier import BLOCK, claim_block, run_for_each_robot, wait_at_barrier

SENSE, OBEY, RUN = 0, 1, 2

# For a kernel that is handed arrays: none is made in it, so none need be counted, and counting takes its time.
njit_for_worlds = njit_entry(nogil=True, error_model="numpy", _nrt=False)


@inlined
def interpret_commands(
    c: Any, row: int, world: int, commands: Any, which: int, cargo: Any, pulling: Any, calling: Any
) -> None:
    """Compute a robot's intended step, signal and loading from its commands, and grip or release boxes.

    Boxes are gripped and released before any robot moves, so within the distances that the robots have just sensed.
    """
    robot, move = c.robots[uint64(row)], c.moves[uint64(row - world * c.facts.count)]
    drive, turn = commands[which, 0], commands[which, 1]
    seed, tick = c.seeds[world], c.tick[world]
    propose_step(robot, c.types[robot.type], drive, turn, seed, tick, c.facts.generator, move)
    if pulling is not None:
        still = drive == 0.0 and turn == 0.0
        grip_box(c, row, world, commands[which, 2], commands[which, 3], still)
        if robot.holding == 0:
            slide_along_walls(c, row, world)
    else:
        slide_along_walls(c, row, world)
    if calling is not None:
        plan_signal(c, row, world, commands[which, 4])
    if cargo is not None:
        work = c.works[row - world * c.facts.count]
        work.still = 1 if drive == 0.0 and turn == 0.0 else 0
        work.load, work.unload = commands[which, 2], commands[which, 3]


@inlined
def sort_robots_into_grid(crew: Any, c: Any, world: int) -> None:
    """Sort the robots of a world into its grid; each thread of the crew writes only data of its own robots."""
    if not c.facts.gridded:
        return
    run_for_each_robot(crew, c, world, note_robot_cell)
    wait_at_barrier(crew)
    if crew[1] == 0:
        count_cells(c)
    wait_at_barrier(crew)
    run_for_each_robot(crew, c, world, place_in_spot)


@inlined
def finish_tick(
    crew: Any, c: Any, world: int, boxes: Any, cargo: Any, living: Any, pulling: Any, calling: Any
) -> None:
    """Move robots and boxes, transfer cargo and update objects, after all robots have chosen their commands."""
    first, leads = world * c.facts.count, crew[1] == 0
    wait_at_barrier(crew)
    if calling is not None:
        run_for_each_robot(crew, c, world, raise_signal)
        wait_at_barrier(crew)
    if pulling is not None:
        if leads:
            plan_pulled_boxes(c, world)
        wait_at_barrier(crew)
        run_for_each_robot(crew, c, world, follow_pulled_box)
        wait_at_barrier(crew)
    run_for_each_robot(crew, c, world, limit_robot_step)
    wait_at_barrier(crew)
    if boxes is not None:
        if leads:
            for row in range(first, first + c.facts.count):
                add_push(c, row, world)
            plan_pushed_boxes(c, world)
            for row in range(first, first + c.facts.count):
                limit_by_boxes(c, row, world)
        wait_at_barrier(crew)
    if pulling is not None:
        if leads:
            limit_pulled_boxes(c, world)
        wait_at_barrier(crew)
    run_for_each_robot(crew, c, world, move_robot)
    wait_at_barrier(crew)
    if leads:
        if boxes is not None:
            move_pushed_boxes(c, world)
        if pulling is not None:
            move_pulled_boxes(c, world)
        if cargo is not None:
            transfer_cargo(c, world)
        if living is not None:
            update_objects(c, world)
        c.tick[world] += 1
        record_goal_tick(c, world)
        if c.facts.failing:
            freeze_failing_robots(c, world)


@inner
def decide_with_coordinators(
    crew: Any, c: Any, world: int, now: float, values: Any, tables: Any, stacks: Any, commands: Any, running: Any,
    led: Any, camera: Any, ranging: Any, cargo: Any, pulling: Any, calling: Any,
) -> None:  # fmt: skip
    """Sense with all robots, run their coordinators, then run the robots' own automata and interpret the commands.

    The first thread of the crew runs all coordinators of a world.
    """
    bands, leads = led
    sensed, there = bands[0][2], bands[0][3]
    start, blocks = world * c.facts.count, (c.facts.count + BLOCK - 1) // BLOCK
    block = claim_block(crew, blocks, -1)
    while block >= 0:
        low, high = start + block * BLOCK, start + min(c.facts.count, (block + 1) * BLOCK)
        sense_robots(c, low, high, world, True, camera, ranging, calling)
        for row in range(low, high):
            there[row] = not c.robots[row].frozen
            for column in range(sensed.shape[1]):
                sensed[row, column] = values[row - low, column]
        block = claim_block(crew, blocks, block)
    wait_at_barrier(crew)
    if crew[1] == 0:
        run_world_coordinators(world, now, bands, leads)
    wait_at_barrier(crew)
    block = claim_block(crew, blocks, -1)
    while block >= 0:
        for row in range(start + block * BLOCK, start + min(c.facts.count, (block + 1) * BLOCK)):
            running[row] = pulse_agent(row, sensed[row], now, tables, stacks)
            interpret_commands(c, row, world, commands, running[row], cargo, pulling, calling)
        block = claim_block(crew, blocks, block)


@njit_for_worlds
def run_ticks(
    arrays: Any, mode: int, first: int, end: int, part: int, parts: int, barrier: Any, ticks: int,
    until_finished: bool, values: Any, tables: Any, stacks: Any, commands: Any, running: Any, out: Any, led: Any,
    camera: Any, ranging: Any, boxes: Any, cargo: Any, living: Any, pulling: Any, calling: Any,
) -> None:  # fmt: skip
    """Advance the worlds from `first` up to `end` by a number of ticks, in a `mode`.

    SENSE only measures, into `out` [N, F]. OBEY runs one tick with `commands` [N, 5]. RUN measures, decides with
    `tables` and `stacks`, and executes one row of `commands` [B, 5] per robot, whose number it writes to
    `running` [N]; `values` are the context's `rows`. This thread is number `part` of `parts` threads that share
    each world. `led` has the bands and leads of coordinators (see `_squad_kernels`), or is None. With
    `until_finished` a world stops when it reaches its goal; worlds that have ended are left out. `camera` (cameras),
    `ranging` (range sensors), `boxes` (to push), `cargo`, `living` (objects that appear, vanish or walk), `pulling`
    (boxes) and `calling` (signals) are None if the scenario has none of these: the kernel is compiled without them
    then.
    """
    c = refer_to(arrays)
    for world in range(first, end):
        start, crew = world * c.facts.count, (barrier, part, parts)
        blocks = (c.facts.count + BLOCK - 1) // BLOCK
        for turn in range(ticks):
            wait_at_barrier(crew)
            if mode == RUN and (c.ended[world] or (until_finished and c.finished[world] >= 0)):
                break
            c.facts.drift = (turn % c.facts.keep) * c.facts.most_step
            if turn % c.facts.keep == 0:
                sort_robots_into_grid(crew, c, world)
                wait_at_barrier(crew)
            now = c.tick[world] * c.facts.tick_s
            if c.facts.lines_up:
                gather_object_places(c, world)
            if calling is not None:
                list_signalers(c, world)
            if led is not None:
                decide_with_coordinators(
                    crew, c, world, now, values, tables, stacks, commands, running, led, camera, ranging, cargo,
                    pulling, calling,
                )  # fmt: skip
            block = claim_block(crew, blocks, -1) if led is None else -1
            while block >= 0:
                low, high = start + block * BLOCK, start + min(c.facts.count, (block + 1) * BLOCK)
                sense_robots(c, low, high, world, mode != SENSE, camera, ranging, calling)
                for row in range(low, high):
                    if mode == SENSE:
                        for column in range(out.shape[1]):
                            out[row, column] = values[row - low, column]
                    elif mode == OBEY:
                        interpret_commands(c, row, world, commands, row, cargo, pulling, calling)
                    else:
                        running[row] = pulse_agent(row, values[row - low], now, tables, stacks)
                if mode == RUN:
                    for row in range(low, high):
                        interpret_commands(c, row, world, commands, running[row], cargo, pulling, calling)
                block = claim_block(crew, blocks, block)
            if mode != SENSE:
                finish_tick(crew, c, world, boxes, cargo, living, pulling, calling)
