"""Tables as people have them: separators, commas, comments, titles, encodings, compression, nested fields, damage."""

import bz2
import gzip
import io
import json
import lzma
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from understudy.addons.recordings.drive_table import read_recorded_drive
from understudy.addons.recordings.recorded_table import RecordedTable
from understudy.addons.recordings.table_readers import read_csv, read_json_lines, read_parquet
from understudy.errors import FileError

HEADER = "time_s,range(ball),command.drive"
ROWS = [f"{row / 10},{1000.5 + row},{row % 20 / 10 - 0.5}" for row in range(100)]
TEXT = "\n".join([HEADER, *ROWS]) + "\n"
EURO = TEXT.replace(",", ";").replace(".", ",").replace("command,", "command.")


def group(text: str, mark: str) -> str:
    """Write a mark between thousands: 1.000,5 for 1000,5."""
    return text.replace("1000", f"1{mark}000").replace(";10", f";1{mark}0")


WRITTEN: list[tuple[str, str | bytes, str]] = [  # what is odd, the file, what is said
    ("nothing", TEXT, ""),
    ("lines of Windows", TEXT.replace("\n", "\r\n"), ""),
    ("lines of old Macs", TEXT.replace("\n", "\r"), ""),
    ("spaces", TEXT.replace(",", " , "), ""),
    ("quotes", "\n".join('"' + line.replace(",", '","') + '"' for line in TEXT.splitlines()), ""),
    ("tabs", TEXT.replace(",", "\t"), "its columns are separated by tabs"),
    ("bars", TEXT.replace(",", "|"), "its columns are separated by bars"),
    ("semicolons", TEXT.replace(",", ";"), "its columns are separated by semicolons"),
    ("decimal commas", EURO, "300 numbers are read with decimal commas, such as 0,0 as 0.0"),
    ("decimal commas and points", group(EURO, "."), "decimal commas, such as 1.000,5 as 1000.5"),
    ("tabs and decimal commas", EURO.replace(";", "\t"), "300 numbers are read with decimal commas"),
    ("a named separator", "sep=;\n" + TEXT.replace(",", ";"), "its columns are separated by semicolons"),
    (
        "English thousands",
        group(TEXT.replace(",", ";"), ","),
        "commas between thousands, such as 1,000.5 as 1000.5",
    ),
    ("a separator at the end", TEXT.replace("\n", ",\n"), ""),
    ("a separator at the end of rows", TEXT.replace("\n", ",\n").replace("drive,", "drive", 1), ""),
    ("comments", "# by me\n" + TEXT.replace("\n0.5", "\n# pause, here\n0.5"), ""),
    ("names in a comment", "# by me\n# " + TEXT, ""),
    ("a title", "My drive\n\n" + TEXT, "line 1: a title; left out"),
    ("names again", TEXT + HEADER + "\n", "line 102: it has the names of the columns again; left out"),
    ("empty lines", TEXT.replace("\n", "\n\n"), ""),
    ("UTF-8 with its mark", TEXT.encode("utf-8-sig"), ""),
    ("UTF-16", TEXT.encode("utf-16"), ""),
    ("UTF-16 without its mark", TEXT.encode("utf-16-be"), ""),
    ("UTF-32", TEXT.encode("utf-32"), ""),
    ("Windows-1252", ("# Größe\n" + TEXT).encode("cp1252"), "line 1: a letter is not in UTF-8"),
    ("zeros at the end", TEXT.encode() + b"\0" * 5000, "line 102: bytes that were never written; left out"),
    ("gzip", gzip.compress(TEXT.encode()), ""),
    ("bzip2", bz2.compress(TEXT.encode()), ""),
    ("xz", lzma.compress(TEXT.encode()), ""),
]


def write(folder: Path, content: str | bytes, name: str = "drive.csv") -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize(("what", "content", "said"), WRITTEN, ids=[each[0] for each in WRITTEN])
def test_tables_are_read_however_they_are_written(
    tmp_path: Path, what: str, content: str | bytes, said: str
) -> None:
    drive = read_recorded_drive(write(tmp_path, content))
    table = np.array([row.split(",") for row in ROWS], np.float64)
    np.testing.assert_allclose(drive.times, table[:, 0])
    np.testing.assert_allclose(drive.values["range", "ball"], table[:, 1])
    np.testing.assert_allclose(drive.commands[:, 0], table[:, 2])
    assert any(said in each for each in drive.omissions) if said else drive.omissions == ()


def test_compressed_files_may_be_called_so(tmp_path: Path) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("folder/drive.csv", TEXT)
    for name, content in (("a.csv.gz", gzip.compress(TEXT.encode())), ("b.zip", packed.getvalue())):
        assert read_recorded_drive(write(tmp_path, content, name)).ticks == 100
    zstandard = pytest.importorskip("zstandard")
    halves = b"".join(map(zstandard.compress, (TEXT[:900].encode(), TEXT[900:].encode())))
    assert read_recorded_drive(write(tmp_path, halves, "c.csv.zst")).ticks == 100
    with pytest.raises(FileError, match="it cannot be decompressed"):
        read_recorded_drive(write(tmp_path, halves[:-20], "d.csv.zst"))


LEFT_OUT: list[tuple[str | bytes, int, str]] = [  # the file, its rows that are read, what is said
    (TEXT.replace("\n0.5,", "\n0.5,1,"), 99, "line 7: 4 cells instead of 3; left out"),
    (
        TEXT.replace("\n0.5,", "\n0.5;").replace("\n0.7,", "\n"),
        98,
        "line 7 and 1 more lines: 2 cells instead of 3",
    ),
    (TEXT + "10.0,1100", 100, "line 102: 2 cells instead of 3; the file ends in the middle of it"),
    (TEXT.encode("utf-16")[:-5], 100, "it ends in the middle of a letter"),
    (
        TEXT.replace("1050.5", "10" + "\0" * 999 + "50.5"),
        99,
        "bytes that were never written; left out",
    ),
]


