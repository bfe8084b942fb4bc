"""The time of each row of a recorded table: numbers, dates and stamps, made to rise.

Rows of equal time are spread over the time until the next one, a row that was written a little late is put where it
belongs, and where time goes back, another episode begins. Each of these is said in a sentence with its place.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, date, datetime, time, timedelta
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from understudy.addons.recordings.mapping_file import UNITS, RecordingMap
from understudy.addons.recordings.recorded_table import RecordedTable
from understudy.addons.recordings.table_cells import parse_number, read_cells
from understudy.errors import join_names
from understudy.model.value_kinds import Column

SECONDS_PARTS = ("sec", "secs", "s")
NANOSECONDS_PARTS = ("nanosec", "nsec", "nsecs", "nanosecs", "nanoseconds", "ns")
"""The names by which ROS and others split a time in two."""
SHORTEST_GAP_S = 1.0
"""The time without a row after which an episode ends, unless the mapping file says otherwise, s."""
GAP_STEPS = 5
"""The same in usual times between rows, for recordings of few rows a second."""
LONGEST_STEP_S, SHORTEST_STEP_S = 2.0, 1e-4
"""The usual times between rows, s, outside of which the unit of the times must be another one."""
SINCE_1970_S = 1e8
"""Times above it are seconds since 1970, and a zero among them is no time."""
MOST_LATE_ROWS = 5
"""The largest number of rows in a row that may have been written late."""
NEAR = 0.3
"""The distance of two rows, in usual times between rows, below which they are about the same moment."""
NUMERIC_DATE = re.compile(r"(\d{1,4})[./-](\d{1,2})[./-](\d{1,4})[T ]+(.*)")
CLOCK = re.compile(r"(?:(\d{1,2}):)?(\d{1,2}):(\d{1,2}(?:[.,]\d*)?)")


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
    raw = _read_times(table, mapping)
    rows = _drop_rows_before_time(table, raw)
    times = raw[rows]
    known = times[~np.isnan(times)]
    if len(known) < 2 or np.ptp(known) == 0:
        if mapping.time is not None and len(known) > 1:
            problem = f"its times are all {known[0]:g} s"
            remedy = "name another column as time, or leave it out and give tick_s"
            raise table.refuse(f"column {_name_time(mapping)!r}", problem, remedy)
        return RowTimes(rows, times, [0], mapping.tick_s or 1.0)
    gap_s = mapping.gap_s or max(SHORTEST_GAP_S, GAP_STEPS * _measure_usual(times))
    rows, times, starts = _sort_late_rows(table, rows, times, gap_s)
    times = _spread_equal_times(table, rows, times, starts, gap_s)
    usual = _measure_usual(times)
    _refuse_unit(table, mapping, usual)
    starts = _find_gaps(table, rows, times, starts, gap_s)
    return RowTimes(rows, times, starts, usual)


def _name_time(mapping: RecordingMap) -> str:
    return mapping.time if isinstance(mapping.time, str) else join_names(mapping.time or ())


def _measure_usual(times: Column) -> float:
    """Return the median of the time between two rows, those of equal time taken as spread evenly, s."""
    known = times[~np.isnan(times)]
    steps = np.diff(known)
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
        whole, part = (read_cells(table.list_cells(each, of="the time")).values for each in names)
        return whole - np.nanmin(whole) + part * 1e-9 + np.nanmin(whole)
    cells = table.list_cells(names[0], of="the time")
    times = _parse_times(cells, UNITS[mapping.time_unit][1])
    if np.isnan(times).all() and len(times):
        problem = f"{str(cells[0])!r:.40} is no time"
        remedy = "write seconds, or dates as 2026-05-01T10:00:00.5Z"
        raise table.refuse(f"{table.format_place(0)}, column {names[0]!r}", problem, remedy)
    return _remove_zeros(table, names[0], times)


def _find_split_stamp(header: Sequence[str], name: str) -> list[str] | None:
    """Find the columns of a time that is split into seconds and nanoseconds: stamp.sec and stamp.nanosec."""
    for between in (".", "_", "/"):
        for whole in SECONDS_PARTS:
            for part in NANOSECONDS_PARTS:
                names = [f"{name}{between}{whole}", f"{name}{between}{part}"]
                if set(names) <= set(header):
                    return names
    return None


def _parse_times(cells: Sequence[Any] | Column, factor: float) -> Column:
    """Parse times: numbers in a unit of `factor` seconds, dates, or times of day."""
    if isinstance(cells, np.ndarray) and cells.dtype.kind == "f":
        return cells * factor
    cells = list(cells)
    if all(parse_number(each) is not None for each in cells):
        # Nanoseconds since 1970 have more digits than a float.
        integers = [_parse_integer(each) for each in cells]
        known = [each for each in integers if each is not None]
        if known and len(known) == len(cells) and max(map(abs, known)) > 2**53:
            begin = known[0]
            return np.array([(each - begin) * factor for each in known]) + begin * factor
        return read_cells(cells).values * factor
    day_first = _is_day_first(cells)
    return np.array([_parse_date(each, factor, day_first=day_first) for each in cells], dtype=np.float64)


def _parse_integer(cell: Any) -> int | None:
    try:
        return int(cell) if not isinstance(cell, float) else None
    except (TypeError, ValueError):
        return None


def _is_day_first(cells: Sequence[Any]) -> bool:
    """Return whether dates as 1/2/2026 have the day first: a month above 12 in any of them says so, or else a point."""
    parts = [match.groups() for each in cells if (match := NUMERIC_DATE.fullmatch(str(each).strip()))]
    if any(len(first) < 3 and int(first) > 12 for first, *_ in parts):
        return True
    if any(len(first) < 3 and int(second) > 12 for first, second, *_ in parts):
        return False
    return (
        any("." in str(each).split(" ")[0] for each in cells[:1]) or len({first for first, *_ in parts}) > 1
    )


def _parse_date(cell: Any, factor: float, *, day_first: bool) -> float:
    """Parse a date or a time of day as s since 1970, or since midnight; NaN if it is none."""
    number = parse_number(cell)
    if number is not None:
        return number * factor
    if isinstance(cell, datetime):
        return (cell if cell.tzinfo else cell.replace(tzinfo=UTC)).timestamp()
    if isinstance(cell, timedelta):
        return cell.total_seconds()
    if isinstance(cell, date):
        return datetime(cell.year, cell.month, cell.day, tzinfo=UTC).timestamp()
    if isinstance(cell, time):
        return cell.hour * 3600 + cell.minute * 60 + cell.second + cell.microsecond * 1e-6
    text = str(cell).strip().removesuffix(" UTC").removesuffix(" GMT")
    if clock := CLOCK.fullmatch(text):
        hours, minutes, seconds = clock.groups()
        return int(hours or 0) * 3600 + int(minutes) * 60 + float(seconds.replace(",", "."))
    if (numeric := NUMERIC_DATE.fullmatch(text)) and len(numeric[1]) < 3:
        one, other, year, clock_text = numeric.groups()
        day, month = (one, other) if day_first else (other, one)
        text = f"{year.rjust(4, '2') if len(year) == 4 else f'20{year}'}-{month:0>2}-{day:0>2} {clock_text}"
    try:
        parsed = datetime.fromisoformat(text.replace(",", ".").replace("/", "-"))
    except ValueError:
        return nan
    return (parsed if parsed.tzinfo else parsed.replace(tzinfo=UTC)).timestamp()


def _remove_zeros(table: RecordedTable, name: str, times: Column) -> Column:
    """Take zeros among seconds since 1970 as no time, as drivers send that do not fill in a stamp."""
    zero = times == 0
    if zero.any() and float(np.nanmedian(times)) > SINCE_1970_S:
        place = table.format_place(int(np.flatnonzero(zero)[0]))
        table.omissions.append(
            f"{table.path} at {place}, column {name!r}: {int(zero.sum())} stamps are 0; their rows are put between "
            "their neighbors"
        )
        times = np.where(zero, nan, times)
    return times


def _drop_rows_before_time(table: RecordedTable, times: Column) -> NDArray[np.int64]:
    """Return the rows from the first one that has a time; those before it are left out."""
    known = np.flatnonzero(~np.isnan(times))
    if not len(known):
        return np.zeros(0, np.int64)
    unknown = len(times) - len(known)
    if unknown:
        first = int(np.flatnonzero(np.isnan(times))[0])
        what = f"{unknown} rows have no time; " if unknown > 1 else "no time; "
        before = f"the {known[0]} at the beginning are left out" if known[0] else "put between its neighbors"
        table.omissions.append(f"{table.path} at {table.format_place(first)}: {what}{before}")
    return np.arange(known[0], len(times))


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
    """Return whether a row was written late, into a hole that rows before it left; else the clock was set back."""
    if top - times[at] > gap_s or not (times[at + 1 : at + 1 + MOST_LATE_ROWS] >= top).any():
        return False
    return bool(np.abs(times[first:at] - times[at]).min() > NEAR * usual)


def _fill_forward(times: Column) -> Column:
    """Give rows without a time that of the row before, with which they are spread."""
    at = np.where(np.isnan(times), 0, np.arange(len(times)))
    filled: Column = times[np.maximum.accumulate(at)]
    return filled


def _spread_equal_times(
    table: RecordedTable, rows: NDArray[np.int64], times: Column, starts: Sequence[int], gap_s: float
) -> Column:
    """Spread rows of equal time evenly over the time until the next one."""
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
    many = np.flatnonzero(counts > 1)
    first = int(begins[many[0]])
    table.omissions.append(
        f"{table.path} at {table.format_place(int(rows[first]))}: {counts[many[0]]} rows have the time "
        f"{times[first]:.12g} s"
        + (f", and so on {len(many) - 1} more times" if len(many) > 1 else "")
        + "; spread evenly until the next"
    )
    return spread


def _refuse_unit(table: RecordedTable, mapping: RecordingMap, usual: float) -> None:
    """Refuse times whose unit must be another one."""
    if mapping.time is None or SHORTEST_STEP_S <= usual <= (mapping.gap_s or LONGEST_STEP_S):
        return
    if usual < SHORTEST_STEP_S:
        problem, remedy = f"rows are {usual:g} s apart", "give the right time_unit"
    else:
        limit = f"gap_s ({mapping.gap_s:g} s)" if mapping.gap_s else f"{LONGEST_STEP_S:g} s"
        problem = f"rows are {usual:g} s apart, farther than {limit}"
        remedy = "give the right time_unit, or a longer gap_s"
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
