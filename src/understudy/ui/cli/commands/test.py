"""Command `understudy test`: test a library on its lessons and properties, and compare it with former versions."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from understudy.ui.cli.options import LIBRARY, WORLD, FoundWorld, Json, KitName

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rich.console import Console

    from understudy.analysis.lesson_replay import DecisionChange, ReplayedPress
    from understudy.falsification.failing_world import FailingWorld
    from understudy.model.library import Kit, Library, TrainedAutomaton
    from understudy.properties.lesson_tests import LessonTestResult
    from understudy.properties.library_properties import FittingLibraries
    from understudy.properties.run_property import PropertyResult
    from understudy.sim.scenario.schema import Scenario


def run_library_tests(
    folder: Annotated[
        Path | None,
        typer.Argument(
            metavar="[LIBRARY]",
            help="Folder of the library; library if left out.",
            show_default=False,
        ),
    ] = None,
    same: Annotated[
        Path | None,
        typer.Option("--library", "-l", help="Folder of the library, as an option.", show_default=False),
    ] = None,
    world: FoundWorld = None,
    failures: Annotated[
        Path | None,
        typer.Option(
            "--failures",
            metavar="FOLDER",
            help="Folder of failing worlds, all of which are run again.",
            show_default=False,
        ),
    ] = None,
    kit: KitName = None,
    as_json: Json = False,
) -> None:
    """Test a library: every recorded moment of its lessons, every property, and failing worlds.

    Each automaton is compared with its last former version. Properties are those stored in lessons, and those of the
    file properties.toml in the library's folder. Failing worlds are those that understudy falsify kept in a folder. The
    exit code is 1 if something that worked no longer does, or if a property fails, or if a failing world still does.

    [dim]understudy test demo/library[/]

    [dim]understudy test demo/library --failures failures[/]
    """
    from understudy.errors import SettingError
    from understudy.properties.lesson_tests import describe_test_result, run_lesson_test
    from understudy.storage.library_folder import list_documents
    from understudy.ui.cli.library_data import find_fitting_world
    from understudy.ui.cli.options import (
        find_kit,
        find_optional_scenario,
        open_scenario,
        open_team_libraries,
    )
    from understudy.ui.cli.output import make_console, print_json

    if folder is not None and same not in (None, folder):
        remedy = "name one of them"
        problem = f"is another folder than {folder}"
        raise SettingError(where="--library", setting=str(same), problem=problem, remedy=remedy)
    library = folder or same or LIBRARY
    list_documents(library)  # a folder that is not there is the first thing to say
    failing = _list_failures(failures)
    named = world or (find_fitting_world(library) if kit is None else WORLD)
    scenario, parts = find_optional_scenario(named), find_kit(kit, named)
    where = scenario or open_scenario(WORLD)  # a body of one's own has no team
    known = open_team_libraries(where, None, library, parts)
    found = []
    for place, of in _places(where, library, parts, known):
        former = _former(place, of)
        formers = {name: taught for name, (_, taught) in former.items()}
        for name in of.taught:
            seen = run_lesson_test(of, name, formers, known)
            version = former[name][0] if name in former else None
            label = str(place.relative_to(library) / name)
            found.append(
                (_make_row(label, seen, version), list(describe_test_result(seen, f"version {version}")))
            )
    rows = [row for row, _ in found]
    tested = list(_run_properties(library, kit, quiet=as_json))
    rerun = [_rerun(each, library, kit) for each in failing]
    works = all(row.works for row in rows) and all(each.was_met for each in tested)
    works = works and all(row.verdict == "passes" for row in rerun)
    result = LibraryTestResult(
        library,
        named if scenario is None else where.name,
        works,
        rows,
        [_make_property_row(each) for each in tested],
        rerun,
    )
    if as_json:
        print_json(result)
    else:
        _show(result, found, make_console())
    raise typer.Exit(0 if result.works else 1)


@dataclass(frozen=True, slots=True)
class LessonPropertyRow:
    """Property of a lesson, the time until it was reached (s), why it could not be tested, and whether it held."""

    outcome: str
    took_s: float | None
    problem: str | None
    held: bool


@dataclass(frozen=True, slots=True)
class FailedPropertyRow:
    """Property of a lesson that failed, and the automata with whose former versions it holds."""

    outcome: str
    problem: str | None
    comes_with_former: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class AutomatonTestRow:
    """Test results of one automaton on its lesson."""

    name: str
    works: bool
    examples: int
    moments_before: int
    former: int | None
    """Number of the former version; None if there is none."""
    changed: bool
    affected: Sequence[str]
    no_longer: Sequence[str]
    different: Sequence[ReplayedPress]
    otherwise: Sequence[int]
    """Numbers of the examples that are decided differently than shown."""
    changes_before: Sequence[DecisionChange]
    outcomes: Sequence[LessonPropertyRow]
    failed: Sequence[FailedPropertyRow]


@dataclass(frozen=True, slots=True)
class LibraryTestResult:
    """Test results of a library."""

    library: Path
    world: str
    works: bool
    automata: Sequence[AutomatonTestRow]
    properties: Sequence[PropertyRow]
    failures: Sequence[FailureRow]
    """The failing worlds that were run again; empty without `--failures`."""


@dataclass(frozen=True, kw_only=True)
class FailureRow:
    """Result of running a failing world again."""

    name: str
    behavior: str
    verdict: str
    """"passes", "fails", or "unknown" if it could not be run."""
    robustness: float | None
    """The distance from failing, below 0 if it still fails."""
    why: str
    """A short description of the failure as it was found, or the reason why the world could not be run."""


@dataclass(frozen=True, kw_only=True)
class PropertyRow:
    """Test results of one property of the library's file."""

    name: str
    property: str
    """The property in words."""
    behavior: str
    world: str
    verdict: str
    """"holds", "fails" or "undecided"."""
    at_least: float | None
    """The share of worlds that it claims to hold in; None for all."""
    worlds: int
    failures: int
    failure_rate_low: float
    """The lower limit of the 95 % interval of the failure rate, from 0 to 1."""
    failure_rate_high: float
    """The upper limit of that interval; without a failure and `at_least`, the one-sided limit of 95 %."""
    least_robustness: float | None
    failed: Sequence[FailedWorldRow]
    """The worlds in which it failed."""
    sentences: Sequence[str]


