"""Contexts of kernels: all arrays that a kernel reads and writes, and working memory, prepared for one thread."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.jit.settings import ALL_PARTS, read_kernel_parts
from understudy.sim.kernels.dtypes import (
    CAMERA,
    FACTS,
    MOVE,
    OFFSET,
    PULL,
    PUSH,
    SEGMENT,
    SPOT,
    THING,
    TO_CLASS,
    TO_UNCLAIMED,
    VIEW,
    WORK,
)
from understudy.sim.layout.neighbor_grid import RobotGrid, StaticNeighbors
from understudy.sim.scenario.schema import Scenario
from understudy.sim.sensing.sense_plan import SensePlan
from understudy.sim.sensing.sensor_table import find_sensor_row
from understudy.sim.state import Records, WorldParams, WorldState

BLOCK = 32
"""The number of robots that are processed together; it equals BLOCK of `thread_barrier`."""


MOST_THREADS = 64
"""The largest number of threads that work on one world."""


class KernelWorlds(NamedTuple):
    """The data of worlds for kernels: changing state, constant rules, and the fixed things near each place."""

    state: WorldState
    rules: WorldParams
    near: StaticNeighbors
    has: tuple[bool | None, ...]
    """The optional parts that kernels are compiled with; see `find_world_contents`."""
    ended: NDArray[np.bool_]
    """The worlds that are not advanced any more [B]."""
    fails: NDArray[np.int64]
    """The tick from which each robot has failed [B*N]; -1 never."""


class ThreadScratch(NamedTuple):
    """The working memory shared by threads that work on one world: its grid, records, and their barrier."""

    grid: RobotGrid
    moves: Records
    """MOVE [N]."""
    works: Records
    """WORK [N]."""
    pushes: Records
    """PUSH [K]."""
    pulls: Records
    """PULL [K]."""
    barrier: NDArray[np.int64]


def make_thread_scratch(worlds: KernelWorlds, grid: RobotGrid) -> ThreadScratch:
    """Make the working memory for threads that work on one world at a time."""
    objects = worlds.state.objects.shape[1]
    robots = worlds.rules.robots
    moves, works = np.zeros(robots, MOVE), np.zeros(robots, WORK)
    pushes, pulls = np.zeros(objects, PUSH), np.zeros(objects, PULL)
    return ThreadScratch(grid, moves, works, pushes, pulls, np.zeros(8 * (2 + MOST_THREADS), np.int64))


class Arrays(NamedTuple):
    """All inputs of a kernel: `facts`, and one-dimensional arrays, with worlds one after the other."""

    facts: Any
    """A record FACTS."""
    robots: Records
    types: Records
    objects: Records
    classes: Records
    class_of: NDArray[np.int32]
    discs: Records
    segments: Records
    seeds: NDArray[np.int64]
    tick: NDArray[np.int64]
    finished: NDArray[np.int64]
    ended: NDArray[np.bool_]
    fails: NDArray[np.int64]
    memory: NDArray[np.float64]
    steps: Records
    parts: Records
    sectors: Records
    of_type: NDArray[np.int64]
    near_start: NDArray[np.int64]
    near_items: NDArray[np.int32]
    start: NDArray[np.int32]
    """The arrays of the grid: this and the next two."""
    spots: Records
    spot_of: NDArray[np.int32]
    moves: Records
    """The arrays of the working memory: this and all that follow."""
    works: Records
    pushes: Records
    pulls: Records
    rows: NDArray[np.float64]
    offsets: Records
    object_x: NDArray[np.float64]
    object_y: NDArray[np.float64]
    object_order: NDArray[np.int64]
    callers: Records
    caller_counts: NDArray[np.int64]
    a: NDArray[np.float64]
    b: NDArray[np.float64]
    things: Records
    views: Records
    pieces: Records


class KernelContext:
    """The inputs of kernels for one thread, as `arrays`, with its own working memory.

    `rows` [BLOCK, F] receives the readings of the robots that are processed together.
    """

    def __init__(self, worlds: KernelWorlds, plan: SensePlan, room: ThreadScratch) -> None:
        state, rules = worlds.state, worlds.rules
        objects, segments = worlds.state.objects.shape[1], worlds.state.segments.shape[1]
        things = state.discs.shape[1] + objects + rules.robots if CAMERA in plan.steps["what"] else 0
        self.room = room
        self.has = worlds.has
        self.rows = np.full((BLOCK, max(1, plan.width)), np.nan)
        arrays: dict[str, NDArray[Any]] = {
            **{name: getattr(state, name) for name in _OF_STATE},
            **{name: getattr(rules, name) for name in ("types", "classes", "class_of")},
            **{name: getattr(plan, name) for name in ("steps", "parts", "sectors", "of_type")},
            **{name: getattr(room.grid, name) for name in ("start", "spots", "spot_of")},
            "ended": worlds.ended,
            "fails": worlds.fails,
            "near_start": worlds.near.start,
            "near_items": worlds.near.items,
            "moves": room.moves,
            "works": room.works,
            "pushes": room.pushes,
            "pulls": room.pulls,
            "rows": self.rows,
            "offsets": np.zeros(BLOCK, OFFSET),
            "object_x": np.zeros(objects),
            "object_y": np.zeros(objects),
            "object_order": np.arange(objects),
            "callers": np.zeros(rules.signals * rules.robots, SPOT),
            "caller_counts": np.zeros(rules.signals, np.int64),
            "a": _apart(plan.most_parts),
            "b": _apart(plan.most_parts),
            "things": np.zeros(things, THING),
            "views": np.zeros(things + segments if things else 0, VIEW),
            "pieces": np.zeros(segments if things else 0, SEGMENT),
        }
        facts = _facts(worlds, plan, room, width_of_row=self.rows.shape[1])
        self.arrays = Arrays(facts, **{name: array.reshape(-1) for name, array in arrays.items()})


def _facts(worlds: KernelWorlds, plan: SensePlan, room: ThreadScratch, *, width_of_row: int) -> Any:
    """Return the constants and sizes of worlds as a record FACTS."""
    state, rules, grid, near = worlds.state, worlds.rules, room.grid, worlds.near
    record: Any = np.zeros(1, FACTS)[0]
    for name in ("width", "height", "tick_s", "goal", "goal_target", "goal_within", "goal_count"):
        record[name] = getattr(rules, name)
    record["signals"], record["generator"] = rules.signals, rules.generator
    for name in ("cell", "columns", "lines", "shift", "keep", "most_radius", "most_step"):
        record[name] = getattr(grid, name)
    for name in ("columns", "lines"):
        record[f"near_{name}"] = getattr(near, name)
    record["per_cell"], record["near_per_cell"] = 1.0 / grid.cell, 1.0 / near.cell
    record["passable"] = not rules.types["collides"].all()
    record["gridded"] = len(grid.spots) > 0
    record["count"] = rules.robots
    record["type_count"], record["class_count"] = len(rules.types), len(rules.classes)
    record["object_count"] = state.objects.shape[1]
    record["disc_count"], record["segment_count"] = state.discs.shape[1], state.segments.shape[1]
    record["memory_count"] = state.memory.shape[1]
    record["width_of_row"] = width_of_row
    record["lines_up"] = bool(np.isin(plan.steps["place"], (TO_CLASS, TO_UNCLAIMED)).any())
    record["solids"] = bool(rules.classes["solid"].any())
    record["failing"] = bool((worlds.fails >= 0).any())
    return record


def find_world_contents(scenario: Scenario, rules: WorldParams) -> tuple[bool | None, ...]:
    """Return True, or None if absent, for each optional part of the kernels that a scenario needs.

    The parts are cameras, range sensors, boxes to push, cargo, objects that appear, vanish or walk, boxes to pull,
    and signals. If UNDERSTUDY_KERNEL_PARTS is `all`, every scenario gets every part.
    """
    everything = read_kernel_parts() == ALL_PARTS
    sensing = {find_sensor_row(sensor).kernels for kind in scenario.types.values() for sensor in kind.sensors}
    classes = rules.classes
    comes, captured = ~np.isnan(classes["away_least"]), ~np.isnan(classes["capture_range"])
    contents = (
        "camera" in sensing,
        "ranging" in sensing,
        classes["pushable"].any(),
        (rules.types["capacity"] > 0).any(),
        (comes | captured | (classes["walk"] > 0) | (classes["respawn"] != 0)).any(),
        (classes["pull"] > 0).any(),
        rules.signals > 0,
    )
    return tuple(True if there or everything else None for there in contents)


def _apart(count: int) -> NDArray[np.float64]:
    """Return an array of numbers that shares no cache line with memory of another thread."""
    line = 64 // 8
    return np.full(count + 2 * line, np.nan)[line:-line]


_OF_STATE = ("robots", "objects", "discs", "segments", "seeds", "tick", "finished", "memory")
