"""Tables of recordings: CSV files, JSON lines whose objects are rows, and Parquet.

A row that cannot be read is left out, and a cell that is no number is absent. A sentence says so, with the place.
`recording_readers` has the reader of each kind of file.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Sequence
from importlib import import_module
from math import isfinite, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from understudy.addons.recordings.mapping_file import RecordingMap
from understudy.errors import FileError, join_names, suggest_known_name
from understudy.extras import format_install_command
from understudy.model.value_kinds import Column

TIME = "time_s"
"""The column of times in a table that needs no mapping file, and in all tables of messages."""


class RecordedTable(NamedTuple):
    """A recording of another program as a table: a row for each moment, a column for each quantity.

    Parameters
    ----------
    path
        The file.
    header
        Names of the columns, each once.
    lines
        The number in the file of each row, for errors; it rises.
    cells
        The rows, each with a cell for each column: a number, or a text that is one. Everything else is absent, such as
        None, NaN and empty texts.
    omissions
        Sentences about what was left out, each with its place in the file.
    counted
        What `lines` counts: lines, or messages.
    time
        The column of the times, s, if the mapping names none. None: the rows of such a mapping are evenly spaced.
    """

    path: Path
    header: tuple[str, ...]
    lines: Sequence[int]
    cells: Sequence[Sequence[Any]]
    omissions: list[str]
    counted: str = "line"
    time: str | None = None

    def format_place(self, row: int) -> str:
        """Return where a row stands in the file.

        Parameters
        ----------
        row
            Index of the row, from 0.

        Returns
        -------
        str
            A place such as "line 3".
        """
        return f"{self.counted} {self.lines[row]}"

    def refuse(self, place: str, problem: str, remedy: str) -> FileError:
        """Make the error that something at a place of the file cannot be used.

        Parameters
        ----------
        place
            The place, such as "line 3, column 'x'".
        problem
            What is wrong.
        remedy
            What would be right.

        Returns
        -------
        FileError
            The error, to be raised.
        """
        return FileError(path=self.path, place=place, problem=problem, remedy=remedy)

    def read_numbers(self, column: str, *, of: str, quiet: bool = False) -> Column:
        """Read a column as numbers.

        Parameters
        ----------
        column
            Name of the column.
        of
            What it has, for the error.
        quiet
            Whether cells that are no numbers are left unmentioned.

        Returns
        -------
        array, shape [T]
            The numbers as float64; NaN where a cell is no number.

        Raises
        ------
        FileError
            If there is no such column, or no cell of it is a number.
        """
        if column not in self.header:
            meant = suggest_known_name(column, self.header)
            raise self.refuse(
                self.format_place(0) if self.lines else "line 1",
                f"there is no column {column!r} for {of}",
                f"{meant}the columns are {join_names(self.header)}",
            )
        at = self.header.index(column)
        numbers, wrong = np.empty(len(self.cells)), []
        for row, cells in enumerate(self.cells):
            numbers[row] = value = _parse(cells[at])
            if not isfinite(value) and cells[at] not in ("", None):
                wrong.append(row)
        if wrong:
            more = f" and {len(wrong) - 1} more" if len(wrong) > 1 else ""
            first = self.format_place(wrong[0])
            what = f"{self.cells[wrong[0]][at]!r:.40}{more} is no number; taken as absent"
            if not quiet:
                self.omissions.append(f"{self.path} at {first}, column {column!r}: {what}")
            if len(wrong) == len(numbers):
                raise self.refuse(f"{first}, column {column!r}", "no cell is a number", "map another column")
        return numbers


def _parse(cell: Any) -> float:
    if isinstance(cell, bool):
        return float(cell)
    try:
        value = float(cell)
    except (TypeError, ValueError):
        return nan
    return value if isfinite(value) else nan


def read_csv(path: Path | str, _mapping: RecordingMap | None = None) -> RecordedTable:
    """Read a CSV file, whose first row names the columns."""
    path = Path(path)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            rows = [(reader.line_num, [cell.strip() for cell in row]) for row in reader if row]
    except (OSError, ValueError, csv.Error) as error:
        raise _unreadable(path, error) from None
    if not rows:
        raise FileError(path=path, place="", problem="it is empty", remedy="give a table of a drive")
    (_, header), *rest = rows
    table = RecordedTable(path, tuple(header), [], [], [])
    complete = list(_whole_rows(table, rest))
    return table._replace(lines=[line for line, _ in complete], cells=[row for _, row in complete])


def _whole_rows(
    table: RecordedTable, rows: Sequence[tuple[int, list[str]]]
) -> Iterator[tuple[int, list[str]]]:
    """Yield rows that have all cells; the last one of a file that was cut short has fewer."""
    for line, row in rows:
        if len(row) == len(table.header):
            yield line, row
        else:
            end = "the file ends in the middle of it" if line == rows[-1][0] else "it is left out"
            table.omissions.append(
                f"{table.path} at line {line}: {len(row)} cells instead of {len(table.header)}; {end}"
            )


def read_json_lines(path: Path | str, _mapping: RecordingMap | None = None) -> RecordedTable:
    """Read JSON lines: an object in each, whose nested keys are columns such as pose.x."""
    path = Path(path)
    try:
        lines = path.read_text("utf-8-sig").splitlines()
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from None
    rows: list[tuple[int, dict[str, Any]]] = []
    omissions = []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            value = json.loads(line)
        except (ValueError, RecursionError):
            value = None
        if isinstance(value, dict):
            rows.append((number, dict(_flatten(value))))
        else:
            end = "the file ends in the middle of it" if number == len(lines) else "it is left out"
            omissions.append(f"{path} at line {number}: no JSON object; {end}")
    if not rows:
        raise FileError(
            path=path, place="", problem="no line has a JSON object", remedy="give JSON lines of a drive"
        )
    header = tuple(dict.fromkeys(key for _, row in rows for key in row))
    cells = [[row.get(key) for key in header] for _, row in rows]
    return RecordedTable(path, header, [number for number, _ in rows], cells, omissions)


def read_parquet(path: Path | str, _mapping: RecordingMap | None = None) -> RecordedTable:
    """Read a Parquet file; its rows count as lines, from 1."""
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
        with duckdb.connect() as database, path.open("rb"):
            result = database.execute("SELECT * FROM read_parquet(?)", [str(path)])
            header = tuple(each[0] for each in result.description)
            cells = result.fetchall()
    except (OSError, duckdb.Error) as error:
        raise _unreadable(path, error) from None
    return RecordedTable(path, header, range(1, len(cells) + 1), cells, [])


def _flatten(content: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of an object by path, with dots between the keys."""
    for key, value in content.items():
        if isinstance(value, dict):
            yield from _flatten(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _unreadable(path: Path, error: Exception) -> FileError:
    gone = isinstance(error, FileNotFoundError)
    problem = "there is no such file" if gone else f"it cannot be read ({error})"
    return FileError(path=path, place="", problem=problem, remedy="give a CSV file, JSON lines or Parquet")
