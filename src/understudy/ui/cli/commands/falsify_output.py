"""The results of `understudy falsify`: as JSON and as text, and the progress of the search."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Any

from rich.markup import escape
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from understudy.addons.checks.falsification.failing_world import SCENARIO_FILE, FailingWorld
from understudy.storage.json_text import select_facts
from understudy.ui.cli.output import format_count, make_console
from understudy.ui.cli.progress_bar import write_lines

if TYPE_CHECKING:
    from understudy.addons.checks.falsification.falsify import Falsification


@dataclass(frozen=True, slots=True)
class FalsifyResult:
    """The result of a falsification, with the time limit, s.

    `failure` describes the failing world that was kept, as `--json` prints it; None if no world failed. Of a body of
    the user's own, it has no scenario, and a recording.
    """

    behavior: str
    world: str
    limit_s: float
    found: Falsification
    failure: Mapping[str, Any] | None


@contextmanager
def show_search(*, quiet: bool) -> Iterator[Callable[[str, int, int], None]]:
    """Show the runs so far on stderr while the block runs; yield a function to call with (what, runs, failures)."""
    out = make_console(err=True)
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    is_shown, line = out.is_terminal and not quiet, "Starting"
    with (
        Progress(*columns, console=out, transient=True, disable=not is_shown) as bar,
        write_lines(lambda: line, quiet=quiet or is_shown),
    ):
        task = bar.add_task(line, total=None)

        def report(doing: str, runs: int, failed: int) -> None:
            nonlocal line
            line = f"{doing}: {runs} runs, {failed} failed"
            bar.update(task, description=line)

        yield report


def describe_failure(kept: FailingWorld, command: str) -> dict[str, Any]:
    """Describe a failing world that was kept for `--json`; `command` runs it again."""
    names = ("seed", "found_by", "robustness", "wrong_s", "steps", "why")
    facts = select_facts(kept.facts, *names, wrong_s=round(kept.facts.wrong_s, 6))
    places = {"folder": kept.folder, "scenario": kept.folder / SCENARIO_FILE}
    return {**places, **facts, "command": command, "recording": None}


def describe_falsification(result: FalsifyResult) -> dict[str, Any]:
    """Describe a result for `--json`, with the 95 % interval of the share of worlds that fail at random."""
    found, random, directed = result.found, result.found.random, result.found.directed
    low, high = random.interval
    seeds = [seed for _, seed in random.failures]
    near = None
    if directed is not None:
        near = select_facts(directed, "runs", "failed", "nearest", failed=len(directed.failures))
    return {
        **select_facts(result, "behavior", "world", "limit_s"),
        **select_facts(found, "seconds", "interrupted", seconds=round(found.seconds, 3)),
        "random": select_facts(random, "runs", "failed", low=low, high=high, seeds=seeds),
        "directed": near,
        "failure": result.failure,
        "notes": found.notes,
    }


def show_falsification(result: FalsifyResult) -> None:
    """Print the result as text."""
    out, found, random = make_console(), result.found, result.found.random
    if found.interrupted:
        out.print("[yellow]Interrupted; this is what was found until then.[/]")
    low, high = random.interval
    at_most = f"at most {high:.3g} of all worlds at 95 %"
    share = at_most if not random.failed else f"{low:.3g} to {high:.3g} of all worlds at 95 %"
    runs = format_count(random.runs, "world")
    out.print(f"At random: {random.failed} of {runs} failed: {share}", soft_wrap=True)
    if found.directed is not None:
        failed, nearest = len(found.directed.failures), found.directed.nearest
        near = f"; the least robustness was {nearest:.3g}" if nearest < inf else ""
        runs = format_count(found.directed.runs, "world")
        out.print(f"Directed: {failed} of {runs} failed{near}", soft_wrap=True)
    for note in found.notes:
        out.print(f"[dim]No directed search: {escape(note)}[/]", soft_wrap=True)
    failure = result.failure
    if failure is None:
        out.print(
            "[green]No failing world was found.[/] That is no proof that there is none.", soft_wrap=True
        )
        return
    where = failure["scenario"] or f"{result.world} {failure['seed']}"
    out.print(f"\n[bold]{escape(result.behavior)} fails in {escape(str(where))}[/]", soft_wrap=True)
    for sentence in failure["why"]:
        out.print(f"  {escape(sentence)}", soft_wrap=True)
    if failure["steps"]:
        steps = escape(", ".join(failure["steps"]))
        out.print(f"[dim]  Simpler than the world that was found: {steps}.[/]", soft_wrap=True)
    out.print("\nRun it again:", soft_wrap=True)
    out.print(f"  {failure['command']}", markup=False, soft_wrap=True)