@pytest.mark.parametrize(("content", "rows", "said"), LEFT_OUT, ids=[each[2] for each in LEFT_OUT])
def test_what_is_left_out_is_said(tmp_path: Path, content: str | bytes, rows: int, said: str) -> None:
    table = read_csv(write(tmp_path, content))
    assert len(table.cells) == rows
    assert any(said in each for each in table.omissions)


REFUSED: list[tuple[str | bytes, str]] = [  # the file, the problem
    (
        TEXT.replace("range(ball)", "time_s"),
        "line 1: 2 columns are called 'time_s'; rename one, or name the one",
    ),
    (TEXT.replace("range(ball)", "command.drive"), "line 1: 2 columns are called 'command.drive'"),
    (
        TEXT.replace("time_s,range(ball)", "range(ball),range(ball)"),
        "line 1: 2 columns are called 'range(ball)'",
    ),
    ("\n".join(ROWS), "line 1: it has numbers, and not the names of the columns"),
    (TEXT.replace("1010.5", '"1010.5'), "line 12: a quotation mark there is never closed"),
    (HEADER, "it has no rows"),
    ("\n".join([HEADER, *(row.replace(".", ",") for row in ROWS)]), "it has no rows (before that: "),
    (b"\0" * 500, "it is empty"),
    (b"", "it is empty"),
    (bytes(range(256)) * 8, "it is no text"),
    ("a" * 200_000 + ",b\n1,2\n", "it cannot be read"),
    (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "it is a pointer of git-lfs"),
    (gzip.compress(TEXT.encode())[:-30], "it cannot be decompressed"),
]


@pytest.mark.parametrize(("content", "problem"), REFUSED, ids=[each[1] for each in REFUSED])
def test_what_is_no_table_is_refused(tmp_path: Path, content: str | bytes, problem: str) -> None:
    with pytest.raises(FileError) as caught:
        read_recorded_drive(write(tmp_path, content))
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_archive_of_two_files_is_refused(tmp_path: Path) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("one.csv", TEXT)
        archive.writestr("two.csv", TEXT)
    with pytest.raises(FileError, match="it has 2 files, and one is expected; unpack it"):
        read_recorded_drive(write(tmp_path, packed.getvalue(), "drives.zip"))


def test_a_column_of_two_with_one_name_can_be_named(tmp_path: Path) -> None:
    table = read_csv(write(tmp_path, "x,x,\n1,2,3\n"))
    assert table.header == ("x (column 1)", "x (column 2)", " (column 3)")
    assert table.list_cells("x (column 2)", of="a reading") == ["2"]


NESTED = {
    "time_s": 0.5,
    "pose": {"at": {"x": 1}},
    "scan": [1, [2, 3]],
    "ok": True,
    "mode": "auto",
    "none": None,
}
FLAT = {
    "time_s": 0.5,
    "pose.at.x": 1,
    "scan.0": 1,
    "scan.1.0": 2,
    "scan.1.1": 3,
    "ok": True,
    "mode": "auto",
    "none": None,
}


def test_nested_fields_are_columns(tmp_path: Path) -> None:
    table = read_json_lines(
        write(tmp_path, json.dumps(NESTED) + '\n\n{"scan": [7, []], "more": "a\u2028b"}\n')
    )
    assert table.header == (*FLAT, "more")
    assert [*table.cells[0]] == [*FLAT.values(), None]
    assert table.cells[1][2:4] == [7, None]
    assert list(table.lines) == [1, 3]


def test_nested_columns_of_parquet(tmp_path: Path) -> None:
    duckdb = pytest.importorskip("duckdb")
    with duckdb.connect() as database:
        struct = "{'x': i, 'more': [i, 2 * i]}"
        query = f"SELECT i AS time_s, CASE WHEN i > 1200 THEN {struct} END AS pose FROM range(1300) t(i)"
        database.execute(f"COPY ({query}) TO '{tmp_path / 'drive.parquet'}' (FORMAT parquet)")
    table = read_parquet(tmp_path / "drive.parquet")
    assert {"pose.x", "pose.more.0", "pose.more.1"} <= set(table.header)
    assert [*table.cells[1250]][:1] == [1250]


ODD_LINES: list[tuple[str, str]] = [  # the lines, the problem or what is said
    ('{"x": 1, "x": 2}', "line 1: 'x' is there twice; rename one of them"),
    ('{"a": {"b": 1}, "a.b": 2}', "line 1: 'a.b' is there twice"),
    ('[{"x": 1}]', "no line has a JSON object; write an object in each line"),
    ("[" * 100_000, "no line has a JSON object"),
    ('{"x": 1}\nnonsense\n[]\n{"x": 2}', "line 2 and 1 more lines: no JSON object; left out"),
    ('{"x": 1}\n{"x": ', "line 2: no JSON object; the file ends in the middle of it"),
    (json.dumps({"x": [0] * 5000}), "line 1: 'x' has 5000 elements; the first 4096 are used"),
]


@pytest.mark.parametrize(("text", "said"), ODD_LINES, ids=[each[1] for each in ODD_LINES])
def test_odd_lines_of_json(tmp_path: Path, text: str, said: str) -> None:
    def read(path: Path) -> RecordedTable:
        return read_json_lines(path)

    path = write(tmp_path, text)
    assert said in say(read, path)


def say(read: Callable[[Path], Any], path: Path) -> str:
    """What is said of a file, or why it is refused."""
    try:
        return "\n".join(read(path).omissions)
    except FileError as error:
        return str(error)