@dataclass(frozen=True, slots=True)
class FailedWorldRow:
    """World in which a property failed: its seed, when (s), and how clearly (below 0)."""

    seed: int
    failed_s: float
    robustness: float


def _run_properties(library: Path, kit: str | None, *, quiet: bool) -> Iterator[PropertyResult]:
    """Test the properties of a library's file, if there is one."""
    from understudy.properties.library_properties import FittingLibraries, run_library_properties
    from understudy.properties.property_file import FILE
    from understudy.ui.cli.options import find_kit, open_scenario, open_team_libraries
    from understudy.ui.cli.output import show_progress

    def open_world(world: str) -> FittingLibraries:
        where = open_scenario(world)
        return FittingLibraries(where, open_team_libraries(where, None, library, find_kit(kit, world)))

    if (library / FILE).exists():
        with show_progress("Worlds run", quiet=quiet) as report:
            yield from run_library_properties(library / FILE, open_world, progress=report)


def _list_failures(folder: Path | None) -> Sequence[FailingWorld]:
    """List the failing worlds of a folder; report on stderr which cannot be read."""
    from understudy.errors import FileError
    from understudy.falsification.failure_list import list_failing_worlds

    if folder is None:
        return ()
    if not folder.is_dir():
        remedy = "name the folder in which understudy falsify keeps failing worlds"
        raise FileError(path=folder, place="", problem="is not a folder", remedy=remedy)
    found = list_failing_worlds(folder)
    for problem in found.problems:
        typer.echo(f"Note: a failing world is left out: {problem}", err=True)
    return found.worlds


def _rerun(failing: FailingWorld, library: Path, kit: str | None) -> FailureRow:
    """Run a failing world again with the library as it is."""
    from understudy.errors import UnderstudyError
    from understudy.falsification.rerun_failures import RerunResult, rerun_failing_world
    from understudy.properties.property_file import FILE, load_properties
    from understudy.sim.kit import make_scenario_kit
    from understudy.ui.cli.options import find_kit, open_team_libraries

    scenario, facts = failing.trial.scenario, failing.facts
    try:
        parts = make_scenario_kit(scenario) if kit is None else find_kit(kit, scenario.name)
        known = open_team_libraries(scenario, facts.behavior, library, parts)
        properties = load_properties(library / FILE) if facts.property is not None else ()
        found = rerun_failing_world(failing, known, properties=properties)
    except UnderstudyError as error:
        found = RerunResult(failing, float("nan"), str(error))
    return FailureRow(
        name=failing.folder.name,
        behavior=facts.behavior,
        verdict="unknown" if found.problem else "fails" if found.has_failed else "passes",
        robustness=None if found.problem else found.robustness,
        why=found.problem or failing.summary,
    )


def _make_property_row(result: PropertyResult) -> PropertyRow:
    from understudy.properties.run_property import describe_result

    tested, outcomes = result.tested, result.outcomes
    low, high = result.failure_interval
    return PropertyRow(
        name=tested.name,
        property=tested.claim,
        behavior=tested.behavior,
        world=tested.start.world,
        verdict=result.verdict,
        at_least=tested.at_least,
        worlds=result.worlds,
        failures=result.failures,
        failure_rate_low=low,
        failure_rate_high=high,
        least_robustness=float(outcomes.robustness.min()) if result.worlds else None,
        failed=[
            FailedWorldRow(seed, float(outcomes.failed_s[row]), float(outcomes.robustness[row]))
            for row, seed in enumerate(result.seeds)
            if not outcomes.held[row]
        ],
        sentences=list(describe_result(result)),
    )


