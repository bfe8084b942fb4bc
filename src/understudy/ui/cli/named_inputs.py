"""Functions that open what options name: worlds, kits, libraries, and the behavior to run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import typer

from understudy.addons.bridges.environments.body_maker import BodyMaker, find_world
from understudy.entry_points import KITS, load_instance
from understudy.errors import SettingError, UnknownName, join_names
from understudy.learning.fit import learn
from understudy.model.automaton import Automaton
from understudy.model.library import Kit, Library, list_missing_parts
from understudy.runtime.link import link
from understudy.sim.kit import list_readings, make_scenario_kit
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import (
    Libraries,
    collect_libraries,
    find_behavior_sort,
    list_running_sorts,
    load_type_libraries,
)
from understudy.storage.library_folder import LoadedLibrary, open_library
from understudy.ui.cli.library_data import report_left_out
from understudy.ui.cli.options import parse_bindings

KIT_REMEDY = "name a Kit as MODULE:NAME, such as mylab.robots:kit, that Python finds from this folder"
MAIN = "forage"
ALONE = "robot"
"""Name of the sort of robots that have no scenario."""


def find_optional_scenario(name: str | None) -> Scenario | None:
    """Return the scenario of this name; None if there is no name, or if it is a function that makes a body."""
    found = None if name is None else find_world(name)
    return found if isinstance(found, Scenario) else None


def find_kit(named: str | None, world: str | None) -> Kit:
    """Return the kit named as MODULE:NAME or by its entry point, or that of the world if `named` is None.

    Without a world, the kit is empty: what lessons of recordings need is added when their library is opened.
    """
    if named is not None:
        return load_kit(named)
    return Kit.from_parts() if world is None else make_world_kit(find_world(world))


def choose_kit(named: str | None, world: Scenario | BodyMaker) -> Kit:
    """Return the kit named as MODULE:NAME or by its entry point, or that of an opened world if `named` is None."""
    return make_world_kit(world) if named is None else load_kit(named)


def load_kit(named: str) -> Kit:
    """Load the kit named as MODULE:NAME or by its entry point."""
    return load_instance(named, KITS, Kit, where="--kit", remedy=KIT_REMEDY)


def make_world_kit(world: Scenario | BodyMaker) -> Kit:
    """Return the kit of a scenario, or that of the body that a function makes; SettingError if the body has none."""
    return make_scenario_kit(world) if isinstance(world, Scenario) else world.find_kit()


def open_library_with_notes(library: Path, kit: Kit) -> LoadedLibrary:
    """Open a library; report on stderr what was left out, and which transition functions were learned again."""
    found = open_library(library, kit, learn)
    report_left_out({"": found})
    for name, reason in found.rebuilt.items():
        if "classifier" not in reason:
            typer.echo(f"Note: {name} was learned again from its examples: {reason}.", err=True)
    return found


def open_behavior_library(behavior: str | None, folder: Path, kit: Kit) -> Library:
    """Open the library in a folder; without the folder, return an empty one with the kit's basic behaviors.

    Raises UnknownName if there is no folder and `behavior` is not a basic one.
    """
    if folder.exists():
        return open_library_with_notes(folder, kit).library
    if behavior is not None and behavior not in kit.behaviors:
        where = f"there is no folder {folder} with automata, and the kit"
        raise UnknownName(what="behavior", name=behavior, where=where, known=list(kit.behaviors))
    return Library(kit)


def open_team_libraries(
    scenario: Scenario, behavior: str | None, folder: Path, kit: Kit
) -> Mapping[str, Library]:
    """Open the libraries of all sorts of agents in a scenario.

    Squads, and robot types that differ, have subfolders of their names in `folder`.
    """

    def look(where: Path, kit: Kit) -> Library:
        return open_library_with_notes(where, kit).library if where.is_dir() else Library(kit)

    if not folder.exists():
        open_behavior_library(behavior, folder, kit)
    robots = load_type_libraries(scenario, folder, kit, look)
    return collect_libraries(scenario, robots, lambda name, kit: look(folder / name, kit))


def choose_behavior(library: Library, named: str | None, folder: Path) -> str:
    """Return the behavior that was named, or else the only automaton that no other automaton uses.

    If there are several such automata, `forage` is chosen if it is among them. Otherwise SettingError lists them.
    """
    if named is not None:
        return named
    tops = [name for name in library.taught if not library.find_users(name)]
    if len(tops) == 1:
        return tops[0]
    if MAIN in tops:
        return MAIN
    automata = f"the automata of {folder} are {join_names(library.taught)}"
    if not folder.exists():
        automata = f"there is no folder {folder} with automata"
    raise SettingError(
        where="command line",
        setting="--behavior",
        problem="is missing",
        remedy=f"give --behavior NAME: {automata}, and the basic behaviors are {join_names(library.kit.behaviors)}",
    )


@dataclass(frozen=True, slots=True)
class RunAssignment:
    """Behavior to run, the sort of agents it belongs to, all libraries, and what each sort runs (`roots`)."""

    libraries: Libraries
    sort: str
    behavior: str
    binding: dict[str, str]
    roots: dict[str, tuple[str, dict[str, str]]]

    @property
    def flags(self) -> set[str]:
        """Names of the behavior's states that raise a flag and so end it."""
        root = self.libraries[self.sort].behavior(self.behavior)
        states = root.states if isinstance(root, Automaton) else ()
        return {state.name for state in states if state.flag is not None}


def assign_run(
    world: Scenario | BodyMaker,
    behavior: str | None,
    folder: Path,
    kit: Kit,
    bind: list[str] | None,
    *,
    bound_for_others: bool = False,
) -> RunAssignment:
    """Find the behavior that the options name and the agents that run it.

    With `bound_for_others`, bindings of parameters that it does not have are meant for another behavior. Mistakes are
    reported here, before anything is compiled or moves. Raises the errors of `open_team_libraries`, `choose_behavior`
    and `link`.
    """
    bound = parse_bindings(bind)
    if isinstance(world, Scenario):
        known = open_team_libraries(world, behavior, folder, kit)
    else:
        known = {ALONE: open_behavior_library(behavior, folder, kit)}
    sort = find_behavior_sort(known, behavior)
    found = choose_behavior(known[sort], behavior and behavior.removeprefix(f"{sort}/"), folder)
    if bound_for_others:
        parameters = known[sort].parameters(found)
        bound = {name: target for name, target in bound.items() if name in parameters}
    link(known[sort], found, bound)
    if isinstance(world, Scenario):
        _refuse_other_readings(known[sort], found, world)
    return RunAssignment(
        known, sort, found, bound, dict.fromkeys(list_running_sorts(known, sort, found), (found, bound))
    )


def _refuse_other_readings(library: Library, name: str, scenario: Scenario) -> None:
    """Refuse a world that lacks readings or targets that an automaton learned from a recording needs."""
    readings, targets = {each.name for each in list_readings(scenario)}, make_scenario_kit(scenario).targets
    missing = list_missing_parts(library.taught.get(name), readings, targets)
    if missing:
        raise SettingError(
            where="command line",
            setting="SCENARIO",
            problem=f"is {scenario.name!r}, whose robots have no {join_names(missing)}: {name!r} was learned from a "
            "recording or a table",
            remedy="name a world whose robots have them, or run it over a recording: understudy replay FILE",
        )
