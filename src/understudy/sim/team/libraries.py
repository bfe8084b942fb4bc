"""Teams of a scenario: who is in them, what each sort of agents knows, and all of it running.

A library of a team is a folder: the robots' automata in it, those of each sort of squads in a folder of its name.
Where types of robots differ in what they sense or do, each type has a folder of its name, too.
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
"""What each sort of agents knows, by its name: types of robots, and sorts of squads."""


def collect_libraries(
    scenario: Scenario,
    robots: Library | Libraries,
    squads: Callable[[str, Kit], Library] = lambda name, kit: Library(kit),
) -> Libraries:
    """What everybody knows: what the robots do, all of them or by type, and what `squads` finds for each sort of them,
    given its kit.
    """
    of_types = dict.fromkeys(scenario.types, robots) if isinstance(robots, Library) else robots
    found: dict[str, Library] = {name: of_types[name] for name in scenario.types}
    readings: dict[str, Sequence[Reading]] = dict.fromkeys(scenario.types, list_readings(scenario))
    for squad, _ in assign_team_members(scenario).squads:
        below = [reading for role in squad.roles for reading in readings[role.of]]
        readings[squad.name] = readings_of_squad(squad, below)
        kit = make_squad_kit(squad, below, {role.of: found[role.of] for role in squad.roles})
        found[squad.name] = squads(squad.name, kit)
    return MappingProxyType(found)


def find_type_folders(scenario: Scenario, folder: Path | str, kit: Kit) -> Mapping[str, tuple[Path, Kit]]:
    """Where the automata of each type are kept, and the kit that they are taught with.

    Types that can be taught the same share the folder itself. Others have one of their name in it each; but one that
    has none while there are automata in the folder itself, as before there were such, knows these.
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
    """What each type of robots knows, as `look` finds it in folders, each once; types that share one share it."""
    places = find_type_folders(scenario, folder, kit)
    found = {where: look(where, own) for where, own in dict(places.values()).items()}
    return {name: found[where] for name, (where, _) in places.items()}


def find_behavior_sort(libraries: Libraries, behavior: str | None) -> str:
    """The sort of agents that a behavior was taught to, squads before robots; of a basic one, the first who has it.

    Where none is named, the topmost that was taught something. SettingError where several sorts know it; name it
    SORT/BEHAVIOR then.
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
    found = leading or taught or able[:1] or names[:1]
    if any(libraries[name] is not libraries[found[0]] for name in found) or len(leading) > 1:
        sorts = "squads" if leading else "robots"
        remedy = f"name it as {join_names(f'{name}/{behavior}' for name in found)}"
        problem = f"belongs to several sorts of {sorts}"
        raise SettingError(where="team", setting=repr(behavior), problem=problem, remedy=remedy)
    return found[0]


def list_running_sorts(libraries: Libraries, sort: str, behavior: str) -> list[str]:
    """The sorts of agents that run a behavior of a sort: those that share its library; of a basic one, all robots that
    have it.
    """
    basic = behavior not in libraries[sort].taught and not _leads(libraries[sort])
    return [
        name
        for name, library in libraries.items()
        if library is libraries[sort] or (basic and not _leads(library) and behavior in library.kit.behaviors)
    ]


def _leads(library: Library) -> bool:
    """Whether it is one of coordinators."""
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
    """The team that a scenario describes, with its radio, on a body of as many worlds as there are seeds."""
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
    """The squads of a sort with all below them, in the world of a seed: a body for a session, run by interpreters."""
    world = World(scenario, [seed])
    team = make_scenario_team(world, scenario, libraries, {}, seeds=[seed], trained=sort)
    return CoordinatorBody(team, sort)


def make_team(
    scenario: Scenario,
    seeds: Sequence[int],
    libraries: Libraries,
    roots: Mapping[str, tuple[str, Mapping[str, str]]],
) -> Team:
    """The team in worlds of these seeds, with engines; who is in no squad runs what `roots` says, by sort of agents."""
    world = World(scenario, seeds)
    return make_scenario_team(world, scenario, libraries, roots, seeds=world.seeds, makes=Engine)
