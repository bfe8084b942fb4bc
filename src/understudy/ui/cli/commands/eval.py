"""Command `understudy eval`: measure the success rate and the speed of a behavior."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer
from msgspec import UNSET, UnsetType

from understudy.ui.cli.options import (
    LIBRARY,
    WORLD,
    BehaviorName,
    Bind,
    Json,
    KitName,
    LibraryOption,
    SameWorld,
    ScenarioName,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from understudy.analysis.evaluation import Evaluation

MOST_SEEDS = 1_000_000


def evaluate_behavior(
    scenario: ScenarioName = None,
    behavior: BehaviorName = None,
    library: LibraryOption = LIBRARY,
    world: SameWorld = None,
    seeds: Annotated[
        str,
        typer.Option("--seeds", metavar="A:B", help="Seeds of the worlds, from A up to but not including B."),
    ] = "0:100",
    bind: Bind = None,
    kit: KitName = None,
    each: Annotated[bool, typer.Option("--each", help="Print one row per world.")] = False,
    as_json: Json = False,
) -> None:
    """Evaluate a behavior in many worlds of a scenario; all its robots run it.

    A world is a success if the behavior raises its flag done, or its only one, within the scenario's time limit. A
    behavior without such a flag has to reach the scenario's goal by then. Where there is a hand-written controller to
    compare with, as for foraging by a single robot, the limit is three times its time in the same world.

    [dim]understudy eval --library demo/library --behavior forage --seeds 1000:1100[/]

    [dim]understudy eval arena --library mine --behavior goto --bind A=red_flag[/]
    """
    from understudy.analysis.evaluate import evaluate, make_evaluation_task
    from understudy.ui.cli.options import assign_run, choose_scenario_name, find_kit, open_scenario
    from understudy.ui.cli.output import print_json, show_progress

    chosen, named = parse_seeds(seeds), choose_scenario_name(scenario, world)
    where, parts = open_scenario(named), find_kit(kit, named)
    assigned = assign_run(where, behavior, library, parts, bind)
    ran, bound = f"{assigned.sort}/{assigned.behavior}", assigned.binding
    make_evaluation_task(assigned.libraries, ran, where, binding=bound)  # mistakes are told at once
    began = perf_counter()
    with show_progress("Worlds run", quiet=as_json) as report:
        judged = evaluate(assigned.libraries, ran, where, chosen, binding=bound, progress=report)
    results = make_world_rows(judged) if each else UNSET
    found = summarize_evaluation(judged, results, seconds=perf_counter() - began)
    if as_json:
        print_json(found)
    else:
        watch = format_run_command(named, behavior or assigned.behavior, library, bind=bind or [], kit=kit)
        _show(found, watch, flag=judged.flag)
    raise typer.Exit(0)


def parse_seeds(text: str) -> range:
    """Return the seeds named by A:B (B excluded) or by a single number."""
    from understudy.errors import SettingError

    first, colon, last = text.partition(":")
    if first.isdecimal() and (last.isdecimal() if colon else True):
        seeds = range(int(first), int(last) if colon else int(first) + 1)
        if 0 < len(seeds) <= MOST_SEEDS:
            return seeds
    raise SettingError(
        where="--seeds",
        setting=repr(text),
        problem="is not a range of seeds",
        remedy="write A:B with A below B: 0:100",
    )


@dataclass(frozen=True, slots=True)
class WorldRow:
    """Result in one world, with that of the yardstick where there is one; times in s."""

    seed: int
    success: bool
    seconds: float
    delivered: float
    gathered: float
    expert_seconds: float | UnsetType = UNSET
    relative: float | UnsetType = UNSET


@dataclass(frozen=True, slots=True)
class EvaluationResult:
    """Results of an evaluation as `--json` prints them; None or NaN where a value does not apply."""

    behavior: str
    world: str
    seeds: tuple[int, int]
    worlds: int
    success: float
    relative_to_expert: float
    median_s: float | None
    median_gathered: float
    expert_median_s: float | None
    failed_seeds: list[int]
    seconds: float
    results: Sequence[WorldRow] | UnsetType


def summarize_evaluation(
    judged: Evaluation, results: Sequence[WorldRow] | UnsetType, *, seconds: float
) -> EvaluationResult:
    """Summarize an evaluation over all worlds; `seconds` is its computing time (s)."""
    import numpy as np

    taught, expert = judged.taught, judged.expert
    times = taught.seconds[taught.finished]
    return EvaluationResult(
        behavior=judged.behavior,
        world=judged.world,
        seeds=(judged.seeds[0], judged.seeds[-1] + 1),
        worlds=len(judged.seeds),
        success=judged.success,
        relative_to_expert=judged.relative_to_expert,
        median_s=float(np.median(times)) if len(times) else None,
        median_gathered=float(np.median(taught.gathered)),
        expert_median_s=None if expert is None else float(np.nanmedian(expert.seconds)),
        failed_seeds=[seed for seed, done in zip(judged.seeds, taught.finished, strict=True) if not done],
        seconds=round(seconds, 3),
        results=results,
    )


def make_world_rows(judged: Evaluation) -> list[WorldRow]:
    """Return the results, one row per world."""
    taught, expert = judged.taught, judged.expert
    columns = [taught.finished, taught.seconds, taught.delivered, taught.gathered]
    if expert is not None:
        columns += [expert.seconds, judged.relative]
    lists = [column.tolist() for column in columns]
    return [WorldRow(*row) for row in zip(judged.seeds, *lists, strict=True)]


def format_run_command(
    world: str, behavior: str, library: Path, *, bind: Sequence[str] = (), kit: str | None = None
) -> str:
    """Return the shell command that runs a behavior as it was evaluated, without the seed."""
    words = ["understudy", "run", *([] if world == WORLD else [world]), "--behavior", behavior]
    words += [] if library == LIBRARY else ["--library", str(library)]
    words += [] if kit is None else ["--kit", kit]
    for pair in bind:
        words += ["--bind", pair]
    return shlex.join(words)


def _show(found: EvaluationResult, watch: str, *, flag: str | None) -> None:
    from rich.markup import escape

    from understudy.ui.cli.output import make_console

    out, seeds = make_console(), f"{found.seeds[0]}:{found.seeds[1]}"
    ended = "finished in time" if flag is None else f"{flag} in time"
    if found.results:
        _show_each(found.results)
    out.print(f"[bold]{found.behavior}[/] on {found.worlds} {found.world} worlds, seeds {seeds}")
    out.print(f"  {ended:<19} [bold]{found.success:.0%}[/]")
    taken = _number(found.median_s, 0)
    if found.expert_median_s is not None:
        relative, expert = _number(found.relative_to_expert, 3), found.expert_median_s
        out.print(f"  food per second     [bold]{relative}[/] of the yardstick's (median)")
        out.print(f"  time to finish      {taken} s; the yardstick {expert:.0f} s (medians)")
    elif found.median_s is not None:
        out.print(f"  time to finish      {taken} s (median)")
    if found.median_gathered:
        out.print(f"  boxes gathered      {found.median_gathered:.0f} (median)")
    failed = found.failed_seeds
    if failed:
        shown = ", ".join(map(str, failed[:10])) + (" …" if len(failed) > 10 else "")
        out.print(f"  not finished        seeds {shown}")
        out.print(f"[dim]Watch one: {escape(f'{watch} --seed {failed[0]}')}[/]", soft_wrap=True)


def _show_each(rows: Sequence[WorldRow]) -> None:
    from understudy.ui.cli.output import make_console, make_table

    columns = {
        "seconds": ("#seconds", 1),
        "expert_seconds": ("#yardstick", 1),
        "delivered": ("#delivered", 0),
    }
    if any(row.gathered for row in rows):
        columns["gathered"] = ("#gathered", 0)
    columns["relative"] = ("#relative", 2)
    columns = {key: shown for key, shown in columns.items() if getattr(rows[0], key) is not UNSET}
    made = make_table("#seed", "finished", *(title for title, _ in columns.values()))
    for row in rows:
        ended = "[green]yes[/]" if row.success else "[red]no[/]"
        cells = (_number(getattr(row, key), digits) for key, (_, digits) in columns.items())
        made.add_row(str(row.seed), ended, *cells)
    make_console().print(made)


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None or value != value else f"{value:.{digits}f}"
