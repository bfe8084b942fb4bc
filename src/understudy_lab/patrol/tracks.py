"""Recording of patrol runs: for each tick the positions, sightings and orders of all robots."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from understudy.errors import SettingError
from understudy.model.features import Percept
from understudy.runtime.engine.engine import Engine
from understudy.runtime.team.squad_body import SquadBody
from understudy.runtime.team.team import Team
from understudy.sim.world import World
from understudy_lab.teams import world_of

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
"""The activity that an order stands for, by behavior and target."""
ALONE: Mapping[str, int] = MappingProxyType(
    {"disperse": DISPERSE, "wander": DISPERSE, "attack": ATTACK, "hunt": ATTACK, "home": HOME}
)
"""The activity of an uncoordinated robot, by the first word of its state."""

Tick: TypeAlias = Callable[[], tuple[NDArray[np.int8], Percept]]
"""A function that runs one tick, and returns the activity of all robots [W, N] and what they sensed."""
Reach: TypeAlias = tuple[SquadBody, NDArray[np.intp], NDArray[np.intp]]
"""A layer of squads, and the robots that its orders reach: pairs of a squad member and a robot [K each]."""


class OrderedActivity:
    """The activity that each robot is ordered to do by the outermost meaningful order, or does without one.

    `homes` are the homes of the squads, in order; `squad` [N] is the index of each robot's squad.
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
        """Return the present activity of all robots [W, N]."""
        if self._reaches:
            activities = np.full(self._team.ground.agents, OTHER, np.int8)
        else:
            activities = self._of_states[_engine(self._team).stacks.state[:, 0]]
        for squads, member, robot in self._reaches:
            ordering = squads.ordering
            orders = [each if each is None else (each.behavior, each.binding) for each in ordering.duties]
            meanings = [[find_activity(each, home) for home in self._homes] for each in orders]
            meant = np.array(meanings, np.int8)[ordering.heard[member], self._squad[robot]]
            activities[robot] = np.where(meant == OTHER, activities[robot], meant)
        return activities.reshape(self._worlds, -1)


def _engine(team: Team) -> Engine:
    runner = team.layers[0].runner
    if not isinstance(runner, Engine):
        raise SettingError(where="patrol", setting="team", problem="has no engine", remedy="make it with one")
    return runner


def _reaches(team: Team) -> Iterator[Reach]:
    """Yield each layer of squads with the robots that its orders reach, innermost first."""
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


def find_activity(duty: tuple[str, Mapping[str, str]] | None, home: str = "home") -> int:
    """Return the activity that an order, a behavior and its targets, stands for, for a robot with this home."""
    if duty is None:
        return OTHER
    target = next(iter(duty[1].values()), None)
    return DOING.get((duty[0], OWN_HOME if target == home else target), OTHER)


Bools = NDArray[np.bool_]
Floats = NDArray[np.float32]

NOBODY: Mapping[int, Sequence[int]] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class ObjectTrack:
    """The presence and position (m) of an object over time [T, W each]."""

    there: Bools
    x: Floats
    y: Floats


