"""Readers of tables: CSV files, JSON lines whose objects are rows, and Parquet.

A row that cannot be read is left out, and a sentence says so. `recording_readers` has the reader of each kind of file.
"""

from __future__ import annotations

import csv
import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from itertools import takewhile
from pathlib import Path
from typing import Any

from understudy.addons.recordings.mapping_file import RecordingMap
from understudy.addons.recordings.recorded_bytes import open_decompressed, read_lines
from understudy.addons.recordings.recorded_table import RecordedTable
from understudy.addons.recordings.table_cells import is_number
from understudy.errors import FileError
from understudy.extras import format_install_command

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}
NAMED_SEPARATOR = re.compile(r'"?sep=(.)\1*"?', re.IGNORECASE)
"""A first line by which Excel names the separator."""
THOUSANDS = re.compile(r"[+-]?\d{1,3}(,\d{3})+(\.\d*)?")
"""A number with commas between thousands."""
POINTED_THOUSANDS = re.compile(r"[+-]?\d{1,3}(\.\d{3})+(,\d*)?")
"""A number with points between thousands, where decimals have commas."""
COMMENT = "#"
LONGEST_LIST = 4096
"""The largest number of elements of a list in a cell that become columns of their own."""
REMEDY = "give a CSV file, JSON lines or Parquet"


def read_csv(path: Path | str, mapping: RecordingMap | None = None) -> RecordedTable:
    """Read a CSV file, whose first row names the columns.

    Columns are separated by commas, semicolons, tabs or bars, whichever the first rows agree on. Lines that begin with
    # are comments.
    """
    path, omissions = Path(path), list[str]()
    lines = read_lines(path, omissions, remedy=REMEDY)
    try:
        separator = _find_separator(lines)
        rows = list(_split_lines(path, lines, separator))
    except csv.Error as error:
        raise FileError(path=path, place="", problem=f"it cannot be read ({error})", remedy=REMEDY) from None
    if not rows:
        raise FileError(path=path, place="", problem="it is empty", remedy="give a table of a drive")
    names, rest = _find_header(path, lines, rows, separator, omissions)
    if separator != ",":
        omissions.append(f"{path}: its columns are separated by {SEPARATORS.get(separator, repr(separator))}")
    width = len(names)
    if width > 1 and not names[-1] and all(len(row) < width or not row[width - 1] for _, row in rest):
        names, width = names[:-1], width - 1  # a separator at the end of each line
    cells, numbers, repeated, odd = [], [], list[int](), dict[int, int]()
    for line, row in rest:
        complete = row[:-1] if len(row) == width + 1 and not row[-1] else row
        if complete == names:
            repeated.append(line)
        elif len(complete) == width:
            cells.append(complete)
            numbers.append(line)
        else:
            odd[line] = len(row)
    _note_lines(path, repeated, "it has the names of the columns again; left out", omissions)
    if rest and (end := rest[-1][0]) in odd:
        what = f"{odd.pop(end)} cells instead of {width}; the file ends in the middle of it"
        omissions.append(f"{path} at line {end}: {what}")
    if odd:
        what = f"{next(iter(odd.values()))} cells instead of {width}; left out"
        _note_lines(path, list(odd), what, omissions)
    _convert_commas(path, cells, separator, omissions)
    return RecordedTable(path, _tell_apart(names), numbers, cells, omissions)


def _note_lines(path: Path, lines: Sequence[int], what: str, omissions: list[str]) -> None:
    """Say the same of some lines in one sentence."""
    if lines:
        more = f" and {len(lines) - 1} more lines" if len(lines) > 1 else ""
        omissions.append(f"{path} at line {lines[0]}{more}: {what}")


def _find_separator(lines: list[str]) -> str:
    """Return the separator by which most of the first lines have as many cells as each other, and more than one.

    Excel may name it in a first line such as sep=; which is removed.
    """
    if lines and (named := NAMED_SEPARATOR.fullmatch(lines[0].strip())):
        lines[0] = ""
        return named[1]
    begin = [each for each in lines[:200] if each.strip() and not each.lstrip().startswith(COMMENT)][:50]
    if not begin:
        return ","

    def measure_agreement(separator: str) -> tuple[float, int]:
        counts = [len(row) for row in csv.reader(begin, delimiter=separator)]
        common, times = Counter(counts).most_common(1)[0]
        return (times / len(counts) if common > 1 else 0.0), common

    return max(SEPARATORS, key=measure_agreement)


