"""Describe automata of a library as plain data, for tables and for `--json`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from understudy.errors import DefinitionError, SettingError, UnderstudyError, UnknownName, join_names
from understudy.model.automaton import Automaton, State
from understudy.model.describe import (
    convert_to_plain,
    describe_options,
    describe_transitions,
)
from understudy.model.example_source import ExampleSource
from understudy.model.lesson import Example
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.storage.document import Learn, LoadedDocument
from understudy.storage.library_folder import (
    VERSIONS,
    LoadedLibrary,
    SavedVersion,
    list_documents,
    list_versions,
    make_file_stem,
    open_each_automaton,
)

if TYPE_CHECKING:
    from understudy.model.library import Kit, Library, TrainedAutomaton
    from understudy.sim.scenario.schema import Scenario
    from understudy.sim.team.libraries import Libraries


def open_all_libraries(
    folder: Path, scenario: Scenario | None, kit: Kit | None, learn: Learn | None
) -> dict[str, LoadedLibrary]:
    """Open the libraries in a folder file by file, and return them by prefix.

    The library of the folder itself has the prefix '', those of squads and robot types have 'SORT/'. With a scenario,
    the folders are those that `understudy run` reads, each with the kit of its sort of agents. Without one, they are
    all folders that contain an automaton, and features are defined by the documents.
    """
    found: dict[str, LoadedLibrary] = {}

    def look(place: Path, kit: Kit | None) -> Library:
        prefix = "" if place == folder else f"{place.name}/"
        if prefix not in found:
            empty = LoadedLibrary(place, Library(Kit.from_parts() if kit is None else kit), {}, {})
            there = not prefix or place.is_dir()
            found[prefix] = open_each_automaton(place, kit, learn) if there else empty
        return found[prefix].library

    look(folder, kit)
    if scenario is None or kit is None:
        for place in list_sort_folders(folder):
            look(place, None)
        return found
    from understudy.sim.team.libraries import collect_libraries, load_type_libraries

    robots = load_type_libraries(scenario, folder, kit, look)
    collect_libraries(scenario, robots, lambda name, kit: look(folder / name, kit))
    return {prefix: each for prefix, each in found.items() if each.opened or each.problems or not prefix}


def list_sort_folders(folder: Path) -> list[Path]:
    """Return the subfolders of a library that contain automata (of squads and robot types), ordered by name."""

    def holds_automata(place: Path) -> bool:
        return place.is_dir() and bool(open_each_automaton(place, None, lambda _: {}).opened)

    return [place for place in sorted(folder.iterdir()) if place.name != VERSIONS and holds_automata(place)]


def find_listed(listings: Mapping[str, LoadedLibrary], name: str) -> tuple[str, str]:
    """Find an automaton or broken file named NAME or SORT/NAME; return its library's prefix and its own name.

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
    from understudy.sim.kit import make_scenario_kit

    try:  # names need no transition functions
        listings = open_all_libraries(folder, scenario, make_scenario_kit(scenario), lambda _: {})
    except UnderstudyError as error:  # squads whose members know different things by one name
        return {str(folder): error}
    return find_problems(folder, listings, scenario)


def find_fitting_world(folder: Path) -> str:
    """Return the first built-in scenario whose kit has every name that the automata of a folder use.

    Raises the error of a file that is broken in any scenario; otherwise SettingError with the scenarios tried.
    """
    from understudy.sim.catalog import find_scenario
    from understudy.sim.scenario.files import list_builtin_scenarios
    from understudy.ui.cli.options import WORLD

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
    nearest = min(tried, key=lambda world: len(tried[world]))
    wrong = next(iter(tried[nearest].values()))
    raise SettingError(
        where=str(folder),
        setting="--world",
        problem=f"cannot be determined: none of the scenarios {join_names(tried)} has everything that its automata use "
        f"(the best match is {nearest}: {wrong})",
        remedy="give the scenario, such as --world my-scenario.toml",
    )


def find_broken_documents(folder: Path) -> dict[str, UnderstudyError]:
    """Return, by [SORT/]NAME, the errors of documents that cannot be opened with any kit."""
    return {
        f"{prefix}{file.removesuffix('.json')}": error
        for prefix, listing in open_all_libraries(folder, None, None, lambda _: {}).items()
        for file, error in listing.problems.items()
    }


def _find_unresolved_name(library: Library, name: str) -> UnderstudyError | None:
    """Return why an automaton could not run (unknown name, unbound parameter), or None if it could."""
    from understudy.runtime.program import link

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


@dataclass(frozen=True, kw_only=True)
class AutomatonSummary:
    """Summary of one automaton, mostly counts: one row of `understudy list`."""

    name: str
    parameters: Sequence[str]
    states: int
    features: int
    examples: int
    """Number of examples from presses."""
    watched: int
    """Number of examples from silence."""
    uses: Sequence[str]
    used_by: Sequence[str]
    versions: int
    saved: datetime
    rebuilt: str | None
    """Reason why the transition functions were learned again on loading; None if they were not."""


