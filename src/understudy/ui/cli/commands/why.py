"""`understudy why`: why a robot of a recorded run did what it did at some moment."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from understudy.ui.cli.options import Json

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rich.console import Console

    from understudy.analysis.explain_run import Level, Reason, Why

MOST_EXAMPLES = 6
NEAR_S = 1e-6
"""Times this near are one."""


def why(
    run: Annotated[Path, typer.Argument(help="What `understudy run` wrote: a trace, or a recording.")],
    time_s: Annotated[float, typer.Option("--time", "-t", min=0, help="The moment, s.")],
    robot: Annotated[int, typer.Option("--agent", "-a", min=0, help="Which robot, from 0.")] = 0,
    library: Annotated[
        Path | None,
        typer.Option(
            "--library", "-l", help="Where the automata are now, if not where they were.", show_default=False
        ),
    ] = None,
    world: Annotated[
        str | None,
        typer.Option("--world", "-w", metavar="SCENARIO", help="The scenario, if its file is elsewhere now."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Say why a robot of a recorded run did what it did: what each level decided, what held, and who showed that.

    The run is made again until then. Where its library has changed since, former versions take their place; where
    none is what was run, that is said, with exit code 1. Of a recording (.mcap), whatever robot it is of, the readings
    are decided on again.

    [dim]understudy run --library demo/library --seed 7 --trace run.jsonl[/]

    [dim]understudy why run.jsonl --time 12.5[/]
    """
    from understudy.ui.cli.output import console, print_json
    from understudy.ui.cli.recordings import is_recording

    if is_recording(run):
        told = _of_recording(run, time_s, robot, library)
    else:
        told = _of_trace(run, time_s, robot, library, world, quiet=as_json)
    if as_json:
        print_json(told)
    else:
        _show(told, console())


def _of_trace(
    run: Path, time_s: float, robot: int, library: Path | None, world: str | None, *, quiet: bool
) -> dict[str, Any]:
    """Of a simulated run, which is made again."""
    from understudy.analysis.explain_run import CannotRepeat
    from understudy.analysis.explain_run import why as reasons
    from understudy.analysis.run_header import recorded, world_mark
    from understudy.ui.cli.library_data import known_then
    from understudy.ui.cli.options import find_kit, find_world
    from understudy.ui.cli.output import compile_once

    found = recorded(run, robot=robot, time_s=time_s)
    how = found.how
    where = find_world(world or how.scenario)
    if world_mark(where) != how.world:
        remedy = "run it again with --trace, or name the scenario as it was with --world"
        raise CannotRepeat(problem=f"the scenario {where.name} is another by now", remedy=remedy)
    parts = find_kit(how.kit, world or how.scenario)
    known, former = known_then(where, how.behavior, library or Path(how.library), parts, how.automata)
    compile_once(world=where, quiet=quiet)
    header, row = found.header, found.row
    run_facts = {"scenario": header.scenario, "seed": header.seed, "robot": row.robot, "doing": row.doing}
    return _facts(run_facts, reasons(found, where, known), former)


def _of_recording(run: Path, time_s: float, robot: int, library: Path | None) -> dict[str, Any]:
    """Of a recording, whose readings are decided on again."""
    from understudy.analysis.replay_diff import why_recorded
    from understudy.analysis.rerun import Rerun
    from understudy.analysis.run_trace import BETWEEN
    from understudy.errors import SettingError
    from understudy.robots.recording.reader import read_recording
    from understudy.ui.cli.library_data import known_then
    from understudy.ui.cli.recordings import kit_for, scenario_of

    recording = read_recording(run)
    ran, names = recording.head.ran, recording.head.names
    if not 0 <= robot < len(names):
        remedy = f"count from 0 to {len(names) - 1}"
        raise SettingError(where=str(run), setting="--agent", problem=f"is {robot}", remedy=remedy)
    if time_s > recording.times[-1] + recording.head.tick_s:
        problem, remedy = f"is {time_s:g}, after the run had ended", f"give at most {recording.times[-1]:g}"
        raise SettingError(where=str(run), setting="--time", problem=problem, remedy=remedy)
    if ran.behavior is None:
        problem, remedy = "ran: a person taught", "give a recording of a run"
        raise SettingError(where=str(run), setting="no automaton", problem=problem, remedy=remedy)
    where = scenario_of(recording)
    folder, parts = library or Path(ran.library), kit_for(recording, None, where)
    known, former = known_then(where, ran.behavior, folder, parts, ran.automata)
    sorts = [each for each in ran.sorts if each in known] or list(known)[:1]
    rerun = Rerun(recording, known, sorts, ran.behavior, binding=ran.binding, scenario=where)
    tick = max(0, int(sum(recording.times <= time_s + NEAR_S)) - 1)
    said = why_recorded(rerun, robot, tick)
    called = names[robot] if where is None else where.name
    doing = BETWEEN.join(recording.paths[robot][tick])
    return _facts({"scenario": called, "seed": ran.seed, "robot": robot, "doing": doing}, said, former)