@dataclass(frozen=True, eq=False)
class PatrolTracks:
    """The record of T ticks in W worlds with N robots: the sensed state of each tick and the activity decided on it.

    `doing` [T, W, N] is the activity of each robot; `x`, `y`, `heading` [T, W, N] its pose; `sees` and `sees_boss` [T,
    W, N] whether it sees an intruder or the boss; `home` [N, 2] its home. `firsts` are the first robots of the squads,
    whose activity stands for the order to their squad. `obstacles` are discs (x, y, radius) [W, O, 3].
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
        """The number of recorded ticks."""
        return len(self.doing)

    @property
    def ordered(self) -> NDArray[np.int8]:
        """The activity that each squad is ordered to do [T, W, S]."""
        return self.doing[:, :, self.firsts]

    @property
    def hours(self) -> float:
        """The simulated time of all worlds together, h."""
        ticks, worlds, _ = self.doing.shape
        return float(ticks * worlds * self.tick_s / 3600.0)


def watch(
    team: Team, ticks: int, failing: Mapping[int, Sequence[int]] = NOBODY, homes: Sequence[str] = ("home",)
) -> PatrolTracks:
    """Run a team for `ticks` ticks and record it; `failing` maps a tick to the robots that fail in it.

    `homes` are the homes of the squads, in order.
    """
    world = world_of(team)
    ordered = OrderedActivity(team, world.worlds, homes)

    def tick() -> tuple[NDArray[np.int8], Percept]:
        team.tick()
        return ordered.now(), team.layers[0].percept

    return record_tracks(world, ticks, tick, squad=ordered.squad, homes=homes, failing=failing)


def record_tracks(
    world: World,
    ticks: int,
    tick: Tick,
    *,
    squad: NDArray[np.intp],
    homes: Sequence[str] = ("home",),
    failing: Mapping[int, Sequence[int]] = NOBODY,
) -> PatrolTracks:
    """Call `tick` for each tick of a run and record what it does in the world.

    `squad` [N] is the index of each robot's squad, and `homes` are the homes of the squads. `failing` maps a tick to
    the robots that fail in it.
    """
    shape = (ticks, world.worlds, world.robots)
    doing = np.zeros(shape, np.int8)
    x, y, heading = (np.zeros(shape, np.float32) for _ in range(3))
    sees, sees_boss = np.zeros(shape, np.bool_), np.zeros(shape, np.bool_)
    slots = [_slot(world, name) for name in ("intruder", "boss")]
    things = np.zeros((ticks, world.worlds, 2), world.state.objects.dtype)
    for number in range(ticks):
        robots = world.state.robots.reshape(shape[1:])
        x[number], y[number], heading[number] = robots["x"], robots["y"], robots["heading"]
        things[number] = world.state.objects[:, slots]
        for robot in failing.get(number, ()):
            world.freeze(robot)
        doing[number], percept = tick()
        sees[number] = _find_seen(percept, "intruder", world.agents).reshape(shape[1:])
        sees_boss[number] = _find_seen(percept, "boss", world.agents).reshape(shape[1:])
    intruder, boss = (_thing(things[:, :, index]) for index in range(2))
    places = [[float(world.state.objects[0, _slot(world, name)][axis]) for axis in "xy"] for name in homes]
    discs = world.state.discs
    obstacles = np.stack([discs[name] for name in ("x", "y", "radius")], axis=-1)
    home, firsts = np.array(places)[squad], np.unique(squad, return_index=True)[1]
    return PatrolTracks(
        world.tick_s, doing, x, y, heading, sees, sees_boss, intruder, boss, home, firsts, obstacles
    )


def make_tracks(
    tick_s: float, doing: NDArray[np.int8], places: Floats, *, intruder: Floats, boss: Floats, home: Floats
) -> PatrolTracks:
    """Make the tracks of one world in which neither headings nor what robots see was recorded.

    `doing` [T, N] are the activities and `places` [T, N, 2] the positions of the robots; `intruder` and `boss` [T, 3]
    the position of each and whether it is there, `home` [2] that of the home.
    """
    x, y = places.astype(np.float32).transpose(2, 0, 1)[:, :, None]
    never = np.zeros(x.shape, np.bool_)
    seen_intruder, seen_boss = (
        ObjectTrack(each[:, None, 2] > 0, *each[:, None, :2].astype(np.float32).transpose(2, 0, 1))
        for each in (intruder, boss)
    )
    return PatrolTracks(
        tick_s, doing[:, None], x, y, np.zeros_like(x), never, never, seen_intruder, seen_boss,
        np.tile(home, (x.shape[2], 1)), np.array([0], np.intp), np.zeros((1, 0, 3)),
    )  # fmt: skip


def _slot(world: World, name: str) -> int:
    """Return the index of the first object of a class in a world."""
    return int(world.rules.classes["first"][world.names.classes.index(name)])


def _thing(things: NDArray[Any]) -> ObjectTrack:
    return ObjectTrack(things["present"] != 0, things["x"].astype(np.float32), things["y"].astype(np.float32))


def _find_seen(percept: Percept, target: str, agents: int) -> Bools:
    sizes = percept.get(("blob_size", target), percept.get(("blob_x", target)))
    return np.zeros(agents, np.bool_) if sizes is None else ~np.isnan(sizes)
