"""A progress bar on stderr, where someone is looking."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from understudy.sim.scenario.schema import Scenario

SLOW_S = 2.0


@contextmanager
def progress(what: str, *, quiet: bool = False) -> Iterator[Callable[[int, int], None]]:
    """A function to call with how many are done of how many; it shows a bar until the block ends."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from understudy.ui.cli.output import console

    out = console(err=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=out, transient=True, disable=quiet or not out.is_terminal) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def compile_once(*, learner: bool = False, world: Scenario | None = None, quiet: bool = False) -> None:
    """Have compiled what a command is going to need, and say so where that takes its time."""
    from understudy.ui.cli.output import console

    out = console(err=True)
    out.quiet = quiet
    began = perf_counter()
    with out.status("Compiling once; the next run starts at once …"):
        if learner:
            from understudy.learning.tree_growth import prepare as prepare_learner

            prepare_learner()
        if world is not None:
            from understudy.sim.catalog import prepare as prepare_world

            prepare_world(world)
    if perf_counter() - began > SLOW_S:
        out.print(f"[dim]Compiled in {perf_counter() - began:.0f} s; the next run starts at once.[/]")
