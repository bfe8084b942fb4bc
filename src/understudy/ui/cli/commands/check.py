"""Command `understudy check`: find what can go wrong with automata from their trees, without running them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.markup import escape
from rich.padding import Padding

from understudy.addons.checks.falsification.finding_trials import try_findings
from understudy.addons.checks.verification.chatter import HELD
from understudy.addons.checks.verification.check_library import CheckReport, check_library, join_reports
from understudy.addons.checks.verification.coordinators import SquadMembers
from understudy.addons.checks.verification.finding import Finding, FindingCell, Severity
from understudy.addons.checks.verification.scenario_facts import NOTHING_ASSUMED, collect_scenario_facts
from understudy.errors import join_names
from understudy.learning.fit import learn
from understudy.model.describe import convert_to_plain
from understudy.model.library import Kit, Library
from understudy.sim.catalog import find_scenario
from understudy.sim.team.assignment import assign_team_members
from understudy.sim.team.libraries import Libraries, collect_libraries, load_type_libraries
from understudy.storage.json_text import select_facts
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.library_data import find_listed, find_optional_kit, open_documents, report_left_out
from understudy.ui.cli.library_options import CheckOptions, FailOn
from understudy.ui.cli.named_inputs import find_optional_scenario
from understudy.ui.cli.options import WORLD
from understudy.ui.cli.output import format_count, make_console
from understudy.ui.cli.world_libraries import open_all_libraries

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.sim.scenario.schema import Scenario
    from understudy.storage.library_folder import LoadedLibrary

COLORS = {"error": "red", "warning": "yellow", "note": "dim"}


def check_automata(options: CheckOptions) -> None:
    """Find what can go wrong with automata from their trees and examples."""
    report = _check(options.library, options.names or [], options.world, options.kit, worlds=options.worlds)
    failing = options.fail_on is not FailOn.NEVER and any(
        each.severity.rank >= _rank(options.fail_on) for each in report.findings
    )
    if options.as_json:
        facts = {"library": options.library, "world": options.world, "holds": not failing}
        print_json({**facts, **_describe_report(report)})
    else:
        _show(options.library, options.world, report, make_console(), everything=options.everything)
    raise typer.Exit(1 if failing else 0)


def _rank(fail_on: FailOn) -> int:
    return Severity(fail_on.value).rank


def _check(
    folder: Path, names: Sequence[str], world: str | None, kit: str | None, *, worlds: int
) -> CheckReport:
    """Open the libraries in a folder and check them; raise the error of the first file that cannot be opened.

    Given a world, try what was found in new ones.
    """
    scenario = find_optional_scenario(world)
    parts = find_optional_kit(kit, world)
    if parts is None:
        listings = open_documents(folder, None, learn)
    else:
        listings = open_all_libraries(folder, scenario or find_scenario(WORLD), parts, learn)
    report_left_out(listings)
    wanted: dict[str, list[str]] = {}
    for name in names:
        prefix, own = find_listed(listings, name)
        if error := listings[prefix].problems.get(f"{own}.json"):
            raise error
        wanted.setdefault(prefix, []).append(own)
    if not names:
        for listing in listings.values():
            listing.refuse_damaged()
        wanted = {prefix: list(listing.library.taught) for prefix, listing in listings.items()}
    libraries = None if scenario is None or parts is None else _collect(scenario, folder, parts, listings)
    squads = {} if scenario is None or libraries is None else _find_squads(scenario, libraries)
    reports = [
        check_library(
            listings[prefix].library,
            chosen,
            facts=NOTHING_ASSUMED
            if scenario is None
            else collect_scenario_facts(
                scenario, listings[prefix].library, squads[prefix].squad if prefix in squads else None
            ),
            prefix=prefix,
            kit_known=parts is not None,
            members=squads.get(prefix),
        )
        for prefix, chosen in wanted.items()
    ]
    report = join_reports(reports)
    if scenario is None or libraries is None or not worlds:
        return report
    return try_findings(report, libraries, scenario, worlds=worlds)


def _collect(
    scenario: Scenario, folder: Path, kit: Kit, listings: Mapping[str, LoadedLibrary]
) -> Library | Libraries:
    """Return the library of all robots; or, of a team, that of each sort of agents."""

    def look(place: Path, kit: Kit) -> Library:
        prefix = "" if place == folder else f"{place.name}/"
        return listings[prefix].library if prefix in listings else Library(kit)

    robots = load_type_libraries(scenario, folder, kit, look)
    found = collect_libraries(scenario, robots, lambda name, kit: look(folder / name, kit))
    return next(iter(found.values())) if len(found) == 1 else found


def _find_squads(scenario: Scenario, libraries: Library | Libraries) -> dict[str, SquadMembers]:
    """Return the squads whose coordinators have automata, with their members' libraries, by prefix."""
    if isinstance(libraries, Library):
        return {}
    return {
        f"{squad.name}/": SquadMembers(squad, {role.name: libraries[role.of] for role in squad.roles})
        for squad, _ in assign_team_members(scenario).squads
    }


