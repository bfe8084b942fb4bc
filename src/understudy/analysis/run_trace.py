"""Traces: where each robot was and what it did, tick by tick, on disk while it runs - JSON lines, or Parquet.

A line for each robot and tick is long but plain: it is cut, filtered and grouped by whatever reads it (jq, pandas,
DuckDB, a person), and the columns are the same in Parquet, which takes a tenth of the room.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import IO, Any

import msgspec
import numpy as np

from understudy.errors import SettingError
from understudy.extras import format_install_command
from understudy.sim.view import WorldView
from understudy.storage.atomic_write import UNFINISHED, convert_os_errors, sync_folder

VERSION = 1
LINES, PARQUET = ".jsonl", ".parquet"
COLUMNS = {
    "time_s": "DOUBLE",
    "robot": "INTEGER",
    "x": "DOUBLE",
    "y": "DOUBLE",
    "heading": "DOUBLE",
    "doing": "VARCHAR",
}
"""What a trace holds, as DuckDB calls its types."""
DIGITS = 6
BETWEEN = " > "
"""Between the states of a path, outermost first."""


class TraceRow(msgspec.Struct, frozen=True):
    """Where one robot was after a tick, and the states it was in then, outermost first: a line of a trace."""

    time_s: float
    robot: int
    x: float
    y: float
    heading: float
    doing: str


class TraceWriter:
    """Writes a trace that `write_trace` opened."""

    def __init__(self, file: IO[bytes], header: dict[str, Any]) -> None:
        self._file, self._encoder = file, msgspec.json.Encoder()
        self._whole = self._file.write(self._encoder.encode_lines([header]))
        self.ticks = 0

    def add(self, view: WorldView, paths: Sequence[Sequence[str]]) -> None:
        """Record a moment: each robot's place, and the states it is in, outermost first."""
        robots, time_s = view.robots, round(view.time_s, DIGITS)
        rows = zip(
            *(np.round(column, DIGITS).tolist() for column in (robots.x, robots.y, robots.heading)),
            map(BETWEEN.join, paths),
            strict=True,
        )
        data = self._encoder.encode_lines(
            [
                TraceRow(time_s, robot, x, y, heading, doing)
                for robot, (x, y, heading, doing) in enumerate(rows)
            ]
        )
        self._file.write(data)
        self._file.flush()
        self._whole += len(data)
        self.ticks += 1

    def close(self) -> None:
        """Leave whole ticks on disk: of one that was interrupted nothing remains."""
        self._file.flush()
        self._file.truncate(self._whole)
        os.fsync(self._file.fileno())


@contextmanager
def write_trace(
    path: Path | str,
    *,
    scenario: str,
    seed: int,
    tick_s: float,
    robots: int,
    run: Mapping[str, Any] | None = None,
) -> Iterator[TraceWriter]:
    """Write a trace to a file that ends in .jsonl or .parquet; what is there stays until the run has ended.

    `run` says what it takes to run it again, where that is known.

    However the run ends, the trace holds every tick until then; where there is none, nothing is written.
    """
    path = Path(path)
    parquet = _is_parquet(path)
    header = {
        "format": "understudy trace",
        "version": VERSION,
        "scenario": scenario,
        "seed": seed,
        "tick_s": tick_s,
        "robots": robots,
        **({} if run is None else {"run": run}),
    }
    lines = path.with_name(f".{path.name}.{os.getpid()}{LINES}{UNFINISHED}")
    with convert_os_errors(path, "writing the trace"):
        file = lines.open("wb")
    try:
        with file:
            writer = TraceWriter(file, header)
            try:
                yield writer
            finally:
                with convert_os_errors(path, "writing the trace"):
                    writer.close()
                    if writer.ticks:
                        _finish(lines, path, header, parquet=parquet)
    finally:
        lines.unlink(missing_ok=True)


def _is_parquet(path: Path) -> bool:
    suffix = path.suffix.lower()
    if suffix not in (LINES, PARQUET):
        remedy = f"name a file that ends in {LINES} (to read) or {PARQUET} (for tables)"
        raise SettingError(where="trace", setting=repr(str(path)), problem="is not a trace", remedy=remedy)
    if suffix == PARQUET:
        _duckdb(path)
    return suffix == PARQUET


def _duckdb(path: Path) -> Any:
    """DuckDB, which writes Parquet; told before a run begins where it is not installed."""
    try:
        return import_module("duckdb")
    except ImportError as missing:
        remedy = f"{format_install_command('parquet')}, or name a file that ends in {LINES}"
        problem = "is Parquet, which needs DuckDB"
        raise SettingError(
            where="trace", setting=repr(str(path)), problem=problem, remedy=remedy
        ) from missing


def _finish(lines: Path, path: Path, header: dict[str, Any], *, parquet: bool) -> None:
    """Put the trace in its place, whole."""
    if not parquet:
        lines.replace(path)
    else:
        made = path.with_name(f".{path.name}.{os.getpid()}{UNFINISHED}")
        try:
            _convert(lines, made, header)
            made.replace(path)
        finally:
            made.unlink(missing_ok=True)
    sync_folder(path.parent)


def _convert(lines: Path, made: Path, header: dict[str, Any]) -> None:
    about = msgspec.json.encode(header).decode()
    with _duckdb(made).connect() as database:
        database.execute(
            f"COPY (SELECT * FROM read_json({_text(_no_glob(lines))}, format = 'newline_delimited', "
            f"columns = {COLUMNS}) WHERE robot IS NOT NULL) "
            f"TO {_text(str(made))} (FORMAT parquet, COMPRESSION zstd, KV_METADATA {{understudy: {_text(about)}}})"
        )


def _no_glob(path: Path) -> str:
    """A path that stands for nothing but itself, where DuckDB takes patterns."""
    return "".join(f"[{letter}]" if letter in "*?[" else letter for letter in str(path))


def _text(value: str) -> str:
    return "'" + value.replace("'", "''") + "'"
