"""Files of tables: CSV and JSON lines, which need nothing, and Parquet, which DuckDB writes. Those of ticks are read.

Parquet has the kind and unit of each reading. The other two do not: there, texts are labels, and all else numbers.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterator, Mapping, Sequence
from math import nan
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np

from understudy.errors import FileError, SettingError
from understudy.model.data_frames import Cell
from understudy.model.features import parse_reading_label
from understudy.model.value_kinds import Categorical, Column, Continuous, Kind, parse_kind
from understudy.records.header import ReadingInfo
from understudy.records.record import BETWEEN, COMMAND, POSE, READING, Episode, Record
from understudy.records.record_tables import DataTable
from understudy.runtime.body import Channel, Reading
from understudy.storage.atomic_write import (
    UNFINISHED,
    check_file_place,
    convert_os_errors,
    sync_folder,
    write_atomically,
)
from understudy.storage.parquet import LINES, PARQUET, convert_to_parquet, import_duckdb, read_parquet_rows

CSV = ".csv"
WRITING, REMEDY = "writing the table", "name a file in a folder that you may write to"
SUFFIXES = (CSV, LINES, PARQUET)
COLUMNS = ("episode", "agent", "tick", "time_s", "states")
"""The columns that every table of ticks has."""
FORMAT = "understudy ticks"
"""The format that the metadata of Parquet names."""
NO_TABLE = "name a table of ticks that `understudy export table` wrote"
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
    Kinds and units of readings are metadata of Parquet; the other two have none.
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


class TickTable(NamedTuple):
    """The rows of a table of ticks by the titles of their columns, and what is known of readings and commands."""

    rows: list[dict[str, Any]]
    about: Mapping[str, ReadingInfo]


def is_tick_table(path: Path | str) -> bool:
    """Return whether a file begins as a table of ticks does; one that cannot be read does not."""
    path = Path(path)
    try:
        if path.suffix.lower() == PARQUET:
            return set(COLUMNS) <= set(read_parquet_rows(path, limit=0)[1])
        with path.open(encoding="utf-8") as lines:
            first = next(lines, "")
        if path.suffix.lower() == LINES:
            return set(COLUMNS) <= set(msgspec.json.decode(first, type=dict[str, Any]))
        return set(COLUMNS) <= set(next(csv.reader([first]), []))
    except (OSError, UnicodeDecodeError, ValueError, AttributeError, FileError):
        return False


def read_tick_records(path: Path | str) -> list[Record]:
    """Read a record of each episode of a table of ticks; FileError names what of it is none of such a table."""
    path = Path(path)
    table = _read_rows(path)
    of_episodes: dict[tuple[Any, Any], list[dict[str, Any]]] = {}
    for row in table.rows:
        of_episodes.setdefault((row["episode"], row["agent"]), []).append(row)
    readings = _find_readings(table, path)
    try:
        return [
            _make_record(path, str(agent), rows, readings, table.about)
            for (_, agent), rows in of_episodes.items()
        ]
    except (KeyError, TypeError, ValueError) as error:
        problem = f"a row of it is not as tables of ticks have them ({type(error).__name__}: {error})"
        raise FileError(path=path, place="", problem=problem, remedy="restore it") from None


def _read_rows(path: Path) -> TickTable:
    with convert_os_errors(path, "reading the table", remedy=NO_TABLE):
        if path.suffix.lower() == PARQUET:
            cells, titles, metadata = read_parquet_rows(path)
            stored = msgspec.json.decode(metadata) if metadata else {}
            about = msgspec.convert(stored.get("columns", {}), dict[str, ReadingInfo])
            return _check(path, TickTable([dict(zip(titles, row, strict=True)) for row in cells], about))
        if path.suffix.lower() == LINES:
            rows = msgspec.json.Decoder(dict[str, Any]).decode_lines(path.read_bytes())
            return _check(path, TickTable(rows, {}))
        with path.open(encoding="utf-8", newline="") as file:
            whole = [row for row in csv.DictReader(file) if None not in row.values()]
            return _check(path, TickTable(whole, {}))


def _check(path: Path, table: TickTable) -> TickTable:
    missing = [] if not table.rows else [each for each in COLUMNS if each not in table.rows[0]]
    if missing or not table.rows:
        problem = "it has no tick" if not table.rows else f"it has no column {missing[0]!r}"
        raise FileError(path=path, place="", problem=problem, remedy=NO_TABLE)
    return table


def _find_readings(table: TickTable, path: Path) -> dict[str, Reading]:
    """Find the readings by name: as the metadata describe them, or else with labels for texts, and numbers."""
    columns: dict[str, list[str]] = {}
    for title in table.rows[0]:
        if title.startswith(READING):
            columns.setdefault(parse_reading_label(title.removeprefix(READING))[0], []).append(title)
    return {name: _find_reading(table, path, name, titles) for name, titles in columns.items()}


def _find_reading(table: TickTable, path: Path, name: str, titles: Sequence[str]) -> Reading:
    of_targets = any(parse_reading_label(title.removeprefix(READING))[1] is not None for title in titles)
    described = next((table.about[title] for title in titles if title in table.about), None)
    if described is not None:
        kind = parse_kind(described.kind, where=f"{path}: {name}")
        return Reading(name, kind, described.unit, of_targets)
    texts = {str(row[title]) for row in table.rows for title in titles if row[title] not in (None, "")}
    are_numbers = all(_is_number(each) for each in texts)
    return Reading(name, Continuous() if are_numbers else Categorical(tuple(sorted(texts))), "", of_targets)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _make_record(
    path: Path,
    agent: str,
    rows: Sequence[Mapping[str, Any]],
    readings: Mapping[str, Reading],
    about: Mapping[str, ReadingInfo],
) -> Record:
    times = _make_column(rows, "time_s", Continuous())
    steps = np.diff(times)
    channels = [title for title in rows[0] if title.startswith(COMMAND)]
    commands = [_make_column(rows, title, Continuous()) for title in channels]
    keys = {
        parse_reading_label(title.removeprefix(READING)): title
        for title in rows[0]
        if title.startswith(READING)
    }
    unknown = (
        f"{path}: it does not say units and kinds of readings; numbers were taken as distances, not as angles"
    )
    return Record(
        times=times,
        values={key: _make_column(rows, title, readings[key[0]].kind) for key, title in keys.items()},
        commands=np.column_stack(commands) if commands else np.zeros((len(rows), 0)),
        channels=tuple(
            Channel(title.removeprefix(COMMAND), unit=about[title].unit if title in about else "")
            for title in channels
        ),
        readings=tuple(readings.values()),
        targets=tuple(dict.fromkeys(target for _, target in keys if target is not None)),
        tick_s=float(f"{np.median(steps):.6g}") if len(steps) else 1.0,
        episodes=(Episode(path.name, 0, len(rows)),),
        omissions=() if about or not keys else (unknown,),
        states=tuple(tuple(str(row["states"] or "").split(BETWEEN)) if row["states"] else () for row in rows),
        pose={name: _make_column(rows, name, Continuous()) for name in POSE if name in rows[0]},
        agent=agent,
        source=str(path),
    )


def _make_column(rows: Sequence[Mapping[str, Any]], title: str, kind: Kind) -> Column:
    index = {label: float(number) for number, label in enumerate(getattr(kind, "labels", ()))}
    cells = [row.get(title) for row in rows]
    if index:
        return np.array([nan if cell in (None, "") else index[str(cell)] for cell in cells], np.float64)
    return np.array([nan if cell in (None, "") else float(cell) for cell in cells], np.float64)
