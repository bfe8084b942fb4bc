"""What commands print: one JSON object with --json, tables and text for people otherwise."""

from __future__ import annotations

import sys
from datetime import datetime
from typing import TYPE_CHECKING, Any

import msgspec

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table


def print_json(result: Any) -> None:
    """One result for programs, on stdout; what is absent is null."""
    text = msgspec.json.format(msgspec.json.encode(result), indent=2) + b"\n"
    if sys.stdout is not None:  # it is none where a program was started without
        sys.stdout.flush()
        sys.stdout.buffer.write(text)  # UTF-8, whatever letters the terminal has
        sys.stdout.buffer.flush()


def console(*, err: bool = False) -> Console:
    """Where text for people goes."""
    from rich.console import Console

    class Piped(Console):
        def on_broken_pipe(self) -> None:
            raise  # to where all commands end; rich would end them with an exit code of its own

    return Piped(stderr=err, highlight=False, emoji=False)


def table(*columns: str, title: str | None = None) -> Table:
    """A light table; a column whose name begins with # holds numbers, one that begins with ~ text that may wrap."""
    from rich import box
    from rich.table import Table

    made = Table(box=box.SIMPLE_HEAD, title=title, title_justify="left", title_style="bold", pad_edge=False)
    for name in columns:
        numbers, text = name.startswith("#"), name.startswith("~")
        made.add_column(
            name[1:] if numbers or text else name, justify="right" if numbers else "left", no_wrap=not text
        )
    return made


def count(number: int, one: str, many: str | None = None) -> str:
    """'1 example', '3 examples'."""
    return f"{number} {one if number == 1 else many or one + 's'}"


def when(saved: datetime | None) -> str:
    """A moment in the reader's own time."""
    return "" if saved is None else f"{saved.astimezone():%Y-%m-%d %H:%M}"
