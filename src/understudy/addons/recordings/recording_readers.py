"""The readers of recordings of other programs, by the ends of the names of files, here and in other packages."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from pkgutil import resolve_name
from typing import Protocol, cast

from understudy.addons.recordings.mapping_file import RecordingMap
from understudy.addons.recordings.recorded_bytes import strip_compression
from understudy.addons.recordings.recorded_table import RecordedTable
from understudy.entry_points import READERS, list_entry_points, load_object
from understudy.errors import SettingError

CSV = "understudy.addons.recordings.table_readers.read_csv"
JSON_LINES = "understudy.addons.recordings.table_readers.read_json_lines"
MESSAGES = "understudy.addons.recordings.recorded_messages.read_messages"
FOLDER = ""
"""Stands for the end of the name of a folder."""
BUILTIN_READERS: Mapping[str, str] = {
    ".csv": CSV,
    ".jsonl": JSON_LINES,
    ".ndjson": JSON_LINES,
    ".parquet": "understudy.addons.recordings.table_readers.read_parquet",
    ".mcap": MESSAGES,
    ".bag": MESSAGES,
    ".db3": MESSAGES,
    FOLDER: MESSAGES,
}
"""The place of each built-in reader, by the end of the names of its files."""
REMEDY = "let the entry point name a function from a path and a RecordingMap, or None, to a RecordedTable"


class RecordingReader(Protocol):
    """A reader of recordings: a function from a file, and the mapping that says which columns are used, to a table.

    It reads all columns, or only those that the mapping names; without a mapping, columns are called as ours: `time_s`,
    `command.drive`, `range(ball)`. It uses what can be used of a damaged file, and says what it left out. It raises a
    FileError if there is no such file, or nothing of it can be used. It changes no file, and gives the same table for
    the same file. It is called in any thread, once for each file.
    """

    def __call__(self, path: Path, mapping: RecordingMap | None, /) -> RecordedTable:
        """Read a file."""
        ...


def find_reader(path: Path | str) -> RecordingReader:
    """Find the reader of a recording by the end of its name; a file that no reader knows is read as CSV.

    SettingError is raised if another package offers the reader, and it cannot be loaded.
    """
    path = Path(path)
    suffix = FOLDER if path.is_dir() else strip_compression(path).suffix.lower() or ".csv"
    name = suffix.removeprefix(".")
    if suffix not in BUILTIN_READERS and name in list_entry_points(READERS):
        return _load_reader(name)
    return cast("RecordingReader", resolve_name(BUILTIN_READERS.get(suffix, CSV)))


def _load_reader(name: str) -> RecordingReader:
    function = load_object(name, READERS, where="reader", remedy=REMEDY)
    if not callable(function):
        problem = f"is a {type(function).__name__}"
        raise SettingError(where="reader", setting=repr(name), problem=problem, remedy=REMEDY)

    def read(path: Path, mapping: RecordingMap | None) -> RecordedTable:
        table = function(path, mapping)
        if not isinstance(table, RecordedTable):
            problem = f"returned a {type(table).__name__}"
            raise SettingError(where="reader", setting=repr(name), problem=problem, remedy=REMEDY)
        return table

    return read
