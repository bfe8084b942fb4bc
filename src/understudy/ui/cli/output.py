"""Output of commands: one JSON object with `--json`, otherwise tables and text."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime
from time import perf_counter
from typing import TYPE_CHECKING, Any

from understudy.storage.json_text import format_json

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from understudy.sim.scenario.schema import Scenario


def print_json(result: Any) -> None:
    """Print one result as a JSON object on stdout; absent values are null.

    `result` is plain data or an instance whose fields are printed in order. Raises TypeError unless it encodes to an
    object: objects can gain keys later without breaking programs that read them.
    """
    text = format_json(result)
    if not text.startswith(b"{"):
        raise TypeError(f"a command prints one object, and this is a {type(result).__name__}")
    if sys.stdout is not None:  # it is none where a program was started without
        sys.stdout.flush()
        sys.stdout.buffer.write(text)  # UTF-8, whatever letters the terminal has
        sys.stdout.buffer.flush()


def make_console(*, err: bool = False) -> Console:
    """Return the rich console for text on stdout, or on stderr with `err`."""
    from rich.console import Console

    class Piped(Console):
        def on_broken_pipe(self) -> None:
            raise  # to where all commands end; rich would end them with an exit code of its own

    return Piped(stderr=err, highlight=False, emoji=False)


def make_table(*columns: str, title: str | None = None) -> Table:
    """Make a table without borders; the prefix # marks columns of numbers, ~ columns of text that may wrap."""
    from rich import box
    from rich.table import Table

    made = Table(box=box.SIMPLE_HEAD, title=title, title_justify="left", title_style="bold", pad_edge=False)
    for name in columns:
        numbers, text = name.startswith("#"), name.startswith("~")
        made.add_column(
            name[1:] if numbers or text else name, justify="right" if numbers else "left", no_wrap=not text
        )
    return made


def format_count(number: int, one: str, many: str | None = None) -> str:
    """Return the number with its noun in the singular or plural: '1 example', '3 examples'."""
    return f"{number} {one if number == 1 else many or one + 's'}"


def format_saved_time(saved: datetime | None) -> str:
    """Format a time in the local time zone to the minute; '' for None."""
    return "" if saved is None else f"{saved.astimezone():%Y-%m-%d %H:%M}"


SLOW_S = 2.0


@contextmanager
def show_progress(what: str, *, quiet: bool = False) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar while the block runs; yield a function to call with (done, total).

    While kernels are compiled, it says so, since everything is slower until then.
    """
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from understudy.jit.switch import is_compiling

    out = make_console(err=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=out, transient=True, disable=quiet or not out.is_terminal) as bar:
        task = bar.add_task(what, total=None)

        def report(done: int, total: int) -> None:
            description = f"{what} (slower until the engine is compiled)" if is_compiling() else what
            bar.update(task, description=description, completed=done, total=total)

        yield report


def compile_once(*, learner: bool = False, world: Scenario | None = None, quiet: bool = False) -> None:
    """Compile the kernels that a measurement needs, and say so on stderr if it takes longer than 2 s."""
    out = make_console(err=True)
    out.quiet = quiet
    began = perf_counter()
    with out.status("Compiling once; the next run starts at once …"):
        if learner:
            from understudy.learning.tree_growth import compile_tree_kernels as prepare_learner

            prepare_learner()
        if world is not None:
            from understudy.sim.catalog import compile_world_kernels as prepare_world

            prepare_world(world)
    if perf_counter() - began > SLOW_S:
        out.print(f"[dim]Compiled in {perf_counter() - began:.0f} s; the next run starts at once.[/]")
