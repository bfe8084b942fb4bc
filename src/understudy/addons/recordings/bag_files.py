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
from understudy.errors import FileError, UnderstudyError

SIZES = Struct(">16xH10xI")
"""The size of a page of SQLite, and the number of pages, in the beginning of a file."""
ZSTANDARD = b"\x28\xb5\x2f\xfd"
"""The first bytes of a message that was compressed with Zstandard."""


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
        marks = ",".join("?" * len(numbers))
        # In the order of the file and not by the index of times, half of which a cut file may lack.
        query = f"SELECT topic_id, timestamp, data FROM messages NOT INDEXED WHERE topic_id IN ({marks}) ORDER BY id"
        with closing(connect()) as database:
            with suppress(sqlite3.Error):
                opened.first_ns = database.execute("SELECT min(timestamp) FROM messages").fetchone()[0]
            for number, time_ns, data in database.execute(query, numbers):
                plain = _decompress(data) if data.startswith(ZSTANDARD) else data
                yield RecordedMessage(names[number], time_ns, plain)

    opened.iterate = iterate
    return opened


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