def _describe_report(report: CheckReport) -> dict[str, Any]:
    """Describe the findings on a library for `--json`, and what was checked."""
    findings = [_describe_finding(each) for each in report.findings]
    return select_facts(report, "findings", "checked", "unchecked", "ties", findings=findings)


def _describe_finding(finding: Finding) -> dict[str, Any]:
    names = (
        "automaton",
        "kind",
        "severity",
        "certain",
        "sentence",
        "states",
        "assumptions",
        "cells",
        "examples",
    )
    cells = [_describe_cell(each) for each in finding.cells]
    return select_facts(finding, *names, "remedy", "trial", certain=finding.is_certain, cells=cells)


def _describe_cell(cell: FindingCell) -> dict[str, Any]:
    """Describe a part of the feature space: in words, the ranges of its features, and a value of each."""
    ranges = {str(bound): region._asdict() for bound, region in zip(cell.features, cell.box, strict=True)}
    values = zip(cell.features, cell.at, strict=True)
    at = {str(bound): convert_to_plain(value, bound) for bound, value in values}
    return {"condition": cell.condition, "ranges": ranges, "at": at}


def _show(folder: Path, world: str | None, report: CheckReport, out: Console, *, everything: bool) -> None:
    by_name: dict[str, list[Finding]] = {finding.automaton: [] for finding in report.findings}
    for finding in report.findings:
        by_name[finding.automaton].append(finding)
    checked = {each.name: each for each in report.checked}
    for name in dict.fromkeys((*by_name, *checked)):
        found, each = by_name.get(name, []), checked[name]
        worst = max((finding.severity for finding in found), key=lambda severity: severity.rank, default=None)
        mark = {"error": "[red]✗[/]", "warning": "[yellow]![/]"}.get(str(worst), "[green]✓[/]")
        size = f"{format_count(each.states, 'state')}, {format_count(each.boxes, 'leaf', 'leaves')}"
        out.print(f"{mark} [bold]{escape(name)}[/] [dim]{size}[/]")
        for finding in found:
            _show_finding(finding, out, everything=everything)
    if report.ties and not everything:
        ties = format_count(len(report.ties), "tie between readings", "ties between readings")
        out.print(f"[dim]Assumed of {escape(str(world))}: {ties} (--all)[/]")
    elif report.ties:
        out.print(f"[dim]Assumed of {escape(str(world))}:[/]")
        for tie in report.ties:
            _print_indented(f"[dim]{escape(tie)}[/]", out)
    untried = sum(HELD in each.assumptions and each.trial is None for each in report.findings)
    if untried and not everything:
        which = format_count(untried, "finding assumes", "findings assume")
        out.print(f"[dim]{which} that such readings occur: --world tries how often (--all)[/]")
    for reason in report.unchecked:
        out.print(f"[yellow]Not checked:[/] {escape(reason)}")
    counts = [
        f"[{COLORS[severity]}]{format_count(number, severity)}[/]"
        for severity in COLORS
        if (number := sum(each.severity == severity for each in report.findings))
    ]
    found_text = join_names(counts) if counts else "[green]nothing found[/]"
    automata = format_count(len(report.checked), "automaton", "automata")
    out.print(f"{escape(str(folder))}: {automata} checked, {found_text}", soft_wrap=True)


def _show_finding(finding: Finding, out: Console, *, everything: bool) -> None:
    """Show a finding; of one that did not happen where it was tried only the sentence, without `everything`."""
    color, trial = COLORS[finding.severity], finding.trial
    said = escape(finding.sentence)
    if finding.severity == "note":
        _print_indented(f"[dim]note {said}[/]", out)
        if everything and finding.kind == "one example":
            for state, cell, number in zip(finding.states, finding.cells, finding.examples, strict=True):
                _print_indented(
                    f"[dim]{escape(f'{state}, {cell.condition}: example {number}')}[/]", out, by=6
                )
        return
    often = "" if trial is None else f" [{color if trial.happened else 'dim'}]It {trial}.[/]"
    _print_indented(f"[{color}]{finding.severity}[/] {said}{often}", out)
    for each in finding.assumptions:
        if everything or (trial is None and each != HELD):
            _print_indented(f"[dim]assumes: {escape(each)}[/]", out, by=6)
    if everything or trial is None or trial.happened:
        _print_indented(f"→ {escape(finding.remedy)}", out, by=6)


def _print_indented(text: str, out: Console, *, by: int = 4) -> None:
    out.print(Padding(text, (0, 0, 0, by), expand=False))
