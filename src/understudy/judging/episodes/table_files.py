"""Files of tables: CSV and JSON lines, which need nothing, and Parquet, which DuckDB writes."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterator
from pathlib import Path

import msgspec

from understudy.errors import FileError, SettingError, join_names
from understudy.judging.episodes.episode_tables import DataTable
from understudy.judging.episodes.tick_files import FORMAT
from understudy.model.data_frames import Cell
from understudy.storage.atomic_write import (
    UNFINISHED,
    check_file_place,
    convert_os_errors,
    sync_folder,
    write_atomically,
)
from understudy.storage.parquet import LINES, PARQUET, convert_to_parquet, import_duckdb

CSV = ".csv"
WRITING, REMEDY = "writing the table", "name a file in a folder that you may write to"
SUFFIXES = (CSV, LINES, PARQUET)
DUCKDB_TYPES: dict[type, str] = {float: "DOUBLE", int: "BIGINT", str: "VARCHAR", bool: "BOOLEAN"}


def check_table_path(path: Path | str) -> None:
    """Refuse a file that cannot be written as a table, or is there already, before anything is read.

    SettingError is raised for another ending than .csv, .jsonl or .parquet, or if DuckDB is missing for the last, and
    FileError if the file exists or nothing can be written there.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        remedy = "name a file that ends in .csv, .jsonl or .parquet"
        raise SettingError(where="--out", setting=repr(str(path)), problem="is no table", remedy=remedy)
    if suffix == PARQUET:
        import_duckdb(path, where="--out")
    if path.exists():
        remedy = "name another file, or move that one away"
        raise FileError(path=path, place="", problem="is there already", remedy=remedy)
    check_file_place(path, WRITING, remedy=REMEDY)


def write_table(table: DataTable, path: Path | str) -> None:
    """Write a table to a new file that ends in .csv, .jsonl or .parquet.

    In CSV an absent value is an empty cell, in JSON lines and Parquet null. Numbers are written in full precision.
    Kinds and units of readings are metadata of Parquet; the other two have none (`describe_losses`).
    """
    path = Path(path)
    check_table_path(path)
    suffix = path.suffix.lower()
    with convert_os_errors(path, WRITING, remedy=REMEDY):
        if suffix == CSV:
            write_atomically(path, _format_csv(table).encode())
        elif suffix == LINES:
            write_atomically(path, _format_lines(table))
        else:
            _write_parquet(table, path)


def describe_losses(table: DataTable, path: Path | str) -> list[str]:
    """Return sentences about what a file cannot hold of a table."""
    angles = [title for title, each in table.about.items() if each.kind.startswith("toroidal")]
    if not table.about or Path(path).suffix.lower() == PARQUET:
        return []
    circle = (
        f", and that {join_names(angles)} {'is' if len(angles) == 1 else 'are'} on a circle" if angles else ""
    )
    return [f"{Path(path).suffix} has no place for units and kinds of readings{circle}; Parquet has"]


def _format_csv(table: DataTable) -> str:
    text = io.StringIO(newline="")
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(table.columns)
    lines.writerows([_format_cell(cell) for cell in row] for row in _rows(table))
    return text.getvalue()


def _format_cell(cell: Cell) -> Cell:
    """Write truth values as other programs read them; the writer does the rest."""
    return str(cell).lower() if isinstance(cell, bool) else cell


def _format_lines(table: DataTable) -> bytes:
    titles = tuple(table.columns)
    return msgspec.json.Encoder().encode_lines([dict(zip(titles, row, strict=True)) for row in _rows(table)])


def _rows(table: DataTable) -> Iterator[tuple[Cell, ...]]:
    return zip(*table.columns.values(), strict=True)


def _write_parquet(table: DataTable, path: Path) -> None:
    lines = path.with_name(f".{path.name}.{os.getpid()}{LINES}{UNFINISHED}")
    unfinished = path.with_name(f".{path.name}.{os.getpid()}{UNFINISHED}")
    try:
        lines.write_bytes(_format_lines(table))
        convert_to_parquet(
            lines,
            unfinished,
            {title: DUCKDB_TYPES[kind] for title, kind in table.types.items()},
            key="understudy" if table.about else "",
            metadata=msgspec.json.encode({"format": FORMAT, "version": 1, "columns": table.about}).decode(),
        )
        unfinished.replace(path)
        sync_folder(path.parent)
    finally:
        lines.unlink(missing_ok=True)
        unfinished.unlink(missing_ok=True)
