"""What one teaching of the swarm comes to in unseen worlds, beside the same by hand and with fewer coordinators."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from understudy.errors import SettingError
from understudy.runtime.team.team import Team
from understudy.sim.team.libraries import Libraries
from understudy.sim.world import World
from understudy_lab.swarm.practice import make_swarm_team
from understudy_lab.tasks.swarm_world import (
    EACH,
    PLATOON,
    ROBOT,
    SQUAD,
    SWARM,
    make_expert_libraries,
    of_platoons,
)

WORLDS, TICKS = 10, 6_000
"""Worlds that each teaching is judged on, and ticks of 0.1 s: ten minutes."""
LOADS: Mapping[str, int] = {"crate": 1, "container": 10}
"""A container, which takes sixteen robots, holds as much as ten crates, which take four each."""
PLATOONS, LARGE_TICKS = 400, 3_000
"""Platoons of the ten thousand, and how long they run: five minutes."""
FAILS_TICK = (1_000, 3_000)
"""When robots fail, each at a random moment; what is gathered after that counts."""
FAILING = 3
"""One of so many fails."""
THREE, TWO, ONE, ANSWERING, ALONE = (
    "three levels",
    "platoons",
    "squads",
    "alone, answering calls",
    "alone",
)
WAYS: Mapping[str, tuple[str, str]] = {
    THREE: (SWARM, "swarm_work"),
    TWO: (PLATOON, "platoon_work"),
    ONE: (SQUAD, "squad_work"),
    ANSWERING: (ROBOT, "alone_answering"),
    ALONE: (ROBOT, "alone"),
}
"""Who is told what: all, each platoon, each squad, or each robot."""


def worlds_of(seed: int) -> range:
    """The unseen worlds that the teaching of this seed is judged on; no two teachings share one."""
    return range(WORLDS * seed, WORLDS * (seed + 1))


def measure_swarm(libraries: Libraries, worlds: Sequence[int], ticks: int = TICKS) -> dict[str, Any]:
    """What is gathered in an hour: by way as taught, by hand, with a third killed, and by ten thousand."""
    by_way = {
        way: measure_gathered(make_swarm_team(libraries, worlds, way=told), ticks)
        for way, told in WAYS.items()
    }
    whole, killed = (
        measure_late_gathering(make_swarm_team(libraries, worlds), ticks, fails)
        for fails in ({}, schedule_failures(worlds))
    )
    large = make_swarm_team(libraries, worlds[:1], of_platoons(PLATOONS))
    same = make_swarm_team(libraries, worlds)
    return {
        "taught": by_way,
        "by_hand": measure_gathered(make_swarm_team(make_expert_libraries(), worlds), ticks),
        "kept": round(killed / whole, 4) if whole else 0.0,
        "large": _each(large, min(ticks, LARGE_TICKS)),
        "small": _each(same, min(ticks, LARGE_TICKS)),
    }


def measure_gathered(team: Team, ticks: int) -> dict[str, float]:
    """Crates and containers an hour, and `loads`: what both hold, counted as LOADS says."""
    team.run(ticks)
    return _rates(world_of(team))


def measure_late_gathering(team: Team, ticks: int, fails: Mapping[int, Sequence[int]]) -> float:
    """Loads an hour after the last moment in which robots fail; these fail in these ticks."""
    world, at = world_of(team), 0
    for tick in sorted({*fails, FAILS_TICK[1]}):
        team.run(tick - at)
        at = tick
        for robot in fails.get(tick, ()):
            world.freeze(robot)
    early = _loads(world)
    team.run(ticks - at)
    return (_loads(world) - early) / ((ticks - at) * world.tick_s / 3600 * world.worlds)


def schedule_failures(worlds: Sequence[int], robots: int = 8 * EACH) -> dict[int, list[int]]:
    """A third of the robots of each world, whoever they are, each some time: rows by tick."""
    draws = np.random.default_rng(list(worlds))
    found: dict[int, list[int]] = {}
    for world in range(len(worlds)):
        for robot in draws.choice(robots, robots // FAILING, replace=False).tolist():
            found.setdefault(int(draws.integers(*FAILS_TICK)), []).append(world * robots + robot)
    return found


def world_of(team: Team) -> World:
    """The world it is in."""
    if not isinstance(team.ground, World):
        raise SettingError(where="swarm", setting="team", problem="is in no world", remedy="give it one")
    return team.ground


def _each(team: Team, ticks: int) -> float:
    """Loads that each robot gathers in an hour."""
    world = world_of(team)
    team.run(ticks)
    return round(_rates(world)["loads"] * world.worlds / world.agents, 2)


def _rates(world: World) -> dict[str, float]:
    hours = world.worlds * world.time_s / 3600
    things = {f"{name}s": count / hours for name, count in _counted(world).items()}
    rates = {**things, "loads": _loads(world) / hours}
    return {name: round(rate, 1) for name, rate in rates.items()}


def _loads(world: World) -> float:
    return sum(count * LOADS[name] for name, count in _counted(world).items())


def _counted(world: World) -> dict[str, float]:
    """How many of each were gathered, in all worlds."""
    rules, objects = world.rules.classes, world.state.objects["gathered"].sum(axis=0)
    found = {}
    for name in LOADS:
        number = world.names.classes.index(name)
        of_class = slice(int(rules["first"][number]), int(rules["end"][number]))
        found[name] = float(objects[of_class].sum())
    return found
