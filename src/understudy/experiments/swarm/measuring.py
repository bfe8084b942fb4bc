"""What one teaching of the swarm comes to in unseen worlds, beside the same by hand and without coordinators."""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter

from understudy.experiments.swarm import by_hand
from understudy.experiments.swarm.practice import alone, coordinated, of_platoons, scenario
from understudy.model.library import Library
from understudy.runtime.team import Team
from understudy.worlds.kits import kit_of
from understudy.worlds.teams import Libraries, libraries_of
from understudy.worlds.world import World

WORLDS, TICKS = 10, 6000
"""Worlds that each teaching is judged on, and ticks of 0.1 s: ten minutes."""
WARM_UP = 20


def worlds_of(seed: int) -> range:
    """The unseen worlds that the teaching of this seed is judged on; no two teachings share one."""
    return range(WORLDS * seed, WORLDS * (seed + 1))


def hand_coded() -> Libraries:
    """What robots and coordinators know that were written by hand."""

    def squads(name: str, kit: object) -> Library:
        return by_hand.SQUADS[name](kit)  # type: ignore[arg-type]

    return libraries_of(scenario(), by_hand.robots(kit_of(scenario())), squads)


def judged(libraries: Libraries, worlds: Sequence[int], ticks: int = TICKS) -> dict[str, dict[str, float]]:
    """What is gathered in an hour, by way: taught and by hand, with all coordinators and with none."""
    return {
        "taught": gathered(coordinated(libraries, worlds), ticks),
        "by_hand": gathered(coordinated(hand_coded(), worlds), ticks),
        "alone": gathered(alone(libraries, worlds), ticks),
        "answering": gathered(alone(libraries, worlds, "alone_answering"), ticks),
    }


def gathered(team: Team, ticks: int) -> dict[str, float]:
    """Crates and containers an hour, and `hands`: each counts for as many robots as it takes."""
    team.run(ticks)
    world = team.ground
    if not isinstance(world, World):
        raise TypeError("a team that is in no world")
    hours = world.worlds * world.time_s / 3600.0
    rules, counted = world.rules.classes, world.state.objects["gathered"].sum(axis=0)
    found, hands = {}, 0.0
    for name in ("crate", "container"):
        number = world.names.classes.index(name)
        of_class = slice(int(rules["first"][number]), int(rules["end"][number]))
        found[f"{name}s"] = float(counted[of_class].sum()) / hours
        hands += found[f"{name}s"] * float(rules["pull"][number])
    return {**found, "hands": hands}


def speed(libraries: Libraries, platoons: int, ticks: int) -> float:
    """Ticks in a second with so many platoons."""
    team = coordinated(libraries, [0], of_platoons(platoons))
    team.run(WARM_UP)
    began = perf_counter()
    team.run(ticks)
    return ticks / (perf_counter() - began)
