"""`understudy eval`: how good a taught behavior is, beside the hand-coded yardstick."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import typer

from understudy.cli.parts import LIBRARY, WORLD, Bind, Json, KitName, Library, World

if TYPE_CHECKING:
    from understudy.evaluation import Evaluation

MOST_SEEDS = 1_000_000


def evaluate(
    behavior: Annotated[str, typer.Option("--behavior", help="The behavior to judge.")] = "forage",
    library: Library = LIBRARY,
    world: World = WORLD,
    seeds: Annotated[
        str, typer.Option("--seeds", metavar="A:B", help="One world per seed from A up to, not including, B.")
    ] = "0:100",
    bind: Bind = None,
    kit: KitName = None,
    each: Annotated[bool, typer.Option("--each", help="A row for every world.")] = False,
    as_json: Json = False,
) -> None:
    """Judge a taught behavior on many worlds, beside the hand-coded yardstick on the same ones.

    Success: all food is at the station within three times the yardstick's time.

    [dim]understudy eval --library demo/library --behavior forage --seeds 1000:1100[/]
    """
    from understudy.cli.output import print_json
    from understudy.cli.parts import bindings, find_kit, find_world, opened
    from understudy.cli.progress import compile_once, progress
    from understudy.evaluation import evaluate as judge

    chosen = parse_seeds(seeds)
    where, found = find_world(world), opened(library, find_kit(kit, world))
    compile_once(world=where, quiet=as_json)
    began = perf_counter()
    with progress("Worlds finished", quiet=as_json) as report:
        judged = judge(found.library, behavior, where, chosen, binding=bindings(bind), progress=report)
    facts = result(judged, seconds=perf_counter() - began)
    if as_json:
        print_json({**facts, "results": rows(judged)} if each else facts)
    else:
        _show(facts, rows(judged) if each else [])
    raise typer.Exit(0)


def parse_seeds(text: str) -> range:
    """The seeds that A:B or a single number stands for."""
    from understudy.errors import SettingError

    first, colon, last = text.partition(":")
    if first.isdecimal() and (last.isdecimal() if colon else True):
        seeds = range(int(first), int(last) if colon else int(first) + 1)
        if 0 < len(seeds) <= MOST_SEEDS:
            return seeds
    raise SettingError(
        where="--seeds",
        setting=repr(text),
        problem="is no range of seeds",
        remedy="write A:B with A below B: 0:100",
    )


def result(judged: Evaluation, *, seconds: float) -> dict[str, Any]:
    """An evaluation as plain data."""
    import numpy as np

    taught, expert = judged.taught, judged.expert
    times = taught.seconds[taught.finished]
    return {
        "behavior": judged.behavior,
        "world": judged.world,
        "seeds": [judged.seeds[0], judged.seeds[-1] + 1],
        "worlds": len(judged.seeds),
        "success": judged.success,
        "relative_to_expert": judged.relative_to_expert,
        "median_s": float(np.median(times)) if len(times) else None,
        "expert_median_s": float(np.median(expert.seconds)),
        "failed_seeds": [seed for seed, done in zip(judged.seeds, taught.finished, strict=True) if not done],
        "seconds": round(seconds, 3),
    }


def rows(judged: Evaluation) -> list[dict[str, Any]]:
    """One world each."""
    columns = (judged.taught.seconds, judged.expert.seconds, judged.taught.delivered, judged.relative)
    names = ("seconds", "expert_seconds", "delivered", "relative")
    lists = [column.tolist() for column in columns]
    return [
        {"seed": seed, "success": bool(done), **dict(zip(names, values, strict=True))}
        for seed, done, *values in zip(judged.seeds, judged.taught.finished, *lists, strict=True)
    ]


def _show(facts: dict[str, Any], each: list[dict[str, Any]]) -> None:
    from understudy.cli.output import console, table

    out = console()
    if each:
        made = table("#seed", "finished", "#seconds", "#yardstick", "#delivered", "#relative")
        for row in each:
            ended = "[green]yes[/]" if row["success"] else "[red]no[/]"
            numbers = [_number(row[key], 1) for key in ("seconds", "expert_seconds")]
            made.add_row(
                str(row["seed"]), ended, *numbers, str(row["delivered"]), _number(row["relative"], 2)
            )
        out.print(made)
    seeds = f"{facts['seeds'][0]}:{facts['seeds'][1]}"
    out.print(f"[bold]{facts['behavior']}[/] on {facts['worlds']} {facts['world']} worlds, seeds {seeds}")
    out.print(f"  finished in time    [bold]{facts['success']:.0%}[/]")
    relative, taken = _number(facts["relative_to_expert"], 3), _number(facts["median_s"], 0)
    out.print(f"  food per second     [bold]{relative}[/] of the yardstick's (median)")
    out.print(f"  time to finish      {taken} s; the yardstick {facts['expert_median_s']:.0f} s (medians)")
    failed = facts["failed_seeds"]
    if failed:
        shown = ", ".join(map(str, failed[:10])) + (" …" if len(failed) > 10 else "")
        out.print(f"  not finished        seeds {shown}")
        out.print(f"[dim]Watch one: understudy run --behavior {facts['behavior']} --seed {failed[0]}[/]")


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None or value != value else f"{value:.{digits}f}"