def _facts(run: dict[str, Any], said: Why, former: Mapping[str, int]) -> dict[str, Any]:
    return {
        **run,
        "time_s": round(said.time_s, 6),
        "decided_s": round(said.decided_s, 6),
        "former": dict(former),
        "switched": said.switched,
        "agents": [
            {
                "sort": each.sort,
                "agent": each.agent,
                "ordered": each.ordered,
                "levels": [_level(level) for level in each.levels],
            }
            for each in said.agents
        ],
        "last_switch": None if said.last is None else reason_facts(said.last),
    }


def _level(level: Level) -> dict[str, Any]:
    return {
        "automaton": level.automaton,
        "state": level.state,
        "since_s": round(level.since_s, 6),
        "decision": None if level.decision is None else reason_facts(level.decision),
        "rests": level.rests or None,
        "entry": None if level.entry is None else reason_facts(level.entry),
    }


def reason_facts(reason: Reason) -> dict[str, Any]:
    """A decision and what was behind it, as plain data."""
    from understudy.model.describe import plain, values

    said, features = reason.explanation, reason.taught.automaton.features
    return {
        "time_s": round(reason.time_s, 6),
        "automaton": reason.automaton,
        "before": said.state,
        "after": said.next,
        "conditions": list(said.conditions),
        "shown": said.shown,
        "values": {
            label: plain(value, bound)
            for bound, (label, value) in zip(features, reason.values.items(), strict=True)
        },
        "read": values(features, list(reason.values.values())),
        "by_hand": reason.taught.lesson is None,
        "examples": [
            {
                "number": example.number,
                "kind": example.kind.value,
                "correction": example.correction,
                "next": example.next,
                "shown_s": reason.moments.get(example.number),
            }
            for example in sorted(said.examples, key=lambda each: (not each.shown, each.number))
        ],
    }


def _show(told: dict[str, Any], out: Console) -> None:
    from rich.markup import escape

    head = f"robot {told['robot']} of {told['scenario']} {told['seed']} at {told['time_s']:g} s"
    out.print(f"[bold]{escape(head)}[/]: {escape(told['doing'] or 'nothing')}", soft_wrap=True)
    for name, version in told["former"].items():
        out.print(f"[dim]{escape(name)} is another by now: this is its version {version}[/]", soft_wrap=True)
    for each in told["agents"]:
        _agent(each, out, several=len(told["agents"]) > 1)
    last = told["last_switch"]
    if not told["switched"] and last is not None:
        out.print(f"\n[bold]The last switch[/], at {last['time_s']:g} s, of {escape(last['automaton'])}")
        show_decision(last, out)


def _agent(each: dict[str, Any], out: Console, *, several: bool) -> None:
    from rich.markup import escape

    if several:
        ordered = each["ordered"]
        under = "" if ordered is None else f", ordered to {ordered}" if ordered else ", without orders"
        out.print(f"\n[bold]{escape(each['sort'])} {each['agent']}[/]{escape(under)}")
    if not each["levels"]:
        out.print("  runs no automaton: nothing is decided", soft_wrap=True)
    for level in each["levels"]:
        since = f"in {level['state']} since {level['since_s']:g} s"
        out.print(f"\n[cyan]{escape(level['automaton'])}[/] {escape(since)}")
        if level["decision"] is None:
            out.print(f"  stays: {escape(level['rests'])}", soft_wrap=True)
        else:
            show_decision(level["decision"], out)


def show_decision(said: dict[str, Any], out: Console) -> None:
    """Print the facts of a decision for people."""
    from rich.markup import escape
    from rich.padding import Padding

    from understudy.model.describe import signed

    stays = said["before"] == said["after"]
    what = f"stays in {said['before']}" if stays else f"goes from {said['before']} to {said['after']}"
    held = signed(" and ".join(said["conditions"]))
    if said["shown"]:
        what += f" because {held}" if held else ", always"
    else:
        what += f": nothing was ever shown where {held}" if held else ": nothing was ever shown there"
    lines = [what, *([f"[dim]it read {escape(said['read'])}[/]"] if said["read"] else [])]
    if said["by_hand"]:
        lines.append("[dim]it was written by hand: no example is behind it[/]")
    elif said["examples"]:
        lines.append(f"shown by {_examples(said['examples'])}")
    lines[0] = escape(lines[0])
    for line in lines:
        out.print(Padding(line, (0, 0, 0, 2), expand=False))


def _examples(rows: list[dict[str, Any]]) -> str:
    """Who showed it: "3 (directive at 12.3 s), 7 (correction at 40.1 s) and 5 more"."""
    from understudy.errors import listed

    named = [_example(row) for row in rows[:MOST_EXAMPLES]]
    more = len(rows) - len(named)
    return listed([*named, f"{more} more"] if more else named)


def _example(row: dict[str, Any]) -> str:
    kind = "correction" if row["correction"] and row["kind"] != "default" else row["kind"]
    when = "" if row["shown_s"] is None else f" at {row['shown_s']:.1f} s"
    return f"{row['number']} ({kind}{when})"
