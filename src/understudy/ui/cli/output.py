"""Output of commands as text: tables, counts and progress."""

from __future__ import annotations

from datetime import datetime

from rich import box
from rich.console import Console
from rich.table import Table


def make_console(*, err: bool = False) -> Console:
    """Return the rich console for text on stdout, or on stderr with `err`."""

    class Piped(Console):
        def on_broken_pipe(self) -> None:
            raise  # to where all commands end; rich would end them with an exit code of its own

    return Piped(stderr=err, highlight=False, emoji=False)


def make_table(*columns: str, title: str | None = None) -> Table:
    """Make a table without borders; the prefix # marks columns of numbers, ~ columns of text that may wrap."""
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
