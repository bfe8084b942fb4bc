"""Load and check the plan of a team of real robots from its file, as each of its agents does on its own computer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from hashlib import blake2b
from pathlib import Path

import msgspec

from understudy.addons.robots.robot_file import RobotFile, TeamFile, load_robot, load_team
from understudy.addons.robots.skills.stand_ins import add_robot_skills
from understudy.addons.robots.team_network.library_push import LibraryFolder
from understudy.addons.robots.team_network.zenoh_network import ZenohOptions
from understudy.addons.robots.team_settings import TeamSettings
from understudy.errors import FileError, UnderstudyError, join_names
from understudy.model.library import Library
from understudy.runtime.agents.leadership import SILENT_S
from understudy.runtime.agents.messages import LONGEST_LEASE_S
from understudy.runtime.agents.team_plan import TeamPlan
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import list_readings, make_scenario_kit
from understudy.sim.scenario.schema import RobotGroup, Scenario
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.team.libraries import Libraries, collect_libraries, load_type_libraries
from understudy.storage.document import fingerprint_automaton
from understudy.storage.library_folder import open_library

FEW, DEPUTIES = 4, 2
"""The largest size of a squad all of whose members may lead it, and the number that may in a larger one, by default.

Each of them hears the reports of all members, so that traffic grows with their number.
"""
RESERVED = "/*?#$"
"""The signs that names must not have, because they are parts of keys."""
LONGEST_TICK_S = SILENT_S / 2
"""The longest tick, s: with a longer one, a leader that works would be taken for silent."""
LEASE_TICKS = 3
"""The number of ticks for which an order holds at least, so that a lost message ends none."""


def choose_deputies(members: Sequence[str]) -> Sequence[str]:
    """Choose the agents that may lead a squad besides its own: all members of a small one, or the first ones."""
    return members if len(members) <= FEW else members[:DEPUTIES]


@dataclass(frozen=True)
class LoadedTeam:
    """A team as one agent has loaded it.

    Attributes
    ----------
    name
        The name of the team.
    settings
        How its agents run.
    scenario
        The scenario with the team's robots.
    robots
        The robot file of each robot and where it is, by the robot's name.
    library
        The folder of the automata.
    libraries
        The library of each sort.
    fingerprints
        The fingerprint of each sort's library.
    plan
        The team.
    """

    name: str
    settings: TeamSettings
    scenario: Scenario
    robots: Mapping[str, tuple[RobotFile, Path]]
    library: Path
    libraries: Libraries
    fingerprints: Mapping[str, str]
    plan: TeamPlan

    @property
    def agents(self) -> tuple[str, ...]:
        """The names of all agents: robots, then squads bottom-up."""
        return (*self.plan.robots, *self.plan.squads)

    def make_network_options(self, agent: str | None = None) -> ZenohOptions:
        """Return how an agent reaches the others; without an agent, how a visitor does, which listens at no address."""
        return make_network_options(self.settings, agent)


def make_network_options(settings: TeamSettings, agent: str | None = None) -> ZenohOptions:
    """Return how an agent reaches the others; without an agent, how a visitor does, which listens at no address."""
    network = settings.network
    own = None if agent is None else settings.each.get(agent)
    listen = () if agent is None else network.listen
    return ZenohOptions(
        connect=network.connect if own is None else (*network.connect, *own.connect),
        listen=listen if own is None or not own.listen else own.listen,
        multicast=network.multicast,
        config=network.config if own is None else {**network.config, **own.config},
    )


def load_team_names(path: Path | str) -> tuple[TeamFile, tuple[str, ...]]:
    """Load a team's file and the names of its robots only, so that they can be stopped even if other parts are invalid.

    A robot whose file is invalid has the name of the file.
    """
    team, paths = load_team(path)
    names = []
    for each in paths:
        try:
            names.append(load_robot(each).name)
        except FileError:
            names.append(each.stem)
    return team, tuple(names)


def load_team_plan(
    path: Path | str, *, agent: str | None = None, library: Path | str | None = None
) -> LoadedTeam:
    """Load a team's file with its robot files and its library.

    Parameters
    ----------
    path
        The team's file.
    agent
        The agent for which it is loaded; its library may be elsewhere.
    library
        The folder of the automata. None: as the file says.

    Returns
    -------
    LoadedTeam
        The team.

    Raises
    ------
    FileError
        If a file is missing or invalid, or the team's file contradicts itself.
    """
    team, paths = load_team(path)
    settings = team.agents
    files = [load_robot(each) for each in paths]
    check_robot_worlds(path, team, files)
    robots = {file.name: (file, where) for file, where in zip(files, paths, strict=True)}
    scenario = _cast(path, files, paths)
    own = None if agent is None else settings.each.get(agent)
    named = settings.library if own is None or own.library is None else own.library
    folder = Path(path).parent / named if library is None else Path(library)
    if agent is not None:
        LibraryFolder(folder, agent, partial(fingerprint_folder, scenario)).recover()
    if library is not None and not folder.is_dir():
        raise FileError(path=folder, place="", problem="there is no such folder", remedy="give a library")
    libraries = open_libraries(scenario, folder)
    fingerprints = {sort: fingerprint_library(each) for sort, each in libraries.items()}
    plan = _make_plan(path, settings, scenario, tuple(robots), libraries, fingerprints)
    check_agents(path, team, plan.robots, plan.squads)
    return LoadedTeam(team.name, settings, scenario, robots, folder, libraries, fingerprints, plan)


def _cast(path: Path | str, files: Sequence[RobotFile], paths: Sequence[Path]) -> Scenario:
    """Return the scenario of the robot files, with the team's robots."""
    worlds = {file.world for file in files}
    world = files[0].world
    if world is None or len(worlds) > 1:
        raise _wrong(
            path, "robots", "are not all of one scenario", "name the same `world` in each robot's file"
        )
    beside = paths[0].parent / world
    scenario = find_scenario(beside if beside.is_file() else world)
    groups = tuple(RobotGroup(type=file.kind or next(iter(scenario.types))) for file in files)
    skilled = add_robot_skills(scenario, files)
    return msgspec.structs.replace(skilled, tick_s=files[0].tick_s, robots=groups, walls=(), obstacles=())


