"""Evaluation of a taught swarm in unseen worlds, compared with hand-written automata and fewer coordinators."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from understudy.runtime.team.team import Team
from understudy.sim.team.libraries import Libraries
from understudy.sim.world import World
from understudy_lab import teams
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
from understudy_lab.teams import run_with_failures, world_of

WORLDS, TICKS = 10, 6_000
"""The number of worlds per teaching, and the ticks of 0.1 s that each runs: ten minutes."""
LOADS: Mapping[str, int] = {"crate": 1, "container": 10}
"""A container, which takes sixteen robots, holds as much as ten crates, which take four each."""
PLATOONS, LARGE_TICKS = 400, 3_000
"""The number of platoons of the ten thousand robots, and the ticks they run: five minutes."""
FAILS_TICK = (1_000, 3_000)
"""The range of ticks in which robots fail at random; only the yield after it counts."""
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
"""The type of agent that starts a behavior, and that behavior, by degree of coordination."""


def worlds_of(seed: int) -> range:
    """Return the seeds of the unseen worlds of a teaching; no two teachings share one."""
    return range(WORLDS * seed, WORLDS * (seed + 1))


def measure_swarm(libraries: Libraries, worlds: Sequence[int], ticks: int = TICKS) -> dict[str, Any]:
    """Measure the hourly yield of a swarm in all variants.

    The variants are: each degree of coordination, hand-written automata, a third of the robots failing, and ten
    thousand robots.
    """
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
    """Run a team and return its crates, containers and loads (see LOADS) per hour."""
    team.run(ticks)
    return _rates(world_of(team))


def measure_late_gathering(team: Team, ticks: int, fails: Mapping[int, Sequence[int]]) -> float:
    """Return the loads per hour after the last possible failure; `fails` maps a tick to the robots that fail in it."""
    world, at = world_of(team), FAILS_TICK[1]
    run_with_failures(team, at, fails)
    early = _loads(world)
    team.run(ticks - at)
    return (_loads(world) - early) / ((ticks - at) * world.tick_s / 3600 * world.worlds)


schedule_failures = partial(teams.schedule_failures, robots=8 * EACH, within=FAILS_TICK)


def _each(team: Team, ticks: int) -> float:
    """Run a team and return the loads that one robot gathers per hour."""
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
    """Return the number of gathered objects of each class over all worlds."""
    rules, objects = world.rules.classes, world.state.objects["gathered"].sum(axis=0)
    counts = {}
    for name in LOADS:
        number = world.names.classes.index(name)
        of_class = slice(int(rules["first"][number]), int(rules["end"][number]))
        counts[name] = float(objects[of_class].sum())
    return counts
