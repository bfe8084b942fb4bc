"""Commands `understudy export table` and `export dataset`: write data of lessons and runs for other programs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, TypeAlias

import typer
from rich.markup import escape

from understudy.addons.bridges.datasets.lerobot import write_lerobot
from understudy.addons.bridges.datasets.minari import write_minari
from understudy.addons.bridges.datasets.new_folder import check_new_folder
from understudy.errors import SettingError
from understudy.judging.record_files import DOCUMENT, TABLE, read_lesson
from understudy.model.example_frame import list_example_columns
from understudy.records.record import Record, split_episodes
from understudy.records.record_losses import describe_losses
from understudy.records.record_tables import TABLES, DataTable
from understudy.records.table_files import check_table_path, is_tick_table, write_table
from understudy.ui.cli.export_options import ExportDatasetOptions, ExportTableOptions
from understudy.ui.cli.json_output import print_json
from understudy.ui.cli.output import format_count, make_console
from understudy.ui.cli.recorded_runs import read_run

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
    name, made, losses = _make_table(options.source, options.table, options.out)
    write_table(made, options.out)
    _say_losses(options.out, losses)
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
    found = split_episodes(record for source in options.sources for record in read_run(source))
    episodes = found if options.to == LEROBOT else [episode for episode in found if episode.ticks > 1]
    if options.to == LEROBOT:
        write_lerobot(episodes, options.out)
    else:
        write_minari(episodes, options.out)
    _say_losses(options.out, [*_list_omissions(found), *describe_losses(episodes, options.to)])
    ticks, left_out = sum(episode.ticks for episode in episodes), len(found) - len(episodes)
    if options.as_json:
        facts = {"sources": options.sources, "to": options.to, "out": options.out, "episodes": len(episodes)}
        print_json({**facts, "ticks": ticks, "left_out": left_out})
        return
    size = f"{format_count(len(episodes), 'episode')}, {format_count(ticks, 'tick')}"
    rest = f" ({format_count(left_out, 'episode')} of a single tick left out)" if left_out else ""
    make_console().print(f"[bold]{options.to}[/] in {escape(str(options.out))}: {size}{rest}", soft_wrap=True)


def _make_table(source: Path, table: str | None, out: Path) -> tuple[str, DataTable, list[str]]:
    """Return the name of the table, its contents, and what its file cannot hold."""
    is_lesson = source.suffix.lower() == DOCUMENT or (
        source.suffix.lower() == TABLE and not is_tick_table(source)
    )
    table = table or (EXAMPLES if is_lesson else TICKS)
    if table == EXAMPLES:
        return table, DataTable(*list_example_columns(read_lesson(source))), []
    if table not in TABLES:
        remedy = f"give {', '.join([EXAMPLES, *list(TABLES)[:-1]])} or {list(TABLES)[-1]}"
        raise SettingError(where="--table", setting=repr(table), problem="is unknown", remedy=remedy)
    if is_lesson:
        problem, remedy = (
            f"are not in {source}, which is a lesson",
            "give --table examples, or name a journal or a run",
        )
        raise SettingError(where="--table", setting=table, problem=problem, remedy=remedy)
    records = read_run(source)
    losses = describe_losses(records, out.suffix.lower().removeprefix(".")) if table == TICKS else []
    return table, TABLES[table](records), [*_list_omissions(records), *losses]


def _list_omissions(records: Sequence[Record]) -> list[str]:
    return list(dict.fromkeys(each for record in records for each in record.omissions))


def _say_losses(out: Path, losses: Sequence[str]) -> None:
    for sentence in losses:
        typer.echo(f"Note: {sentence if ': ' in sentence else f'{out}: {sentence}'}.", err=True)
