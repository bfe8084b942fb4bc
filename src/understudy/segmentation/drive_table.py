"""Drives in tables: CSV files, JSON lines whose objects are rows, and Parquet.

What can be used is used: a cell that is no number is absent, a row without a command is left out, and where time goes
back or pauses, an episode ends. Each of these is said in a sentence with its place.
"""

from __future__ import annotations

import csv
import itertools
import json
from collections.abc import Iterator, Sequence
from importlib import import_module
from math import isfinite, nan
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.errors import FileError, join_names, suggest_known_name
from understudy.extras import format_install_command
from understudy.model.kinds import Categorical, Column, Toroidal
from understudy.runtime.body import Channel, Reading
from understudy.segmentation.mapping_file import UNITS, CommandColumn, ReadingColumn, RecordingMap
from understudy.segmentation.recorded_drive import Episode, RecordedDrive

Floats = NDArray[np.float64]
TIME, COMMAND = "time_s", "command."
"""The column of times, and the beginning of the names of those of commands, in a table that needs no mapping file."""
JSON_SUFFIXES = (".jsonl", ".ndjson")
PARQUET_SUFFIX = ".parquet"
MOST_UNEVEN = 0.1
"""Rows that are apart by up to this share more or less than a tick are taken as ticks as they are."""
WIDEST_RAD = 13.0
"""An angle in radians that goes beyond two turns is taken for one in degrees."""


class _Table(NamedTuple):
    """Rows of cells by line of the file, and what was left out."""

    path: Path
    header: tuple[str, ...]
    lines: Sequence[int]
    cells: Sequence[Sequence[Any]]
    omissions: list[str]

    def refuse(self, place: str, problem: str, remedy: str) -> FileError:
        return FileError(path=self.path, place=place, problem=problem, remedy=remedy)

    def read_numbers(self, column: str, *, of: str, quiet: bool = False) -> Column:
        """Read a column; what is no number is NaN, and said once unless `quiet`."""
        if column not in self.header:
            meant = suggest_known_name(column, self.header)
            raise self.refuse(
                f"line {self.lines[0] if self.lines else 1}",
                f"there is no column {column!r} for {of}",
                f"{meant}the columns are {join_names(self.header)}",
            )
        at = self.header.index(column)
        found, wrong = np.empty(len(self.cells)), []
        for row, cells in enumerate(self.cells):
            found[row] = value = _parse(cells[at])
            if not isfinite(value) and cells[at] not in ("", None):
                wrong.append(row)
        if wrong:
            more = f" and {len(wrong) - 1} more" if len(wrong) > 1 else ""
            first = self.lines[wrong[0]]
            what = f"{self.cells[wrong[0]][at]!r:.40}{more} is no number; taken as absent"
            if not quiet:
                self.omissions.append(f"{self.path} at line {first}, column {column!r}: {what}")
            if len(wrong) == len(found):
                raise self.refuse(
                    f"line {first}, column {column!r}", "no cell is a number", "map another column"
                )
        return found


def _parse(cell: Any) -> float:
    if isinstance(cell, bool):
        return float(cell)
    try:
        value = float(cell)
    except (TypeError, ValueError):
        return nan
    return value if isfinite(value) else nan