@dataclass(frozen=True, slots=True)
class FeatureRow:
    """One feature of an automaton; `own` is True for counters and timers of the automaton itself."""

    name: str
    kind: str
    unit: str
    own: bool


@dataclass(frozen=True, kw_only=True)
class ExampleRow:
    """One example; categorical values are labels, absent values None."""

    number: int
    state: str
    next: str
    kind: str
    correction: bool
    edited: bool
    quarantined: str
    values: Mapping[str, float | str | None]
    source: ExampleSource | None
    """Place in a recording that it was made from; None for any other example."""


@dataclass(frozen=True, kw_only=True)
class AutomatonDescription:
    """Full description of one automaton: everything that its summary counts, listed."""

    name: str
    parameters: Sequence[str]
    states: Sequence[State]
    features: Sequence[FeatureRow]
    examples: Sequence[ExampleRow]
    watched: int
    uses: Sequence[str]
    used_by: Sequence[str]
    versions: Sequence[SavedVersion]
    saved: datetime
    rebuilt: str | None
    stateless: bool
    conditions: Mapping[str, Sequence[str]]
    options: Mapping[str, Any] | None


def summarize_automaton(folder: Path, library: Library, opened: LoadedDocument) -> AutomatonSummary:
    """Return the summary of one automaton of the library in `folder`."""
    automaton, lesson = opened.taught.automaton, opened.taught.lesson
    examples = () if lesson is None else lesson.examples
    watched = sum(not each.is_from_press for each in examples)
    return AutomatonSummary(
        name=automaton.name,
        parameters=automaton.parameters,
        states=len(automaton.states),
        features=len(automaton.features),
        examples=len(examples) - watched,
        watched=watched,
        uses=list_used_automata(automaton, library),
        used_by=library.find_users(automaton.name),
        versions=len(list_versions(folder, automaton.name)),
        saved=_find_saved_time(folder, automaton),
        rebuilt=opened.rebuilt,
    )


def _find_saved_time(folder: Path, automaton: Automaton) -> datetime:
    path = folder / f"{make_file_stem(automaton.name)}.json"
    return datetime.fromtimestamp(path.stat().st_mtime, UTC)


def list_used_automata(automaton: Automaton, library: Library) -> list[str]:
    """Return the names of the library's automata that the states of this one run."""
    runs = dict.fromkeys(state.behavior or "" for state in automaton.states)
    return [name for name in runs if name in library.taught]


def describe_automaton(folder: Path, library: Library, opened: LoadedDocument) -> AutomatonDescription:
    """Return the full description of one automaton of the library in `folder`."""
    automaton, lesson = opened.taught.automaton, opened.taught.lesson
    examples = () if lesson is None else lesson.examples
    return AutomatonDescription(
        name=automaton.name,
        parameters=automaton.parameters,
        states=automaton.states,
        features=[
            FeatureRow(str(bound), str(bound.kind), bound.feature.unit, bound.is_own)
            for bound in automaton.features
        ],
        examples=[make_example_row(each, automaton) for each in examples],
        watched=sum(not each.is_from_press for each in examples),
        uses=list_used_automata(automaton, library),
        used_by=library.find_users(automaton.name),
        versions=list_versions(folder, automaton.name),
        saved=_find_saved_time(folder, automaton),
        rebuilt=opened.rebuilt,
        stateless=automaton.stateless,
        conditions=describe_transitions(automaton, lesson),
        options=None if lesson is None else describe_options(lesson),
    )


def make_example_row(example: Example, automaton: Automaton) -> ExampleRow:
    """Convert one example to plain data, with categorical values as labels."""
    values = zip(automaton.features, example.values, strict=True)
    return ExampleRow(
        number=example.number,
        state=example.state,
        next=example.next,
        kind=example.kind.value,
        correction=example.correction,
        edited=example.edited,
        quarantined=example.quarantined,
        values={str(bound): convert_to_plain(value, bound) for bound, value in values},
        source=example.source,
    )


def load_current_libraries(where: Scenario | None, behavior: str | None, folder: Path, kit: Kit) -> Libraries:
    """Load the current library of every sort of agents in a scenario, or of a single robot without one."""
    from understudy.ui.cli.options import ALONE, open_behavior_library, open_team_libraries

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
    """Load the libraries of all sorts as they were when a run was made.

    `automata` holds the fingerprints of the run, by sort and name. Also returns the version number of each automaton
    that has changed since. Raises RunNotReproducible if no stored version has the fingerprint.
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
    """Return the library with the automaton of this fingerprint, and its version number (None: current)."""
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
