"""Command `understudy export data`: write a lesson, journal, recording or trace as a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from understudy.ui.cli.options import Json

if TYPE_CHECKING:
    from understudy.data.episode_tables import DataTable

EXAMPLES, TICKS = "examples", "ticks"


@dataclass(frozen=True, kw_only=True)
class DataExport:
    """The table that was written: its file, its columns and the number of its rows."""

    source: Path
    table: str
    out: Path
    rows: int
    columns: Sequence[str]


def export_data(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="SOURCE", help="Automaton's document, table of examples, journal, recording or trace."
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE",
            help="File to write, ending in .csv, .jsonl or .parquet; a new one.",
        ),
    ],
    table: Annotated[
        str | None,
        typer.Option(
            "--table",
            metavar="TABLE",
            help="Table: examples, ticks, presses or episodes. By default the examples of a lesson, otherwise ticks.",
            show_default=False,
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Export the data of a lesson, a session or a run as a table for statistics and other programs.

    Lessons and journals have examples; journals, recordings and traces have ticks (states, readings and commands),
    presses and episodes. Parquet needs the extra parquet.

    [dim]understudy export data library/goto.json --out goto.csv[/]

    [dim]understudy export data run.jsonl --out ticks.parquet[/]

    [dim]understudy export data drive.mcap --table presses --out presses.csv[/]
    """
    from rich.markup import escape

    from understudy.data.table_files import check_table_path, write_table
    from understudy.ui.cli.output import format_count, make_console, print_json

    check_table_path(out)
    name, made = _make_table(source, table)
    write_table(made, out)
    if as_json:
        print_json(DataExport(source=source, table=name, out=out, rows=made.rows, columns=list(made.columns)))
        return
    size = f"{format_count(made.rows, 'row')}, {format_count(len(made.columns), 'column')}"
    make_console().print(
        f"[bold]{name}[/] of {escape(str(source))} in {escape(str(out))}: {size}", soft_wrap=True
    )


def _make_table(source: Path, table: str | None) -> tuple[str, DataTable]:
    """Return the name of the table, and its contents."""
    from understudy.data.episode_tables import TABLES, DataTable
    from understudy.data.sources import DOCUMENT, TABLE, read_episodes, read_lesson
    from understudy.errors import SettingError
    from understudy.model.example_frame import list_example_columns

    is_lesson = source.suffix.lower() in (DOCUMENT, TABLE)
    table = table or (EXAMPLES if is_lesson else TICKS)
    if table == EXAMPLES:
        return table, DataTable(*list_example_columns(read_lesson(source)))
    if table not in TABLES:
        remedy = f"give {', '.join([EXAMPLES, *list(TABLES)[:-1]])} or {list(TABLES)[-1]}"
        raise SettingError(where="--table", setting=repr(table), problem="is unknown", remedy=remedy)
    if is_lesson:
        problem, remedy = (
            f"are not in {source}, which is a lesson",
            "give --table examples, or name a journal or a run",
        )
        raise SettingError(where="--table", setting=table, problem=problem, remedy=remedy)
    return table, TABLES[table](read_episodes(source))
