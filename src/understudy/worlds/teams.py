"""Teams of a scenario: who is in them, what each sort of agents knows, and all of it running.

A library of a team is a folder: the robots' automata in it, those of each sort of squads in a folder of its name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TypeAlias

from understudy.errors import SettingError, listed
from understudy.model.kit import Kit
from understudy.model.library import Library
from understudy.runtime.body import Body, Reading
from understudy.runtime.engine import Engine
from understudy.runtime.program import Program
from understudy.runtime.squad_kits import squad_kit
from understudy.runtime.squads import readings_of as readings_of_squad
from understudy.runtime.team import Team
from understudy.runtime.troop import Troop
from understudy.worlds.dealing import deal
from understudy.worlds.kits import readings_of
from understudy.worlds.scenario import Scenario
from understudy.worlds.world import World

Libraries: TypeAlias = Mapping[str, Library]
"""What each sort of agents knows, by its name: types of robots, and sorts of squads."""


def libraries_of(
    scenario: Scenario,
    robots: Library,
    squads: Callable[[str, Kit], Library] = lambda name, kit: Library(kit),
) -> Libraries:
    """What everybody knows: what the robots do, and what `squads` finds for each sort of them, given its kit."""
    found: dict[str, Library] = dict.fromkeys(scenario.types, robots)
    readings: dict[str, Sequence[Reading]] = dict.fromkeys(scenario.types, readings_of(scenario))
    for squad, _ in deal(scenario).squads:
        below = [reading for role in squad.roles for reading in readings[role.of]]
        readings[squad.name] = readings_of_squad(squad, below)
        kit = squad_kit(squad, below, {role.of: found[role.of] for role in squad.roles})
        found[squad.name] = squads(squad.name, kit)
    return MappingProxyType(found)


def sort_of(libraries: Libraries, behavior: str | None) -> str:
    """The sort of agents that a behavior was taught to, squads before robots; else the robots, as of a basic one.

    Where none is named, the topmost that was taught something. SettingError where several sorts of squads know it;
    name it SORT/BEHAVIOR then.
    """
    if behavior is None:
        names = list(libraries)
        return next((name for name in reversed(names) if libraries[name].taught), names[0])
    sort, slash, _ = behavior.partition("/")
    if slash and sort in libraries:
        return sort
    robots = next(iter(libraries))
    taught = [name for name, library in libraries.items() if behavior in library.taught]
    squads = [name for name in taught if libraries[name] is not libraries[robots]]
    if len(squads) > 1:
        remedy = f"name it as {listed(f'{name}/{behavior}' for name in squads)}"
        raise SettingError(
            where="team", setting=repr(behavior), problem="is known to several sorts of squads", remedy=remedy
        )
    return squads[0] if squads else robots


def troop_of(scenario: Scenario, sort: str, libraries: Libraries, *, seed: int = 0) -> Troop:
    """The squads of a sort with all below them, in the world of a seed: a body for a session, run by interpreters."""
    world = World(scenario, [seed])
    radio = scenario.radio
    team = Team(
        world,
        deal(scenario),
        libraries,
        {},
        trained=sort,
        delay_s=radio.delay_s,
        loss=radio.loss,
        seeds=[seed],
    )
    return Troop(team, sort)


def engined(body: Body, programs: Sequence[Program], others: Sequence[Program]) -> Engine:
    """What runs agents fast."""
    return Engine(body, programs, others)


def team_of(
    scenario: Scenario,
    seeds: Sequence[int],
    libraries: Libraries,
    roots: Mapping[str, tuple[str, Mapping[str, str]]],
) -> Team:
    """The team in worlds of these seeds, with engines; who is in no squad runs what `roots` says, by sort of agents."""
    world = World(scenario, seeds)
    return Team(
        world,
        deal(scenario),
        libraries,
        roots,
        worlds=len(seeds),
        makes=engined,
        delay_s=scenario.radio.delay_s,
        loss=scenario.radio.loss,
        seeds=world.seeds,
    )
