"""Describe automata of a library as plain data, for tables and for `--json`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from understudy.errors import UnderstudyError
from understudy.model.automaton import Automaton
from understudy.model.describe import (
    convert_to_plain,
    describe_options,
    describe_transitions,
    list_shown_vectors,
)
from understudy.model.lesson import Example
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.model.tree import STAY, Tree
from understudy.model.tree_text import describe_tree_outcomes as tree_conditions
from understudy.storage.document import Learn, LoadedDocument
from understudy.storage.library_folder import (
    add_automaton,
    list_documents,
    list_versions,
    make_file_stem,
    open_document,
)

if TYPE_CHECKING:
    from understudy.model.library import Kit, Library, TrainedAutomaton
    from understudy.sim.scenario.schema import Scenario
    from understudy.sim.team.libraries import Libraries


@dataclass(frozen=True)
class LibraryListing:
    """A library's folder looked at file by file: what opened, and what is wrong with what did not."""

    folder: Path
    library: Library
    opened: dict[str, LoadedDocument]
    problems: dict[str, UnderstudyError]


def open_each_automaton(folder: Path, kit: Kit | None, learn: Learn | None) -> LibraryListing:
    """Open each file of a library on its own, so that one bad file does not hide the others.

    Without a kit features are as the documents say, so that any library can be looked at.
    """
    library = Library(Kit.from_parts() if kit is None else kit)
    opened: dict[str, LoadedDocument] = {}
    problems: dict[str, UnderstudyError] = {}
    for path in list_documents(folder):
        try:
            found = open_document(path, kit, learn)
            library = add_automaton(library, found.taught, path)
            opened[found.taught.automaton.name] = found
        except UnderstudyError as error:
            problems[path.name] = error
    return LibraryListing(folder, library, opened, problems)


def list_conditions_by_switch(taught: TrainedAutomaton) -> dict[tuple[str, str], list[str]]:
    """By state and next state, in words, when: for a picture."""
    automaton, names = taught.automaton, taught.automaton.state_names
    return {
        (state, names[outcome]): list(texts)
        for state, function in automaton.transitions.items()
        if isinstance(function, Tree)
        for outcome, texts in tree_conditions(
            function, automaton.features, list_shown_vectors(taught.lesson, state)
        ).items()
        if outcome != STAY and names[outcome] != state
    }


def summarize_automaton(folder: Path, library: Library, opened: LoadedDocument) -> dict[str, Any]:
    """One automaton in a line."""
    automaton, lesson = opened.taught.automaton, opened.taught.lesson
    path = folder / f"{make_file_stem(automaton.name)}.json"
    return {
        "name": automaton.name,
        "parameters": automaton.parameters,
        "states": len(automaton.states),
        "features": len(automaton.features),
        "examples": 0 if lesson is None else sum(example.is_from_press for example in lesson.examples),
        "watched": 0 if lesson is None else sum(not example.is_from_press for example in lesson.examples),
        "uses": list_used_automata(automaton, library),
        "used_by": library.find_users(automaton.name),
        "versions": len(list_versions(folder, automaton.name)),
        "saved": datetime.fromtimestamp(path.stat().st_mtime, UTC),
        "rebuilt": opened.rebuilt,
    }


def list_used_automata(automaton: Automaton, library: Library) -> list[str]:
    """The automata that its states run."""
    runs = dict.fromkeys(state.behavior or "" for state in automaton.states)
    return [name for name in runs if name in library.taught]


def describe_automaton(folder: Path, library: Library, opened: LoadedDocument) -> dict[str, Any]:
    """Everything about one automaton."""
    automaton, lesson = opened.taught.automaton, opened.taught.lesson
    return {
        **summarize_automaton(folder, library, opened),
        "states": automaton.states,
        "features": [
            {"name": str(bound), "kind": str(bound.kind), "unit": bound.feature.unit, "own": bound.is_own}
            for bound in automaton.features
        ],
        "stateless": automaton.stateless,
        "conditions": describe_transitions(automaton, lesson),
        "options": None if lesson is None else describe_options(lesson),
        "examples": [] if lesson is None else [make_example_row(each, automaton) for each in lesson.examples],
        "versions": [
            {"number": version.number, "saved": version.saved, "file": version.path}
            for version in list_versions(folder, automaton.name)
        ],
    }


def make_example_row(example: Example, automaton: Automaton) -> dict[str, Any]:
    """One example; categorical values as labels, absent ones null."""
    values = zip(automaton.features, example.values, strict=True)
    return {
        "number": example.number,
        "state": example.state,
        "next": example.next,
        "kind": example.kind.value,
        "correction": example.correction,
        "edited": example.edited,
        "quarantined": example.quarantined,
        "values": {str(bound): convert_to_plain(value, bound) for bound, value in values},
    }


ALONE = "robot"
"""What the sort of a robot without a scenario is called."""


def load_current_libraries(where: Scenario | None, behavior: str | None, folder: Path, kit: Kit) -> Libraries:
    """What everybody of a scenario knows now, or a robot without one."""
    from understudy.ui.cli.options import open_behavior_library, open_team_libraries

    if where is None:
        return {ALONE: open_behavior_library(behavior, folder, kit)}
    return open_team_libraries(where, behavior, folder, kit)


def load_recorded_libraries(
    where: Scenario | None,
    behavior: str | None,
    folder: Path,
    kit: Kit,
    automata: Mapping[str, Mapping[str, str]],
) -> tuple[Libraries, dict[str, int]]:
    """What everybody knew when the run was made, by the fingerprints of its automata, and the number of the former
    version of each automaton that is another by now; CannotRepeat where one is gone.
    """
    from understudy.sim.team.libraries import find_type_folders

    known = dict(load_current_libraries(where, behavior, folder, kit))
    places = {} if where is None else find_type_folders(where, folder, kit)
    former: dict[str, int] = {}
    for sort, marks in automata.items():
        place = folder if where is None else places[sort][0] if sort in places else folder / sort
        for name, mark in marks.items():
            library, version = _as_it_was(known[sort], place, name, mark)
            if version is not None:
                known = {each: library if it is known[sort] else it for each, it in known.items()}
                former[name] = version
    return known, former


def _as_it_was(library: Library, place: Path, name: str, mark: str) -> tuple[Library, int | None]:
    """The library with an automaton as its mark says, and which former version that is; None where it still is so."""
    from understudy.analysis.explain_run import RunNotReproducible
    from understudy.errors import UnderstudyError
    from understudy.storage.document import fingerprint_automaton
    from understudy.storage.library_folder import list_versions, load_version
    from understudy.ui.cli.options import import_learner

    now = library.taught.get(name)
    if now is not None and fingerprint_automaton(now) == mark:
        return library, None
    for version in reversed(list_versions(place, name)):
        try:
            taught: TrainedAutomaton = load_version(
                place, name, version.number, library.kit, import_learner()
            ).taught
        except UnderstudyError:
            continue  # of another kit, or damaged: it is none of what was run, as far as anybody can tell
        if fingerprint_automaton(taught) == mark:
            return library.with_automaton(taught), version.number
    problem = f"{name} in {place} {'is another by now' if now else 'is gone'}, and no former version is what was run"
    raise RunNotReproducible(problem=problem, remedy="run it again with --trace, and ask that")
