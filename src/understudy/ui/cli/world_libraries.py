"""Libraries opened for a scenario, and the scenario that fits a library."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from understudy.errors import DefinitionError, SettingError, UnderstudyError, UnknownName, join_names
from understudy.model.library import Kit, Library
from understudy.runtime.link import link
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.files import list_builtin_scenarios
from understudy.sim.team.libraries import collect_libraries, load_type_libraries
from understudy.storage.library_folder import (
    LoadedLibrary,
    find_recorded_kits,
    list_documents,
    open_each_automaton,
)
from understudy.ui.cli.library_data import list_sort_folders, open_documents
from understudy.ui.cli.named_inputs import find_kit, find_optional_scenario
from understudy.ui.cli.options import WORLD, LibraryOptions

if TYPE_CHECKING:
    from understudy.sim.scenario.schema import Scenario
    from understudy.storage.document import Learn


def open_named_libraries(options: LibraryOptions, learn: Learn) -> dict[str, LoadedLibrary]:
    """Open the libraries in a folder with the world or the kit that options name."""
    kit = find_kit(options.kit, options.world or WORLD)
    return open_all_libraries(options.library, find_optional_scenario(options.world), kit, learn)


def open_all_libraries(
    folder: Path, scenario: Scenario | None, kit: Kit, learn: Learn
) -> dict[str, LoadedLibrary]:
    """Open the libraries in a folder file by file, and return them by prefix, as `open_documents` does.

    With a scenario, the folders are those that `understudy run` reads, each with the kit of its sort of agents.
    """
    if scenario is None:
        return open_documents(folder, kit, learn)
    found: dict[str, LoadedLibrary] = {}

    def look(place: Path, kit: Kit) -> Library:
        prefix = "" if place == folder else f"{place.name}/"
        if prefix not in found:
            there = not prefix or place.is_dir()
            empty = LoadedLibrary(place, Library(kit), {}, {})
            found[prefix] = open_each_automaton(place, kit, learn) if there else empty
        return found[prefix].library

    look(folder, kit)
    robots = load_type_libraries(scenario, folder, kit, look)
    collect_libraries(scenario, robots, lambda name, kit: look(folder / name, kit))
    return {prefix: each for prefix, each in found.items() if each.opened or each.problems or not prefix}


def find_problems(
    folder: Path, listings: Mapping[str, LoadedLibrary], scenario: Scenario
) -> dict[str, UnderstudyError]:
    """Return, by [SORT/]NAME, why automata cannot be opened or cannot run in a scenario.

    `listings` are the libraries of the folder as opened for this scenario.
    """
    found: dict[str, UnderstudyError] = {}
    for prefix, listing in listings.items():
        found |= {f"{prefix}{file.removesuffix('.json')}": why for file, why in listing.problems.items()}
        for name in listing.opened:
            if (why := _find_unresolved_name(listing.library, name)) is not None:
                found[f"{prefix}{name}"] = why
    looked = {listing.folder for listing in listings.values()}
    sorts = (*scenario.types, *scenario.squads)
    for place in list_sort_folders(folder):
        if place not in looked:
            where = f"scenario {scenario.name!r}"
            unknown = UnknownName(what="squad or type of robots", name=place.name, where=where, known=sorts)
            found |= {f"{place.name}/{path.stem}": unknown for path in list_documents(place)}
    return found


def find_misfits(folder: Path, scenario: Scenario) -> dict[str, UnderstudyError]:
    """Return, by [SORT/]NAME, why automata in a folder cannot be used in a scenario.

    If the folder as a whole does not fit, the only key is the folder's name.
    """
    try:  # names need no transition functions
        listings = open_all_libraries(folder, scenario, make_scenario_kit(scenario), lambda _: {})
    except UnderstudyError as error:  # squads whose members know different things by one name
        return {str(folder): error}
    return find_problems(folder, listings, scenario)


def choose_library_world(
    folder: Path, world: str | None, kit: str | None, name: str | None = None
) -> str | None:
    """Choose the world that a library is opened for, or None if it needs none.

    That is the named one; none if a kit is named, or if the lessons of its recordings say all that its automata use;
    or else the first built-in scenario that fits, or that fits the automaton of a name.
    """
    if world is not None or kit is not None or _needs_recordings_only(folder):
        return world
    return find_fitting_world(folder, name)


def _needs_recordings_only(folder: Path) -> bool:
    """Return whether all automata of a folder can run with what the lessons of their recordings have."""
    if not find_recorded_kits(folder) or list_sort_folders(folder):
        return False
    listing = open_each_automaton(folder, Kit.from_parts(), lambda _: {})
    return not listing.problems and all(
        _find_unresolved_name(listing.library, name) is None for name in listing.opened
    )


def find_fitting_world(folder: Path, name: str | None = None) -> str:
    """Return the first built-in scenario whose kit has every name that the automata of a folder use.

    If there is none, that is the first that has those of the automaton of a name, or else that of most automata; it is
    reported on stderr. Raises the error of a file that is broken in any scenario; otherwise SettingError with the
    scenarios tried.
    """
    if not list_documents(folder) and not list_sort_folders(folder):
        remedy = "name a folder with automata, or the scenario they were taught in"
        raise SettingError(
            where=str(folder), setting="--world", problem="cannot be determined", remedy=remedy
        )
    for error in find_broken_documents(folder).values():
        raise error
    tried: dict[str, dict[str, UnderstudyError]] = {}
    for world in dict.fromkeys((WORLD, *list_builtin_scenarios())):
        tried[world] = find_misfits(folder, find_scenario(world))
        if not tried[world]:
            return world
    nearest = min(tried, key=lambda world: (_misses(tried[world], name), len(tried[world])))
    total = sum(len(each.opened) for each in open_documents(folder, None, lambda _: {}).values())
    fitting = total - len(tried[nearest])
    if str(folder) not in tried[nearest] and (
        2 * fitting > total if name is None else not _misses(tried[nearest], name)
    ):
        typer.echo(
            f"Note: the world is {nearest}, which fits {fitting} of {total} automata of {folder}.", err=True
        )
        return nearest
    wrong = next(iter(tried[nearest].values()))
    raise SettingError(
        where=str(folder),
        setting="--world",
        problem=f"cannot be determined: none of the scenarios {join_names(tried)} has everything that its automata use "
        f"(the best match is {nearest}: {wrong})",
        remedy="give the scenario, such as --world my-scenario.toml",
    )


def _misses(misfits: Mapping[str, UnderstudyError], name: str | None) -> bool:
    """Return whether an automaton named NAME or SORT/NAME is among those that do not fit; of no name, False."""
    return name is not None and any(name in (label, label.rpartition("/")[2]) for label in misfits)


def find_broken_documents(folder: Path) -> dict[str, UnderstudyError]:
    """Return, by [SORT/]NAME, the errors of documents that cannot be opened with any kit."""
    return {
        f"{prefix}{file.removesuffix('.json')}": error
        for prefix, listing in open_documents(folder, None, lambda _: {}).items()
        for file, error in listing.problems.items()
    }


def _find_unresolved_name(library: Library, name: str) -> UnderstudyError | None:
    """Return why an automaton could not run (unknown name, unbound parameter), or None if it could."""
    targets = list(library.kit.targets)
    parameters = library.automaton(name).parameters
    if parameters and not targets:
        problem = f"the kit has no target to bind to its parameters ({', '.join(parameters)})"
        return DefinitionError(what=f"automaton {name!r}", problem=problem, remedy="add a target to the kit")
    try:
        link(library, name, dict.fromkeys(parameters, targets[0]) if parameters else {})
    except UnderstudyError as error:
        return error
    return None
