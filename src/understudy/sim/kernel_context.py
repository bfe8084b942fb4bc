"""Contexts: everything a kernel looks at, and room for it to work in, put together for one thread."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.sim.kernels.dtypes import CONTEXT, MOVE, OFFSET, PULL, PUSH, SEGMENT, SPOT, THING, VIEW, WORK
from understudy.sim.layout.neighbor_grid import Grid, Near
from understudy.sim.scenario.schema import Bumper, Camera, Scenario, Sonar
from understudy.sim.sensing.sense_plan import CAMERA, TO_CLASS, TO_UNCLAIMED, Plan
from understudy.sim.state import Records, Rules, State

BLOCK = 32
"""Robots that sense, decide and mean to move together; `_barrier_kernels` has the same."""


MOST_THREADS = 64
"""On one world."""


class Stage(NamedTuple):
    """Worlds as kernels see them: what changes, what stays, and what stays near each place."""

    state: State
    rules: Rules
    near: Near
    has: tuple[bool | None, ...]
    """What kernels are compiled for; see `has`."""


class Shared(NamedTuple):
    """What threads at work on the same world have in common: its grid, scratch records, and their barrier."""

    grid: Grid
    moves: Records
    """MOVE [N]."""
    works: Records
    """WORK [N]."""
    pushes: Records
    """PUSH [K]."""
    pulls: Records
    """PULL [K]."""
    barrier: NDArray[np.int64]


def shared(stage: Stage, grid: Grid) -> Shared:
    """Room for the threads that work on one world at a time."""
    objects = stage.state.objects.shape[1]
    robots = stage.rules.robots
    moves, works = np.zeros(robots, MOVE), np.zeros(robots, WORK)
    pushes, pulls = np.zeros(objects, PUSH), np.zeros(objects, PULL)
    return Shared(grid, moves, works, pushes, pulls, np.zeros(8 * (2 + MOST_THREADS), np.int64))


class Context:
    """A CONTEXT, as `record` [1], and the arrays that it points to, which live as long as it does.

    `rows` [BLOCK, F] is where the readings of the robots at work go.
    """

    def __init__(self, stage: Stage, plan: Plan, room: Shared) -> None:
        state, rules = stage.state, stage.rules
        objects, discs, segments = (array.shape[1] for array in (state.objects, state.discs, state.segments))
        seen = discs + objects + rules.robots if CAMERA in plan.steps["what"] else 0
        self.room = room
        self.rows = np.full((BLOCK, max(1, plan.width)), np.nan)
        arrays: dict[str, NDArray[Any]] = {
            **{name: getattr(state, name) for name in _OF_STATE},
            **{name: getattr(rules, name) for name in ("types", "classes", "class_of")},
            **{name: getattr(plan, name) for name in ("steps", "parts", "sectors", "of_type")},
            **{name: getattr(room.grid, name) for name in ("start", "spots", "spot_of")},
            "near_start": stage.near.start,
            "near_items": stage.near.items,
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
            "things": np.zeros(seen, THING),
            "views": np.zeros(seen + segments if seen else 0, VIEW),
            "pieces": np.zeros(segments if seen else 0, SEGMENT),
        }
        self._arrays = arrays
        self.record = np.zeros(1, CONTEXT)
        record = self.record[0]
        for name, array in arrays.items():
            record[name] = array.ctypes.data
        for name in (
            "width",
            "height",
            "tick_s",
            "goal",
            "goal_target",
            "goal_within",
            "goal_count",
            "signals",
        ):
            record[name] = getattr(rules, name)
        for name in ("cell", "columns", "lines", "shift", "keep", "most_radius", "most_step"):
            record[name] = getattr(room.grid, name)
        for name in ("columns", "lines"):
            record[f"near_{name}"] = getattr(stage.near, name)
        record["per_cell"], record["near_per_cell"] = 1.0 / room.grid.cell, 1.0 / stage.near.cell
        classes = rules.classes
        record["passable"] = not rules.types["collides"].all()
        record["gridded"] = len(room.grid.spots) > 0
        record["count"] = rules.robots
        record["type_count"], record["class_count"] = len(rules.types), len(classes)
        record["object_count"], record["disc_count"], record["segment_count"] = objects, discs, segments
        record["memory_count"] = state.memory.shape[1]
        record["width_of_row"] = self.rows.shape[1]
        record["lines_up"] = bool(np.isin(plan.steps["place"], (TO_CLASS, TO_UNCLAIMED)).any())
        record["solids"] = bool(classes["solid"].any())
        self.has = stage.has


def has(scenario: Scenario, rules: Rules) -> tuple[bool | None, ...]:
    """What there is - cameras, what ranges, boxes to push, cargo, objects that come, go or walk, boxes to pull,
    signals: True, or None.
    """
    sensors = [sensor for kind in scenario.types.values() for sensor in kind.sensors]
    classes = rules.classes
    comes, captured = ~np.isnan(classes["away_least"]), ~np.isnan(classes["capture_range"])
    found = (
        any(isinstance(sensor, Camera) for sensor in sensors),
        any(isinstance(sensor, Sonar | Bumper) for sensor in sensors),
        classes["pushable"].any(),
        (rules.types["capacity"] > 0).any(),
        (comes | captured | (classes["walk"] > 0) | (classes["respawn"] != 0)).any(),
        (classes["pull"] > 0).any(),
        rules.signals > 0,
    )
    return tuple(True if there else None for there in found)


def _apart(count: int) -> NDArray[np.float64]:
    """Room for some numbers that shares no cache line with what another thread writes."""
    line = 64 // 8
    return np.full(count + 2 * line, np.nan)[line:-line]


_OF_STATE = ("robots", "objects", "discs", "segments", "seeds", "tick", "finished", "memory")
