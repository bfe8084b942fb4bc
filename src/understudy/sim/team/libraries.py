"""Build the team of a scenario: the libraries of automata of each sort of agents, and the running team itself.

A sort is a type of robots or a kind of squads. The folder of a team's library contains the automata of the robots,
and one subfolder, named after the sort, for the automata of each kind of squads. If types of robots differ in sensors
or behaviors, each type has a subfolder of its own, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TypeAlias

from understudy.errors import SettingError, join_names
from understudy.model.library import Kit, Library
from understudy.runtime.body import Body, Reading
from understudy.runtime.engine.engine import Engine
from understudy.runtime.team.coordinator_body import CoordinatorBody
from understudy.runtime.team.squad_body import list_squad_readings as readings_of_squad
from understudy.runtime.team.squad_kit import make_squad_kit
from understudy.runtime.team.team import Makes, Team, make_interpreter_runner
from understudy.sim.kit import have_different_kits, list_readings, make_type_kits
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.world import World
from understudy.storage.library_folder import list_documents

Libraries: TypeAlias = Mapping[str, Library]
"""The library of automata of each sort of agents (types of robots, kinds of squads), by the sort's name."""


def collect_libraries(
    scenario: Scenario,
    robots: Library | Libraries,
    squads: Callable[[str, Kit], Library] = lambda name, kit: Library(kit),
) -> Libraries:
    """Collect the libraries of all sorts of agents in a scenario: its types of robots and its kinds of squads.

    Parameters
    ----------
    scenario
        The scenario, which names the types and squads.
    robots
        One library for all types of robots, or a library for each type, by its name.
    squads
        A function that returns the library of a kind of squads, given its name and its kit (the features and orders
        that its coordinators can use). By default each gets an empty library.

    Returns
    -------
    Libraries
        The library of each sort, by name: types of robots first, then squads, each after its members.

    Raises
    ------
    SettingError
        If the squads of the scenario contradict each other or there are not enough robots for them.
    """
    of_types = dict.fromkeys(scenario.types, robots) if isinstance(robots, Library) else robots
    libraries: dict[str, Library] = {name: of_types[name] for name in scenario.types}
    readings: dict[str, Sequence[Reading]] = dict.fromkeys(scenario.types, list_readings(scenario))
    for squad, _ in assign_team_members(scenario).squads:
        below = [reading for role in squad.roles for reading in readings[role.of]]
        readings[squad.name] = readings_of_squad(squad, below)
        kit = make_squad_kit(squad, below, {role.of: libraries[role.of] for role in squad.roles})
        libraries[squad.name] = squads(squad.name, kit)
    return MappingProxyType(libraries)


def find_type_folders(scenario: Scenario, folder: Path | str, kit: Kit) -> Mapping[str, tuple[Path, Kit]]:
    """Return the folder that contains the automata of each type of robots, and the kit that they use.

    All types use `folder` itself if their kits are equal. Otherwise each has a subfolder of its name; a type without
    one still uses `folder` if that contains automata, as folders made before there were subfolders do.
    """
    folder, kits = Path(folder), make_type_kits(scenario, kit)
    if not have_different_kits(kits):
        return dict.fromkeys(kits, (folder, kit))
    former = folder.is_dir() and bool(list_documents(folder))
    return {
        name: (folder, kit) if former and not (folder / name).is_dir() else (folder / name, own)
        for name, own in kits.items()
    }


def load_type_libraries(
    scenario: Scenario, folder: Path | str, kit: Kit, look: Callable[[Path, Kit], Library]
) -> Mapping[str, Library]:
    """Load the library of each type of robots by calling `look(folder, kit)`, once for types that share a folder."""
    places = find_type_folders(scenario, folder, kit)
    libraries = {where: look(where, own) for where, own in dict(places.values()).items()}
    return {name: libraries[where] for name, (where, _) in places.items()}


