"""The tests of a library for `understudy test`, in one process or shared among several."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import redirect_stderr
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from multiprocessing import parent_process
from pathlib import Path
from typing import Any, NamedTuple

import typer

from understudy.addons.checks.falsification.failing_world import FailingWorld
from understudy.addons.checks.falsification.rerun_failures import rerun_failing_world
from understudy.clock import REAL_TIME
from understudy.errors import UnderstudyError
from understudy.judging.process_pool import LOADING_S, share_calls
from understudy.judging.properties.lesson_tests import (
    LessonTestResult,
    describe_lost_decisions,
    describe_test_result,
    run_lesson_test,
)
from understudy.judging.properties.library_properties import FittingLibraries, open_properties, try_property
from understudy.judging.properties.property_file import FILE, load_properties
from understudy.judging.properties.run_property import PropertyResult, describe_result
from understudy.learning.fit import learn
from understudy.model.library import Kit, Library, TrainedAutomaton
from understudy.model.property import Property
from understudy.sim.catalog import find_scenario
from understudy.sim.kit import make_scenario_kit
from understudy.sim.scenario.schema import Scenario
from understudy.sim.team.libraries import find_type_folders
from understudy.storage.library_folder import list_versions, read_document
from understudy.ui.cli.named_inputs import find_kit, find_optional_scenario, open_team_libraries
from understudy.ui.cli.options import WORLD
from understudy.ui.cli.progress_bar import show_progress


@dataclass(frozen=True, slots=True)
class LibraryTestResult:
    """Test results of a library."""

    library: Path
    world: str
    works: bool
    automata: Sequence[Mapping[str, Any]]
    """The results of each automaton, see `_describe_lesson_test`."""
    properties: Sequence[Mapping[str, Any]]
    """The results of each property of the library's file, see `_describe_property`."""
    failures: Sequence[Mapping[str, Any]]
    """The failing worlds that were run again, see `_rerun`; empty without `--failures`."""


class LibrarySetting(NamedTuple):
    """The folder of a library, the world that it fits, and the kit that was named, if any.

    Without a world, it needs only what the lessons of its recordings have.
    """

    folder: Path
    world: str | None
    kit: str | None


def test_library(
    setting: LibrarySetting, failing: Sequence[FailingWorld], *, jobs: int, quiet: bool
) -> LibraryTestResult:
    """Test the lessons and the properties of a library, and run failing worlds again.

    The results do not depend on the number of processes.

    Parameters
    ----------
    setting
        The library.
    failing
        The failing worlds.
    jobs
        The largest number of processes; there are never more than cores, and none for what takes a short time.
    quiet
        Whether no progress is shown.

    Returns
    -------
    LibraryTestResult
        The results.

    Raises
    ------
    UnderstudyError
        If the library or its file of properties is not valid. Nothing has been run then.
    """
    _open.cache_clear()  # files may have changed since the last call in this process
    _open_world.cache_clear()
    opened = _open(setting)
    labels = [(place, name) for place, of in opened.places for name in of.taught]
    subjects = _open_properties(setting)
    calls: list[tuple[Callable[..., Any], Any]] = [
        *((_test_lesson, each) for each in labels),
        *((_test_property, subject) for subject, _ in subjects),
        *((_rerun, each) for each in failing),
    ]
    with show_progress("Tests run", quiet=quiet) as report:
        found = _run(setting, calls, jobs, report)
    lessons, end = len(labels), len(labels) + len(subjects)
    automata, properties, rerun = found[:lessons], found[lessons:end], found[end:]
    works = all(row["works"] for row in automata) and all(row["verdict"] != "fails" for row in properties)
    works = works and all(row["verdict"] == "passes" for row in rerun)
    return LibraryTestResult(setting.folder, opened.world, works, automata, properties, rerun)


