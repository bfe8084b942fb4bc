"""Command `understudy test`: test a library on its lessons and properties, and compare it with former versions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.markup import escape
from rich.padding import Padding

from understudy.addons.checks.falsification.failing_world import list_failing_worlds
from understudy.errors import FileError
from understudy.storage.library_folder import list_documents
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.library_options import LibraryTestOptions
from understudy.ui.cli.library_tests import LibrarySetting, LibraryTestResult, test_library
from understudy.ui.cli.options import WORLD
from understudy.ui.cli.output import format_count, make_console
from understudy.ui.cli.world_libraries import choose_library_world

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.addons.checks.falsification.failing_world import FailingWorld


def run_library_tests(options: LibraryTestOptions) -> None:
    """Test a library: every recorded moment of its lessons, every property, and failing worlds."""
    library = options.library
    list_documents(library)  # a folder that is not there is the first thing to say
    failing = _list_failures(options.failures)
    named = choose_library_world(library, options.world, options.kit)
    if options.kit is not None:
        named = named or WORLD
    result = test_library(
        LibrarySetting(library, named, options.kit), failing, jobs=options.jobs, quiet=options.as_json
    )
    if options.as_json:
        print_json(result)
    else:
        _show(result, make_console())
    undecided = any(row["verdict"] == "undecided" for row in result.properties)
    raise typer.Exit(0 if result.works and not (options.strict and undecided) else 1)


def _list_failures(folder: Path | None) -> Sequence[FailingWorld]:
    """List the failing worlds of a folder; report on stderr which cannot be read."""
    if folder is None:
        return ()
    if not folder.is_dir():
        remedy = "name the folder in which understudy falsify keeps failing worlds"
        raise FileError(path=folder, place="", problem="is not a folder", remedy=remedy)
    worlds, problems = list_failing_worlds(folder)
    for problem in problems:
        typer.echo(f"Note: a failing world is left out: {problem}", err=True)
    return worlds


def _show(result: LibraryTestResult, out: Console) -> None:
    for each in result.automata:
        lines = each["sentences"]
        mark = "[red]✗[/]" if not each["works"] else "[yellow]•[/]" if lines else "[green]✓[/]"
        about = format_count(each["examples"], "example") if each["examples"] else "nothing recorded"
        if each["outcomes"]:
            about += f", {format_count(len(each['outcomes']), 'property', 'properties')}"
        out.print(f"{mark} [bold]{escape(each['name'])}[/] [dim]{about}[/]")
        for line in lines:
            out.print(Padding(escape(line), (0, 0, 0, 4), expand=False))
    for row in result.properties:
        mark = {"fails": "[red]✗[/]", "undecided": "[yellow]•[/]"}.get(row["verdict"], "[green]✓[/]")
        about, lines = f"{row['behavior']} in {row['world']}: {row['property']}", row["sentences"]
        out.print(f"{mark} [bold]{escape(row['name'])}[/] [dim]{escape(about)}[/]", soft_wrap=True)
        for number, line in enumerate(lines, 1):
            # Where the flag was raised comes last.
            is_marked = row["leaves_shown"] and number == len(lines)
            text = f"[yellow]{escape(line)}[/]" if is_marked else escape(line)
            out.print(Padding(text, (0, 0, 0, 4), expand=False))
    for failure in result.failures:
        mark = "[green]✓[/]" if failure["verdict"] == "passes" else "[red]✗[/]"
        about = "passes now" if failure["verdict"] == "passes" else failure["why"]
        out.print(f"{mark} [bold]{escape(failure['name'])}[/] [dim]{escape(about)}[/]", soft_wrap=True)
    bad = sum(not each["works"] for each in result.automata)
    otherwise = sum(len(each["otherwise"]) + each["overruled"] for each in result.automata)
    anew = sum(change.moments for each in result.automata for change in each["changes_before"])
    said = "[green]all as shown[/]"
    if anew:
        said = (
            f"[green]presses as shown[/], [yellow]{format_count(anew, 'moment')} before them decided anew[/]"
        )
    if bad:
        said = f"[red]{format_count(bad, 'does', 'do')} not do what was shown[/]"
    elif otherwise:
        said = f"[yellow]{format_count(otherwise, 'moment')} decided otherwise than shown[/]"
    tested = format_count(len(result.automata), "automaton", "automata")
    out.print(f"{escape(str(result.library))}, in {escape(result.world)}: {tested}, {said}", soft_wrap=True)
    if result.properties:
        out.print(_count_verdicts(result.properties), soft_wrap=True)
    if result.failures:
        passed = sum(row["verdict"] == "passes" for row in result.failures)
        out.print(f"{format_count(len(result.failures), 'failing world')}: {passed} now pass", soft_wrap=True)


def _count_verdicts(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return how many properties hold, fail, and are undecided, with colors."""
    verdicts = [row["verdict"] for row in rows]
    parts = []
    if fails := verdicts.count("fails"):
        parts.append(f"[red]{format_count(fails, 'fails', 'fail')}[/]")
    if undecided := verdicts.count("undecided"):
        parts.append(f"[yellow]{undecided} undecided[/]")
    if holds := verdicts.count("holds"):
        parts.append(f"[green]{format_count(holds, 'holds', 'hold')}[/]")
    return f"{format_count(len(rows), 'property', 'properties')}: {', '.join(parts)}"
