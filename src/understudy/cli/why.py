"""`understudy why`: why a robot of a recorded run did what it did at some moment."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from understudy.cli.parts import Json

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rich.console import Console

    from understudy.model.kit import Kit
    from understudy.model.library import Library, Taught
    from understudy.review.recorded import How, Recorded
    from understudy.review.why import Level, Reason, Why
    from understudy.worlds.scenario import Scenario
    from understudy.worlds.teams import Libraries

MOST_EXAMPLES = 6


def why(
    run: Annotated[Path, typer.Argument(help="The trace that `understudy run --trace` wrote.")],
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
    none is what was run, that is said, with exit code 1.

    [dim]understudy run --library demo/library --seed 7 --trace run.jsonl[/]

    [dim]understudy why run.jsonl --time 12.5[/]
    """
    from understudy.cli.output import console, print_json
    from understudy.cli.parts import find_kit, find_world
    from understudy.cli.progress import compile_once
    from understudy.review.recorded import recorded, world_mark
    from understudy.review.why import CannotRepeat
    from understudy.review.why import why as reasons

    found = recorded(run, robot=robot, time_s=time_s)
    how = found.how
    where = find_world(world or how.scenario)
    if world_mark(where) != how.world:
        remedy = "run it again with --trace, or name the scenario as it was with --world"
        raise CannotRepeat(problem=f"the scenario {where.name} is another by now", remedy=remedy)
    parts = find_kit(how.kit, world or how.scenario)
    known, former = _known(how, where, library or Path(how.library), parts)
    compile_once(world=where, quiet=as_json)
    told = _facts(found, reasons(found, where, known), former)
    if as_json:
        print_json(told)
    else:
        _show(told, console())


def _known(how: How, where: Scenario, folder: Path, kit: Kit) -> tuple[Libraries, dict[str, int]]:
    """What everybody knew when the run was made, and the number of the former version of each automaton that is
    another by now; CannotRepeat where one is gone.
    """
    from understudy.cli.parts import team_for
    from understudy.worlds.teams import folders_of

    known = dict(team_for(where, how.behavior, folder, kit))
    folders = {name: place for name, (place, _) in folders_of(where, folder, kit).items()}
    former: dict[str, int] = {}
    for sort, automata in how.automata.items():
        place = folders.get(sort, folder / sort)
        for name, mark in automata.items():
            library, version = _as_it_was(known[sort], place, name, mark)
            if version is not None:
                known = {each: library if it is known[sort] else it for each, it in known.items()}
                former[name] = version
    return known, former


def _as_it_was(library: Library, place: Path, name: str, mark: str) -> tuple[Library, int | None]:
    """The library with an automaton as its mark says, and which former version that is; None where it still is so."""
    from understudy.cli.parts import learner
    from understudy.errors import UnderstudyError
    from understudy.model.fingerprint import fingerprint
    from understudy.model.folder import load_version, versions
    from understudy.review.why import CannotRepeat

    now = library.taught.get(name)
    if now is not None and fingerprint(now) == mark:
        return library, None
    for version in reversed(versions(place, name)):
        try:
            taught: Taught = load_version(place, name, version.number, library.kit, learner()).taught
        except UnderstudyError:
            continue  # of another kit, or damaged: it is none of what was run, as far as anybody can tell
        if fingerprint(taught) == mark:
            return library.with_taught(taught), version.number
    problem = f"{name} in {place} {'is another by now' if now else 'is gone'}, and no former version is what was run"
    raise CannotRepeat(problem=problem, remedy="run it again with --trace, and ask that")


def _facts(found: Recorded, said: Why, former: Mapping[str, int]) -> dict[str, Any]:
    return {
        "scenario": found.header.scenario,
        "seed": found.header.seed,
        "robot": found.row.robot,
        "time_s": said.time_s,
        "decided_s": round(said.decided_s, 6),
        "doing": found.row.doing,
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
    from understudy.desk.words import values
    from understudy.model.account import plain

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

    from understudy.desk.words import signed

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
