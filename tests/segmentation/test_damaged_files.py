"""Recordings of messages that were cut or are damaged: MCAP and SQLite."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.segmentation.test_message_files import check_whole, list_messages, read, write_folder, write_mcap

from understudy.addons.recordings.sqlite_pages import salvage_rows
from understudy.errors import FileError

pytest.importorskip("mcap")
pytest.importorskip("rosbags")

CUTS: list[tuple[str, dict[str, Any], Callable[[bytes], bytes]]] = [
    ("in a chunk", {}, lambda content: content[: len(content) // 2]),
    ("in a chunk of LZ4", {"compression": 2}, lambda content: content[: len(content) // 2]),
    ("without chunks", {"use_chunking": False}, lambda content: content[: len(content) // 2]),
    ("zeros from there on", {}, lambda content: content[: len(content) // 2] + b"\0" * 999),
]


@pytest.mark.parametrize(("name", "more", "cut"), CUTS, ids=[each[0] for each in CUTS])
def test_what_comes_before_the_damage_is_read(
    tmp_path: Path, name: str, more: dict[str, Any], cut: Callable[[bytes], bytes]
) -> None:
    from mcap.writer import CompressionType

    if "compression" in more:
        more = {"compression": CompressionType.LZ4}
    path = write_mcap(tmp_path / "drive.mcap", list(list_messages()), **more)
    path.write_bytes(cut(path.read_bytes()))
    drive = read(path)
    assert 60 < drive.ticks < 140
    check_whole(drive, drive.ticks)
    assert any(
        "it cannot be read" in each and "what comes before is used" in each for each in drive.omissions
    )


def find_chunks(path: Path) -> list[tuple[int, int]]:
    """Find the place and the length of each chunk."""
    from mcap.reader import make_reader

    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    return [(each.chunk_start_offset, each.chunk_length) for each in summary.chunk_indexes]


Spoil = Callable[[int], tuple[int, bytes]]
"""Says, by the length of a chunk, what is written where in it."""
DAMAGED_CHUNKS: list[tuple[str, dict[str, Any], Spoil, str]] = [  # the last is what is said
    ("content", {}, lambda length: (length - 99, b"x" * 50), "a chunk is damaged ("),
    ("plain content", {"compression": 0}, lambda _: (900, b"x" * 50), "(its checksum is wrong)"),
    ("checksum", {}, lambda _: (9 + 24, b"\1\2\3\4"), "(its checksum is wrong)"),
    ("a record", {"compression": 0, "enable_crcs": False}, lambda _: (900, b"\xff" * 200), "a record in it"),
    ("its length", {}, lambda _: (1, b"\xff" * 8), " cannot be read ("),
    ("its length, a little", {}, lambda _: (2, b"\x7f"), " cannot be read ("),
    ("zeros", {}, lambda length: (0, b"\0" * length), ""),
]


@pytest.mark.parametrize(
    ("name", "more", "spoil", "said"), DAMAGED_CHUNKS, ids=[each[0] for each in DAMAGED_CHUNKS]
)
@pytest.mark.parametrize("number", [0, 5])
def test_a_damaged_chunk_is_skipped(
    tmp_path: Path, name: str, more: dict[str, Any], spoil: Spoil, said: str, number: int
) -> None:
    from mcap.writer import CompressionType

    if "compression" in more:
        more = more | {"compression": CompressionType.NONE}
    path = write_mcap(tmp_path / "drive.mcap", list(list_messages()), **more)
    content, (at, length) = bytearray(path.read_bytes()), find_chunks(path)[number]
    place, written = spoil(length)
    content[at + place : at + place + len(written)] = written
    path.write_bytes(content)
    drive = read(path)
    assert 150 < drive.ticks < 200
    ranges = drive.values["range", "ball"] * 64
    heard = ~np.isnan(ranges)
    assert heard.sum() >= drive.ticks - 1  # a chunk may end between a range and its command
    np.testing.assert_allclose((drive.times[heard] - drive.times[-1]) / 0.1, ranges[heard] - 199, atol=1e-3)
    (damage,) = (each for each in drive.omissions if "the rest is read" in each)
    assert said in damage, drive.omissions
    lost = "29 messages, of 0.0 to 1.4 s" if number == 0 else "40 messages, of 9.4 to 11.3 s"
    assert "a chunk is damaged" not in damage or "a record in it" in damage or lost in damage


def test_a_file_without_its_end_is_read_whole(tmp_path: Path) -> None:
    path = write_mcap(tmp_path / "drive.mcap", list(list_messages()))
    path.write_bytes(path.read_bytes()[:-100])
    drive = read(path)
    check_whole(drive)
    assert "after message 400" in drive.omissions[0]


def test_sqlite_that_was_cut(tmp_path: Path) -> None:
    path = next(write_folder(tmp_path / "drive").glob("*.db3"))
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * 4 // 5])
    before = path.read_bytes()
    drive = read(path.parent)
    assert 50 < drive.ticks < 200
    check_whole(drive, drive.ticks)
    assert f"it has {len(before)} of its {len(whole)} bytes" in drive.omissions[0]
    assert path.read_bytes() == before


def write_small_pages(path: Path) -> Path:
    """Write the drive as ROS 2 does, on pages so small that their tree is deep and long messages take several."""
    bag = next(write_folder(path).glob("*.db3"))
    with closing(sqlite3.connect(bag)) as old, closing(sqlite3.connect(path / "small.db3")) as new:
        new.execute("PRAGMA page_size = 512")
        for (table,) in old.execute("SELECT sql FROM sqlite_master WHERE type = 'table'").fetchall():
            new.execute(table)
        for name in ("schema", "metadata", "topics", "message_definitions"):
            for row in old.execute(f"SELECT * FROM {name}").fetchall():
                new.execute(f"INSERT INTO {name} VALUES ({','.join('?' * len(row))})", row)
        new.execute(
            "INSERT INTO topics SELECT 9, '/big', type, serialization_format, '', '' FROM topics LIMIT 1"
        )
        for number, *row in old.execute("SELECT * FROM messages ORDER BY id").fetchall():
            new.execute("INSERT INTO messages VALUES (?, ?, ?, ?)", (2 * number - 1, *row))
            new.execute("INSERT INTO messages VALUES (?, 9, ?, ?)", (2 * number, row[1], b"\x0d" * 1500))
            new.commit()
    bag.unlink()
    return path / "small.db3"


@pytest.mark.parametrize("share", [0.2, 0.3, 0.5, 0.7, 0.9])
def test_messages_of_a_cut_file_are_found_page_by_page(tmp_path: Path, share: float) -> None:
    path = write_small_pages(tmp_path / "drive")
    whole = path.read_bytes()
    path.write_bytes(whole[: int(len(whole) * share)])
    drive = read(path)
    assert drive.ticks == pytest.approx(200 * share, abs=12)  # the tables of types come before
    check_whole(drive, drive.ticks)
    assert any("messages found page by page after that: " in each for each in drive.omissions)


@pytest.mark.parametrize("kind", ["a leaf", "an inner page", "a page of a long message"])
def test_messages_after_a_damaged_page_are_found(tmp_path: Path, kind: str) -> None:
    path = write_small_pages(tmp_path / "drive")
    content = bytearray(path.read_bytes())
    first = {"a leaf": 13, "an inner page": 5, "a page of a long message": 0}[kind]
    begin = len(content) // 3 // 512 * 512
    page = next(at for at in range(begin, len(content), 512) if content[at] == first)
    content[page : page + 512] = b"\xff" * 512
    path.write_bytes(content)
    drive = read(path)
    ranges = drive.values["range", "ball"] * 64
    heard = ~np.isnan(ranges)
    assert ranges[heard][-1] == 199
    assert heard.sum() >= (200 if kind == "an inner page" else 190)
    late = (drive.times[heard] - drive.times[-1]) / 0.1 - (ranges[heard] - 199)
    assert np.all((late > -0.01) & (late < 4.0))  # a reading is held where some are lost
    said = " ".join(drive.omissions)
    if kind == "a leaf":
        assert "; messages lost: " in said


@settings(max_examples=50, deadline=None)
@given(places=st.lists(st.integers(100, 40_000), min_size=1, max_size=30), seed=st.integers(0, 99))
def test_any_damage_is_survived(places: list[int], seed: int) -> None:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "rows.db3"
        with closing(sqlite3.connect(path)) as database:
            database.execute("PRAGMA page_size = 512")
            database.execute("CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id, timestamp, data)")
            database.executemany(
                "INSERT INTO messages VALUES (?, ?, ?, ?)",
                [(each, each % 3, each, b"x" * (each * 7)) for each in range(1, 99)],
            )
            database.commit()
        content, random = bytearray(path.read_bytes()), Random(seed)
        for place in places:
            content[place % len(content)] = random.randrange(256)
        path.write_bytes(content)
        for row in salvage_rows(path, ("id", "topic_id", "timestamp", "data"), topics={0, 1, 2}, after=0):
            assert row.number > 0


def test_rows_are_read_as_sqlite_reads_them(tmp_path: Path) -> None:
    path = tmp_path / "rows.db3"
    rows = [
        (7, 1, 0, b""), (8, 0, 1, b"\0"), (9, 127, -1, b"a" * 476), (10, 128, 2**40, b"b" * 477),
        (300, -1, 2**47, b"c" * 478), (2**40, 3, 2**62, b"d" * 5000), (2**62, 3, 5, b"e" * 20_000),
    ]  # fmt: skip
    with closing(sqlite3.connect(path)) as database:
        database.execute("PRAGMA page_size = 512")
        database.execute("CREATE TABLE other (id INTEGER PRIMARY KEY, name TEXT, size INTEGER)")
        database.executemany(
            "INSERT INTO other VALUES (?, ?, ?)", [(each, "x" * 40, each) for each in range(99)]
        )
        database.execute("CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id, timestamp, data)")
        for row in rows:
            database.execute("INSERT INTO messages VALUES (?, ?, ?, ?)", row)
        database.commit()
    columns, topics = ("id", "topic_id", "timestamp", "data"), {row[1] for row in rows}
    found = [tuple(row) for row in salvage_rows(path, columns, topics=topics, after=0)]
    assert found == rows
    assert [row.number for row in salvage_rows(path, columns, topics=topics, after=300)] == [2**40, 2**62]
    assert {row.data for row in salvage_rows(path, columns, topics=(), after=0)} == {None}


DAMAGED = [
    "UPDATE message_definitions SET topic_type = NULL, encoded_message_definition = NULL",
    "UPDATE topics SET name = CAST(x'8f' AS TEXT)",
    "UPDATE topics SET type = NULL",
    "DROP TABLE topics",
]


@pytest.mark.parametrize("damage", DAMAGED)
def test_sqlite_with_any_value_in_any_place_is_refused(tmp_path: Path, damage: str) -> None:
    folder = write_folder(tmp_path / "drive")
    with sqlite3.connect(next(folder.glob("*.db3"))) as database:
        if "message_definitions" in damage:
            database.execute("CREATE TABLE loose AS SELECT * FROM message_definitions")
            database.execute("DROP TABLE message_definitions")
            database.execute("ALTER TABLE loose RENAME TO message_definitions")
        if "topics SET type" in damage:
            database.execute("CREATE TABLE loose AS SELECT * FROM topics")
            database.execute("DROP TABLE topics")
            database.execute("ALTER TABLE loose RENAME TO topics")
        database.execute(damage)
    with pytest.raises(FileError, match=r"drive\.db3: it cannot be read"):
        read(folder)
