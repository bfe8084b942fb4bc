"""What happens in worlds with a patrol, tick by tick: where all are, what they see, what they are told to do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.model.squad import Duty
from understudy.runtime.engine import Engine
from understudy.runtime.squads import Squads
from understudy.runtime.team import Team
from understudy.worlds.world import World

Bools = NDArray[np.bool_]
Floats = NDArray[np.float32]

OTHER, DISPERSE, ATTACK, HOME, RUN_AWAY = range(5)
DOING: Mapping[tuple[str, str | None], int] = MappingProxyType(
    {
        ("disperse", None): DISPERSE,
        ("attack", "intruder"): ATTACK,
        ("attack", "home"): HOME,
        ("run_away", None): RUN_AWAY,
    }
)
"""What an order means, by the behavior and its target."""
NOBODY: Mapping[int, Sequence[int]] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Thing:
    """An object over time: whether it is there, and where, m [T, W each]."""

    there: Bools
    x: Floats
    y: Floats


@dataclass(frozen=True, eq=False)
class Tracks:
    """T ticks of W worlds with N robots: what was sensed in each tick, and what was decided on it.

    `doing` [T, W, N] is what each robot is to do; `x`, `y`, `heading` [T, W, N] where it is; `sees` and `sees_boss`
    [T, W, N] whether it sees an intruder or the boss. Obstacles are discs (x, y, radius) [W, O, 3].
    """

    tick_s: float
    doing: NDArray[np.int8]
    x: Floats
    y: Floats
    heading: Floats
    sees: Bools
    sees_boss: Bools
    intruder: Thing
    boss: Thing
    home: tuple[float, float]
    obstacles: NDArray[np.float64]

    @property
    def ticks(self) -> int:
        """How many there are."""
        return len(self.doing)

    @property
    def hours(self) -> float:
        """Of all worlds together."""
        ticks, worlds, _ = self.doing.shape
        return float(ticks * worlds * self.tick_s / 3600.0)


def watch(team: Team, ticks: int, failing: Mapping[int, Sequence[int]] = NOBODY) -> Tracks:
    """Let a team run for so many ticks, and write down what happens. Some robots fail, in these ticks."""
    world = _world(team)
    told = _Told(team)
    shape = (ticks, world.worlds, world.robots)
    doing = np.zeros(shape, np.int8)
    x, y, heading = (np.zeros(shape, np.float32) for _ in range(3))
    sees, sees_boss = np.zeros(shape, np.bool_), np.zeros(shape, np.bool_)
    slots = [
        int(world.rules.classes["first"][world.names.classes.index(name)]) for name in ("intruder", "boss")
    ]
    things = np.zeros((ticks, world.worlds, 2), world.state.objects.dtype)
    for tick in range(ticks):
        robots = world.state.robots.reshape(shape[1:])
        x[tick], y[tick], heading[tick] = robots["x"], robots["y"], robots["heading"]
        things[tick] = world.state.objects[:, slots]
        for robot in failing.get(tick, ()):
            world.freeze(robot)
        team.tick()
        doing[tick] = told.now()
        sees[tick] = _seen(team, "intruder").reshape(shape[1:])
        sees_boss[tick] = _seen(team, "boss").reshape(shape[1:])
    intruder, boss = (_thing(things[:, :, index]) for index in range(2))
    home = world.state.objects[0, int(world.rules.classes["first"][world.names.classes.index("home")])]
    discs = world.state.discs
    obstacles = np.stack([discs[name] for name in ("x", "y", "radius")], axis=-1)
    place = float(home["x"]), float(home["y"])
    return Tracks(world.tick_s, doing, x, y, heading, sees, sees_boss, intruder, boss, place, obstacles)


def _world(team: Team) -> World:
    if not isinstance(team.ground, World):
        raise SettingError(where="patrol", setting="team", problem="is in no world", remedy="give it one")
    return team.ground


def _engine(team: Team) -> Engine:
    runner = team.layers[0].runner
    if not isinstance(runner, Engine):
        raise SettingError(where="patrol", setting="team", problem="has no engine", remedy="make it with one")
    return runner


def _thing(things: NDArray[Any]) -> Thing:
    return Thing(things["present"] != 0, things["x"].astype(np.float32), things["y"].astype(np.float32))


def _seen(team: Team, target: str) -> Bools:
    percept = team.layers[0].percept
    sizes = percept.get(("blob_size", target), percept.get(("blob_x", target)))
    return np.zeros(team.ground.agents, np.bool_) if sizes is None else ~np.isnan(sizes)


class _Told:
    """What each robot is to do: what it was ordered where it has a coordinator, else the state it is in by itself."""

    def __init__(self, team: Team) -> None:
        self._team = team
        names = {"disperse": DISPERSE, "wander": DISPERSE, "attack": ATTACK, "hunt": ATTACK, "home": HOME}
        tasks = [place.state.partition("_")[0] for place in _engine(team).compiled.places]
        self._of_states = np.array([names.get(task, OTHER) for task in tasks], np.int8)

    def now(self) -> NDArray[np.int8]:
        """Of all robots [W, N]."""
        team = self._team
        world = _world(team)
        body = team.layers[-1].body
        if isinstance(body, Squads):
            of_duties = np.array([_meaning(duty) for duty in body.ordering.duties], np.int8)
            return of_duties[body.ordering.heard].reshape(world.worlds, world.robots)
        return self._of_states[_engine(team).stacks.state[:, 0]].reshape(world.worlds, world.robots)


def _meaning(duty: Duty | None) -> int:
    if duty is None:
        return OTHER
    target = next(iter(duty.binding.values()), None)
    return DOING.get((duty.behavior, target), OTHER)
