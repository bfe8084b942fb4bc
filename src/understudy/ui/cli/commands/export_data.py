"""Command `understudy export data`: write a lesson, journal, recording or trace as a table, or runs as a data set."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from understudy.ui.cli.options import Json

if TYPE_CHECKING:
    from understudy.data.episode import Episode
    from understudy.data.episode_tables import DataTable

EXAMPLES, TICKS = "examples", "ticks"
LEROBOT, MINARI = "lerobot", "minari"


@dataclass(frozen=True, kw_only=True)
class DataExport:
    """The table that was written: its file, its columns and the number of its rows."""

    source: Path
    table: str
    out: Path
    rows: int
    columns: Sequence[str]


@dataclass(frozen=True, kw_only=True)
class DataSetExport:
    """The data set that was written: its format and folder, and how many episodes and ticks it has.

    `left_out` counts the episodes of a single tick, which the format cannot represent.
    """

    sources: Sequence[Path]
    to: str
    out: Path
    episodes: int
    ticks: int
    left_out: int


def export_data(
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar="SOURCE...",
            help="Automaton's document, table of examples, journal, recording or trace; several for a data set.",
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            "--out",
            "-o",
            metavar="FILE",
            help="File to write, ending in .csv, .jsonl or .parquet, or with --to a folder; a new one.",
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
    to: Annotated[
        str | None,
        typer.Option(
            "--to",
            metavar="FORMAT",
            help="Data set of demonstrations: lerobot or minari.",
            show_default=False,
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Export the data of a lesson, a session or a run as a table, or of runs as a data set of demonstrations.

    Lessons and journals have examples; journals, recordings and traces have ticks (states, readings and commands),
    presses and episodes. Parquet needs the extra parquet, as do data sets for LeRobot; those for Minari need the extra
    minari.

    [dim]understudy export data library/goto.json --out goto.csv[/]

    [dim]understudy export data run.jsonl --out ticks.parquet[/]

    [dim]understudy export data drive.mcap --table presses --out presses.csv[/]

    [dim]understudy export data one.mcap two.mcap --to lerobot --out drives[/]
    """
    if to is not None:
        _export_data_set(sources, to, out, table, as_json)
    else:
        _export_table(sources, out, table, as_json)


def _export_table(sources: Sequence[Path], out: Path, table: str | None, as_json: bool) -> None:
    from rich.markup import escape

    from understudy.data.table_files import check_table_path, write_table
    from understudy.errors import SettingError
    from understudy.ui.cli.output import format_count, make_console, print_json

    if len(sources) > 1:
        problem, remedy = "is one source too many for a table", "name one, or give --to for a data set"
        raise SettingError(where="export data", setting=str(sources[1]), problem=problem, remedy=remedy)
    source = sources[0]
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


def _export_data_set(sources: Sequence[Path], to: str, out: Path, table: str | None, as_json: bool) -> None:
    from rich.markup import escape

    from understudy.data.lerobot import write_lerobot
    from understudy.data.minari import write_minari
    from understudy.data.sources import read_episodes
    from understudy.errors import SettingError
    from understudy.ui.cli.output import format_count, make_console, print_json

    if to not in (LEROBOT, MINARI):
        raise SettingError(
            where="--to", setting=repr(to), problem="is unknown", remedy=f"give {LEROBOT} or {MINARI}"
        )
    if table is not None:
        problem, remedy = "does not go with --to, which writes whole episodes", "leave out one of them"
        raise SettingError(where="export data", setting="--table", problem=problem, remedy=remedy)
    found: list[Episode] = [episode for source in sources for episode in read_episodes(source)]
    episodes = found if to == LEROBOT else [episode for episode in found if episode.ticks > 1]
    if to == LEROBOT:
        write_lerobot(episodes, out)
    else:
        write_minari(episodes, out)
    written = DataSetExport(
        sources=sources,
        to=to,
        out=out,
        episodes=len(episodes),
        ticks=sum(episode.ticks for episode in episodes),
        left_out=len(found) - len(episodes),
    )
    if as_json:
        print_json(written)
        return
    size = f"{format_count(written.episodes, 'episode')}, {format_count(written.ticks, 'tick')}"
    rest = (
        f" ({format_count(written.left_out, 'episode')} of a single tick left out)"
        if written.left_out
        else ""
    )
    make_console().print(f"[bold]{to}[/] in {escape(str(out))}: {size}{rest}", soft_wrap=True)


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
