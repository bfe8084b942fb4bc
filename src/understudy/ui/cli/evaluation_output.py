"""The results of `understudy eval`: as JSON, as text, and as tables for papers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import typer
from msgspec import UNSET, UnsetType
from rich.markup import escape

from understudy.judging.raised_range import RaisedRange, describe_raised
from understudy.judging.result_table import Limits, format_cell, format_table
from understudy.ui.cli.output import make_console, make_table

if TYPE_CHECKING:
    from understudy.judging.comparison import Comparison, MetricComparison, SuccessComparison
    from understudy.judging.evaluation import Evaluation
    from understudy.judging.intervals import MedianEstimate


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
    metrics: Mapping[str, float] | UnsetType = UNSET


@dataclass(frozen=True, slots=True)
class EvaluationResult:
    """Results of an evaluation as `--json` prints them; None, NaN or infinite where a value does not apply."""

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
    success_interval: tuple[float, float]
    goal: str | None
    metrics: Mapping[str, MedianEstimate]
    problems: Sequence[str]
    comparison: ComparisonResult | UnsetType = UNSET
    raised: RaisedResult | UnsetType = UNSET


@dataclass(frozen=True, slots=True)
class RaisedResult:
    """Where the flag that counts as success was raised, beside where it was shown, as `--json` prints it.

    Ranges are in the unit of the feature, which is `m` for distances and rad for angles.
    """

    feature: str
    shown: tuple[float, float]
    raised: tuple[float, float] | None
    elsewhere: int
    beyond: int
    text: str


@dataclass(frozen=True, slots=True)
class ComparisonResult:
    """The paired comparison with another behavior as `--json` prints it; differences are the other minus this one."""

    against: str
    success: SuccessComparison
    metrics: Mapping[str, MetricComparison]


def summarize_evaluation(
    judged: Evaluation,
    results: Sequence[WorldRow] | UnsetType,
    *,
    seconds: float,
    comparison: ComparisonResult | UnsetType = UNSET,
) -> EvaluationResult:
    """Summarize an evaluation over all worlds; `seconds` is its computing time (s)."""
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
        success_interval=judged.success_interval,
        goal=judged.goal,
        metrics={name: judged.medians[name] for name in judged.metrics},
        problems=judged.problems,
        comparison=comparison,
        raised=UNSET if judged.raised is None else _make_raised_result(judged.raised),
    )


def _make_raised_result(raised: RaisedRange) -> RaisedResult:
    shown = raised.shown
    return RaisedResult(
        feature=str(shown.feature),
        shown=(shown.low, shown.high),
        raised=raised.find_ends(),
        elsewhere=raised.elsewhere,
        beyond=raised.beyond,
        text=raised.describe(),
    )


def make_world_rows(judged: Evaluation) -> list[WorldRow]:
    """Return the results, one row per world."""
    taught, expert = judged.taught, judged.expert
    columns = [taught.finished, taught.seconds, taught.delivered, taught.gathered]
    if expert is not None:
        columns += [expert.seconds, judged.relative]
    lists = [column.tolist() for column in columns]
    rows = [WorldRow(*row) for row in zip(judged.seeds, *lists, strict=True)]
    if not judged.metrics:
        return rows
    values = {name: column.tolist() for name, column in judged.metrics.items()}
    return [
        replace(row, metrics={name: column[number] for name, column in values.items()})
        for number, row in enumerate(rows)
    ]


def format_results(judged: Evaluation, layout: str, *, each: bool = False) -> str:
    """Format the results as a table in a layout, of all worlds together or with a row for each."""
    if not each:
        return judged.to_table(layout)
    columns = judged.columns
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return format_table(list(columns), [list(row) for row in rows], layout, caption=judged.describe())


def show_results(found: EvaluationResult, watch: str, *, wanted: str | None) -> None:
    """Print results as text, with the command `watch` that runs a world which failed.

    `wanted` is the flag or reading that counted as success. None: the scenario's goal did.
    """
    out, seeds = make_console(), f"{found.seeds[0]}:{found.seeds[1]}"
    ended = "finished in time" if wanted is None else f"{wanted} in time"
    ended = f"it {wanted}:" if wanted is not None and " " in wanted else ended  # a chosen goal is a statement
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
    for name, each in found.metrics.items():
        value = (
            f"{_number(each.median, 2)} (median; 95 % interval {format_cell(Limits(each.low, each.high))})"
        )
        out.print(f"  {escape(name):<19} {escape(value)}", soft_wrap=True)
    if found.raised is not UNSET:
        color = "yellow" if found.raised.elsewhere or found.raised.beyond else "dim"
        out.print(f"  [{color}]{escape(found.raised.text)}[/]", soft_wrap=True)
    elif found.goal is None and wanted is not None:
        out.print(f"  [dim]{escape(describe_raised(wanted, None))}[/]", soft_wrap=True)
    failed = found.failed_seeds
    if failed:
        shown = ", ".join(map(str, failed[:10])) + (" …" if len(failed) > 10 else "")
        out.print(f"  not finished        seeds {shown}")
        out.print(f"[dim]Watch one: {escape(f'{watch} --seed {failed[0]}')}[/]", soft_wrap=True)


def make_comparison_result(found: Comparison, against: str) -> ComparisonResult:
    """Return a paired comparison as `--json` prints it."""
    return ComparisonResult(against, found.success, found.metrics)


def show_comparison(found: Comparison, names: tuple[str, str]) -> None:
    """Print a paired comparison, one line for each result."""
    out = make_console()
    out.print(
        f"[bold]{escape(names[0])}[/] and [bold]{escape(names[1])}[/] in the same worlds", soft_wrap=True
    )
    for name, ran in zip(names, (found.first, found.second), strict=True):
        if raised := describe_raised(ran.flag, ran.raised):
            color = "yellow" if ran.raised is not None and ran.raised.leaves_shown else "dim"
            out.print(f"  [{color}]{escape(f'{name}: {raised}')}[/]", soft_wrap=True)
    for row in found.list_rows()[1]:
        measure, one, other, difference, interval, p, effect, pairs = (format_cell(cell) for cell in row)
        size = f", rank-biserial correlation {effect}" if measure != "success" else ""
        text = f"{one} and {other}, difference {difference} {interval}, p = {p}{size}".replace("p = <", "p <")
        if pairs == "0":
            text = "in no world do both have it"
        out.print(f"  {escape(f'{measure:<19} {text}')}", soft_wrap=True)


PROBLEMS_SHOWN = 3


def show_problems(problems: Sequence[str]) -> None:
    """Print on stderr why values of metrics are absent."""
    for problem in problems[:PROBLEMS_SHOWN]:
        typer.echo(f"Note: {problem}.", err=True)
    if len(problems) > PROBLEMS_SHOWN:
        typer.echo(f"Note: {len(problems)} values are absent in all.", err=True)


def _show_each(rows: Sequence[WorldRow]) -> None:
    columns = {
        "seconds": ("#seconds", 1),
        "expert_seconds": ("#yardstick", 1),
        "delivered": ("#delivered", 0),
    }
    if any(row.gathered for row in rows):
        columns["gathered"] = ("#gathered", 0)
    columns["relative"] = ("#relative", 2)
    columns = {key: shown for key, shown in columns.items() if getattr(rows[0], key) is not UNSET}
    metrics = [] if rows[0].metrics is UNSET else list(rows[0].metrics)
    titles = [title for title, _ in columns.values()] + [f"#{escape(name)}" for name in metrics]
    made = make_table("#seed", "finished", *titles)
    for row in rows:
        ended = "[green]yes[/]" if row.success else "[red]no[/]"
        cells = (_number(getattr(row, key), digits) for key, (_, digits) in columns.items())
        values = [] if row.metrics is UNSET else [_number(row.metrics[name], 2) for name in metrics]
        made.add_row(str(row.seed), ended, *cells, *values)
    make_console().print(made)


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None or value != value else f"{value:.{digits}f}"