def _run(
    setting: LibrarySetting,
    calls: Sequence[tuple[Callable[..., Any], Any]],
    jobs: int,
    report: Callable[[int, int], None],
    clock: Callable[[], float] = REAL_TIME,
) -> list[Any]:
    """Return the results of tests in order.

    What is left takes as long as the last of its kind did, each; the first of a kind may have loaded kernels.
    """
    report(0, len(calls))
    found, took_s = dict[int, Any](), dict[Callable[..., Any], float]()

    def estimate_left_s() -> float:
        return sum(took_s.get(test, 0.0) for test, _ in calls[len(found) :])

    def measure() -> Iterator[Callable[[], Any]]:
        for test, of in calls:
            begun_s = clock()
            yield partial(_test, test, setting, of)
            loading_s = 0.0 if test in took_s else LOADING_S
            took_s[test] = max(0.0, clock() - begun_s - loading_s)

    for number, each in share_calls(measure(), jobs=jobs, estimate_left_s=estimate_left_s):
        found[number] = each.result()
        report(len(found), len(calls))
    return [found[number] for number in range(len(calls))]


def _test(test: Callable[..., Any], setting: LibrarySetting, of: object) -> Any:
    """Run a test; in a process of its own without notes, since the main process has written them already."""
    if parent_process() is None:
        return test(setting, of)
    with redirect_stderr(io.StringIO()):
        return test(setting, of)


class _OpenLibraries(NamedTuple):
    """The libraries of a setting: the name of their world, of all sorts, and those with automata by folder."""

    world: str
    known: Mapping[str, Library]
    places: Sequence[tuple[Path, Library]]
    formers: Mapping[Path, Mapping[str, tuple[int, TrainedAutomaton]]]


@lru_cache(maxsize=1)
def _open(setting: LibrarySetting) -> _OpenLibraries:
    """Open the libraries of a setting, once in each process."""
    scenario, parts = find_optional_scenario(setting.world), find_kit(setting.kit, setting.world)
    where = scenario or find_scenario(WORLD)  # a body of one's own has no team
    known = open_team_libraries(where, None, setting.folder, parts)
    places = list(_places(where, setting.folder, parts, known))
    formers = {place: _former(place, of) for place, of in places}
    world = setting.world or "no world" if scenario is None else where.name
    return _OpenLibraries(world, known, places, formers)


def _test_lesson(setting: LibrarySetting, of: tuple[Path, str]) -> dict[str, Any]:
    """Test an automaton of a folder on its lesson."""
    (place, name), opened = of, _open(setting)
    former = opened.formers[place]
    formers = {each: taught for each, (_, taught) in former.items()}
    seen = run_lesson_test(dict(opened.places)[place], name, formers, opened.known)
    version = former[name][0] if name in former else None
    return _describe_lesson_test(str(place.relative_to(setting.folder) / name), seen, version)


def _open_properties(setting: LibrarySetting) -> list[tuple[Property, FittingLibraries]]:
    """Open and check the properties of a library's file, if there is one."""
    path = setting.folder / FILE
    return open_properties(path, lambda world: _open_world(setting, world)) if path.exists() else []


@lru_cache(maxsize=8)
def _open_world(setting: LibrarySetting, world: str) -> FittingLibraries:
    """Open a scenario and the libraries for it, once in each process."""
    where = find_scenario(world)
    parts = find_kit(setting.kit, world)
    return FittingLibraries(where, open_team_libraries(where, None, setting.folder, parts))


def _test_property(setting: LibrarySetting, subject: Property) -> dict[str, Any]:
    """Test a property in its worlds."""
    return _describe_property(try_property(subject, partial(_open_world, setting)))


def _rerun(setting: LibrarySetting, failing: FailingWorld) -> dict[str, Any]:
    """Run a failing world again with the library as it is; return how it went, as `--json` prints it.

    "robustness" is the distance from failing, below 0 if it still fails; None if it could not be run. "why" is a short
    description of the failure as it was found, or the reason why it could not be run.
    """
    library, _, kit = setting
    scenario, facts = failing.trial.scenario, failing.facts
    try:
        parts = make_scenario_kit(scenario) if kit is None else find_kit(kit, scenario.name)
        known = open_team_libraries(scenario, facts.behavior, library, parts)
        properties = load_properties(library / FILE) if facts.property is not None else ()
        found = rerun_failing_world(failing, known, properties=properties)
    except UnderstudyError as error:
        found = replace(failing, problem=str(error))
    return {
        "name": failing.folder.name,
        "behavior": facts.behavior,
        "verdict": found.verdict,
        "robustness": None if found.problem else found.robustness,
        "why": found.problem or failing.summary,
    }


