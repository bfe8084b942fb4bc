"""Libraries opened file by file, and their automata as plain data; without a world, this imports little."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import typer

from understudy.errors import SettingError, UnknownName, join_names
from understudy.model.automaton import Automaton
from understudy.model.describe import convert_to_plain, describe_options, describe_transitions
from understudy.model.features import BoundFeature
from understudy.model.lesson import Example
from understudy.model.library import Kit, Library
from understudy.storage.document import Learn, LoadedDocument
from understudy.storage.json_text import select_facts
from understudy.storage.library_folder import (
    VERSIONS,
    LoadedLibrary,
    list_versions,
    make_file_stem,
    open_each_automaton,
)
from understudy.ui.cli.loading import import_on_call
from understudy.ui.cli.options import WORLD, LibraryOptions

open_named_libraries = import_on_call("understudy.ui.cli.world_libraries:open_named_libraries")
find_kit = import_on_call("understudy.ui.cli.named_inputs:find_kit")
"""Imported only if a world or a kit is named."""


def open_listings(options: LibraryOptions, learn: Learn) -> dict[str, LoadedLibrary]:
    """Open the libraries in a folder file by file, and return them by prefix, as `open_documents` does.

    If a world or a kit is named, it defines the features, and the folders are those that `understudy run` reads there;
    what is of another kit is reported on stderr.
    """
    if options.world is None and options.kit is None:
        return open_documents(options.library, None, learn)
    found: dict[str, LoadedLibrary] = open_named_libraries(options, learn)
    report_left_out(found)
    return found


def open_documents(folder: Path, kit: Kit | None, learn: Learn) -> dict[str, LoadedLibrary]:
    """Open the libraries in a folder file by file, and return them by prefix.

    The library of the folder itself has the prefix '', those of squads and robot types have 'SORT/'; they are all
    folders that contain an automaton. Without a kit, features are defined by the documents.
    """
    found = {"": open_each_automaton(folder, kit, learn)}
    for place in list_sort_folders(folder):
        found[f"{place.name}/"] = open_each_automaton(place, None, learn)
    return found


def report_left_out(listings: Mapping[str, LoadedLibrary]) -> None:
    """Report on stderr which automata were left out because they are of another kit, and why."""
    for prefix, listing in listings.items():
        for name, reason in listing.library.left_out.items():
            typer.echo(f"Note: {prefix}{name} is of another kit, and is left out: {reason}", err=True)


def find_optional_kit(named: str | None, world: str | None) -> Kit | None:
    """Return the kit if a kit or a world is named; otherwise None, and the documents define the features."""
    if named is None and world is None:
        return None
    found: Kit = find_kit(named, world or WORLD)
    return found


def list_sort_folders(folder: Path) -> list[Path]:
    """Return the subfolders of a library that contain automata (of squads and robot types), ordered by name."""

    def holds_automata(place: Path) -> bool:
        return place.is_dir() and bool(open_each_automaton(place, None, lambda _: {}).opened)

    return [place for place in sorted(folder.iterdir()) if place.name != VERSIONS and holds_automata(place)]


def find_listed(listings: Mapping[str, LoadedLibrary], name: str) -> tuple[str, str]:
    """Find an automaton or unopened file named NAME or SORT/NAME; return its library's prefix and its own name.

    Raises UnknownName if there is none, and SettingError if several sorts of agents have one of this name.
    """
    known = [
        (prefix, each)
        for prefix, listing in listings.items()
        for each in (*listing.opened, *(file.removesuffix(".json") for file in listing.problems))
    ]
    exact = [(prefix, each) for prefix, each in known if f"{prefix}{each}" == name]
    found = exact or [(prefix, each) for prefix, each in known if each == name]
    labels = [f"{prefix}{each}" for prefix, each in found or known]
    if not found:
        raise UnknownName(what="automaton", name=name, where="the library", known=labels)
    if len(found) > 1:
        problem, remedy = "belongs to several sorts of agents", f"name it as {join_names(labels)}"
        raise SettingError(where="library", setting=repr(name), problem=problem, remedy=remedy)
    return found[0]


def find_automaton(listings: Mapping[str, LoadedLibrary], name: str) -> tuple[LoadedLibrary, str]:
    """Find an automaton named NAME or SORT/NAME; return its library and its own name.

    Raises the error of its file if it cannot be opened, and the errors of `find_listed`.
    """
    prefix, name = find_listed(listings, name)
    if name not in listings[prefix].opened:
        raise listings[prefix].problems[f"{name}.json"]
    return listings[prefix], name


def summarize_automaton(folder: Path, library: Library, opened: LoadedDocument) -> dict[str, Any]:
    """Summarize an automaton of the library in `folder`, mostly by counts: one row of `understudy list`.

    `examples` counts the examples from presses, and `watched` those from silence. `rebuilt` is the reason why the
    transition functions were learned again on loading; None if they were not.
    """
    automaton, lesson = opened.taught.automaton, opened.taught.lesson
    examples = () if lesson is None else lesson.examples
    watched = sum(not each.is_from_press for each in examples)
    return {
        "name": automaton.name,
        "parameters": automaton.parameters,
        "states": len(automaton.states),
        "features": len(automaton.features),
        "examples": len(examples) - watched,
        "watched": watched,
        "uses": list_used_automata(automaton, library),
        "used_by": library.find_users(automaton.name),
        "versions": len(list_versions(folder, automaton.name)),
        "saved": _find_saved_time(folder, automaton),
        "rebuilt": opened.rebuilt,
    }


def _find_saved_time(folder: Path, automaton: Automaton) -> datetime:
    path = folder / f"{make_file_stem(automaton.name)}.json"
    return datetime.fromtimestamp(path.stat().st_mtime, UTC)


def list_used_automata(automaton: Automaton, library: Library) -> list[str]:
    """Return the names of the library's automata that the states of this one run."""
    runs = dict.fromkeys(state.behavior or "" for state in automaton.states)
    return [name for name in runs if name in library.taught]


def describe_automaton(folder: Path, library: Library, opened: LoadedDocument) -> dict[str, Any]:
    """Describe an automaton of the library in `folder`: everything that its summary counts, listed."""
    automaton, lesson = opened.taught.automaton, opened.taught.lesson
    examples = () if lesson is None else lesson.examples
    return summarize_automaton(folder, library, opened) | {
        "states": automaton.states,
        "features": [
            {"name": str(each), "kind": str(each.kind), "unit": each.feature.unit, "own": each.is_own}
            for each in automaton.features
        ],
        "examples": [_describe_example(each, automaton) for each in examples],
        "versions": list_versions(folder, automaton.name),
        "stateless": automaton.stateless,
        "conditions": describe_transitions(automaton, lesson),
        "options": None if lesson is None else describe_options(lesson),
    }


def _describe_example(example: Example, automaton: Automaton) -> dict[str, Any]:
    names = ("number", "state", "next", "kind", "correction", "edited", "quarantined", "values", "source")
    values = list_plain_values(example, automaton)
    return select_facts(example, *names, values={str(bound): value for bound, value in values})


def list_plain_values(
    example: Example, automaton: Automaton
) -> list[tuple[BoundFeature, float | str | None]]:
    """List the values of an example with their features: labels of categorical ones, None where absent."""
    values = zip(automaton.features, example.values, strict=True)
    return [(bound, convert_to_plain(value, bound)) for bound, value in values]
