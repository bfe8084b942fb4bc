"""Episodes read back from the tables of ticks that `understudy export table` writes: CSV, JSON lines and Parquet.

Parquet has the kind and unit of each reading. The other two do not: there, texts are labels, and all else numbers.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from math import nan
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np

from understudy.errors import FileError
from understudy.judging.episodes.episode import Episode
from understudy.judging.run_trace import BETWEEN, COMMAND, READING, ReadingInfo
from understudy.model.value_kinds import Categorical, Column, Continuous, Kind, parse_kind
from understudy.storage.atomic_write import convert_os_errors
from understudy.storage.parquet import LINES, PARQUET, read_parquet_rows

COLUMNS = ("episode", "agent", "tick", "time_s", "states")
"""The columns that every table of ticks has."""
POSE = ("x", "y", "heading")
FORMAT = "understudy ticks"
"""The format that the metadata of Parquet names."""
REMEDY = "name a table of ticks that `understudy export table` wrote"


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


def read_tick_episodes(path: Path | str) -> list[Episode]:
    """Read the episodes of a table of ticks; FileError names what of it is none of such a table."""
    path = Path(path)
    table = _read_rows(path)
    of_episodes: dict[tuple[Any, Any], list[dict[str, Any]]] = {}
    for row in table.rows:
        of_episodes.setdefault((row["episode"], row["agent"]), []).append(row)
    kinds = _find_kinds(table, path)
    try:
        return [
            _make_episode(path, str(agent), rows, kinds, table.about)
            for (_, agent), rows in of_episodes.items()
        ]
    except (KeyError, TypeError, ValueError) as error:
        problem = f"a row of it is not as tables of ticks have them ({type(error).__name__}: {error})"
        raise FileError(path=path, place="", problem=problem, remedy="restore it") from None


def _read_rows(path: Path) -> TickTable:
    with convert_os_errors(path, "reading the table", remedy=REMEDY):
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
        raise FileError(path=path, place="", problem=problem, remedy=REMEDY)
    return table


def _find_kinds(table: TickTable, path: Path) -> dict[str, Kind]:
    """Find the kind of each reading: that of the metadata, labels for texts, and numbers otherwise."""
    kinds: dict[str, Kind] = {}
    for title in table.rows[0]:
        if not title.startswith(READING):
            continue
        label = title.removeprefix(READING)
        if title in table.about:
            kinds[label] = parse_kind(table.about[title].kind, where=f"{path}: {label}")
            continue
        texts = {str(row[title]) for row in table.rows if row[title] not in (None, "")}
        are_numbers = all(_is_number(each) for each in texts)
        kinds[label] = Continuous() if are_numbers else Categorical(tuple(sorted(texts)))
    return kinds


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _make_episode(
    path: Path,
    agent: str,
    rows: Sequence[Mapping[str, Any]],
    kinds: Mapping[str, Kind],
    about: Mapping[str, ReadingInfo],
) -> Episode:
    times = _make_column(rows, "time_s", Continuous())
    steps = np.diff(times)
    channels = [title for title in rows[0] if title.startswith(COMMAND)]
    readings = {label: _make_column(rows, READING + label, kind) for label, kind in kinds.items()}
    return Episode(
        agent=agent,
        tick_s=float(f"{np.median(steps):.6g}") if len(steps) else 1.0,
        times=times,
        states=tuple(tuple(str(row["states"] or "").split(BETWEEN)) if row["states"] else () for row in rows),
        readings=readings,
        kinds=dict(kinds),
        units={label: about[READING + label].unit for label in readings if READING + label in about},
        commands={title.removeprefix(COMMAND): _make_column(rows, title, Continuous()) for title in channels},
        channel_units={
            title.removeprefix(COMMAND): about[title].unit for title in channels if title in about
        },
        pose={name: _make_column(rows, name, Continuous()) for name in POSE if name in rows[0]},
        source=str(path),
    )


def _make_column(rows: Sequence[Mapping[str, Any]], title: str, kind: Kind) -> Column:
    index = {label: float(number) for number, label in enumerate(getattr(kind, "labels", ()))}
    cells = [row.get(title) for row in rows]
    if index:
        return np.array([nan if cell in (None, "") else index[str(cell)] for cell in cells], np.float64)
    return np.array([nan if cell in (None, "") else float(cell) for cell in cells], np.float64)
