"""Output of commands as text: tables, counts and progress."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import datetime

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

WIDEST = 10_000
INDENT = "    "


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


def print_table(out: Console, made: Table, *, lead: int = 1) -> None:
    """Print a table; where it is wider than the terminal, each row as a paragraph, in which no word is broken.

    Parameters
    ----------
    out
        Where to print.
    made
        The table.
    lead
        How many of its columns begin a paragraph, without their headings.
    """
    if out.measure(made, options=out.options.update(width=WIDEST)).maximum <= out.width:
        out.print(made)
        return
    heads = [str(column.header) for column in made.columns]
    for row in zip(*(column.cells for column in made.columns), strict=True):
        cells = [Text.from_markup(str(cell)) for cell in row]
        out.print(Text("  ").join(cell for cell in cells[:lead] if cell), style="bold", soft_wrap=True)
        facts = [
            f"{head} {cell.plain}" for head, cell in zip(heads[lead:], cells[lead:], strict=True) if cell
        ]
        for line in join_lines(facts, out.width - len(INDENT)):
            out.print(INDENT + line, markup=False, soft_wrap=True)


def join_lines(parts: Iterable[str], width: int) -> list[str]:
    """Join parts by commas to lines of at most a width, without breaking a part; one that is longer has its own."""
    lines: list[str] = []
    for part in parts:
        if lines and len(lines[-1]) + len(part) + 3 <= width:
            lines[-1] += f", {part}"
        else:
            if lines:
                lines[-1] += ","
            lines.append(part)
    return lines


def format_count(number: int, one: str, many: str | None = None) -> str:
    """Return the number with its noun in the singular or plural: '1 example', '3 examples'."""
    return f"{number} {one if number == 1 else many or one + 's'}"


def format_saved_time(saved: datetime | None) -> str:
    """Format a time in the local time zone to the minute; '' for None."""
    return "" if saved is None else f"{saved.astimezone():%Y-%m-%d %H:%M}"
