"""Where targets are: for those who look at a world from outside, and see what no sensor does."""

from __future__ import annotations

from typing import Any

import numpy as np

from understudy.worlds.scenario import TargetOf
from understudy.worlds.world import World

Place = tuple[float, float]


def place_of(world: World, name: str, agent: int = 0) -> Place | None:
    """Where a target of a robot is now; None where there is none, or where it is a color alone."""
    target = world.scenario.targets[name]
    here = world.state.robots[agent]
    if target.object is not None or target.nearest is not None:
        found = _objects(world, target, agent // world.robots)
    else:
        found = _robots(world, target, agent)
    if not len(found):
        return None
    nearest = found[np.argmin((found["x"] - here["x"]) ** 2 + (found["y"] - here["y"]) ** 2)]
    return float(nearest["x"]), float(nearest["y"])


def _objects(world: World, target: TargetOf, of: int) -> Any:
    """The objects that a target may be."""
    kind = world.rules.classes[world.names.classes.index(target.nearest or target.object)]
    things = world.state.objects[of, kind["first"] : kind["end"]]
    if target.object is not None:
        things = things[target.index : target.index + 1]
    elif kind["food"]:
        things = things[things["amount"] > 0]
    return things[things["present"] != 0]


def _robots(world: World, target: TargetOf, agent: int) -> Any:
    """The robots that a target may be: others of the same world."""
    first = agent // world.robots * world.robots
    robots = world.state.robots[first : first + world.robots]
    teams = world.rules.types["team"][robots["type"]]
    own = teams[agent - first]
    if target.team is not None:
        chosen = teams == world.names.teams.index(target.team)
    elif target.robot is not None:
        wanted = {"teammate": teams == own, "opponent": teams != own, "any": teams == teams}
        chosen = wanted[target.robot]
    else:
        chosen = np.zeros(len(robots), np.bool_)
    chosen[agent - first] = False
    return robots[chosen]
