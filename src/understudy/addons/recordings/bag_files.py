"""Recordings of ROS 2 in SQLite (.db3) and of ROS 1 (.bag): their topics and messages."""

from __future__ import annotations

import sqlite3
from collections.abc import Collection, Iterator
from contextlib import ExitStack, closing, suppress
from pathlib import Path
from shutil import copyfile
from struct import Struct
from tempfile import TemporaryDirectory

from understudy.addons.recordings.recorded_topics import (
    REMEDY,
    ROS_1,
    MessageFile,
    RecordedMessage,
    describe_damage,
    import_for_messages,
    make_ros_topic,
)
from understudy.addons.recordings.sqlite_pages import SalvagedRow, salvage_rows
from understudy.errors import FileError, UnderstudyError

SIZES = Struct(">16xH10xI")
"""The size of a page of SQLite, and the number of pages, in the beginning of a file."""
ZSTANDARD = b"\x28\xb5\x2f\xfd"
"""The first bytes of a message that was compressed with Zstandard."""
MOST_GAPS = 5
"""The largest number of gaps whose times are said."""


def open_sqlite(path: Path | str, omissions: list[str], stack: ExitStack) -> MessageFile:
    """Open a .db3 file of ROS 2; older ones have no definitions of their types."""
    path = _mend_cut(Path(path), omissions, stack)

    def connect() -> sqlite3.Connection:
        fixed = "" if path.with_name(f"{path.name}-wal").exists() else "&immutable=1"
        return sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro{fixed}", uri=True)

    try:
        with closing(connect()) as connection:
            rows = connection.execute("SELECT id, name, type, serialization_format FROM topics").fetchall()
            try:
                stored = connection.execute(
                    "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
                ).fetchall()
            except sqlite3.Error:
                stored = []  # as ROS 2 wrote them before Iron
        definitions = {type: (text.encode(), encoding) for type, encoding, text in stored}
        topics = {
            name: make_ros_topic(name, type, *definitions.get(type, (b"", "")), encoding)
            for _, name, type, encoding in rows
        }
    except UnderstudyError:
        raise
    except Exception as error:  # a damaged file may have any value in any place
        raise FileError(path=path, place="", problem=describe_damage(error), remedy=REMEDY) from None
    names = {number: name for number, name, *_ in rows}
    opened = MessageFile(path, topics, lambda _: iter(()))

    def iterate(wanted: Collection[str]) -> Iterator[RecordedMessage]:
        numbers = [number for number, name in names.items() if name in wanted]
        marks, last = ",".join("?" * len(numbers)), 0
        # In the order of the file and not by the index of times, half of which a cut file may lack.
        query = f"FROM messages NOT INDEXED WHERE topic_id IN ({marks}) ORDER BY id"
        with closing(connect()) as database:
            with suppress(sqlite3.Error):
                opened.first_ns = database.execute("SELECT min(timestamp) FROM messages").fetchone()[0]
            try:
                for row in database.execute(f"SELECT id, topic_id, timestamp, data {query}", numbers):
                    last, number, time_ns, data = row
                    yield RecordedMessage(names[number], time_ns, _decompress(data))
                return
            except sqlite3.DatabaseError as error:
                damage = error
            columns = [name for _, name, *_ in database.execute("PRAGMA table_info(messages)")]
        lost = _LostRows(last)
        for salvaged in salvage_rows(path, columns, topics=numbers, after=last):
            lost.add(salvaged)
            opened.first_ns = salvaged.time_ns if opened.first_ns is None else opened.first_ns
            if salvaged.data is not None:
                yield RecordedMessage(names[salvaged.topic], salvaged.time_ns, _decompress(salvaged.data))
        if not lost.found:
            raise damage
        counts = lost.describe(opened.first_ns or 0)
        omissions.append(f"{opened.path}: it cannot be read in order ({damage}); {counts}")

    opened.iterate = iterate
    return opened


class _LostRows:
    """The messages that are missing among those that were found page by page, by their numbers."""

    def __init__(self, last: int) -> None:
        self.found = self._lost = 0
        self._number = last
        self._times_ns: list[int] = []

    def add(self, row: SalvagedRow) -> None:
        """Take the next row that was found."""
        missing = row.number - self._number - 1
        if missing:
            self._lost += missing
            self._times_ns.append(row.time_ns)
        self.found, self._number = self.found + 1, row.number

    def describe(self, began_ns: int) -> str:
        """Say how many were found and lost, and up to which times, in seconds since the first message."""
        counts = f"messages found page by page after that: {self.found}"
        if not self._lost:
            return counts
        times = [f"{(each - began_ns) * 1e-9:.1f} s" for each in self._times_ns[:MOST_GAPS]]
        more = ", ..." if len(self._times_ns) > MOST_GAPS else ""
        return f"{counts}; messages lost: {self._lost}, before {', '.join(times)}{more}"


def _mend_cut(path: Path, omissions: list[str], stack: ExitStack) -> Path:
    """Return a copy of a cut file that says how long it is, since SQLite refuses one that is shorter than it says."""
    with path.open("rb") as file:
        page_bytes, pages = SIZES.unpack_from(file.read(SIZES.size).ljust(SIZES.size, b"\0"))
    page_bytes = 65_536 if page_bytes == 1 else page_bytes
    size = path.stat().st_size
    if size >= page_bytes * pages:
        return path
    omissions.append(f"{path}: it has {size} of its {page_bytes * pages} bytes; what can be read is used")
    copy = Path(stack.enter_context(TemporaryDirectory(prefix="understudy-"))) / path.name
    copyfile(path, copy)
    with copy.open("r+b") as file:
        file.truncate(size // page_bytes * page_bytes)
        file.seek(SIZES.size - 4)
        file.write((size // page_bytes).to_bytes(4, "big"))
    return copy


def _decompress(data: bytes) -> bytes:
    if not data.startswith(ZSTANDARD):
        return data
    decompressed: bytes = import_for_messages("zstandard").ZstdDecompressor().decompressobj().decompress(data)
    return decompressed


def open_ros_1(path: Path | str) -> MessageFile:
    """Open a .bag file of ROS 1."""
    path, bags = Path(path), import_for_messages("rosbags.rosbag1")
    try:
        with bags.Reader(path) as reader:
            topics = {
                each.topic: make_ros_topic(
                    each.topic, each.msgtype, each.msgdef.data.encode(), "ros1msg", ROS_1
                )
                for each in reader.connections
            }
            first_ns = reader.start_time
    except Exception as error:  # a reader can raise any error on incomplete or damaged bytes
        remedy = "repair it with rosbag reindex"
        raise FileError(path=path, place="", problem=describe_damage(error), remedy=remedy) from None

    def iterate(wanted: Collection[str]) -> Iterator[RecordedMessage]:
        with bags.Reader(path) as reader:
            chosen = [each for each in reader.connections if each.topic in wanted]
            for connection, time_ns, data in reader.messages(connections=chosen):
                yield RecordedMessage(connection.topic, time_ns, bytes(data))

    return MessageFile(path, topics, iterate, first_ns)
