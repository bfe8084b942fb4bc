"""Parquet, converted from JSON lines by DuckDB, which is imported when it is needed."""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from understudy.errors import FileError, SettingError
from understudy.extras import format_install_command
from understudy.storage.atomic_write import FULL

LINES, PARQUET = ".jsonl", ".parquet"
"""The endings of files with JSON lines and of Parquet."""


def import_duckdb(path: Path | str, *, where: str) -> Any:
    """Import DuckDB, which writes the Parquet file of this path; SettingError if it is not installed."""
    try:
        return import_module("duckdb")
    except ImportError as missing:
        remedy = f"{format_install_command('parquet')}, or name a file that ends in {LINES}"
        problem = "is Parquet, which needs DuckDB"
        raise SettingError(where=where, setting=repr(str(path)), problem=problem, remedy=remedy) from missing


def convert_to_parquet(
    lines: Path | str, output: Path | str, columns: Mapping[str, str], *, key: str = "", metadata: str = ""
) -> None:
    """Convert a file of JSON lines to Parquet.

    Parameters
    ----------
    lines
        The file of JSON lines. Lines in which the first column is missing are left out.
    output
        The Parquet file to write.
    columns
        The columns by title, with their types in DuckDB. Other keys of the lines are left out.
    key
        The key under which metadata is stored; empty for none.
    metadata
        The metadata, as text.

    Raises
    ------
    OSError
        If the file cannot be written, as on a full disk.
    """
    spelled = ", ".join(f"{_quote(title)}: {_quote(kind)}" for title, kind in columns.items())
    first = '"' + next(iter(columns)).replace('"', '""') + '"'
    stored = f", KV_METADATA {{{key}: {_quote(metadata)}}}" if key else ""
    duckdb = import_module("duckdb")
    with duckdb.connect() as database:
        try:
            database.execute(
                f"COPY (SELECT * FROM read_json({_quote(_escape_pattern(lines))}, format = 'newline_delimited', "
                f"columns = {{{spelled}}}) WHERE {first} IS NOT NULL) "
                f"TO {_quote(str(output))} (FORMAT parquet, COMPRESSION zstd{stored})"
            )
        except duckdb.IOException as error:
            number = next((each for each in FULL if os.strerror(each) in str(error)), errno.EIO)
            raise OSError(number, os.strerror(number), str(output)) from error


def read_parquet_rows(
    path: Path | str, *, limit: int | None = None
) -> tuple[list[tuple[Any, ...]], list[str], bytes]:
    """Read a Parquet file.

    Parameters
    ----------
    path
        The file.
    limit
        The largest number of rows to read. None: all.

    Returns
    -------
    tuple
        The rows, the titles of their columns, and the metadata under the key "understudy", empty if there is none.

    Raises
    ------
    FileError
        If DuckDB is not installed, or the file is no Parquet.
    """
    try:
        duckdb = import_module("duckdb")
    except ImportError:
        problem = "it is Parquet, which needs DuckDB"
        raise FileError(
            path=path, place="", problem=problem, remedy=format_install_command("parquet")
        ) from None
    with duckdb.connect() as database, Path(path).open("rb"):
        try:
            metadata = database.execute(
                "SELECT value FROM parquet_kv_metadata(?) WHERE decode(key) = 'understudy'", [str(path)]
            ).fetchone()
            ending = "" if limit is None else f" LIMIT {limit}"
            result = database.execute(f"SELECT * FROM read_parquet(?){ending}", [str(path)])
            titles = [column[0] for column in result.description]
            return result.fetchall(), titles, metadata[0] if metadata else b""
        except duckdb.Error as error:
            raise FileError(
                path=path, place="", problem=f"it cannot be read ({error})", remedy="restore it"
            ) from None


def _escape_pattern(path: Path | str) -> str:
    """Escape a path in which DuckDB would find a pattern."""
    return "".join(f"[{letter}]" if letter in "*?[" else letter for letter in str(path))


def _quote(value: str) -> str:
    return "'" + value.replace("'", "''") + "'"