def _split_lines(path: Path, lines: Sequence[str], separator: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the cells of each row with the number of its first line; comments and empty lines are left out."""
    plain = ("" if each.lstrip().startswith(COMMENT) else each for each in lines)
    reader = csv.reader((f"{each}\n" for each in plain), delimiter=separator)
    begin = 1
    for row in reader:
        if reader.line_num == len(lines) > begin and "".join(lines[begin - 1 :]).count('"') % 2:
            problem = "a quotation mark there is never closed, and the rest of the file is one cell"
            remedy = "close it, or take it out"
            raise FileError(path=path, place=f"line {begin}", problem=problem, remedy=remedy)
        if row and any(row):
            yield begin, [cell.strip() for cell in row]
        begin = reader.line_num + 1


def _find_header(
    path: Path,
    lines: Sequence[str],
    rows: list[tuple[int, list[str]]],
    separator: str,
    omissions: list[str],
) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Return the names of the columns, from the first row or from a comment before it, and the other rows.

    Titles before the table are left out.
    """
    usual = Counter(len(row) for _, row in rows[:50]).most_common(1)[0][0]
    titles = list(takewhile(lambda row: usual > 1 and len(row[1]) == 1, rows))
    _note_lines(path, [line for line, _ in titles], "a title; left out", omissions)
    (line, first), *rest = rows[len(titles) :]
    if not any(map(is_number, first)):
        return first, rest
    before = next((each for each in reversed(lines[: line - 1]) if each.strip()), "")
    if before.lstrip().startswith(COMMENT):
        names = next(csv.reader([before.strip().lstrip(COMMENT)], delimiter=separator), [])
        if len(names) == len(first) and not any(map(is_number, names)):
            return [name.strip() for name in names], rows[len(titles) :]
    if not all(map(is_number, first)):
        return first, rest
    raise FileError(
        path=path,
        place=f"line {line}",
        problem="it has numbers, and not the names of the columns",
        remedy="write the names of the columns as the first line",
    )


def _tell_apart(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of columns; those that occur twice get the number of their column, from 1."""
    counts = Counter(names)
    return tuple(
        f"{name} (column {number})" if counts[name] > 1 or not name else name
        for number, name in enumerate(names, 1)
    )


def _convert_commas(path: Path, cells: list[list[str]], separator: str, omissions: list[str]) -> None:
    """Write numbers with commas as 1234.5, in place, and say so.

    Commas are those of decimals, unless all numbers of a column say that they are those of thousands.
    """
    marks = ("decimal commas", "commas between thousands")
    counts, examples = [0, 0], ["", ""]
    for at in range(len(cells[0]) if cells else 0):
        commas = [row[at] for row in cells if "," in row[at]]
        style = int(
            all(map(THOUSANDS.fullmatch, commas))
            and (separator == "," or any("." in each for each in commas))
        )
        for row in cells if commas else ():
            cell = row[at]
            if style:
                number = cell.replace(",", "")
            elif POINTED_THOUSANDS.fullmatch(cell):
                number = cell.replace(".", "").replace(",", ".")
            else:
                number = cell.replace(",", ".", 1)
            if number != cell and is_number(number):
                row[at] = number
                counts[style] += 1
                if not examples[style] or ("." in cell and "." not in examples[style].split()[0]):
                    examples[style] = f"{cell} as {number}"
    for count, mark, example in zip(counts, marks, examples, strict=True):
        if count:
            omissions.append(f"{path}: {count} numbers are read with {mark}, such as {example}")


def read_json_lines(path: Path | str, mapping: RecordingMap | None = None) -> RecordedTable:
    """Read JSON lines: an object in each, whose nested keys are columns such as pose.x, and elements scan.0."""
    path, omissions = Path(path), list[str]()
    lines = read_lines(path, omissions, remedy=REMEDY)
    rows: list[dict[str, Any]] = []
    numbers: list[int] = []
    odd: list[int] = []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            value = json.loads(line, object_pairs_hook=_make_object)
        except _TwiceError as error:
            raise _refuse_twice(path, number, str(error)) from None
        except (ValueError, RecursionError):
            value = None
        if isinstance(value, dict):
            rows.append(value)
            numbers.append(number)
        else:
            odd.append(number)
    if odd and odd[-1] == len(lines):
        omissions.append(f"{path} at line {odd.pop()}: no JSON object; the file ends in the middle of it")
    _note_lines(path, odd, "no JSON object; left out", omissions)
    if not rows:
        raise FileError(
            path=path, place="", problem="no line has a JSON object", remedy="write an object in each line"
        )
    return _make_table(path, rows, numbers, omissions)


def read_parquet(path: Path | str, mapping: RecordingMap | None = None) -> RecordedTable:
    """Read a Parquet file; its rows count as lines, from 1, and nested columns are called as in JSON lines."""
    path = Path(path)
    try:
        duckdb = import_module("duckdb")
    except ImportError:
        raise FileError(
            path=path,
            place="",
            problem="it is Parquet, which needs DuckDB",
            remedy=format_install_command("parquet"),
        ) from None
    try:
        with (
            open_decompressed(path, remedy=REMEDY) as plain,
            duckdb.connect() as database,
            plain.open("rb"),
        ):
            result = database.execute("SELECT * FROM read_parquet(?)", [str(plain)])
            names = [each[0] for each in result.description]
            cells = result.fetchall()
    except (OSError, duckdb.Error) as error:
        gone = isinstance(error, FileNotFoundError)
        problem = "there is no such file" if gone else f"it cannot be read ({error})"
        raise FileError(path=path, place="", problem=problem, remedy=REMEDY) from None
    firsts = (next((row[at] for row in cells if row[at] is not None), None) for at in range(len(names)))
    if not any(isinstance(each, (list, tuple, dict)) for each in firsts):
        return RecordedTable(path, tuple(names), range(1, len(cells) + 1), cells, [])
    rows = [dict(zip(names, row, strict=True)) for row in cells]
    return _make_table(path, rows, range(1, len(rows) + 1), [])


class _TwiceError(Exception):
    """A key that an object has twice."""


def _make_object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    content = dict(pairs)
    if len(content) != len(pairs):
        raise _TwiceError(Counter(key for key, _ in pairs).most_common(1)[0][0])
    return content


def _refuse_twice(path: Path, line: int, key: str) -> FileError:
    return FileError(
        path=path, place=f"line {line}", problem=f"{key!r} is there twice", remedy="rename one of them"
    )


def _make_table(
    path: Path, rows: Sequence[Mapping[str, Any]], numbers: Sequence[int], omissions: list[str]
) -> RecordedTable:
    """Make a table of rows whose values may be nested."""
    flat, long = [], dict[str, str]()
    for number, row in zip(numbers, rows, strict=True):
        pairs = list(_flatten(row, f"{path} at line {number}", long))
        try:
            flat.append(_make_object(pairs))
        except _TwiceError as error:
            raise _refuse_twice(path, number, str(error)) from None
    omissions += long.values()
    header = tuple(dict.fromkeys(key for row in flat for key in row))
    return RecordedTable(path, header, numbers, [[row.get(key) for key in header] for row in flat], omissions)


def _flatten(
    content: Mapping[str, Any], place: str, long: dict[str, str], prefix: str = ""
) -> Iterator[tuple[str, Any]]:
    """Yield the values of an object by path, with dots between keys and numbers of elements; say which are too long."""
    for key, value in content.items():
        path = f"{prefix}{key}"
        if isinstance(value, dict):
            yield from _flatten(value, place, long, f"{path}.")
        elif isinstance(value, (list, tuple)):
            if len(value) > LONGEST_LIST:
                what = f"{path!r} has {len(value)} elements; the first {LONGEST_LIST} are used"
                long.setdefault(path, f"{place}: {what}")
            elements = {str(index): each for index, each in enumerate(value[:LONGEST_LIST])}
            yield from _flatten(elements, place, long, f"{path}.")
        else:
            yield path, value
