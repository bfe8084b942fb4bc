"""Progress bars of commands that run long."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from understudy.jit.switch import is_compiling
from understudy.ui.cli.output import make_console

if TYPE_CHECKING:
    pass


@contextmanager
def show_progress(what: str, *, quiet: bool = False) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar while the block runs; yield a function to call with (done, total).

    While kernels are compiled, it says so, since everything is slower until then.
    """
    out = make_console(err=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=out, transient=True, disable=quiet or not out.is_terminal) as bar:
        task = bar.add_task(what, total=None)

        def report(done: int, total: int) -> None:
            description = f"{what} (slower until the engine is compiled)" if is_compiling() else what
            bar.update(task, description=description, completed=done, total=total)

        yield report
