"""Traces: place and states of each robot in each tick, written during a run as JSON lines or Parquet.

JSON lines have one line per robot and tick, which jq, pandas, DuckDB and people can read. Parquet has the same
columns and takes a tenth of the space.
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
"""The columns of a trace, with their types in DuckDB."""
DIGITS = 6
BETWEEN = " > "
"""The text between the states of a path, outermost first."""


class TraceRow(msgspec.Struct, frozen=True):
    """A line of a trace: place (m), heading (rad) and states of one robot after a tick, the outermost state first."""

    time_s: float
    robot: int
    x: float
    y: float
    heading: float
    doing: str


class TraceWriter:
    """A writer of a trace that `write_trace` opened."""

    def __init__(self, file: IO[bytes], header: dict[str, Any]) -> None:
        self._file, self._encoder = file, msgspec.json.Encoder()
        self._whole = self._file.write(self._encoder.encode_lines([header]))
        self.ticks = 0

    def add(self, view: WorldView, paths: Sequence[Sequence[str]]) -> None:
        """Record the place of each robot, and the states it is in, outermost first."""
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
        """Flush the trace to disk, and cut off a tick whose writing was interrupted."""
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
    """Write a trace to a file that ends in .jsonl or .parquet; an existing file is replaced when the run has ended.

    `run` has what is needed to repeat the run, if that is known. However the run ends, the trace has all ticks until
    then; if there are none, no file is written.
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
    """Import DuckDB, which writes Parquet; raise SettingError before a run begins if it is not installed."""
    try:
        return import_module("duckdb")
    except ImportError as missing:
        remedy = f"{format_install_command('parquet')}, or name a file that ends in {LINES}"
        problem = "is Parquet, which needs DuckDB"
        raise SettingError(
            where="trace", setting=repr(str(path)), problem=problem, remedy=remedy
        ) from missing


def _finish(lines: Path, path: Path, header: dict[str, Any], *, parquet: bool) -> None:
    """Put the complete trace in its place."""
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
    """Escape a path in which DuckDB would find a pattern."""
    return "".join(f"[{letter}]" if letter in "*?[" else letter for letter in str(path))


def _text(value: str) -> str:
    return "'" + value.replace("'", "''") + "'"
