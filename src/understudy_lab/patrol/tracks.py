"""What happens in worlds with a patrol, tick by tick: where all are, what they see, what they are told to do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.model.squad import Assignment
from understudy.runtime.engine.engine import Engine
from understudy.runtime.team.squad_body import SquadBody
from understudy.runtime.team.team import Team
from understudy.sim.world import World

OTHER, DISPERSE, ATTACK, HOME, RUN_AWAY = range(5)
OWN_HOME = "(own home)"
DOING: Mapping[tuple[str, str | None], int] = MappingProxyType(
    {
        ("disperse", None): DISPERSE,
        ("attack", "intruder"): ATTACK,
        ("attack", OWN_HOME): HOME,
        ("gather", OWN_HOME): HOME,
        ("run_away", None): RUN_AWAY,
    }
)
"""What an order means, by the behavior and its target."""
ALONE: Mapping[str, int] = MappingProxyType(
    {"disperse": DISPERSE, "wander": DISPERSE, "attack": ATTACK, "hunt": ATTACK, "home": HOME}
)
"""What a robot does by itself, by how the name of its state begins."""

Reach: TypeAlias = tuple[SquadBody, NDArray[np.intp], NDArray[np.intp]]
"""Squads, and whom their orders reach in the end: pairs of one of their members and a robot [K each]."""


class OrderedActivity:
    """What the robots of so many worlds are to do: the outermost order that means anything, or else what they do by
    themselves. `homes` are those of the squads they are in, one after the other; `squad` [N] is which one that is.
    """

    def __init__(self, team: Team, worlds: int, homes: Sequence[str]) -> None:
        self._team, self._worlds, self._homes = team, worlds, homes
        begins = [place.state.partition("_")[0] for place in _engine(team).compiled.places]
        self._of_states = np.array([ALONE.get(each, OTHER) for each in begins], np.int8)
        self._reaches = list(_reaches(team))
        self._squad = np.zeros(team.ground.agents, np.intp)
        for squads, member, robot in reversed(self._reaches):
            self._squad[robot] = squads.roster.squad[member] % len(homes)
        self.squad = self._squad[: team.ground.agents // worlds]

    def now(self) -> NDArray[np.int8]:
        """Of all robots [W, N]."""
        if self._reaches:
            found = np.full(self._team.ground.agents, OTHER, np.int8)
        else:
            found = self._of_states[_engine(self._team).stacks.state[:, 0]]
        for squads, member, robot in self._reaches:
            ordering = squads.ordering
            meanings = [[_meaning(duty, home) for home in self._homes] for duty in ordering.duties]
            meant = np.array(meanings, np.int8)[ordering.heard[member], self._squad[robot]]
            found[robot] = np.where(meant == OTHER, found[robot], meant)
        return found.reshape(self._worlds, -1)


def _engine(team: Team) -> Engine:
    runner = team.layers[0].runner
    if not isinstance(runner, Engine):
        raise SettingError(where="patrol", setting="team", problem="has no engine", remedy="make it with one")
    return runner


def _reaches(team: Team) -> Iterator[Reach]:
    """Whom orders reach, innermost first."""
    robots = {id(team.layers[0]): [np.array([robot]) for robot in range(team.ground.agents)]}
    for layer in team.layers[1:]:
        squads = layer.body
        if isinstance(squads, SquadBody):
            roster = squads.roster
            of = [
                robots[id(squads.bands[band].layer)][row]
                for band, row in zip(roster.band, roster.row, strict=True)
            ]
            member, robot = np.repeat(np.arange(len(of)), [len(each) for each in of]), np.concatenate(of)
            yield squads, member, robot
            robots[id(layer)] = [robot[roster.squad[member] == squad] for squad in range(roster.squads)]


def _meaning(duty: Assignment | None, home: str) -> int:
    """What an order means to a robot whose home is there."""
    if duty is None:
        return OTHER
    target = next(iter(duty.binding.values()), None)
    return DOING.get((duty.behavior, OWN_HOME if target == home else target), OTHER)


Bools = NDArray[np.bool_]
Floats = NDArray[np.float32]

NOBODY: Mapping[int, Sequence[int]] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class ObjectTrack:
    """An object over time: whether it is there, and where, m [T, W each]."""

    there: Bools
    x: Floats
    y: Floats


@dataclass(frozen=True, eq=False)
class PatrolTracks:
    """T ticks of W worlds with N robots: what was sensed in each tick, and what was decided on it.

    `doing` [T, W, N] is what each robot is to do; `x`, `y`, `heading` [T, W, N] where it is; `sees` and `sees_boss`
    [T, W, N] whether it sees an intruder or the boss. `home` [N, 2] is each robot's own. `firsts` are the first robots
    of the squads: what they are told, their squad is. Obstacles are discs (x, y, radius) [W, O, 3].
    """

    tick_s: float
    doing: NDArray[np.int8]
    x: Floats
    y: Floats
    heading: Floats
    sees: Bools
    sees_boss: Bools
    intruder: ObjectTrack
    boss: ObjectTrack
    home: NDArray[np.float64]
    firsts: NDArray[np.intp]
    obstacles: NDArray[np.float64]

    @property
    def ticks(self) -> int:
        """How many there are."""
        return len(self.doing)

    @property
    def told(self) -> NDArray[np.int8]:
        """What each squad is told [T, W, S]."""
        return self.doing[:, :, self.firsts]

    @property
    def hours(self) -> float:
        """Of all worlds together."""
        ticks, worlds, _ = self.doing.shape
        return float(ticks * worlds * self.tick_s / 3600.0)


def watch(
    team: Team, ticks: int, failing: Mapping[int, Sequence[int]] = NOBODY, homes: Sequence[str] = ("home",)
) -> PatrolTracks:
    """Let a team run for so many ticks, and write down what happens. Some robots fail, in these ticks.

    `homes` are those of the squads, one after the other.
    """
    world = _world(team)
    told = OrderedActivity(team, world.worlds, homes)
    shape = (ticks, world.worlds, world.robots)
    doing = np.zeros(shape, np.int8)
    x, y, heading = (np.zeros(shape, np.float32) for _ in range(3))
    sees, sees_boss = np.zeros(shape, np.bool_), np.zeros(shape, np.bool_)
    slots = [_slot(world, name) for name in ("intruder", "boss")]
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
    places = [[float(world.state.objects[0, _slot(world, name)][axis]) for axis in "xy"] for name in homes]
    discs = world.state.discs
    obstacles = np.stack([discs[name] for name in ("x", "y", "radius")], axis=-1)
    home, firsts = np.array(places)[told.squad], np.unique(told.squad, return_index=True)[1]
    return PatrolTracks(
        world.tick_s, doing, x, y, heading, sees, sees_boss, intruder, boss, home, firsts, obstacles
    )


def _world(team: Team) -> World:
    ground = getattr(team.ground, "world", team.ground)  # in physics: the one that says what there is
    if not isinstance(ground, World):
        raise SettingError(where="patrol", setting="team", problem="is in no world", remedy="give it one")
    return ground


def _slot(world: World, name: str) -> int:
    """Where the first object of a class is among those of a world."""
    return int(world.rules.classes["first"][world.names.classes.index(name)])


def _thing(things: NDArray[Any]) -> ObjectTrack:
    return ObjectTrack(things["present"] != 0, things["x"].astype(np.float32), things["y"].astype(np.float32))


def _seen(team: Team, target: str) -> Bools:
    percept = team.layers[0].percept
    sizes = percept.get(("blob_size", target), percept.get(("blob_x", target)))
    return np.zeros(team.ground.agents, np.bool_) if sizes is None else ~np.isnan(sizes)