def find_behavior_sort(libraries: Libraries, behavior: str | None) -> str:
    """Return the sort of agents that a behavior belongs to: one that it was taught to, squads before robots.

    For a basic behavior, return the first sort that has it. For None, return the topmost sort that was taught anything.
    SettingError if several sorts with different libraries qualify; SORT/BEHAVIOR names one.
    """
    names = list(libraries)
    if behavior is None:
        return next((name for name in reversed(names) if libraries[name].taught), names[0])
    sort, slash, _ = behavior.partition("/")
    if slash and sort in libraries:
        return sort
    taught = [name for name in names if behavior in libraries[name].taught]
    leading = [name for name in taught if _leads(libraries[name])]
    able = [name for name in names if behavior in libraries[name].kit.behaviors]
    candidates = leading or taught or able[:1] or names[:1]
    if any(libraries[name] is not libraries[candidates[0]] for name in candidates) or len(leading) > 1:
        sorts = "squads" if leading else "robots"
        remedy = f"name it as {join_names(f'{name}/{behavior}' for name in candidates)}"
        problem = f"belongs to several sorts of {sorts}"
        raise SettingError(where="team", setting=repr(behavior), problem=problem, remedy=remedy)
    return candidates[0]


def list_running_sorts(libraries: Libraries, sort: str, behavior: str) -> list[str]:
    """List the sorts of agents that can run a behavior of a sort: all that share its library.

    For a basic behavior of robots, these are all types of robots that have a behavior of this name.
    """
    basic = behavior not in libraries[sort].taught and not _leads(libraries[sort])
    return [
        name
        for name, library in libraries.items()
        if library is libraries[sort] or (basic and not _leads(library) and behavior in library.kit.behaviors)
    ]


def _leads(library: Library) -> bool:
    """Return whether a library belongs to coordinators of squads."""
    return any(behavior.order is not None for behavior in library.kit.behaviors.values())


def make_scenario_team(
    ground: Body,
    scenario: Scenario,
    libraries: Libraries,
    roots: Mapping[str, tuple[str, Mapping[str, str]]],
    *,
    seeds: Sequence[int],
    makes: Makes = make_interpreter_runner,
    trained: str | None = None,
) -> Team:
    """Make the team that a scenario describes, with its radio delay and loss, on a body with one world per seed."""
    return Team(
        ground,
        assign_team_members(scenario),
        libraries,
        roots,
        worlds=len(seeds),
        makes=makes,
        trained=trained,
        delay_s=scenario.radio.delay_s,
        loss=scenario.radio.loss,
        seeds=seeds,
    )


def make_coordinator_body(
    scenario: Scenario, sort: str, libraries: Libraries, *, seed: int = 0
) -> CoordinatorBody:
    """Make a body whose agents are the coordinators of one kind of squads, to teach them in a session.

    The squads' members run below them, with interpreters, in one simulated world.

    Parameters
    ----------
    scenario
        The scenario with the squads.
    sort
        The name of the kind of squads to teach.
    libraries
        The library of each sort of agents; see `collect_libraries`.
    seed
        The seed that lays out the world and draws which messages get lost.

    Returns
    -------
    CoordinatorBody
        A body with one agent per squad of this kind.
    """
    world = World(scenario, [seed])
    team = make_scenario_team(world, scenario, libraries, {}, seeds=[seed], trained=sort)
    return CoordinatorBody(team, sort)


def make_team(
    scenario: Scenario,
    seeds: Sequence[int],
    libraries: Libraries,
    roots: Mapping[str, tuple[str, Mapping[str, str]]],
) -> Team:
    """Make a scenario's team in new worlds, run by the compiled engine.

    Parameters
    ----------
    scenario
        The scenario with robots and squads.
    seeds
        The seed of each world.
    libraries
        The library of each sort of agents; see `collect_libraries`.
    roots
        By sort of agents, the name of the behavior that agents outside of any squad run, and the target for each of its
        parameters. Sorts without an entry idle until a coordinator orders something.

    Returns
    -------
    Team
        The team at time 0. `run` advances it.

    Raises
    ------
    SettingError
        If the scenario is not valid or a seed is not a whole number from 0 up.
    UnknownName
        If `roots` names a sort or behavior that does not exist.
    """
    world = World(scenario, seeds)
    return make_scenario_team(world, scenario, libraries, roots, seeds=world.seeds, makes=Engine)