def open_libraries(scenario: Scenario, folder: Path | str) -> Libraries:
    """Open the library of each sort of agents in a folder; one that is missing is empty."""
    folder = Path(folder)

    def look(where: Path, kit: object) -> Library:
        return open_library(where, kit).library if where.is_dir() else Library(kit)  # type: ignore[arg-type]

    robots = load_type_libraries(scenario, folder, make_scenario_kit(scenario), look)
    return collect_libraries(scenario, robots, lambda name, kit: look(folder / name, kit))


def fingerprint_folder(scenario: Scenario, folder: Path | str) -> str:
    """Open all libraries of a folder, and compute one fingerprint of them."""
    libraries = open_libraries(scenario, folder)
    return " ".join(f"{sort}:{fingerprint_library(each)}" for sort, each in sorted(libraries.items()))


def fingerprint_library(library: Library) -> str:
    """Compute the fingerprint of all automata of a library."""
    each = {name: fingerprint_automaton(taught) for name, taught in library.taught.items()}
    return blake2b(repr(sorted(each.items())).encode(), digest_size=8).hexdigest()


def _make_plan(
    path: Path | str,
    settings: TeamSettings,
    scenario: Scenario,
    robots: tuple[str, ...],
    libraries: Libraries,
    fingerprints: Mapping[str, str],
) -> TeamPlan:
    tree = assign_team_members(scenario)
    for sort in settings.runs:
        if sort not in tree.names:
            remedy = f"name one of {join_names(tree.names)}"
            raise _wrong(path, f"agents.runs.{sort}", "is no sort of agents of this team", remedy)
    roots = {sort: (behavior, settings.bind.get(sort, {})) for sort, behavior in settings.runs.items()}
    try:
        plan = TeamPlan(
            tree,
            libraries,
            roots,
            readings=dict.fromkeys(tree.types, list_readings(scenario)),
            targets=tuple(scenario.targets),
            robots=robots,
            deputies=choose_deputies if settings.deputies is None else settings.deputies,
            fingerprints=fingerprints,
            requires_same_library=settings.same_library,
            lease_s=settings.lease_s,
            trainer=settings.trainer,
        )
    except UnderstudyError as error:
        error.add_note(f"{path} asks for it")
        raise
    for squad, deputies in (settings.deputies or {}).items():
        if squad not in plan.squads:
            remedy = f"name one of {join_names(plan.squads)}"
            raise _wrong(path, f"agents.deputies.{squad}", "is no squad of this team", remedy)
        for name in deputies:
            if name not in (*plan.robots, *plan.squads):
                remedy = f"name some of {join_names((*plan.robots, *plan.squads))}"
                raise _wrong(path, f"agents.deputies.{squad}", f"names {name!r}, which is no agent", remedy)
    return plan


