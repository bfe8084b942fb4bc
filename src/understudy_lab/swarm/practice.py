"""The practice worlds of the swarm's robots and coordinators, and the teaching of the whole swarm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from understudy.runtime.body import Commands
from understudy.runtime.team.team import Team
from understudy.sim.scenario.schema import ObjectClass, PullRule, RobotGroup, Scenario
from understudy.sim.team.libraries import Libraries, make_team
from understudy.sim.world import World
from understudy_lab.tasks import swarm_teacher
from understudy_lab.tasks.swarm_world import PLATOON, ROBOT, SQUAD, SWARM, of_platoons, scenario
from understudy_lab.teams import TeamCourse

ROOM_M = 12.0
ENOUGH = ("enough", None)


class PracticeSpec(NamedTuple):
    """A practice world: numbers of objects, robots needed to move one, and a second robot that signals."""

    things: Mapping[str, int] = {}
    needs: int = 1
    at_m: float | None = None  # how far from it the robot begins; anywhere if left out
    held: bool = False  # and holds it
    signal: str | None = None
    between_s: tuple[float, float] = (0.0, 1e9)


def _specs(thing: str, signal: str) -> Mapping[str, PracticeSpec]:
    one = {thing: 1}
    return {
        f"a {thing}": PracticeSpec(one),
        f"at a {thing}": PracticeSpec(one, at_m=0.8),
        f"someone calls at a {thing}": PracticeSpec(one, needs=2, signal=signal),
        f"someone calls in vain at a {thing}": PracticeSpec(one, needs=4, signal=signal),
        f"someone calls late at a {thing}": PracticeSpec(one, needs=4, signal=signal, between_s=(4.0, 1e9)),
        f"beside a {thing}": PracticeSpec(one, needs=2, at_m=1.25, signal=signal),
        f"in vain at a {thing}": PracticeSpec(one, needs=4, at_m=0.8),
    }


SPECS: Mapping[str, PracticeSpec] = {
    "alone": PracticeSpec(),
    "a field": PracticeSpec({"crate": 3, "container": 1}),
    **_specs("crate", "help"),
    **_specs("container", "muster"),
    "crates in vain": PracticeSpec({"crate": 4}, needs=4, at_m=2.0),
    "crates nobody is at": PracticeSpec({"crate": 4}),
    "containers nobody is at": PracticeSpec({"container": 4}),
    "holding a crate": PracticeSpec({"crate": 1}, at_m=0.8, held=True),
    "holding in vain": PracticeSpec({"crate": 1}, needs=4, at_m=0.8, held=True),
    "losing hands": PracticeSpec(
        {"crate": 1}, needs=2, at_m=0.8, held=True, signal="claim", between_s=(0.0, 5.0)
    ),
    "holding in vain what others claim": PracticeSpec(
        {"crate": 1}, needs=4, at_m=0.8, held=True, signal="claim"
    ),
    "a crate that others take": PracticeSpec({"crate": 1}, at_m=2.6, signal="claim", between_s=(1.0, 1e9)),
    "a container that others take": PracticeSpec(
        {"container": 1}, at_m=2.6, signal="claim", between_s=(1.0, 1e9)
    ),
    "a help that stops": PracticeSpec(signal="help", between_s=(0.0, 3.0)),
    "a help that stops soon": PracticeSpec(signal="help", between_s=(0.0, 0.7)),
    "a muster that stops": PracticeSpec(signal="muster", between_s=(0.0, 3.0)),
}
"""The practice worlds of a single robot, by name."""


class PracticeRoom(World):
    """A room in which the first robot is taught; a second one holds an object and signals until it was helped."""

    def __init__(self, spec: PracticeSpec, seed: int) -> None:
        self._spec = spec
        super().__init__(_room(spec), [seed])

    def reset(self, seeds: Sequence[int]) -> None:
        """Restart the room with the given seed."""
        super().reset(seeds)
        self._prepare()

    def _prepare(self) -> None:
        """Run two ticks, so that a signal is received and an object to be held is held."""
        self._helped = False
        for _ in range(2):
            self.act({"load": (np.arange(self.agents) == 0) * float(self._spec.held)})

    def act(self, commands: Commands) -> None:
        """Execute the commands of one tick, with those of the second robot filled in."""
        if self._spec.signal is not None:
            first, last = self._spec.between_s
            calls = first <= self.time_s < last
            commands = {name: column.copy() for name, column in commands.items()}
            self._helped |= bool(self.sense([ENOUGH])[ENOUGH][1])
            signal = (1.0 + self.names.signals.index(self._spec.signal)) * (calls and not self._helped)
            own = {"load": calls, "unload": not calls, "signal": signal, "drive": 0.0, "turn": 0.0}
            for channel, value in own.items():
                commands.setdefault(channel, np.zeros(self.agents))[1] = value
        super().act(commands)


def _room(spec: PracticeSpec) -> Scenario:
    home, crate, container = scenario().objects
    things = [
        _needing(thing, spec.things[thing.name], spec.needs)
        for thing in (crate, container)
        if thing.name in spec.things
    ]
    beside = RobotGroup(type=ROBOT, count=1)
    if things:
        beside = replace(beside, near=things[0].name, near_m=0.8)
    anywhere = RobotGroup(type=ROBOT, count=1)
    robots = [anywhere if spec.at_m is None else replace(beside, near_m=spec.at_m)]
    if spec.signal is not None:
        robots.append(beside)
    if spec.needs > len(robots):  # who stand in a corner, for there must be as many as it takes
        robots.append(RobotGroup(type=ROBOT, at=((0.3, 0.3),) * (spec.needs - len(robots))))
    none = [_needing(thing, 0, 1) for thing in (crate, container) if thing.name not in spec.things]
    return replace(
        scenario(),
        size=(ROOM_M, ROOM_M),
        regions={},
        objects=(replace(home, at=((ROOM_M / 2, ROOM_M / 2),)), *things, *none),
        robots=tuple(robots),
        squads={},
    )


def robots_world(practice: str, seed: int) -> World:
    """Return the world of a practice, in which one robot is taught."""
    return PracticeRoom(SPECS[practice], seed)


@cache
def _squads_practices() -> Mapping[str, Scenario]:
    made = of_platoons(1)
    home, crate, container = made.objects
    five = (RobotGroup(type=ROBOT, count=5, within="cell_0"),)
    ten = (RobotGroup(type=ROBOT, count=10, within="cell_0"),)
    squads = {SQUAD: made.squads[SQUAD]}
    fields = (home, replace(crate, count=10), _needing(container, 0, 1))
    return {
        "squad at work": replace(made, objects=fields, robots=five, squads=squads),
        "squad in vain": replace(
            made, objects=(home, _needing(crate, 6, 10), _needing(container, 0, 1)), robots=ten, squads=squads
        ),
        "platoon at work": replace(
            made, objects=(home, replace(crate, count=4), replace(container, count=1))
        ),
        "platoon in vain": replace(
            of_platoons(2), objects=(home, replace(crate, count=4), _needing(container, 2, 50))
        ),
        "all": made,
    }


def _needing(thing: ObjectClass, count: int, robots: int) -> ObjectClass:
    return replace(thing, count=count, pull=PullRule(robots=robots))


def make_swarm_team(
    libraries: Libraries,
    seeds: Sequence[int],
    world: Scenario | None = None,
    *,
    way: tuple[str, str] = (SWARM, "swarm_work"),
) -> Team:
    """Make a swarm with one world per seed in which all agents of one type run a behavior (`way`: type, behavior)."""
    sort, behavior = way
    return make_team(world or scenario(), seeds, libraries, {sort: (behavior, {})})


COURSE = TeamCourse(
    scenario,
    {
        ROBOT: swarm_teacher.TOPICS,
        SQUAD: (swarm_teacher.SQUAD,),
        PLATOON: (swarm_teacher.PLATOON,),
        SWARM: (swarm_teacher.SWARM,),
    },
    robots_world,
    _squads_practices,
)
teach = COURSE.teach
"""Teach the robots of a swarm and three levels of coordinators."""
