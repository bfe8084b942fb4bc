"""Readers of tables: CSV files, JSON lines whose objects are rows, and Parquet.

A row that cannot be read is left out, and a sentence says so. `recording_readers` has the reader of each kind of file.
"""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from understudy.addons.recordings.mapping_file import RecordingMap
from understudy.addons.recordings.recorded_bytes import open_decompressed, read_text
from understudy.addons.recordings.recorded_table import RecordedTable
from understudy.addons.recordings.table_cells import is_number
from understudy.errors import FileError
from understudy.extras import format_install_command

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}
COMMENT = "#"
LONGEST_LIST = 4096
"""The largest number of elements of a list in a cell that become columns of their own."""
REMEDY = "give a CSV file, JSON lines or Parquet"


def read_csv(path: Path | str, mapping: RecordingMap | None = None) -> RecordedTable:
    """Read a CSV file, whose first row names the columns.

    Columns are separated by commas, semicolons, tabs or bars, whichever the first rows agree on; where these are not
    commas, a number may have a decimal comma. Lines that begin with # are comments.
    """
    path, omissions = Path(path), list[str]()
    lines = read_text(path, omissions, remedy=REMEDY).splitlines()
    separator = _find_separator(lines)
    try:
        rows = list(_split_lines(lines, separator))
    except csv.Error as error:
        raise FileError(path=path, place="", problem=f"it cannot be read ({error})", remedy=REMEDY) from None
    if not rows:
        raise FileError(path=path, place="", problem="it is empty", remedy="give a table of a drive")
    names, rest = _find_header(path, lines, rows, separator)
    if separator != ",":
        omissions.append(f"{path}: its columns are separated by {SEPARATORS[separator]}")
    width = len(names)
    if width > 1 and not names[-1] and all(len(row) < width or not row[width - 1] for _, row in rest):
        names, width = names[:-1], width - 1  # a separator at the end of each line
    cells, numbers = [], []
    for line, row in rest:
        complete = row[:-1] if len(row) == width + 1 and not row[-1] else row
        if complete == names:
            omissions.append(f"{path} at line {line}: it has the names of the columns again; left out")
        elif len(complete) == width:
            cells.append(complete)
            numbers.append(line)
        else:
            end = "the file ends in the middle of it" if line == rest[-1][0] else "it is left out"
            omissions.append(f"{path} at line {line}: {len(row)} cells instead of {width}; {end}")
    if separator != ",":
        _convert_decimal_commas(path, cells, omissions)
    return RecordedTable(path, _tell_apart(names), numbers, cells, omissions)


def _find_separator(lines: Sequence[str]) -> str:
    """Return the separator by which most of the first lines have as many cells as the first one, and more than one."""
    begin = [each for each in lines[:200] if each.strip() and not each.lstrip().startswith(COMMENT)][:50]
    if not begin:
        return ","

    def measure_agreement(separator: str) -> tuple[float, int]:
        counts = [len(row) for row in csv.reader(begin, delimiter=separator)]
        common, times = Counter(counts).most_common(1)[0]
        return (times / len(counts) if common > 1 and counts[0] > 1 else 0.0), common

    return max(SEPARATORS, key=measure_agreement)


