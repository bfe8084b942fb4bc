"""Drives from recordings of any program: their columns become readings and commands in ticks.

What can be used is used: a cell that is no number is absent, a row without a command is left out, and where time goes
back or pauses, an episode ends. Each of these is said in a sentence with its place.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.mapping_file import UNITS, CommandColumn, ReadingColumn, RecordingMap
from understudy.addons.recordings.recorded_drive import DriveEpisode, Floats, RecordedDrive
from understudy.addons.recordings.recorded_table import TIME, RecordedTable
from understudy.addons.recordings.recording_readers import find_reader
from understudy.errors import join_names
from understudy.model.value_kinds import Categorical, Column, Toroidal
from understudy.runtime.body import Channel, Reading

COMMAND = "command."
"""The beginning of the names of columns of commands in a table that needs no mapping file."""
MOST_UNEVEN = 0.1
"""The largest deviation of the time between two rows from a tick, as a share of it; if few deviate more, rows are
ticks."""
WIDEST_RAD = 13.0
"""The largest angle in radians, about two turns; a column with a larger one is refused, as it may be in degrees."""


def read_recorded_drive(path: Path | str, mapping: RecordingMap | None = None) -> RecordedDrive:
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
    RecordedDrive
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


def convert_table(table: RecordedTable, mapping: RecordingMap | None = None) -> RecordedDrive:
    """Make a drive of a table, as `read_recorded_drive` does."""
    if mapping is not None and mapping.time is None and table.time is not None:
        mapping = replace(mapping, time=table.time, time_unit="s")
    mapping = _guess_mapping(table) if mapping is None else mapping
    commands = np.column_stack([_read_column(table, each, "the commands") for each in mapping.commands])
    columns = {
        (each.quantity, each.target): _read_column(table, each, f"reading {each.quantity!r}")
        for each in mapping.readings
    }
    times = _read_times(table, mapping)
    usable, pieces = _find_pieces(table, times, commands, mapping.gap_s)
    if len(usable) < 2:
        raise table.refuse("", "it has fewer than two rows with commands", "give a longer recording")
    for index, each in enumerate(mapping.commands):
        commands[:, index] = commands[:, index] * each.scale
    if not np.ptp(commands[usable], axis=0).any():
        raise table.refuse(
            "",
            "its commands never change, so there is no motion to learn from",
            "give a recording of a drive",
        )
    tick_s, rows, ticks, episodes = _resample(times, usable, pieces, mapping.tick_s, table.path.name)
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


def _guess_mapping(table: RecordedTable) -> RecordingMap:
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


def _read_column(table: RecordedTable, column: ReadingColumn | CommandColumn, of: str) -> Column:
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
                f"{table.format_place(int(outside[0]))}, column {column.column!r}",
                f"{values[outside[0]]:g} is no label of {kind}",
                f"write 0 to {len(kind.labels) - 1}",
            )
    return values


def _read_times(table: RecordedTable, mapping: RecordingMap) -> Column:
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
    table: RecordedTable, times: Column, commands: Floats, gap_s: float
) -> tuple[NDArray[np.int64], list[int]]:
    """Return the rows that can be used, and the positions among them at which episodes begin."""
    usable = np.isfinite(times) & np.isfinite(commands).all(axis=1)
    lost = np.flatnonzero(~usable)
    if len(lost):
        more = f" and {len(lost) - 1} more rows" if len(lost) > 1 else ""
        table.omissions.append(
            f"{table.path} at {table.format_place(int(lost[0]))}{more}: no time or no command; left out"
        )
    usable_rows: list[int] = []
    starts = [0]
    for row in np.flatnonzero(usable).tolist():
        if usable_rows:
            passed = times[row] - times[usable_rows[-1]]
            if passed == 0:
                continue
            if passed < 0 or passed > gap_s:
                what = (
                    f"time goes back from {times[usable_rows[-1]]:g} to {times[row]:g} s"
                    if passed < 0
                    else f"nothing was recorded for {passed:g} s"
                )
                table.omissions.append(
                    f"{table.path} at {table.format_place(row)}: {what}; another episode begins"
                )
                starts.append(len(usable_rows))
        usable_rows.append(row)
    return np.array(usable_rows, np.int64), starts


def _resample(
    times: Column, usable: NDArray[np.int64], starts: Sequence[int], wanted_s: float | None, source: str
) -> tuple[float, NDArray[np.int64], Column, tuple[DriveEpisode, ...]]:
    """Choose the row of each tick: the last one until then. Return the tick, rows, times and episodes."""
    edges = [*starts, len(usable)]
    pieces = [usable[first:end] for first, end in itertools.pairwise(edges) if end > first]
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
        episodes.append(DriveEpisode(source, first, first + len(chosen)))
        first += len(chosen)
    return tick_s, np.concatenate(rows), np.concatenate(ticks), tuple(episodes)
