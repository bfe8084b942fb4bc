"""Parquet files as LeRobot reads them, written by DuckDB."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from understudy.extras import ExtraMissing

EPISODE = "episode_index"


def connect_database() -> Any:
    """Return a new database in memory, which writes Parquet; raise ExtraMissing if DuckDB is not installed."""
    try:
        return import_module("duckdb").connect()
    except ImportError:
        raise ExtraMissing(what="a LeRobot data set", extra="parquet") from None


def write_rows(
    database: Any,
    path: Path | str,
    columns: Mapping[str, str],
    rows: Sequence[Sequence[Any]],
    *,
    pandas: str = "",
) -> None:
    """Write rows of values.

    Parameters
    ----------
    database
        A connection to DuckDB.
    path
        The file to write. Missing folders are created.
    columns
        Names of the columns, and their types in DuckDB.
    rows
        The rows, with one value per column.
    pandas
        What pandas stores about a table, in JSON; empty for nothing.
    """
    declared = ", ".join(f"{_quote_name(column)} {kind}" for column, kind in columns.items())
    database.execute(f"CREATE OR REPLACE TEMP TABLE written ({declared})")
    database.executemany(f"INSERT INTO written VALUES ({', '.join('?' * len(columns))})", rows)
    _copy(database, "SELECT * FROM written", path, pandas=pandas)


def write_names(database: Any, path: Path | str, what: str, names: Sequence[str]) -> None:
    """Write names and their numbers, with the names as pandas' index: LeRobot looks for them there."""
    described = [
        {"name": f"{what}_index", "pandas_type": "int64", "numpy_type": "int64"},
        {"name": what, "pandas_type": "unicode", "numpy_type": "object"},
    ]
    pandas = {
        "index_columns": [what],
        "column_indexes": [],
        "columns": [{**each, "field_name": each["name"], "metadata": None} for each in described],
        "creator": {"library": "understudy", "version": "1"},
        "pandas_version": "2.2.0",
    }
    columns = {f"{what}_index": "BIGINT", what: "VARCHAR"}
    write_rows(database, path, columns, list(enumerate(names)), pandas=json.dumps(pandas))


def write_arrays(
    database: Any,
    path: Path | str,
    columns: Mapping[str, np.ndarray],
    repeated: str = "",
    row_type: str = "",
    rows: Mapping[int, Sequence[Mapping[str, Any]]] | None = None,
) -> None:
    """Write arrays as columns, and one more column that repeats the same rows throughout each episode.

    Parameters
    ----------
    database
        A connection to DuckDB.
    path
        The file to write. Missing folders are created.
    columns
        Arrays of shape [T], or [T, n], whose rows become lists unless n is 1. NaN is written as NaN.
    repeated
        Name of the column that repeats rows; empty for none.
    row_type
        Type of one of these rows, in DuckDB.
    rows
        The rows of each episode, by its number in the column `episode_index`.
    """
    scalars: dict[str, np.ndarray] = {}
    selected = []
    for name, values in columns.items():
        table = values.reshape(len(values), -1)
        parts = [f"{name}/{number}" for number in range(table.shape[1])]
        scalars |= {part: np.ascontiguousarray(table[:, number]) for number, part in enumerate(parts)}
        present = [_keep_absent(part) if table.dtype == np.float64 else _quote_name(part) for part in parts]
        value = present[0] if len(present) == 1 else f"[{', '.join(present)}]"
        selected.append(f"{value} AS {_quote_name(name)}")
    source = "frames"
    if repeated:
        database.execute(f"CREATE OR REPLACE TEMP TABLE repeats (number BIGINT, rows {row_type}[])")
        database.executemany(
            "INSERT INTO repeats VALUES (?, ?)", [list(each) for each in (rows or {}).items()]
        )
        source = (
            f"frames JOIN repeats ON {_quote_name(f'{EPISODE}/0')} = number ORDER BY {_quote_name('index/0')}"
        )
        selected.append(f"rows AS {_quote_name(repeated)}")
    database.register("frames", scalars)
    _copy(database, f"SELECT {', '.join(selected)} FROM {source}", path)
    database.unregister("frames")


def _keep_absent(name: str) -> str:
    """Return the value of a column of floats: DuckDB takes NaN in an array for NULL, which LeRobot cannot load."""
    return f"coalesce({_quote_name(name)}, 'nan'::DOUBLE)"


def _copy(database: Any, query: str, path: Path | str, *, pandas: str = "") -> None:
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    stored = f", KV_METADATA {{pandas: {_quote_text(pandas)}}}" if pandas else ""
    database.execute(f"COPY ({query}) TO {_quote_text(str(path))} (FORMAT parquet, COMPRESSION zstd{stored})")


def _quote_name(column: str) -> str:
    return '"' + column.replace('"', '""') + '"'


def _quote_text(value: str) -> str:
    return "'" + value.replace("'", "''") + "'"
