"""What stands where in a running world: whether a disc put somewhere would overlap something solid."""

from __future__ import annotations

import numpy as np

from understudy.sim.layout.geometry import from_segment
from understudy.sim.params import Names
from understudy.sim.state import Records, Rules, State

CLOSE = 1e-9
"""What rounding may do to a distance, m."""


def in_the_way(
    state: State,
    rules: Rules,
    names: Names,
    world: int,
    x: float,
    y: float,
    radius: float,
    *,
    robot: int = -1,
    slot: int = -1,
    collides: bool = True,
    stays: bool = False,
) -> str | None:
    """What a solid disc there would overlap, in words; None where it is free.

    It is a robot (its id in its world), the object in a slot, or something new. Robots that do not collide may
    overlap each other; an obstacle that `stays` may overlap walls and other obstacles.
    """
    least = radius - CLOSE
    if not stays:
        if not (least <= x <= rules.width - least and least <= y <= rules.height - least):
            return "the outer wall"
        discs = state.discs[world]
        if _hit(discs, discs["radius"] > 0, discs["radius"], x, y, least) is not None:
            return "an obstacle"
        found = _segment(state.segments[world], x, y, least)
        if found is not None:
            return found
    objects = state.objects[world]
    classes = rules.classes[rules.class_of]
    there = (objects["present"] != 0) & (classes["solid"] != 0) & (np.arange(len(objects)) != slot)
    hit = _hit(objects, there, classes["radius"], x, y, least)
    if hit is not None:
        return f"object {hit}, of class {names.classes[rules.class_of[hit]]!r}"
    robots = state.robots[world * rules.robots : (world + 1) * rules.robots]
    types = rules.types[robots["type"]]
    there = (robots["id"] != robot) & ((types["collides"] != 0) & collides if robot >= 0 else True)
    hit = _hit(robots, there, types["radius"], x, y, least)
    return None if hit is None else f"robot {hit}"


def _segment(segments: Records, x: float, y: float, radius: float) -> str | None:
    """The wall or polygon that a disc overlaps, in words."""
    winding = 0
    for piece in segments:
        (x0, y0, x1, y1), wall = (float(piece[name]) for name in ("x0", "y0", "x1", "y1")), piece["wall"]
        if from_segment((x, y), ((x0, y0), (x1, y1))) < radius:
            return "a wall" if wall else "an obstacle"
        if not wall and (y0 <= y < y1 or y1 <= y < y0):
            left = (x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)
            winding += (left > 0) * (y1 > y0) - (left < 0) * (y1 < y0)
    return "an obstacle" if winding else None


def _hit(things: Records, there: Records, radii: Records, x: float, y: float, radius: float) -> int | None:
    """The first of the discs that are there which a disc overlaps."""
    apart = np.hypot(things["x"] - x, things["y"] - y) - radii
    found = np.flatnonzero(there & (apart < radius))
    return int(found[0]) if len(found) else None
