"""Decisions made again over a recording for `understudy replay`, and where they differ."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.markup import escape

from understudy.errors import join_names
from understudy.judging.explain_run import (
    DecisionDiff,
    RunNotReproducible,
    diff_replayed_decisions,
)
from understudy.judging.explanation_text import DIGITS, DecisionData
from understudy.judging.rerun import Rerun
from understudy.sim.team.libraries import Libraries, find_behavior_sort, list_running_sorts
from understudy.storage.document import fingerprint_automaton
from understudy.storage.json_text import select_facts
from understudy.ui.cli.commands.why_team import print_decision, round_values
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.named_inputs import choose_behavior
from understudy.ui.cli.options import parse_bindings
from understudy.ui.cli.output import format_count, make_console
from understudy.ui.cli.recorded_runs import (
    choose_recording_kit,
    load_current_libraries,
    load_recorded_libraries,
    read_recorded_scenario,
)
from understudy.ui.cli.run_options import ReplayOptions

if TYPE_CHECKING:
    from rich.console import Console

    from understudy.model.library import Kit
    from understudy.records.header import RunInfo
    from understudy.records.reader import Recording
    from understudy.sim.scenario.schema import Scenario

DIFFERENT = 1
MOST_SHOWN = 12


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayResult:
    """Result of deciding again over a recording."""

    recording: Path
    whole: bool
    library: Path
    behavior: str
    robots: int
    ticks: int
    seconds: float
    decisions: int
    same: int
    differences: Sequence[DecisionDiff]
    changed: list[str]
    former: dict[str, int]


def decide_again(recording: Recording, options: ReplayOptions) -> None:
    """Decide again over a recording, and show where decisions differ; exit with code 1 if any does."""
    result = _decided_again(recording, options)
    if options.as_json:
        names = (each.name for each in fields(result))
        print_json(select_facts(result, *names, differences=[*map(_describe_difference, result.differences)]))
    else:
        _show(result, make_console())
    if result.differences:
        raise typer.Exit(DIFFERENT)


def _decided_again(recording: Recording, options: ReplayOptions) -> ReplayResult:
    ran, where = recording.head.ran, read_recorded_scenario(recording)
    parts = choose_recording_kit(recording, options.kit, where)
    named = options.behavior or ran.behavior
    known, former = _known(ran, where, named, options.library, parts)
    folder = options.library or Path(ran.library)
    asked = (
        named if options.behavior or not ran.sorts or ran.sorts[0] not in known else f"{ran.sorts[0]}/{named}"
    )
    sort = find_behavior_sort(known, asked)
    name = choose_behavior(known[sort], asked and asked.removeprefix(f"{sort}/"), folder)
    bound = (
        parse_bindings(options.bind) if options.bind else dict(ran.binding) if name == ran.behavior else {}
    )
    sorts = [each for each in ran.sorts if each in known and name == ran.behavior]
    rerun = Rerun(
        recording, known, sorts or list_running_sorts(known, sort, name), name, binding=bound, scenario=where
    )
    again = diff_replayed_decisions(rerun)
    times = recording.times
    return ReplayResult(
        recording=recording.path,
        whole=recording.whole,
        library=folder,
        behavior=name,
        robots=len(recording.head.names),
        ticks=recording.ticks,
        seconds=round(float(times[-1] - times[0]) + recording.head.tick_s, 6),
        decisions=again.decisions,
        same=again.same,
        differences=again.differences,
        changed=_changed(ran, known),
        former=former,
    )


def _describe_difference(each: DecisionDiff) -> dict[str, Any]:
    """Describe consecutive ticks in which a robot's states differ from those recorded for `--json`, times rounded."""
    times = {"time_s": round(each.from_s, DIGITS), "until_s": round(each.until_s, DIGITS)}
    decision = DecisionData.from_optional_reason(each.reason)
    return {"robot": each.agent, **times, **select_facts(each, "ticks", "recorded", "now", decision=decision)}


def _known(
    ran: RunInfo, where: Scenario | None, behavior: str | None, library: Path | None, kit: Kit
) -> tuple[Libraries, dict[str, int]]:
    """Load the libraries of all sorts: as they were when recorded, or as they are if a library is named.

    Current libraries are also used if no stored version matches the recording, or another behavior is named.
    """
    folder = library or Path(ran.library)
    if library is None and behavior == ran.behavior:
        with suppress(RunNotReproducible):
            return load_recorded_libraries(where, behavior, folder, kit, ran.automata)
    return load_current_libraries(where, behavior, folder, kit), {}


def _changed(ran: RunInfo, known: Libraries) -> list[str]:
    """Return the names of automata that have changed since the recording."""
    found = []
    for sort, marks in ran.automata.items():
        taught = known[sort].taught if sort in known else {}
        found += [
            name
            for name, mark in marks.items()
            if name not in taught or fingerprint_automaton(taught[name]) != mark
        ]
    return found


def _show(result: ReplayResult, out: Console) -> None:
    differences = result.differences
    if not result.whole:
        out.print(
            "[yellow]It was not closed:[/] what was recorded until then is all there is.", soft_wrap=True
        )
    if result.changed:
        are = "is another" if len(result.changed) == 1 else "are others"
        out.print(f"[dim]{escape(join_names(result.changed))} {are} since it was recorded[/]", soft_wrap=True)
    for name, version in result.former.items():
        out.print(f"[dim]{escape(name)} is another by now: this is its version {version}[/]", soft_wrap=True)
    head = f"{result.behavior} over {format_count(result.ticks, 'tick')} ({result.seconds:.1f} s)"
    if result.robots > 1:
        head += f" of {result.robots} robots"
    if not differences:
        out.print(f"{escape(head)}: [green]every decision as recorded[/]", soft_wrap=True)
        return
    other = result.decisions - result.same
    out.print(
        f"{escape(head)}: [yellow]{other} of {format_count(result.decisions, 'decision')} differ[/], "
        f"in {format_count(len(differences), 'stretch', 'stretches')}",
        soft_wrap=True,
    )
    for each in differences[:MOST_SHOWN]:
        _show_difference(each, out, several=result.robots > 1)
    if len(differences) > MOST_SHOWN:
        out.print(f"\n[dim]and {len(differences) - MOST_SHOWN} more; --json has all[/]")


def _show_difference(each: DecisionDiff, out: Console, *, several: bool) -> None:
    robot = f"robot {each.agent}, " if several else ""
    until = f" to {round_values(each.until_s)}" if each.ticks > 1 else ""
    recorded, now = (" > ".join(path) or "nothing" for path in (each.recorded, each.now))
    said = f"recorded {recorded}, now {now}"
    out.print(f"\n[bold]{robot}{round_values(each.from_s)}{until} s[/]: {escape(said)}", soft_wrap=True)
    if each.reason is not None:
        out.print(f"  [cyan]{escape(each.reason.automaton)}[/]", soft_wrap=True)
        print_decision(each.reason, out)