def _describe_property(result: PropertyResult) -> dict[str, Any]:
    """Describe the result of a property of the library's file, as `--json` prints it.

    "failure_rate_low" and "failure_rate_high" limit the failure rate at 95 %. Of each world in which it failed,
    "failed" has the seed, when that was, and how clearly. "leaves_shown" is true if it demands a flag, and this was
    raised where it was not shown, in any world.
    """
    tested, outcomes = result.tested, result.outcomes
    low, high = result.failure_interval
    failed = [
        {
            "seed": seed,
            "failed_s": float(outcomes.failed_s[row]),
            "robustness": float(outcomes.robustness[row]),
        }
        for row, seed in enumerate(result.seeds)
        if not outcomes.held[row]
    ]
    return {
        "name": tested.name,
        "property": tested.claim,
        "behavior": tested.behavior,
        "world": tested.start.world,
        "verdict": result.verdict,
        "at_least": tested.at_least,
        "worlds": result.worlds,
        "failures": result.failures,
        "failure_rate_low": low,
        "failure_rate_high": high,
        "least_robustness": float(outcomes.robustness.min()) if result.worlds else None,
        "failed": failed,
        "leaves_shown": result.raised is not None and result.raised.leaves_shown,
        "sentences": list(describe_result(result)),
    }


def _places(
    where: Scenario, folder: Path, kit: Kit, known: Mapping[str, Library]
) -> Iterator[tuple[Path, Library]]:
    """Yield each folder that contains automata once, with its library."""
    folders = {name: place for name, (place, _) in find_type_folders(where, folder, kit).items()}
    seen: set[Path] = set()
    for sort, library in known.items():
        place = folders.get(sort, folder / sort)
        if place not in seen and library.taught:
            seen.add(place)
            yield place, library


def _former(place: Path, library: Library) -> dict[str, tuple[int, TrainedAutomaton]]:
    """Return the last former version of each automaton that has a readable one, with its number."""
    found = {}
    for name in library.taught:
        kept = list_versions(place, name)
        if kept:
            try:
                found[name] = (
                    kept[-1].number,
                    read_document(kept[-1].file, library.kit, learn).taught,
                )
            except UnderstudyError as error:
                typer.echo(f"Note: {name} is compared with no former version: {error}", err=True)
    return found


def _describe_lesson_test(label: str, seen: LessonTestResult, former: int | None) -> dict[str, Any]:
    """Describe the test of an automaton on its lesson, as `--json` prints it.

    "former" is the number of its former version, and "otherwise" has the numbers of the examples that are decided
    differently than shown. Of the examples that were "watched", "overruled" are decided otherwise than the robot did.
    "sentences" say all that differs.
    """
    replay = seen.replayed
    return {
        "name": label,
        "works": seen.is_passing,
        "examples": replay.examples,
        "moments_before": replay.before,
        "former": former,
        "changed": seen.changed,
        "affected": seen.affected,
        "no_longer": list(describe_lost_decisions(replay)),
        "different": replay.different,
        "otherwise": [each.number for each in replay.mismatches],
        "watched": replay.watched,
        "overruled": replay.overruled,
        "changes_before": replay.changes,
        "outcomes": [
            {
                "outcome": str(each.tested),
                "took_s": each.took_s,
                "problem": each.problem or None,
                "held": each.was_met,
            }
            for each in seen.properties
        ],
        "failed": [
            {
                "outcome": str(each.result.tested),
                "problem": each.result.problem or None,
                "comes_with_former": each.since,
            }
            for each in seen.failed
        ],
        "sentences": list(describe_test_result(seen, f"version {former}")),
    }