def _wrong(path: Path | str, place: str, problem: str, remedy: str) -> FileError:
    return FileError(path=path, place=place, problem=problem, remedy=remedy)


def check_robot_worlds(path: Path | str, team: TeamFile, files: Sequence[RobotFile]) -> None:
    """Refuse a team whose robots cannot be agents of one team.

    Parameters
    ----------
    path
        The team's file.
    team
        Its content.
    files
        The content of the robots' files.

    Raises
    ------
    FileError
        If names, ticks, the lease or the topics of commands do not fit.
    """
    _refuse(path, _find_wrong_robots(team, files))


def check_agents(path: Path | str, team: TeamFile, robots: Sequence[str], squads: Sequence[str]) -> None:
    """Refuse settings of agents that the team does not have.

    Parameters
    ----------
    path
        The team's file.
    team
        Its content.
    robots
        The names of the robots.
    squads
        The names of the squads.

    Raises
    ------
    FileError
        If a robot has the name of a squad, or settings are of no agent or sort.
    """
    _refuse(path, _find_wrong_agents(team, robots, squads))


def _refuse(path: Path | str, wrong: Iterator[tuple[str, str, str]]) -> None:
    for place, problem, remedy in wrong:
        raise FileError(path=path, place=place, problem=problem, remedy=remedy)


def _find_wrong_robots(team: TeamFile, files: Sequence[RobotFile]) -> Iterator[tuple[str, str, str]]:
    for place, name in [("name", team.name), *(("robots", file.name) for file in files)]:
        if not name or not set(name).isdisjoint(RESERVED):
            yield place, f"has the name {name!r:.60}", f"give a name without {' '.join(RESERVED)}"
    names = [file.name for file in files]
    for name in names:
        if names.count(name) > 1:
            yield "robots", f"has two robots of the name {name!r}", "rename one of them"
    first = files[0]
    taken: dict[str, str] = {}
    for file in files:
        if file.tick_s != first.tick_s:
            problem = f"differ in tick_s: {first.name} has {first.tick_s:g}, {file.name} {file.tick_s:g}"
            yield "robots", problem, "give all the same"
        topic = f"{file.domain}:{file.topic(file.commands.topic)}"
        if topic in taken:
            problem = f"has {taken[topic]} and {file.name}, which would get the same commands"
            yield "robots", problem, "give each its own namespace or domain"
        taken[topic] = file.name
    if first.tick_s > LONGEST_TICK_S:
        yield "robots", f"have a tick_s of {first.tick_s:g}", f"give agents at most {LONGEST_TICK_S:g}"
    shortest = LEASE_TICKS * first.tick_s
    if not shortest <= team.agents.lease_s <= LONGEST_LEASE_S:
        remedy = f"give from {shortest:g} (three ticks) to {LONGEST_LEASE_S:g}"
        yield "agents.lease_s", f"is {team.agents.lease_s:g}", remedy


def _find_wrong_agents(
    team: TeamFile, robots: Sequence[str], squads: Sequence[str]
) -> Iterator[tuple[str, str, str]]:
    settings = team.agents
    trainer = settings.trainer
    if trainer is not None and (not trainer or not set(trainer).isdisjoint(RESERVED)):
        yield "agents.trainer", f"is {trainer!r:.60}", f"give a name without {' '.join(RESERVED)}"
    if trainer in (*robots, *squads):
        yield "agents.trainer", f"is {trainer!r:.60}, which is that of an agent", "give another name"
    for name in robots:
        if name in squads:
            yield "robots", f"has a robot of the name {name!r}, which is that of a squad", "rename the robot"
    for name in settings.each:
        if name not in (*robots, *squads):
            yield (
                f"agents.each.{name}",
                "is no agent of this team",
                f"name one of {join_names([*robots, *squads])}",
            )
    for sort in settings.bind:
        if sort not in settings.runs:
            yield f"agents.bind.{sort}", "is of a sort that runs nothing", "name it in agents.runs, too"