def _places(
    where: Scenario, folder: Path, kit: Kit, known: Mapping[str, Library]
) -> Iterator[tuple[Path, Library]]:
    """Yield each folder that contains automata once, with its library."""
    from understudy.sim.team.libraries import find_type_folders

    folders = {name: place for name, (place, _) in find_type_folders(where, folder, kit).items()}
    seen: set[Path] = set()
    for sort, library in known.items():
        place = folders.get(sort, folder / sort)
        if place not in seen and library.taught:
            seen.add(place)
            yield place, library


def _former(place: Path, library: Library) -> dict[str, tuple[int, TrainedAutomaton]]:
    """Return the last former version of each automaton that has a readable one, with its number."""
    from understudy.errors import UnderstudyError
    from understudy.storage.library_folder import list_versions, read_document
    from understudy.ui.cli.options import import_learner

    found = {}
    for name in library.taught:
        kept = list_versions(place, name)
        if kept:
            try:
                found[name] = (
                    kept[-1].number,
                    read_document(kept[-1].file, library.kit, import_learner()).taught,
                )
            except UnderstudyError as error:
                typer.echo(f"Note: {name} is compared with no former version: {error}", err=True)
    return found


def _make_row(label: str, seen: LessonTestResult, former: int | None) -> AutomatonTestRow:
    from understudy.properties.lesson_tests import describe_lost_decisions

    replay = seen.replayed
    return AutomatonTestRow(
        name=label,
        works=seen.is_passing,
        examples=replay.examples,
        moments_before=replay.before,
        former=former,
        changed=seen.changed,
        affected=seen.affected,
        no_longer=list(describe_lost_decisions(replay)),
        different=replay.different,
        otherwise=[each.number for each in replay.mismatches],
        changes_before=replay.changes,
        outcomes=[
            LessonPropertyRow(str(each.tested), each.took_s, each.problem or None, each.was_met)
            for each in seen.properties
        ],
        failed=[
            FailedPropertyRow(str(each.result.tested), each.result.problem or None, each.since)
            for each in seen.failed
        ],
    )


def _show(result: LibraryTestResult, found: list[tuple[AutomatonTestRow, list[str]]], out: Console) -> None:
    from rich.markup import escape
    from rich.padding import Padding

    from understudy.ui.cli.output import format_count

    for each, lines in found:
        mark = "[red]✗[/]" if not each.works else "[yellow]•[/]" if lines else "[green]✓[/]"
        about = format_count(each.examples, "example") if each.examples else "nothing recorded"
        if each.outcomes:
            about += f", {format_count(len(each.outcomes), 'property', 'properties')}"
        out.print(f"{mark} [bold]{escape(each.name)}[/] [dim]{about}[/]")
        for line in lines:
            out.print(Padding(escape(line), (0, 0, 0, 4), expand=False))
    for row in result.properties:
        mark = {"fails": "[red]✗[/]", "undecided": "[yellow]•[/]"}.get(row.verdict, "[green]✓[/]")
        about = f"{row.behavior} in {row.world}: {row.property}"
        out.print(f"{mark} [bold]{escape(row.name)}[/] [dim]{escape(about)}[/]", soft_wrap=True)
        for line in row.sentences:
            out.print(Padding(escape(line), (0, 0, 0, 4), expand=False))
    for failure in result.failures:
        mark = "[green]✓[/]" if failure.verdict == "passes" else "[red]✗[/]"
        about = "passes now" if failure.verdict == "passes" else failure.why
        out.print(f"{mark} [bold]{escape(failure.name)}[/] [dim]{escape(about)}[/]", soft_wrap=True)
    bad = sum(not each.works for each, _ in found)
    said = (
        f"[red]{format_count(bad, 'does', 'do')} not do what was shown[/]"
        if bad
        else "[green]all as shown[/]"
    )
    tested = format_count(len(found), "automaton", "automata")
    out.print(f"{escape(str(result.library))}, in {escape(result.world)}: {tested}, {said}", soft_wrap=True)
    if result.properties:
        out.print(_count_verdicts(result.properties), soft_wrap=True)
    if result.failures:
        passed = sum(row.verdict == "passes" for row in result.failures)
        out.print(f"{format_count(len(result.failures), 'failing world')}: {passed} now pass", soft_wrap=True)


def _count_verdicts(rows: Sequence[PropertyRow]) -> str:
    """Return how many properties hold, fail, and are undecided, with colors."""
    from understudy.ui.cli.output import format_count

    verdicts = [row.verdict for row in rows]
    parts = []
    if fails := verdicts.count("fails"):
        parts.append(f"[red]{format_count(fails, 'fails', 'fail')}[/]")
    if undecided := verdicts.count("undecided"):
        parts.append(f"[yellow]{undecided} undecided[/]")
    if holds := verdicts.count("holds"):
        parts.append(f"[green]{format_count(holds, 'holds', 'hold')}[/]")
    return f"{format_count(len(rows), 'property', 'properties')}: {', '.join(parts)}"
