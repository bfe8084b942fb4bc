"""Files of tables: CSV and JSON lines, which need nothing, and Parquet, which DuckDB writes. Those of ticks are read.

Parquet has the kind and unit of each reading. The other two do not: there, texts are labels, and all else numbers.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import nan
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np

from understudy.errors import FileError, SettingError, join_names
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
LEVEL = "state_"
"""The beginning of the titles of columns with the state of one level."""
JITTER = 2e-4
"""The share of a tick by which its usual length may differ from a plain number."""
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
    omissions: tuple[str, ...] = ()


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
    try:
        readings, tick_s = _find_readings(table, path), _find_tick_s(of_episodes.values())
        return [
            _make_record(path, str(agent), rows, readings, table, tick_s)
            for (_, agent), rows in of_episodes.items()
        ]
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        problem = f"a row of it is not as tables of ticks have them ({type(error).__name__}: {error})"
        raise FileError(path=path, place="", problem=problem, remedy="restore it") from None


def _find_tick_s(episodes: Iterable[Sequence[Mapping[str, Any]]]) -> float:
    """Find the length of a tick, s: what most ticks of the file are apart; times that jitter a little are none more."""
    times = [np.diff(_make_column(rows, "time_s", Continuous())) for rows in episodes]
    steps = np.concatenate(times) if times else np.zeros(0)
    if not len(steps):
        return 1.0
    usual = float(np.median(steps))
    plain = float(f"{usual:.3g}")
    return plain if abs(usual - plain) <= JITTER * usual else float(f"{usual:.6g}")


def _read_rows(path: Path) -> TickTable:
    with convert_os_errors(path, "reading the table", remedy=NO_TABLE):
        if path.suffix.lower() == PARQUET:
            cells, titles, metadata = read_parquet_rows(path)
            stored = msgspec.json.decode(metadata) if metadata else {}
            about = msgspec.convert(stored.get("columns", {}), dict[str, ReadingInfo])
            return _check(path, TickTable([dict(zip(titles, row, strict=True)) for row in cells], about))
        return _check(path, _read_lines(path) if path.suffix.lower() == LINES else _read_csv(path))


def _read_lines(path: Path) -> TickTable:
    """Read a table in JSON lines; a last line without an end, as of a copy that was cut, is left out."""
    whole, _, rest = path.read_bytes().rpartition(b"\n")
    try:
        rows = msgspec.json.Decoder(dict[str, Any]).decode_lines(whole)
    except msgspec.MsgspecError as error:
        problem = f"a line of it cannot be read ({error})"
        raise FileError(path=path, place="", problem=problem, remedy="restore it") from None
    cut = (f"{path}: its last line has no end; left out",) if rest.strip() else ()
    return TickTable(rows, {}, cut)


def _read_csv(path: Path) -> TickTable:
    """Read a table in CSV; rows with too few cells are left out, those with too many are refused."""
    with path.open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        titles = reader.fieldnames or ()
        rows: list[tuple[int, dict[str, Any]]] = []
        short: list[tuple[int, dict[str, Any]]] = []
        for row in reader:
            if None in row:
                problem = f"it has {len(titles) + len(row[None])} cells, and the first line {len(titles)}"
                raise FileError(
                    path=path, place=f"line {reader.line_num}", problem=problem, remedy="restore it"
                )
            (short if None in row.values() else rows).append((reader.line_num, row))
    twice = [title for number, title in enumerate(titles) if title in titles[:number]]
    if twice:
        raise FileError(
            path=path, place="line 1", problem=f"two columns are called {twice[0]!r}", remedy="rename one"
        )
    lines = join_names([str(line) for line, _ in short[:3]])
    lost = (
        f"{path} at line {lines}: {len(short)} of {len(short) + len(rows)} rows have too few cells; left out"
    )
    return TickTable([row for _, row in rows], {}, (lost,) if short else ())


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
    table: TickTable,
    tick_s: float,
) -> Record:
    filled = [title for title in rows[0] if any(row.get(title) not in (None, "") for row in rows)]
    channels = [title for title in filled if title.startswith(COMMAND)]
    commands = [_make_column(rows, title, Continuous()) for title in channels]
    titles = [title for title in rows[0] if title.startswith(READING)]
    keys = {parse_reading_label(title.removeprefix(READING)): title for title in titles}
    unknown = (
        f"{path}: it does not say units and kinds of readings; numbers were taken as distances, not as angles"
    )
    is_known = all(title in table.about for title in titles)
    return Record(
        times=_make_column(rows, "time_s", Continuous()),
        values={key: _make_column(rows, title, readings[key[0]].kind) for key, title in keys.items()},
        commands=np.column_stack(commands) if commands else np.zeros((len(rows), 0)),
        channels=tuple(
            Channel(title.removeprefix(COMMAND), unit=table.about[title].unit if title in table.about else "")
            for title in channels
        ),
        readings=tuple(readings.values()),
        targets=tuple(dict.fromkeys(target for _, target in keys if target is not None)),
        tick_s=tick_s,
        episodes=(Episode(path.name, 0, len(rows)),),
        omissions=(*table.omissions, *(() if is_known else (unknown,))),
        states=tuple(map(_read_states, rows)),
        pose={name: _make_column(rows, name, Continuous()) for name in POSE if name in filled},
        agent=agent,
        source=str(path),
        kinds_known=is_known,
    )


def _read_states(row: Mapping[str, Any]) -> tuple[str, ...]:
    """Read the states of all levels: each from its own column, where there are such columns."""
    levels = [row[title] for title in row if title.startswith(LEVEL)]
    if levels:
        return tuple(str(each) for each in levels if each not in (None, ""))
    return tuple(str(row["states"]).split(BETWEEN)) if row["states"] else ()


def _make_column(rows: Sequence[Mapping[str, Any]], title: str, kind: Kind) -> Column:
    index = {label: float(number) for number, label in enumerate(getattr(kind, "labels", ()))}
    cells = [row.get(title) for row in rows]
    if index:
        return np.array([nan if cell in (None, "") else index[str(cell)] for cell in cells], np.float64)
    return np.array([nan if cell in (None, "") else float(cell) for cell in cells], np.float64)
