"""The time of each row of a recorded table: numbers, dates and stamps, made to rise.

Rows of equal time are spread over the time until the next one, a row that was written a little late is put where it
belongs, and where time goes back, another episode begins. Each of these is said in a sentence with its place.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from math import inf, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.mapping_file import UNITS, RecordingMap
from understudy.addons.recordings.recorded_table import RecordedTable
from understudy.addons.recordings.time_cells import parse_times
from understudy.errors import join_names
from understudy.model.value_kinds import Column, Continuous

SECONDS_PARTS = ("sec", "secs", "seconds", "s", "tv_sec")
SPLIT_PARTS: Mapping[str, float] = {
    **dict.fromkeys(("nanosec", "nanosecs", "nanoseconds", "nsec", "nsecs", "ns", "nanos", "tv_nsec"), 1e-9),
    **dict.fromkeys(("microsec", "microsecs", "microseconds", "usec", "usecs", "us", "tv_usec"), 1e-6),
    **dict.fromkeys(("millisec", "millisecs", "milliseconds", "msec", "msecs", "ms"), 1e-3),
}
"""The names of the parts into which ROS and others split a time, and the length of the second one's unit, s."""
SHORTEST_GAP_S = 1.0
"""The time without a row after which an episode ends, unless the mapping file says otherwise, s."""
GAP_STEPS = 5
"""The same in usual times between rows, for recordings of few rows a second."""
LONGEST_STEP_S, SHORTEST_STEP_S = 2.0, 1e-4
"""The usual times between rows, s, outside of which the unit of the times must be another one."""
SINCE_1970_S = 1.5e9, 2.1e9
"""Times between these are probably seconds since 1970, of the years 2017 to 2036."""
LATEST_S = 3e10
"""Times after it, which is after the year 2900, are in another unit."""
MOST_LATE_ROWS = 5
"""The largest number of rows in a row that may have been written late."""
NEAR = 0.3
"""The distance of two rows, in usual times between rows, below which they are about the same moment."""


class RowTimes(NamedTuple):
    """The rows of a table that have a time, in order of time within an episode.

    `rows` [T] are their indices, `times` [T] their times in s, which rise within an episode, `starts` the positions
    at which episodes begin, and `usual_s` is the usual time between two rows.
    """

    rows: NDArray[np.int64]
    times: Column
    starts: list[int]
    usual_s: float


def find_row_times(table: RecordedTable, mapping: RecordingMap) -> RowTimes:
    """Find the time of each row; FileError is raised if the column of times cannot be understood."""
    raw = _remove_zeros(_read_times(table, mapping))
    present = raw[~np.isnan(raw)]
    if len(present) < 2 or np.ptp(present) == 0:
        if mapping.time is not None and len(present) > 1:
            problem = f"its times are all {present[0]:.12g} s"
            remedy = "name another column as time, or leave it out and give tick_s"
            raise table.refuse(f"column {_name_time(mapping)!r}", problem, remedy)
        rows = np.flatnonzero(~np.isnan(raw))
        return RowTimes(rows, raw[rows], [0], mapping.tick_s or 1.0)
    rows = np.arange(len(raw))
    if (np.diff(present) <= 0).all():
        table.omissions.append(f"{table.path}: its last row is the earliest; read from the last to the first")
        rows = rows[::-1]
    rows = _drop_rows_before_time(table, rows, raw)
    has_time = ~np.isnan(raw)
    gap_s = mapping.gap_s or max(SHORTEST_GAP_S, GAP_STEPS * _measure_usual(raw[rows]))
    rows, times, starts = _sort_late_rows(table, rows, raw[rows], gap_s)
    if len(starts) > 1 + len(rows) // 4:
        place = f"{table.format_place(int(rows[starts[1]]))}, column {_name_time(mapping)!r}"
        problem = f"time goes back there and at {len(starts) - 2} more places"
        raise table.refuse(
            place, problem, "sort the rows by time, one robot in each file, or name another column"
        )
    times = _spread_equal_times(table, rows, times, starts, gap_s, has_time)
    usual = _measure_usual(times)
    _refuse_unit(table, mapping, times, usual)
    starts = _find_gaps(table, rows, times, starts, gap_s)
    return RowTimes(rows, times, starts, usual)


def _name_time(mapping: RecordingMap) -> str:
    return mapping.time if isinstance(mapping.time, str) else join_names(mapping.time or ())


def _measure_usual(times: Column) -> float:
    """Return the median of the time between two rows, those of equal time taken as spread evenly, s."""
    present = times[~np.isnan(times)]
    steps = np.diff(present)
    rising = steps[steps > 0]
    if not len(rising):
        return inf
    return float(np.median(rising)) * (len(rising) / max(1, int((steps >= 0).sum())))