def read_recorded_drive(path: Path | str, mapping: RecordingMap | None = None) -> RecordedDrive:
    """Read a drive from a CSV file, JSON lines or Parquet.

    Parameters
    ----------
    path
        The file; one whose name ends in .jsonl or .ndjson has an object in each line, and one that ends in .parquet is
        Parquet, which needs the extra `parquet`.
    mapping
        Which columns are what. None: the column time_s has times, columns such as command.drive have commands, and all
        others are readings, of targets if they are called as range(ball).

    Returns
    -------
    RecordedDrive
        The drive; its `omissions` say what was left out.

    Raises
    ------
    FileError
        If the file cannot be read, has no column that the mapping names, or has no motion.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix == PARQUET_SUFFIX:
        table = _read_parquet(path)
    else:
        table = _read_lines(path) if suffix in JSON_SUFFIXES else _read_rows(path)
    mapping = _guess_mapping(table) if mapping is None else mapping
    commands = np.column_stack([_read_column(table, each, "the commands") for each in mapping.commands])
    columns = {
        (each.quantity, each.target): _read_column(table, each, f"reading {each.quantity!r}")
        for each in mapping.readings
    }
    times = _read_times(table, mapping)
    kept, pieces = _find_pieces(table, times, commands, mapping.gap_s)
    if len(kept) < 2:
        raise table.refuse("", "it has fewer than two rows with commands", "give a longer recording")
    for index, each in enumerate(mapping.commands):
        commands[:, index] = commands[:, index] * each.scale
    if not np.ptp(commands[kept], axis=0).any():
        raise table.refuse(
            "",
            "its commands never change, so there is no motion to learn from",
            "give a recording of a drive",
        )
    tick_s, rows, ticks, episodes = _resample(times, kept, pieces, mapping.tick_s, path.name)
    return RecordedDrive(
        ticks,
        {key: values[rows] for key, values in columns.items()},
        commands[rows],
        tuple(Channel(each.name, each.rest, UNITS[each.unit][0]) for each in mapping.commands),
        tuple(
            {
                each.quantity: Reading(
                    each.quantity, each.value_kind, UNITS[each.unit][0], each.target is not None, each.doc
                )
                for each in mapping.readings
            }.values()
        ),
        tuple(dict.fromkeys(each.target for each in mapping.readings if each.target is not None)),
        tick_s,
        episodes,
        tuple(table.omissions),
    )


def _read_rows(path: Path) -> _Table:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            rows = [(reader.line_num, [cell.strip() for cell in row]) for row in reader if row]
    except (OSError, ValueError, csv.Error) as error:
        raise _unreadable(path, error) from None
    if not rows:
        raise FileError(path=path, place="", problem="it is empty", remedy="give a table of a drive")
    (_, header), *rest = rows
    table = _Table(path, tuple(header), [], [], [])
    kept = list(_whole_rows(table, rest))
    return table._replace(lines=[line for line, _ in kept], cells=[row for _, row in kept])


def _whole_rows(table: _Table, rows: Sequence[tuple[int, list[str]]]) -> Iterator[tuple[int, list[str]]]:
    """Yield rows that have all cells; the last one of a file that was cut short has fewer."""
    for line, row in rows:
        if len(row) == len(table.header):
            yield line, row
        else:
            end = "the file ends in the middle of it" if line == rows[-1][0] else "it is left out"
            table.omissions.append(
                f"{table.path} at line {line}: {len(row)} cells instead of {len(table.header)}; {end}"
            )


def _read_lines(path: Path) -> _Table:
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
            found = json.loads(line)
        except (ValueError, RecursionError):
            found = None
        if isinstance(found, dict):
            rows.append((number, dict(_flatten(found))))
        else:
            end = "the file ends in the middle of it" if number == len(lines) else "it is left out"
            omissions.append(f"{path} at line {number}: no JSON object; {end}")
    if not rows:
        raise FileError(
            path=path, place="", problem="no line has a JSON object", remedy="give JSON lines of a drive"
        )
    header = tuple(dict.fromkeys(key for _, row in rows for key in row))
    cells = [[row.get(key) for key in header] for _, row in rows]
    return _Table(path, header, [number for number, _ in rows], cells, omissions)


def _read_parquet(path: Path) -> _Table:
    """Read a Parquet file; its rows count as lines, from 1."""
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
    return _Table(path, header, range(1, len(cells) + 1), cells, [])


def _flatten(found: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of an object by path, with dots between the keys."""
    for key, value in found.items():
        if isinstance(value, dict):
            yield from _flatten(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _unreadable(path: Path, error: Exception) -> FileError:
    gone = isinstance(error, FileNotFoundError)
    problem = "there is no such file" if gone else f"it cannot be read ({error})"
    return FileError(path=path, place="", problem=problem, remedy="give a CSV file, JSON lines or Parquet")


def _guess_mapping(table: _Table) -> RecordingMap:
    """Make the mapping of a table whose columns are called as ours."""
    commands = [name for name in table.header if name.startswith(COMMAND)]
    if not commands or TIME not in table.header:
        missing = f"{TIME!r}" if TIME not in table.header else f"such as '{COMMAND}drive'"
        raise table.refuse(
            "line 1",
            f"there is no column {missing}; the columns are {join_names(table.header)}",
            f"give --map MAP.toml, or name columns {TIME}, {COMMAND}CHANNEL and the readings",
        )
    readings = []
    for name in table.header:
        if name == TIME or name in commands:
            continue
        reading, opened, target = name.removesuffix(")").partition("(")
        about = target if opened and name.endswith(")") else None
        readings.append(ReadingColumn(column=name, name=reading if about else name, target=about))
    return RecordingMap(
        format="understudy-recording-map/1",
        time=TIME,
        readings=tuple(readings),
        commands=tuple(CommandColumn(column=name, channel=name.removeprefix(COMMAND)) for name in commands),
    )


def _read_column(table: _Table, column: ReadingColumn | CommandColumn, of: str) -> Column:
    """Read a column in the unit of its reading or command."""
    values: Column = table.read_numbers(column.column, of=of, quiet=isinstance(column, CommandColumn))
    _unit, factor = UNITS[column.unit]
    if column.unit == "rad" and np.nanmax(np.abs(values), initial=0.0) > WIDEST_RAD:
        raise table.refuse(
            f"column {column.column!r}",
            f"it reaches {np.nanmax(np.abs(values)):g}, which is no angle in rad",
            'write unit = "deg" in the mapping file',
        )
    values *= factor
    kind = column.value_kind if isinstance(column, ReadingColumn) else None
    if isinstance(kind, Toroidal):
        return kind.wrap(values)
    if isinstance(kind, Categorical):
        outside = np.flatnonzero(~np.isnan(values) & ~np.isin(values, np.arange(len(kind.labels))))
        if len(outside):
            raise table.refuse(
                f"line {table.lines[outside[0]]}, column {column.column!r}",
                f"{values[outside[0]]:g} is no label of {kind}",
                f"write 0 to {len(kind.labels) - 1}",
            )
    return values


def _read_times(table: _Table, mapping: RecordingMap) -> Column:
    """Read the time of each row, s."""
    if mapping.time is None:
        steps: Column = np.arange(len(table.cells), dtype=np.float64)
        steps *= mapping.tick_s or 1.0
        return steps
    raw = table.read_numbers(mapping.time, of="the time", quiet=True)
    times: Column = raw * UNITS[mapping.time_unit][1]
    if len(times) > 1:
        usual = float(np.nanmedian(np.diff(times)))
        if usual > mapping.gap_s:
            raise table.refuse(
                f"column {mapping.time!r}",
                f"rows are {usual:g} s apart, farther than gap_s ({mapping.gap_s:g} s)",
                "give the right time_unit, or a longer gap_s",
            )
    return times


def _find_pieces(
    table: _Table, times: Column, commands: Floats, gap_s: float
) -> tuple[NDArray[np.int64], list[int]]:
    """Return the rows that can be used, and the positions among them at which episodes begin."""
    usable = np.isfinite(times) & np.isfinite(commands).all(axis=1)
    lost = np.flatnonzero(~usable)
    if len(lost):
        more = f" and {len(lost) - 1} more rows" if len(lost) > 1 else ""
        table.omissions.append(
            f"{table.path} at line {table.lines[lost[0]]}{more}: no time or no command; left out"
        )
    kept: list[int] = []
    starts = [0]
    for row in np.flatnonzero(usable).tolist():
        if kept:
            passed = times[row] - times[kept[-1]]
            if passed == 0:
                continue
            if passed < 0 or passed > gap_s:
                what = (
                    f"time goes back from {times[kept[-1]]:g} to {times[row]:g} s"
                    if passed < 0
                    else f"nothing was recorded for {passed:g} s"
                )
                table.omissions.append(
                    f"{table.path} at line {table.lines[row]}: {what}; another episode begins"
                )
                starts.append(len(kept))
        kept.append(row)
    return np.array(kept, np.int64), starts


def _resample(
    times: Column, kept: NDArray[np.int64], starts: Sequence[int], wanted_s: float | None, source: str
) -> tuple[float, NDArray[np.int64], Column, tuple[Episode, ...]]:
    """Choose the row of each tick: the last one until then. Return the tick, rows, times and episodes."""
    edges = [*starts, len(kept)]
    pieces = [kept[first:end] for first, end in itertools.pairwise(edges) if end > first]
    steps = np.concatenate([np.diff(times[piece]) for piece in pieces])
    usual = float(np.median(steps)) if len(steps) else (wanted_s or 1.0)
    tick_s = wanted_s or float(f"{usual:.3g}")
    even = len(steps) == 0 or float(np.mean(np.abs(steps - tick_s) <= MOST_UNEVEN * tick_s)) > 0.98
    rows, ticks, episodes, first = [], [], [], 0
    for piece in pieces:
        at = times[piece]
        if even:
            chosen, when = piece, at
        else:
            when = at[0] + tick_s * np.arange(int((at[-1] - at[0]) / tick_s + 1e-6) + 1)
            chosen = piece[np.searchsorted(at, when + 1e-9, side="right") - 1]
        rows.append(chosen)
        ticks.append(when)
        episodes.append(Episode(source, first, first + len(chosen)))
        first += len(chosen)
    return tick_s, np.concatenate(rows), np.concatenate(ticks), tuple(episodes)
