"""Check of a reader of recordings, on a file and on damaged copies of it."""

from __future__ import annotations

from itertools import pairwise
from numbers import Number
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from understudy.addons.recordings.drive_table import convert_table
from understudy.addons.recordings.mapping_file import RecordingMap
from understudy.addons.recordings.recorded_table import RecordedTable
from understudy.addons.recordings.recording_readers import RecordingReader
from understudy.errors import UnderstudyError
from understudy.testing.laws import LawBroken, require, require_call, require_refusal


def check_reader(reader: RecordingReader, path: Path | str, mapping: RecordingMap | None = None) -> None:
    """Check that a reader reads a recording as its contract says, and what it does with damaged ones.

    The table must have a cell for each column in each row, and become a drive; the file must stay as it is, and give
    the same table again. A missing file must be refused with an UnderstudyError that names it. An empty one, one that
    ends in the middle and one of random bytes must be refused so, or read in part.

    Parameters
    ----------
    reader
        The reader.
    path
        A recording that it can read.
    mapping
        Which columns are what; None for a recording whose columns are called as ours.

    Raises
    ------
    LawBroken
        If the reader breaks a rule.
    """
    path, part = Path(path), f"reader {getattr(reader, '__name__', reader)!r}"
    before = path.read_bytes() if path.is_file() else b""
    table, again = (
        require_call(part, "it reads the recording", lambda: reader(path, mapping)) for _ in range(2)
    )
    check_table(part, table)
    require(
        repr(table) == repr(again), part, "the same file gives the same table", "the second time it differs"
    )
    if path.is_file():
        require(path.read_bytes() == before, part, "it leaves the file as it is", "it changed it")
        _check_damaged(part, reader, path, mapping)
    drive = require_call(part, "its table becomes a drive", lambda: convert_table(table, mapping))
    require(drive.ticks > 1, part, "the drive has ticks", f"it has {drive.ticks}")


def check_table(part: str, table: object) -> None:
    """Check the table that a reader returned."""
    law = "it returns a RecordedTable"
    if not isinstance(table, RecordedTable):
        raise LawBroken(part=part, law=law, found=f"it returned {table!r:.60}")
    header: list[Any] = list(table.header)
    law = "columns have names, each once"
    require(all(isinstance(name, str) and name for name in header), part, law, f"they have {header}")
    require(bool(header) and len(set(header)) == len(header), part, law, f"they have {header}")
    law = "a row has a number in the file, which rises"
    lines, rows = list(table.lines), len(table.cells)
    require(len(lines) == rows, part, law, f"{rows} rows have {len(lines)}")
    require(all(one < other for one, other in pairwise(lines)), part, law, f"they are {lines!r:.60}")
    for row, cells in enumerate(table.cells):
        law = "a row has a cell for each column"
        count = len(cells)
        require(count == len(header), part, law, f"{table.format_place(row)} has {count} of {len(header)}")
        for name, cell in zip(header, cells, strict=True):
            law = "a cell is a number, a text, or None where it is absent"
            fits = cell is None or isinstance(cell, (Number, str))
            place = f"{table.format_place(row)}, column {name!r}"
            require(fits, part, law, f"that of {place} is {type(cell).__name__}")
    for name in [] if table.mapping is None else table.mapping.list_columns():
        require(name in header, part, "its mapping names its columns", f"there is no {name!r} among {header}")
    for each in table.omissions:
        require(isinstance(each, str), part, "omissions are sentences", f"one is {each!r:.60}")


def _check_damaged(part: str, reader: RecordingReader, path: Path, mapping: RecordingMap | None) -> None:
    content = path.read_bytes()
    with TemporaryDirectory() as folder:
        missing = Path(folder) / f"missing{path.suffix}"
        law = "a missing file is refused with an UnderstudyError that names it"
        error = require_refusal(part, law, lambda: reader(missing, mapping))
        require(str(missing) in str(error), part, law, f"it said: {error}")
        damaged = {
            "empty": b"",
            "half": content[: len(content) // 2],
            "random": bytes(range(256)) * 8,
        }
        for name, each in damaged.items():
            copy = Path(folder) / f"{name}{path.suffix}"
            copy.write_bytes(each)
            try:
                check_table(part, reader(copy, mapping))
            except LawBroken:
                raise
            except UnderstudyError:
                continue
            except Exception as error:  # whatever a function of another package does
                law = "a damaged file is read in part, or refused with an UnderstudyError"
                found = f"one that is {name} raised {type(error).__name__}: {error}"
                raise LawBroken(part=part, law=law, found=found) from error
