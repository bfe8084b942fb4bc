"""The results of `understudy eval`: as JSON, as text, and as tables for papers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import typer
from rich.markup import escape

from understudy.judging.raised_range import RaisedRange, describe_raised
from understudy.judging.result_table import Limits, format_cell, format_table
from understudy.storage.json_text import select_facts
from understudy.ui.cli.output import make_console, make_table

if TYPE_CHECKING:
    from understudy.judging.comparison import Comparison
    from understudy.judging.evaluation import Evaluation

PROBLEMS_SHOWN = 3


def summarize_evaluation(
    judged: Evaluation,
    *,
    seconds: float,
    each: bool = False,
    compared: Comparison | None = None,
    against: str = "",
) -> dict[str, Any]:
    """Summarize an evaluation over all worlds, as `--json` prints it; `seconds` is its computing time (s).

    With `each` it has a row for every world, and with a comparison its results. Values are None, NaN or infinite where
    they do not apply.
    """
    taught, expert, raised = judged.taught, judged.expert, judged.raised
    times = taught.seconds[taught.finished]
    return {
        **select_facts(judged, "behavior", "world"),
        "seeds": (judged.seeds[0], judged.seeds[-1] + 1),
        "worlds": len(judged.seeds),
        **select_facts(judged, "success", "relative_to_expert"),
        "median_s": float(np.median(times)) if len(times) else None,
        "median_gathered": float(np.median(taught.gathered)),
        "expert_median_s": None if expert is None else float(np.nanmedian(expert.seconds)),
        "failed_seeds": [seed for seed, done in zip(judged.seeds, taught.finished, strict=True) if not done],
        "seconds": round(seconds, 3),
        **({"results": _list_world_rows(judged)} if each else {}),
        **select_facts(judged, "success_interval", "goal"),
        "metrics": {name: judged.medians[name] for name in judged.metrics},
        "problems": judged.problems,
        **({} if compared is None else {"comparison": _describe_comparison(compared, against)}),
        **({} if raised is None else {"raised": _describe_raised_range(raised)}),
    }


def _describe_comparison(compared: Comparison, against: str) -> dict[str, Any]:
    """Describe the paired comparison with another behavior; differences are the other minus this one."""
    return {"against": against, **select_facts(compared, "success", "metrics")}


def _describe_raised_range(raised: RaisedRange) -> dict[str, Any]:
    """Describe where the flag that counts as success was raised, beside where it was shown, in the feature's unit."""
    shown = {"feature": str(raised.shown.feature), "shown": (raised.shown.low, raised.shown.high)}
    found = select_facts(raised, "raised", "elsewhere", "beyond", raised=raised.find_ends())
    return {**shown, **found, "text": raised.describe()}


def _list_world_rows(judged: Evaluation) -> list[dict[str, Any]]:
    """List the results, one row per world, with those of the yardstick where there is one; times in s."""
    taught, expert = judged.taught, judged.expert
    columns = {"success": taught.finished, "seconds": taught.seconds}
    columns |= {"delivered": taught.delivered, "gathered": taught.gathered}
    if expert is not None:
        columns |= {"expert_seconds": expert.seconds, "relative": judged.relative}
    lists = {name: column.tolist() for name, column in columns.items()}
    metrics = {name: column.tolist() for name, column in judged.metrics.items()}
    rows = []
    for number, seed in enumerate(judged.seeds):
        row = {"seed": seed, **{name: column[number] for name, column in lists.items()}}
        own = {"metrics": {name: column[number] for name, column in metrics.items()}} if metrics else {}
        rows.append({**row, **own})
    return rows


def format_results(judged: Evaluation, layout: str, *, each: bool = False) -> str:
    """Format the results as a table in a layout, of all worlds together or with a row for each."""
    if not each:
        return judged.to_table(layout)
    columns = judged.columns
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return format_table(list(columns), [list(row) for row in rows], layout, caption=judged.describe())


def show_results(found: Mapping[str, Any], watch: str, *, wanted: str | None) -> None:
    """Print results as text, with the command `watch` that runs a world which failed.

    `wanted` is the flag or reading that counted as success. None: the scenario's goal did.
    """
    out, (first, end) = make_console(), found["seeds"]
    ended = "finished in time" if wanted is None else f"{wanted} in time"
    ended = f"it {wanted}:" if wanted is not None and " " in wanted else ended  # a chosen goal is a statement
    if found.get("results"):
        _show_each(found["results"])
    worlds = f"{found['worlds']} {found['world']} worlds, seeds {first}:{end}"
    out.print(f"[bold]{found['behavior']}[/] on {worlds}")
    out.print(f"  {ended:<19} [bold]{found['success']:.0%}[/]")
    taken = _number(found["median_s"], 0)
    if found["expert_median_s"] is not None:
        relative, expert = _number(found["relative_to_expert"], 3), found["expert_median_s"]
        out.print(f"  food per second     [bold]{relative}[/] of the yardstick's (median)")
        out.print(f"  time to finish      {taken} s; the yardstick {expert:.0f} s (medians)")
    elif found["median_s"] is not None:
        out.print(f"  time to finish      {taken} s (median)")
    if found["median_gathered"]:
        out.print(f"  boxes gathered      {found['median_gathered']:.0f} (median)")
    for name, each in found["metrics"].items():
        value = (
            f"{_number(each.median, 2)} (median; 95 % interval {format_cell(Limits(each.low, each.high))})"
        )
        out.print(f"  {escape(name):<19} {escape(value)}", soft_wrap=True)
    if raised := found.get("raised"):
        color = "yellow" if raised["elsewhere"] or raised["beyond"] else "dim"
        out.print(f"  [{color}]{escape(raised['text'])}[/]", soft_wrap=True)
    elif found["goal"] is None and wanted is not None:
        out.print(f"  [dim]{escape(describe_raised(wanted, None))}[/]", soft_wrap=True)
    failed = found["failed_seeds"]
    if failed:
        shown = ", ".join(map(str, failed[:10])) + (" …" if len(failed) > 10 else "")
        out.print(f"  not finished        seeds {shown}")
        out.print(f"[dim]Watch one: {escape(f'{watch} --seed {failed[0]}')}[/]", soft_wrap=True)


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


def show_problems(problems: Sequence[str]) -> None:
    """Print on stderr why values of metrics are absent."""
    for problem in problems[:PROBLEMS_SHOWN]:
        typer.echo(f"Note: {problem}.", err=True)
    if len(problems) > PROBLEMS_SHOWN:
        typer.echo(f"Note: {len(problems)} values are absent in all.", err=True)


def _show_each(rows: Sequence[Mapping[str, Any]]) -> None:
    columns = {
        "seconds": ("#seconds", 1),
        "expert_seconds": ("#yardstick", 1),
        "delivered": ("#delivered", 0),
    }
    if any(row["gathered"] for row in rows):
        columns["gathered"] = ("#gathered", 0)
    columns["relative"] = ("#relative", 2)
    columns = {key: shown for key, shown in columns.items() if key in rows[0]}
    metrics = rows[0].get("metrics", ())
    titles = [title for title, _ in columns.values()] + [f"#{escape(name)}" for name in metrics]
    made = make_table("#seed", "finished", *titles)
    for row in rows:
        ended = "[green]yes[/]" if row["success"] else "[red]no[/]"
        cells = (_number(row[key], digits) for key, (_, digits) in columns.items())
        values = (_number(row["metrics"][name], 2) for name in metrics)
        made.add_row(str(row["seed"]), ended, *cells, *values)
    make_console().print(made)


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None or value != value else f"{value:.{digits}f}"