def _read_times(table: RecordedTable, mapping: RecordingMap) -> Column:
    """Read the column of times, s; NaN where a row has none."""
    if mapping.time is None:
        steps: Column = np.arange(len(table.cells), dtype=np.float64)
        steps *= mapping.tick_s or 1.0
        return steps
    names = [mapping.time] if isinstance(mapping.time, str) else list(mapping.time)
    if len(names) == 1 and names[0] not in table.header:
        names = _find_split_stamp(table.header, names[0]) or names
    if len(names) == 2:
        return _read_split_times(table, *names)
    cells = table.list_cells(names[0], of="the time")
    times = parse_times(cells, UNITS[mapping.time_unit][1])
    if np.isnan(times).all() and len(times):
        problem = f"{str(cells[0])!r:.40} is no time"
        remedy = "write seconds, or dates as 2026-05-01T10:00:00.5Z"
        raise table.refuse(f"{table.format_place(0)}, column {names[0]!r}", problem, remedy)
    return times


def _read_split_times(table: RecordedTable, whole_name: str, part_name: str) -> Column:
    """Read times that are split into seconds and nanoseconds, or another part that the name of its column says."""
    whole, part = (
        table.read_values(each, Continuous(), of="the time").values for each in (whole_name, part_name)
    )
    end = re.split(r"[./]", part_name.lower())[-1]
    unit_s = next((unit for name, unit in SPLIT_PARTS.items() if f"_{end}".endswith(f"_{name}")), None)
    least, most = (float(each) for each in (np.nanmin(part, initial=0.0), np.nanmax(part, initial=0.0)))
    if least < 0 or most * (unit_s or 1e-9) >= 1:
        problem, remedy = (
            f"it reaches {most or least:.12g}, which is no part of a second",
            "name the seconds first",
        )
        raise table.refuse(f"column {part_name!r}", problem, f"{remedy}, then the nanoseconds")
    if unit_s is None and 1e3 < most < 1e6:
        problem = f"it reaches only {most:g}, so it does not seem to be in nanoseconds"
        raise table.refuse(
            f"column {part_name!r}", problem, "call it usec if it is in microseconds, ms or nanosec"
        )
    times: Column = whole + part * (unit_s or 1e-9)
    return times


def _find_split_stamp(header: Sequence[str], name: str) -> list[str] | None:
    """Find the columns of a time that is split into seconds and nanoseconds: stamp.sec and stamp.nanosec."""
    for between in (".", "_", "/"):
        for whole in SECONDS_PARTS:
            for part in SPLIT_PARTS:
                names = [f"{name}{between}{whole}", f"{name}{between}{part}"]
                if set(names) <= set(header):
                    return names
    return None


def _remove_zeros(times: Column) -> Column:
    """Take a zero far from the times after it as no time: drivers send it that do not fill in a stamp."""
    nonzero = np.flatnonzero((times != 0) & ~np.isnan(times))
    if not len(nonzero):
        return times
    gap_s = max(SHORTEST_GAP_S, GAP_STEPS * _measure_usual(times[nonzero]))
    following = np.searchsorted(nonzero, np.arange(len(times)))
    ahead = np.abs(times[nonzero[np.minimum(following, len(nonzero) - 1)]])
    return np.where((times == 0) & (ahead > gap_s), nan, times)


def _drop_rows_before_time(table: RecordedTable, rows: NDArray[np.int64], times: Column) -> NDArray[np.int64]:
    """Return the rows from the first one that has a time; those before it are left out."""
    unknown = np.isnan(times[rows])
    if unknown.any():
        first, before = int(rows[int(np.argmax(unknown))]), int(np.argmin(unknown))
        count = int(unknown.sum())
        where = table.format_place(first)
        more = f" and {count - 1} more rows" if count > 1 else ""
        what = "put between their neighbors" if before < count else "left out"
        if 0 < before < count:
            what += f"; the {before} at the beginning are left out"
        table.omissions.append(f"{table.path} at {where}{more}: no time, or a stamp of 0; {what}")
        rows = rows[before:]
    return rows


def _sort_late_rows(
    table: RecordedTable, rows: NDArray[np.int64], times: Column, gap_s: float
) -> tuple[NDArray[np.int64], Column, list[int]]:
    """Put rows that were written a little late where they belong, and begin an episode where time goes back."""
    filled = _fill_forward(times)
    starts, late, top = [0], list[int](), filled[0]
    usual = _measure_usual(times)
    for at in range(1, len(filled)) if (np.diff(filled) < 0).any() else ():
        if filled[at] >= top:
            top = filled[at]
        elif _is_late(filled, max(starts[-1], at - 10 * MOST_LATE_ROWS), at, top, usual, gap_s):
            late.append(at)
        else:
            place = table.format_place(int(rows[at]))
            table.omissions.append(
                f"{table.path} at {place}: time goes back from {filled[at - 1]:.12g} to {filled[at]:.12g} s; another "
                "episode begins"
            )
            starts.append(at)
            top = filled[at]
    if late:
        more = f" and {len(late) - 1} more rows" if len(late) > 1 else ""
        place = table.format_place(int(rows[late[0]]))
        table.omissions.append(
            f"{table.path} at {place}{more}: written after a later one; put where its time belongs"
        )
        ends = [*starts[1:], len(filled)]
        order = np.concatenate(
            [
                first + np.argsort(filled[first:end], kind="stable")
                for first, end in zip(starts, ends, strict=True)
            ]
        )
        rows, filled = rows[order], filled[order]
    return rows, filled, starts


