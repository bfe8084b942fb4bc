"""The results of `understudy falsify`: as JSON and as text, and the progress of the search."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rich.markup import escape
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from understudy.addons.checks.falsification.failing_world import SCENARIO_FILE, FailingWorld
from understudy.ui.cli.output import format_count, make_console

if TYPE_CHECKING:
    from understudy.addons.checks.falsification.falsify import Falsification


@dataclass(frozen=True, slots=True)
class RandomResult:
    """The search at random as `--json` prints it; `low` and `high` limit the share that fails, at 95 %."""

    runs: int
    failed: int
    low: float
    high: float
    seeds: Sequence[int]


@dataclass(frozen=True, slots=True)
class DirectedResult:
    """The directed search as `--json` prints it; `nearest` is the least robustness."""

    runs: int
    failed: int
    nearest: float | None


@dataclass(frozen=True, slots=True)
class FailureResult:
    """A failing world as `--json` prints it; of a body of one's own, without a scenario and with a recording."""

    folder: str
    scenario: str | None
    seed: int
    found_by: str
    robustness: float
    wrong_s: float | None
    steps: Sequence[str]
    why: Sequence[str]
    command: str
    recording: str | None = None


@dataclass(frozen=True, slots=True)
class FalsifyResult:
    """Result of a falsification as `--json` prints it; None where there was no directed search or no failure."""

    behavior: str
    world: str
    limit_s: float
    seconds: float
    interrupted: bool
    random: RandomResult
    directed: DirectedResult | None
    failure: FailureResult | None
    notes: Sequence[str]


@contextmanager
def show_search(*, quiet: bool) -> Iterator[Callable[[str, int, int], None]]:
    """Show the runs so far on stderr while the block runs; yield a function to call with (what, runs, failures)."""
    out = make_console(err=True)
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=out, transient=True, disable=quiet or not out.is_terminal) as bar:
        task = bar.add_task("Starting", total=None)

        def report(doing: str, runs: int, failed: int) -> None:
            bar.update(task, description=f"{doing}: {runs} runs, {failed} failed")

        yield report


def make_random_result(found: Falsification) -> RandomResult:
    """Return the result of the search at random."""
    low, high = found.random.interval
    return RandomResult(
        found.random.runs, found.random.failed, low, high, [seed for _, seed in found.random.failures]
    )


def make_directed_result(found: Falsification) -> DirectedResult | None:
    """Return the result of the directed search; None if there was none."""
    if found.directed is None:
        return None
    nearest = found.directed.nearest
    return DirectedResult(
        found.directed.runs, len(found.directed.failures), nearest if nearest < float("inf") else None
    )


def make_failure_result(kept: FailingWorld, command: str) -> FailureResult:
    """Return the result about a failing world; `command` runs it again."""
    facts = kept.facts
    return FailureResult(
        folder=str(kept.folder),
        scenario=str(kept.folder / SCENARIO_FILE),
        seed=facts.seed,
        found_by=facts.found_by,
        robustness=facts.robustness,
        wrong_s=round(facts.wrong_s, 6),
        steps=facts.steps,
        why=facts.why,
        command=command,
    )


def show_falsification(result: FalsifyResult) -> None:
    """Print the result as text."""
    out, random = make_console(), result.random
    if result.interrupted:
        out.print("[yellow]Interrupted; this is what was found until then.[/]")
    at_most = f"at most {random.high:.3g} of all worlds at 95 %"
    share = at_most if not random.failed else f"{random.low:.3g} to {random.high:.3g} of all worlds at 95 %"
    runs = format_count(random.runs, "world")
    out.print(f"At random: {random.failed} of {runs} failed: {share}", soft_wrap=True)
    if result.directed is not None:
        nearest = result.directed.nearest
        near = "" if nearest is None else f"; the least robustness was {nearest:.3g}"
        out.print(
            f"Directed: {result.directed.failed} of {format_count(result.directed.runs, 'world')} failed{near}",
            soft_wrap=True,
        )
    for note in result.notes:
        out.print(f"[dim]No directed search: {escape(note)}[/]", soft_wrap=True)
    failure = result.failure
    if failure is None:
        out.print(
            "[green]No failing world was found.[/] That is no proof that there is none.", soft_wrap=True
        )
        return
    where = failure.scenario or f"{result.world} {failure.seed}"
    out.print(f"\n[bold]{escape(result.behavior)} fails in {escape(where)}[/]", soft_wrap=True)
    for sentence in failure.why:
        out.print(f"  {escape(sentence)}", soft_wrap=True)
    if failure.steps:
        out.print(
            f"[dim]  Simpler than the world that was found: {escape(', '.join(failure.steps))}.[/]",
            soft_wrap=True,
        )
    out.print("\nRun it again:", soft_wrap=True)
    out.print(f"  {failure.command}", markup=False, soft_wrap=True)