def _split_lines(lines: Sequence[str], separator: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the cells of each row with the number of its line; comments and empty lines are left out."""
    plain = ("" if each.lstrip().startswith(COMMENT) else each for each in lines)
    reader = csv.reader((f"{each}\n" for each in plain), delimiter=separator)
    for row in reader:
        if row and any(row):
            yield reader.line_num, [cell.strip() for cell in row]


def _find_header(
    path: Path, lines: Sequence[str], rows: list[tuple[int, list[str]]], separator: str
) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Return the names of the columns, from the first row or from a comment before it, and the other rows."""
    (line, first), *rest = rows
    if not all(map(is_number, first)):
        return first, rest
    for before in reversed(lines[: line - 1]):
        names = next(csv.reader([before.strip().lstrip(COMMENT)], delimiter=separator), [])
        if len(names) == len(first):
            return [name.strip() for name in names], rows
    raise FileError(
        path=path,
        place=f"line {line}",
        problem="it has numbers, and not the names of the columns",
        remedy="write the names of the columns as the first line",
    )


def _tell_apart(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of columns; those that occur twice get the number of their column, from 1."""
    counts = Counter(names)
    return tuple(
        f"{name} (column {number})" if counts[name] > 1 or not name else name
        for number, name in enumerate(names, 1)
    )


def _convert_decimal_commas(path: Path, cells: list[list[str]], omissions: list[str]) -> None:
    """Write points for the commas of numbers such as 0,5, in place."""
    converted = 0
    for row in cells:
        for at, cell in enumerate(row):
            if "," in cell and is_number(point := cell.replace(",", ".")):
                row[at] = point
                converted += 1
    if converted:
        omissions.append(f"{path}: {converted} numbers such as 0,5 were read with a decimal comma")


def read_json_lines(path: Path | str, mapping: RecordingMap | None = None) -> RecordedTable:
    """Read JSON lines: an object in each, whose nested keys are columns such as pose.x, and elements scan.0."""
    path, omissions = Path(path), list[str]()
    lines = read_text(path, omissions, remedy=REMEDY).splitlines()
    rows: list[dict[str, Any]] = []
    numbers: list[int] = []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            value = json.loads(line)
        except (ValueError, RecursionError):
            value = None
        if isinstance(value, dict):
            rows.append(value)
            numbers.append(number)
        else:
            end = "the file ends in the middle of it" if number == len(lines) else "it is left out"
            omissions.append(f"{path} at line {number}: no JSON object; {end}")
    if not rows:
        raise FileError(
            path=path, place="", problem="no line has a JSON object", remedy="give JSON lines of a drive"
        )
    return _make_table(path, rows, numbers, omissions)


def read_parquet(path: Path | str, mapping: RecordingMap | None = None) -> RecordedTable:
    """Read a Parquet file; its rows count as lines, from 1, and nested columns are called as in JSON lines."""
    path = Path(path)
    try:
        duckdb = import_module("duckdb")
    except ImportError:
        raise FileError(
            path=path,
            place="",
            problem="it is Parquet, which needs DuckDB",
            remedy=format_install_command("parquet"),
        ) from None
    try:
        with (
            open_decompressed(path, remedy=REMEDY) as plain,
            duckdb.connect() as database,
            plain.open("rb"),
        ):
            result = database.execute("SELECT * FROM read_parquet(?)", [str(plain)])
            names = [each[0] for each in result.description]
            cells = result.fetchall()
    except (OSError, duckdb.Error) as error:
        gone = isinstance(error, FileNotFoundError)
        problem = "there is no such file" if gone else f"it cannot be read ({error})"
        raise FileError(path=path, place="", problem=problem, remedy=REMEDY) from None
    if not any(isinstance(cell, (list, tuple, dict)) for row in cells[:1000] for cell in row):
        return RecordedTable(path, tuple(names), range(1, len(cells) + 1), cells, [])
    rows = [dict(zip(names, row, strict=True)) for row in cells]
    return _make_table(path, rows, range(1, len(rows) + 1), [])


def _make_table(
    path: Path, rows: Sequence[Mapping[str, Any]], numbers: Sequence[int], omissions: list[str]
) -> RecordedTable:
    """Make a table of rows whose values may be nested."""
    flat = [dict(_flatten(row)) for row in rows]
    header = tuple(dict.fromkeys(key for row in flat for key in row))
    return RecordedTable(path, header, numbers, [[row.get(key) for key in header] for row in flat], omissions)


def _flatten(content: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of an object by path, with dots between keys and numbers of elements."""
    for key, value in content.items():
        if isinstance(value, dict):
            yield from _flatten(value, f"{prefix}{key}.")
        elif isinstance(value, (list, tuple)):
            elements = {str(index): each for index, each in enumerate(value[:LONGEST_LIST])}
            yield from _flatten(elements, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value
