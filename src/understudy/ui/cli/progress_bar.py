"""Progress of commands that run long: a bar in a terminal, and now and then a line elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from understudy.clock import REAL_TIME, Clock
from understudy.jit.switch import is_compiling
from understudy.ui.cli.output import make_console

SILENCE_S, LONGEST_SILENCE_S = 2.0, 60.0
"""The times after which the first line is written and, each twice as long as the one before, the last ones, s."""


@contextmanager
def show_progress(
    what: str, *, quiet: bool = False, clock: Clock = REAL_TIME
) -> Iterator[Callable[[int, int], None]]:
    """Show progress on stderr while the block runs; yield a function to call with (done, total).

    In a terminal it is a bar. Elsewhere, as in a pipe, it is a line such as "Tests run: 40 of 200" after 2 s, and then
    after twice as long each, up to 60 s. While kernels are compiled, it says so, since everything is slower until then.
    """
    out = make_console(err=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    is_shown = out.is_terminal and not quiet
    counts: tuple[int, int] | None = None

    def describe() -> str:
        return f"{what} (slower until the engine is compiled)" if is_compiling() else what

    def format_line() -> str:
        return (
            f"{describe()}: still working" if counts is None else f"{describe()}: {counts[0]} of {counts[1]}"
        )

    with (
        Progress(*columns, console=out, transient=True, disable=not is_shown) as bar,
        write_lines(format_line, quiet=quiet or is_shown, clock=clock),
    ):
        task = bar.add_task(what, total=None)

        def report(done: int, total: int) -> None:
            nonlocal counts
            counts = done, total
            bar.update(task, description=describe(), completed=done, total=total)

        yield report


@contextmanager
def write_lines(format_line: Callable[[], str], *, quiet: bool, clock: Clock = REAL_TIME) -> Iterator[None]:
    """Write how far the block is to stderr while it runs: after 2 s of silence, and then less and less often."""
    if quiet:
        yield
        return
    ended, stream = Event(), sys.stderr

    def write() -> None:
        silence_s = SILENCE_S
        while not clock.wait(ended, silence_s):
            try:
                print(format_line(), file=stream, flush=True)
            except (OSError, ValueError):  # nobody reads it any more
                return
            silence_s = min(2 * silence_s, LONGEST_SILENCE_S)

    writer = Thread(target=write, name="progress", daemon=True)
    writer.start()
    try:
        yield
    finally:
        ended.set()
        writer.join()
