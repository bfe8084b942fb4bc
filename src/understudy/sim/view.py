"""Views: one world at one moment as plain columns, for pictures, terminals and web pages.

A view contains copies, so it does not change while its world continues.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.sim.params import ScenarioNames
from understudy.sim.state import Records, WorldParams, WorldState

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.integer[Any]]
Bools: TypeAlias = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class RobotsView:
    """The robots of a world as columns [N] in order of their ids, in m and rad.

    `color`, `team` and `type` are indices of the view's names, -1 for none. `stored` and `delivered` are units of
    food.
    """

    x: Floats
    y: Floats
    heading: Floats
    radius: Floats
    reach: Floats
    color: Ints
    team: Ints
    type: Ints
    stored: Ints
    capacity: Ints
    delivered: Ints
    holding: Ints
    """The slot of the box that the robot holds, -1 for none."""
    signal: Ints
    """The index of the signal that the robot raises among the view's names, -1 for none."""
    frozen: Bools
    """Whether the robot has failed: it neither senses nor moves."""
    fails_s: Floats
    """The time at which the robot fails, s; NaN if it never does."""

    def __len__(self) -> int:
        return len(self.x)


@dataclass(frozen=True, slots=True, eq=False)
class ObjectsView:
    """The objects present in a world as columns [K], in m; the `slot` of an object never changes.

    `kind` is the index of its class among the view's names, `color` that of its color, -1 for none. `amount` is the
    food left in a source, `at_first` its initial food.
    """

    slot: Ints
    kind: Ints
    x: Floats
    y: Floats
    radius: Floats
    color: Ints
    amount: Ints
    at_first: Ints
    food: Bools
    home: Bools
    solid: Bools
    pushable: Bools
    pull: Ints
    """The number of robots that are needed to pull it; 0 if it cannot be pulled."""

    def __len__(self) -> int:
        return len(self.x)


@dataclass(frozen=True, slots=True, eq=False)
class DiscsView:
    """The round obstacles of a world as columns [O], in m; `color` is an index of the view's names, -1 for none."""

    x: Floats
    y: Floats
    radius: Floats
    color: Ints

    def __len__(self) -> int:
        return len(self.x)


@dataclass(frozen=True, slots=True, eq=False)
class WorldView:
    """One world at one moment; the arena spans [0, width] x [0, height], lengths in m, times in s."""

    width: float
    height: float
    time_s: float
    robots: RobotsView
    objects: ObjectsView
    discs: DiscsView
    walls: Floats
    """The segments of inner walls [W, 4] as x0, y0, x1, y1 (m), without the arena's outer walls."""
    edges: Floats
    """The edges of polygonal obstacles [E, 4], one polygon after the other."""
    names: ScenarioNames
    gathered: int = 0
    """The number of boxes that robots have pulled to a home."""

    @property
    def pose(self) -> dict[str, Floats]:
        """The place of each robot: x and y (m) and heading (rad), [N] each."""
        return {"x": self.robots.x, "y": self.robots.y, "heading": self.robots.heading}

    @property
    def polygons(self) -> tuple[Floats, ...]:
        """The corners [P, 2] of each polygonal obstacle (m)."""
        polygons, first = [], 0
        for last, edge in enumerate(self.edges):
            if np.array_equal(edge[2:], self.edges[first, :2]):
                polygons.append(self.edges[first : last + 1, :2])
                first = last + 1
        return tuple(polygons)

    def color(self, index: int) -> str | None:
        """Return the name of a color by its index; None for -1."""
        return self.names.colors[index] if index >= 0 else None


class RunFrame(NamedTuple):
    """One moment of a run: the world, and the name of the state or behavior of each robot."""

    view: WorldView
    doing: Sequence[str]


def make_world_view(
    state: WorldState,
    rules: WorldParams,
    names: ScenarioNames,
    world: int = 0,
    *,
    failure_ticks: Ints | None = None,
) -> WorldView:
    """Copy one world of a state into a view; `failure_ticks` [B*N] are those from which robots have failed."""
    own = slice(world * rules.robots, (world + 1) * rules.robots)
    ticks = np.full(rules.robots, -1) if failure_ticks is None else failure_ticks[own]
    segments = state.segments[world]
    segments = segments[~np.isnan(segments["x0"])]
    lines = np.stack([segments[end] for end in ("x0", "y0", "x1", "y1")], axis=1)
    wall = segments["wall"] != 0
    return WorldView(
        width=rules.width,
        height=rules.height,
        time_s=int(state.tick[world]) * rules.tick_s,
        robots=_make_robots_view(
            state.robots[own], rules, np.where(ticks >= 0, ticks * rules.tick_s, np.nan)
        ),
        objects=_make_objects_view(state.objects[world], rules),
        discs=_discs(state.discs[world]),
        walls=lines[wall],
        edges=lines[~wall],
        names=names,
        gathered=int(state.objects["gathered"][world].sum()),
    )


def _make_robots_view(rows: Records, rules: WorldParams, fails_s: Floats) -> RobotsView:
    own = ("x", "y", "heading", "type", "stored", "delivered")
    typed = ("radius", "reach", "color", "team", "capacity")
    return RobotsView(
        **{name: rows[name].copy() for name in own},
        **{name: rules.types[name][rows["type"]] for name in typed},
        holding=rows["holding"] - 1,
        signal=rows["signal"] - 1,
        frozen=rows["frozen"] != 0,
        fails_s=fails_s,
    )


def _make_objects_view(rows: Records, rules: WorldParams) -> ObjectsView:
    slot = np.flatnonzero(rows["present"])
    kind = rules.class_of[slot]
    return ObjectsView(
        slot=slot,
        kind=kind,
        **{name: rows[name][slot] for name in ("x", "y", "amount", "at_first")},
        **{name: rules.classes[name][kind] for name in ("radius", "color", "pull")},
        **{name: rules.classes[name][kind] != 0 for name in ("food", "home", "solid", "pushable")},
    )


def _discs(rows: Records) -> DiscsView:
    rows = rows[rows["radius"] > 0]
    return DiscsView(**{name: rows[name].copy() for name in ("x", "y", "radius", "color")})
