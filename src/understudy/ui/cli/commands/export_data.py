"""Commands `understudy export table` and `export dataset`: write data of lessons and runs for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypeAlias

import typer
from rich.markup import escape

from understudy.addons.bridges.datasets.lerobot import write_lerobot
from understudy.addons.bridges.datasets.minari import write_minari
from understudy.addons.bridges.datasets.new_folder import check_new_folder
from understudy.errors import SettingError
from understudy.judging.record_files import DOCUMENT, TABLE, read_lesson, read_records
from understudy.model.example_frame import list_example_columns
from understudy.records.record import split_episodes
from understudy.records.record_tables import TABLES, DataTable
from understudy.records.table_files import check_table_path, describe_losses, write_table
from understudy.ui.cli.export_options import ExportDatasetOptions, ExportTableOptions
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.output import format_count, make_console

EXAMPLES, TICKS = "examples", "ticks"
LEROBOT, MINARI = "lerobot", "minari"

TableName: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--table",
        metavar="TABLE",
        help="Table: examples, ticks, presses or episodes. By default the examples of a lesson, otherwise ticks.",
        show_default=False,
    ),
]


def export_table(options: ExportTableOptions) -> None:
    """Export the data of a lesson, a session or a run as a table."""
    check_table_path(options.out)
    name, made = _make_table(options.source, options.table)
    write_table(made, options.out)
    losses = describe_losses(made, options.out)
    for sentence in losses:
        typer.echo(f"Note: {sentence}.", err=True)
    if options.as_json:
        facts = {"source": options.source, "table": name, "out": options.out, "rows": made.rows}
        print_json({**facts, "columns": list(made.columns)})
        return
    size = f"{format_count(made.rows, 'row')}, {format_count(len(made.columns), 'column')}"
    make_console().print(
        f"[bold]{name}[/] of {escape(str(options.source))} in {escape(str(options.out))}: {size}",
        soft_wrap=True,
    )


def export_dataset(options: ExportDatasetOptions) -> None:
    """Export runs as a data set of demonstrations."""
    if options.to not in (LEROBOT, MINARI):
        raise SettingError(
            where="--to", setting=repr(options.to), problem="is unknown", remedy=f"give {LEROBOT} or {MINARI}"
        )
    check_new_folder(options.out)
    found = split_episodes(record for source in options.sources for record in read_records(source))
    episodes = found if options.to == LEROBOT else [episode for episode in found if episode.ticks > 1]
    if options.to == LEROBOT:
        write_lerobot(episodes, options.out)
    else:
        write_minari(episodes, options.out)
    ticks, left_out = sum(episode.ticks for episode in episodes), len(found) - len(episodes)
    if options.as_json:
        facts = {"sources": options.sources, "to": options.to, "out": options.out, "episodes": len(episodes)}
        print_json({**facts, "ticks": ticks, "left_out": left_out})
        return
    size = f"{format_count(len(episodes), 'episode')}, {format_count(ticks, 'tick')}"
    rest = f" ({format_count(left_out, 'episode')} of a single tick left out)" if left_out else ""
    make_console().print(f"[bold]{options.to}[/] in {escape(str(options.out))}: {size}{rest}", soft_wrap=True)


def _make_table(source: Path, table: str | None) -> tuple[str, DataTable]:
    """Return the name of the table, and its contents."""
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
    return table, TABLES[table](read_records(source))
