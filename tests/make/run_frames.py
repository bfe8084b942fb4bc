"""Made-up worlds: states filled in by hand, whose robots go straight ahead, for all that shows worlds."""

from __future__ import annotations

import numpy as np

from understudy.sim.kernels.dtypes import DISC, OBJECT, ROBOT, SEGMENT
from understudy.sim.params import collect_names, make_world_params
from understudy.sim.scenario.schema import ObjectClass, RobotGroup, RobotType, Scenario
from understudy.sim.state import WorldState
from understudy.sim.view import RunFrame, make_world_view

SQUARE = ((6.0, 2.0), (8.0, 2.0), (8.0, 4.0), (6.0, 4.0))
THINGS = (
    ("food", 2.0, 6.0, 8, 3),
    ("food", 9.0, 6.5, 4, 4),
    ("base", 6.0, 6.0, 0, 0),
    ("box", 3.0, 2.0, 0, 0),
)
"""Class, place, food at first and now."""


def make_scenario(robots: int, *, width: float = 12.0, height: float = 8.0) -> Scenario:
    """Red scouts that carry food, and all sorts of objects."""
    return Scenario(
        name="crossing",
        size=(width, height),
        types={"scout": RobotType(color="red", capacity=5), "other": RobotType(radius=0.3)},
        robots=(RobotGroup(type="scout", count=robots - 1), RobotGroup(type="other")),
        objects=(
            ObjectClass(name="food", amount=8, count=2),
            ObjectClass(name="base", home=True),
            ObjectClass(name="box", pushable=True, color="brown"),
            ObjectClass(name="marker", color="#12ab9f", count=3),
        ),
        spare_objects=1,
    )


def make_state(made: Scenario, *, seed: int = 0) -> WorldState:
    """Two worlds side by side: the first with nothing in it, the second as THINGS and SQUARE say."""
    rules, names = make_world_params(made), collect_names(made)
    draw = np.random.default_rng(seed)
    robots = np.zeros(2 * rules.robots, ROBOT)
    robots["id"] = np.tile(np.arange(rules.robots), 2)
    robots["type"] = robots["id"] == rules.robots - 1
    robots["x"] = draw.uniform(0.1, 0.9, len(robots)) * rules.width
    robots["y"] = draw.uniform(0.1, 0.9, len(robots)) * rules.height
    robots["heading"] = draw.uniform(0.0, 2 * np.pi, len(robots))
    objects = np.zeros((2, len(rules.class_of)), OBJECT)
    for name, x, y, at_first, amount in THINGS:
        slots = objects[1, rules.classes["first"][names.classes.index(name)] :]
        free = np.flatnonzero(slots["present"] == 0)[0]
        for field, value in zip(
            ("x", "y", "at_first", "amount", "present"), (x, y, at_first, amount, 1), strict=True
        ):
            slots[field][free] = value
    discs, lines = np.zeros((2, 2), DISC), np.zeros((2, 7), SEGMENT)
    for end in ("x0", "y0", "x1", "y1"):
        lines[end] = np.nan
    discs[1, 0] = (10.0, 3.0, 0.7, 1.0, -1)
    lines[1, 0] = (4.0, 8.0, 4.0, 5.0, 1)
    for at, (corner, following) in enumerate(zip(SQUARE, (*SQUARE[1:], SQUARE[0]), strict=True)):
        lines[1, 1 + at] = (*corner, *following, 0)
    zeros = np.zeros(2, np.int64)
    return WorldState(
        robots, objects, discs, lines, zeros, zeros.copy(), zeros - 1, np.zeros((len(robots), 0))
    )


def make_crossing(ticks: int, *, robots: int = 3, width: float = 12.0, height: float = 8.0) -> list[RunFrame]:
    """Some ticks of the second world; the last robot turns, the others go ahead, then turn."""
    made = make_scenario(robots, width=width, height=height)
    rules, names, state = make_world_params(made), collect_names(made), make_state(made)
    frames = []
    for tick in range(ticks):
        does = ("ahead" if tick % 20 < 15 else "turn",) * (robots - 1) + ("turn",)
        frames.append(RunFrame(make_world_view(state, rules, names, 1), does))
        own = state.robots[robots:]
        own["x"] = np.clip(own["x"] + 0.1 * np.cos(own["heading"]), 0.2, width - 0.2)
        own["y"] = np.clip(own["y"] + 0.1 * np.sin(own["heading"]), 0.2, height - 0.2)
        own["heading"][-1] = (own["heading"][-1] + 0.2) % (2 * np.pi)
        state.tick[:] += 1
    return frames
