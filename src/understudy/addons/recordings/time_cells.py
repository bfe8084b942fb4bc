"""What the cells of a column of times mean: numbers, stamps since 1970, dates in their usual forms, or times of day."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, date, datetime, time, timedelta
from math import nan
from typing import Any

import numpy as np

from understudy.addons.recordings.table_cells import parse_number, read_cells
from understudy.model.value_kinds import Column

DAY_S, HOUR_S = 86_400.0, 3_600.0
NUMERIC_DATE = re.compile(r"(\d{1,4})[./-](\d{1,2})[./-](\d{1,4})[T ,]+(.*)")
CLOCK = re.compile(r"(?:(-?\d+) days?,? \+?)?(?:(\d{1,2}):)?(\d{1,2}):(\d{1,2}(?:[.,]\d*)?)")
HALF_DAY = re.compile(r"(.*\d) ?([ap])\.?m\.?", re.IGNORECASE)
"""A time of a clock with twelve hours."""
MONTHS = ["jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec"]
NAMED_MONTH = re.compile(rf"(\d{{1,2}})[ -]({'|'.join(MONTHS)})[a-z]*[ -](\d{{4}})\b", re.IGNORECASE)


def parse_times(cells: Sequence[Any] | Column, factor: float) -> Column:
    """Parse times.

    Parameters
    ----------
    cells
        Numbers, dates or times of day, as values of Python or as texts.
    factor
        The unit of numbers, s.

    Returns
    -------
    array
        The times, s since 1970 or since midnight, and NaN where a cell is none. They go on at midnight.
    """
    if isinstance(cells, np.ndarray) and cells.dtype.kind == "f":
        return cells * factor
    cells = list(cells)
    if all(parse_number(each) is not None for each in cells):
        return read_cells(cells).values * factor
    day_first = _is_day_first(cells)
    times = np.array([_parse_date(each, factor, day_first=day_first) for each in cells], dtype=np.float64)
    rows = np.flatnonzero(~np.isnan(times))
    if len(rows) and (period_s := _find_period(cells[rows[0]])):  # the clock goes on from 0 at midnight
        times[rows] = np.unwrap(times[rows], period=period_s)
    return times


def _find_period(cell: Any) -> float:
    """Return after how many seconds a time of day comes again; 0 for other times."""
    if isinstance(cell, time):
        return DAY_S
    clock = CLOCK.fullmatch(_split_half_day(str(cell))[0])
    if clock is None or clock[1] is not None:
        return 0.0
    return DAY_S if clock[2] else HOUR_S


def _split_half_day(text: str) -> tuple[str, str]:
    """Split a time of a clock with twelve hours into the time and a or p; others have neither."""
    text = text.strip().removesuffix(" UTC").removesuffix(" GMT")
    half = HALF_DAY.fullmatch(text)
    return (half[1], half[2].lower()) if half else (text, "")


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
    text, half = _split_half_day(str(cell))
    seconds = _parse_clock_or_date(text, day_first=day_first)
    if half:
        hour = seconds % DAY_S // HOUR_S
        seconds += DAY_S / 2 * ((half == "p") - (hour == 12))
    return seconds


def _parse_clock_or_date(text: str, *, day_first: bool) -> float:
    if clock := CLOCK.fullmatch(text):
        days, hours, minutes, seconds = clock.groups()
        whole = (int(days or 0) * 24 + int(hours or 0)) * HOUR_S + int(minutes) * 60
        return whole + float(seconds.replace(",", "."))
    if named := NAMED_MONTH.match(text):
        month = MONTHS.index(named[2].lower()) + 1
        text = f"{named[3]}-{month:0>2}-{named[1]:0>2}{text[named.end() :]}"
    if numeric := NUMERIC_DATE.fullmatch(text):
        one, other, third, clock_text = numeric.groups()
        year, month_text, day = (one, other, third) if len(one) == 4 else (third, other, one)
        if len(one) < 3 and not day_first:
            month_text, day = day, month_text
        year = year if len(year) == 4 else f"20{year:0>2}"
        padded = clock_text if clock_text[1:2] != ":" else f"0{clock_text}"
        text = f"{year}-{month_text:0>2}-{day:0>2} {padded}"
    try:
        parsed = datetime.fromisoformat(text.replace(",", ".").replace("/", "-"))
    except ValueError:
        return nan
    return (parsed if parsed.tzinfo else parsed.replace(tzinfo=UTC)).timestamp()
