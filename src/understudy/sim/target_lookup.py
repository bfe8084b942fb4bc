"""Find the places of targets for people and programs that observe a world from outside, beyond what robots sense."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from understudy.sim.scenario.schema import TargetSpec

if TYPE_CHECKING:
    from understudy.sim.world import World

Place = tuple[float, float]


def find_target_place(world: World, name: str, agent: int = 0) -> Place | None:
    """Return the place (x, y in m) of a robot's target now; None if it is absent or only a color."""
    target = world.scenario.targets[name]
    here = world.state.robots[agent]
    if target.object is not None or target.nearest is not None:
        candidates = _list_target_objects(world, target, agent)
    else:
        candidates = _list_target_robots(world, target, agent)
    if not len(candidates):
        return None
    nearest = candidates[np.argmin((candidates["x"] - here["x"]) ** 2 + (candidates["y"] - here["y"]) ** 2)]
    return float(nearest["x"]), float(nearest["y"])


def _list_target_objects(world: World, target: TargetSpec, agent: int) -> Any:
    """Return the objects that a target may refer to."""
    of = agent // world.robots
    kind = world.rules.classes[world.names.classes.index(target.nearest or target.object)]
    things = world.state.objects[of, kind["first"] : kind["end"]]
    if target.object is not None:
        things = things[target.index : target.index + 1]
    elif kind["food"]:
        things = things[things["amount"] > 0]
    things = things[things["present"] != 0]
    return things if target.unclaimed is None else things[~_claimed(world, target, agent, things)]


def _claimed(world: World, target: TargetSpec, agent: int, things: Any) -> Any:
    """Return which objects another robot of the world claims."""
    robots = _others(world, agent)
    robots = robots[robots["signal"] == 1 + world.names.signals.index(target.unclaimed or "")]
    dx, dy = things["x"][:, None] - robots["x"], things["y"][:, None] - robots["y"]
    return (dx**2 + dy**2 <= (target.within or 0.0) ** 2).any(axis=1)


def _others(world: World, agent: int) -> Any:
    """Return the other robots of a robot's world."""
    first = agent // world.robots * world.robots
    return np.delete(world.state.robots[first : first + world.robots], agent - first)


def _list_target_robots(world: World, target: TargetSpec, agent: int) -> Any:
    """Return the robots that a target may refer to: others of the same world."""
    robots, types = _others(world, agent), world.rules.types["team"]
    teams, own = types[robots["type"]], types[world.state.robots["type"][agent]]
    if target.team is not None:
        chosen = teams == world.names.teams.index(target.team)
    elif target.robot is not None or target.signal is not None:
        wanted = {"teammate": teams == own, "opponent": teams != own, "any": teams == teams}
        chosen = wanted[target.robot or "any"]
    else:
        chosen = np.zeros(len(robots), np.bool_)
    if target.signal is not None:
        chosen = chosen & (robots["signal"] == 1 + world.names.signals.index(target.signal))
    return robots[chosen]
