"""Drives from recordings of any program: their columns become readings and commands in ticks.

What can be used is used: a cell that is no number is absent, a row without a command is left out, and where time goes
back or pauses, an episode ends. Each of these is said in a sentence with its place.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.mapping_file import (
    UNITS,
    WIDEST_RAD,
    CommandColumn,
    ReadingColumn,
    RecordingMap,
)
from understudy.addons.recordings.recorded_table import TIME, RecordedTable
from understudy.addons.recordings.recording_readers import find_reader
from understudy.addons.recordings.row_times import RowTimes, find_row_times
from understudy.errors import join_names
from understudy.model.features import format_reading_label
from understudy.model.value_kinds import BOOLEAN, Categorical, Column, Kind, Toroidal
from understudy.records.record import Episode, Floats, Record
from understudy.runtime.body import Channel, Reading

COMMAND = "command."
"""The beginning of the names of columns of commands in a table that needs no mapping file."""
MOST_UNEVEN = 0.1
"""The largest deviation of the time between two rows from a tick, as a share of it; if few deviate more, rows are
ticks."""
MOST_TICKS = 3
"""The largest number of ticks for each row on average; with more, ticks are as long as rows are apart on average."""


def read_recorded_drive(path: Path | str, mapping: RecordingMap | None = None) -> Record:
    """Read a drive from a table (CSV, JSON lines, Parquet) or from recorded messages (MCAP, ROS 2, ROS 1).

    Parameters
    ----------
    path
        The file; one whose name ends in .jsonl or .ndjson has an object in each line, and one that ends in .parquet is
        Parquet, which needs the extra `parquet`. One that ends in .mcap, .db3 or .bag, or a folder that ROS 2 recorded,
        has messages, and needs the extra `ros2`. Installed packages may read other files.
    mapping
        Which columns are what; it must be given for messages, whose columns are called as /cmd_vel.linear.x. None: the
        column time_s has times, columns such as command.drive have commands, and all others are readings, of targets if
        they are called as range(ball).

    Returns
    -------
    Record
        The drive; its `omissions` say what was left out.

    Raises
    ------
    FileError
        If the file cannot be read, has no column that the mapping names, or has no motion, or if it has messages and
        there is no mapping.
    ExtraMissing
        If the packages for messages are not installed.
    SettingError
        If another package offers a reader of such files, which cannot be loaded.
    """
    path = Path(path)
    return convert_table(find_reader(path)(path, mapping), mapping)


def convert_table(table: RecordedTable, mapping: RecordingMap | None = None) -> Record:
    """Make a drive of a table, as `read_recorded_drive` does."""
    mapping = table.mapping or mapping or _guess_mapping(table)
    if not len(table.cells):
        raise table.refuse("", "it has no rows", "give a recording of a drive")
    at = find_row_times(table, mapping)
    held = _hold_commands(table, mapping, at)
    usable = np.flatnonzero(np.isfinite(held).all(axis=1))
    if len(usable) < 2:
        raise table.refuse("", "it has fewer than two rows with commands", "give a longer recording")
    if not np.ptp(held[usable], axis=0).any():
        raise table.refuse(
            "",
            "its commands never change, so there is no motion to learn from",
            "give a recording of a drive",
        )
    columns = {}
    readings = {}
    for each in mapping.readings:
        read = _read_reading(table, each, at)
        if read is not None:
            columns[each.quantity, each.target] = read.values
            unit, _ = _find_unit(table, each)
            readings[each.quantity] = Reading(
                each.quantity, read.kind, unit, each.target is not None, each.doc
            )
    starts = np.searchsorted(usable, at.starts).tolist()
    tick_s, ticks, when, episodes = _resample(table, at.times[usable], starts, mapping.tick_s)
    rows = usable[ticks]
    return Record(
        when,
        {key: values[rows] for key, values in columns.items()},
        held[rows],
        tuple(
            Channel(each.name, each.rest, UNITS.get(each.unit, (each.unit, 1.0))[0])
            for each in mapping.commands
        ),
        tuple(readings.values()),
        tuple(dict.fromkeys(target for _, target in columns if target is not None)),
        tick_s,
        episodes,
        tuple(table.omissions),
    )


def _guess_mapping(table: RecordedTable) -> RecordingMap:
    """Make the mapping of a table whose columns are called as ours."""
    for name in table.header:
        plain, numbered, _ = name.rpartition(" (column ")
        if numbered and plain:
            table.list_cells(plain, of="a column")  # refuses it: two have this name
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
        if name.startswith(" (column "):
            table.omissions.append(f"{table.path}: a column has no name {name.strip()}; left out")
            continue
        reading, opened, target = name.removesuffix(")").partition("(")
        about = target if opened and name.endswith(")") and ")" not in target else None
        readings.append(ReadingColumn(column=name, name=reading if about else name, target=about))
    return RecordingMap(
        format="understudy-recording-map/1",
        time=TIME,
        readings=tuple(readings),
        commands=tuple(CommandColumn(column=name, channel=name.removeprefix(COMMAND)) for name in commands),
    )


class _ReadingValues(NamedTuple):
    """A reading in rows that have a time, in the unit of the reading, and its kind."""

    values: Column
    kind: Kind


def _read_reading(table: RecordedTable, column: ReadingColumn, at: RowTimes) -> _ReadingValues | None:
    """Read the column of a reading; one whose texts say nothing is left out, and None is returned."""
    kind = column.value_kind
    read = table.read_values(column.column, kind, of=f"reading {column.quantity!r}")
    if read.remark:
        left_out = "; left out" if read.kind is None else ""
        table.omissions.append(f"{table.path}, column {column.column!r}: {read.remark}{left_out}")
    if read.kind is None:
        return None
    values = _convert_unit(table, column, read.values[at.rows])
    if isinstance(read.kind, Toroidal):
        values = read.kind.wrap(values)
    if column.stale_s is not None and table.mapping is None:
        values, ages = _hold(values, at)
        values[ages > column.stale_s] = np.nan
    absent = int(np.isnan(values).sum())
    if absent:
        table.omissions.append(
            f"{table.path}: {format_reading_label((column.quantity, column.target))} is absent in {absent} of "
            f"{len(values)} rows"
        )
    return _ReadingValues(values, read.kind)


def _find_unit(table: RecordedTable, column: ReadingColumn | CommandColumn) -> tuple[str, float]:
    """Return the unit of a reading or command, and the factor to it; a reader that knows its columns converted them."""
    return (column.unit, 1.0) if table.mapping is not None else UNITS[column.unit]


def _convert_unit(table: RecordedTable, column: ReadingColumn | CommandColumn, values: Column) -> Column:
    """Convert a column to the unit of its reading or command."""
    if column.unit == "rad" and np.nanmax(np.abs(values), initial=0.0) > WIDEST_RAD:
        raise table.refuse(
            f"column {column.column!r}",
            f"it reaches {np.nanmax(np.abs(values)):g}, which is no angle in rad",
            'write unit = "deg" in the mapping file',
        )
    return values * _find_unit(table, column)[1]


def _hold_commands(table: RecordedTable, mapping: RecordingMap, at: RowTimes) -> Floats:
    """Return the commands [T, C] of rows that have a time: each holds until the next one, or as long as is said.

    A row before the first command of an episode has none.
    """
    columns = []
    for each in mapping.commands:
        read = table.read_values(each.column, of="the commands")
        if read.kind is None or (isinstance(read.kind, Categorical) and read.kind != BOOLEAN):
            raise table.refuse(f"column {each.column!r}", "its commands are texts", "map a column of numbers")
        commanded = _convert_unit(table, each, read.values[at.rows]) * each.scale
        values, ages = _hold(commanded, at)
        held = np.isnan(commanded) & ~np.isnan(values)
        if held.any():
            longest = int(np.argmax(np.where(held, ages, 0.0)))
            limit = each.hold_s
            stopped = "" if limit is None else f"; after {limit:g} s the robot is at rest"
            place = table.format_place(int(at.rows[longest]))
            table.omissions.append(
                f"{table.path}: {int(held.sum())} of {len(values)} rows have no command of {each.name}; the last one "
                f"holds, at most {ages[longest]:.3g} s ({place}){stopped}"
            )
            if limit is not None:
                values[ages > limit] = each.rest
        columns.append(values)
    commands = np.column_stack(columns)
    lost = np.flatnonzero(~np.isfinite(commands).all(axis=1))
    if len(lost):
        more = f" and {len(lost) - 1} more rows" if len(lost) > 1 else ""
        place = table.format_place(int(at.rows[lost[0]]))
        table.omissions.append(f"{table.path} at {place}{more}: before the first command; left out")
    return commands


def _hold(values: Column, at: RowTimes) -> tuple[Column, Column]:
    """Return values as they last were in the episode, and how old they are, s."""
    count = len(values)
    begins = np.zeros(count, np.int64)
    begins[at.starts] = at.starts
    begins = np.maximum.accumulate(begins)
    last = np.maximum.accumulate(np.where(np.isnan(values), -1, np.arange(count)))
    has_one = last >= begins
    held: Column = np.where(has_one, values[np.maximum(last, 0)], np.nan)
    return held, np.where(has_one, at.times - at.times[np.maximum(last, 0)], 0.0)


def _resample(
    table: RecordedTable, times: Column, starts: Sequence[int], wanted_s: float | None
) -> tuple[float, NDArray[np.int64], Column, tuple[Episode, ...]]:
    """Choose the row of each tick: the last one until then. Return the tick, rows, times and episodes."""
    edges = [*dict.fromkeys(starts), len(times)]
    pieces = [np.arange(first, end) for first, end in itertools.pairwise(edges) if end > first]
    steps = np.concatenate([np.diff(times[piece]) for piece in pieces])
    usual = float(np.median(steps)) if len(steps) else (wanted_s or 1.0)
    if len(steps) and usual * MOST_TICKS < steps.mean():
        usual = float(steps.mean())  # rows that were written a few at a time
    tick_s = wanted_s or float(f"{usual:.3g}")
    even = len(steps) == 0 or float(np.mean(np.abs(steps - tick_s) <= MOST_UNEVEN * tick_s)) > 0.98
    rows, ticks, episodes, first, used = [], [], [], 0, 0
    for piece in pieces:
        at = times[piece]
        if even:
            chosen, when = piece, at
        else:
            when = at[0] + tick_s * np.arange(int((at[-1] - at[0]) / tick_s + 1e-6) + 1)
            chosen = piece[np.searchsorted(at, when + 1e-9, side="right") - 1]
        rows.append(chosen)
        ticks.append(when)
        episodes.append(Episode(table.path.name, first, first + len(chosen)))
        first += len(chosen)
        used += len(np.unique(chosen))
    if used < len(times) and wanted_s is None:
        table.omissions.append(
            f"{table.path}: its rows are not evenly apart; ticks of {tick_s:g} s follow the clock, and "
            f"{len(times) - used} of {len(times)} rows between two ticks are left out"
        )
    return tick_s, np.concatenate(rows), np.concatenate(ticks), tuple(episodes)