def _is_late(times: Column, first: int, at: int, top: float, usual: float, gap_s: float) -> bool:
    """Return whether a row was written late, by less than a step or into a hole; else the clock was set back."""
    if top - times[at] > gap_s or not (times[at + 1 : at + 1 + MOST_LATE_ROWS] >= top).any():
        return False
    return bool(
        top - times[at] < min(usual, SHORTEST_GAP_S)
        or np.abs(times[first:at] - times[at]).min() > NEAR * usual
    )


def _fill_forward(times: Column) -> Column:
    """Give rows without a time that of the row before, with which they are spread."""
    at = np.where(np.isnan(times), 0, np.arange(len(times)))
    filled: Column = times[np.maximum.accumulate(at)]
    return filled


def _spread_equal_times(
    table: RecordedTable,
    rows: NDArray[np.int64],
    times: Column,
    starts: Sequence[int],
    gap_s: float,
    has_time: NDArray[np.bool_],
) -> Column:
    """Spread rows of equal time evenly over the time until the next one; `has_time` [N] are the rows that had one."""
    begins = np.flatnonzero(np.concatenate([[True], np.diff(times) != 0]))
    counts = np.diff([*begins, len(times)])
    if counts.max() == 1:
        return times
    spread, cuts = times.copy(), set(starts)
    step = _measure_usual(times)
    for number, (begin, count) in enumerate(zip(begins.tolist(), counts.tolist(), strict=True)):
        end = begin + count
        is_last = end == len(times) or end in cuts
        ahead = times[end] - times[begin] if not is_last else inf
        if not 0 < ahead <= gap_s:
            before = times[begin] - times[begins[number - 1]] if number and begin not in cuts else inf
            ahead = before if 0 < before <= gap_s and counts[number - 1] == count else step * count
        if count > 1:
            spread[begin:end] += ahead * np.arange(count) / count
    equal = np.add.reduceat(has_time[rows].astype(np.int64), begins)
    many = np.flatnonzero(equal > 1)
    if len(many):
        first = int(begins[many[0]])
        more = f", and so on {len(many) - 1} more times" if len(many) > 1 else ""
        table.omissions.append(
            f"{table.path} at {table.format_place(int(rows[first]))}: {equal[many[0]]} rows have the time "
            f"{times[first]:.12g} s{more}; spread evenly until the next"
        )
    return spread


def _refuse_unit(table: RecordedTable, mapping: RecordingMap, times: Column, usual: float) -> None:
    """Refuse times whose unit must be another one."""
    if mapping.time is None:
        return
    unit_s, first = UNITS[mapping.time_unit][1], float(times[0])
    longest = mapping.gap_s or LONGEST_STEP_S
    remedy = "give the right time_unit in a mapping file"
    if np.abs(times).max() > LATEST_S:
        problem = f"its times, such as {first:.12g} s, are after the year 2900"
        remedy += ", or write dates as 2026-05-01T10:00:00.5Z"
    elif usual < SHORTEST_STEP_S:
        problem = f"rows are {usual:g} s apart"
    elif usual > longest:
        limit = f"gap_s ({longest:g} s)" if mapping.gap_s else f"{longest:g} s"
        problem = f"rows are {usual:g} s apart, farther than {limit}"
        remedy += ", or a longer gap_s"
    elif unit_s < 1 and usual / unit_s <= longest and SINCE_1970_S[0] < first / unit_s < SINCE_1970_S[1]:
        problem = (
            f"its times, such as {first / unit_s:.12g}, are seconds since 1970, and not {mapping.time_unit}"
        )
    else:
        return
    raise table.refuse(f"column {_name_time(mapping)!r}", problem, remedy)


def _find_gaps(
    table: RecordedTable, rows: NDArray[np.int64], times: Column, starts: Sequence[int], gap_s: float
) -> list[int]:
    """Return where episodes begin: also where nothing was recorded for longer than a gap."""
    gaps = np.flatnonzero(np.diff(times) > gap_s * (1 + 1e-9)) + 1
    for at in gaps.tolist():
        if at not in starts:
            passed = times[at] - times[at - 1]
            table.omissions.append(
                f"{table.path} at {table.format_place(int(rows[at]))}: nothing was recorded for {passed:g} s; another "
                "episode begins"
            )
    return sorted({*starts, *gaps.tolist()})
