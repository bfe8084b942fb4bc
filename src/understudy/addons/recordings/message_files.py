"""Files of recorded messages: MCAP, and recordings of ROS 1 and ROS 2, with or without definitions of their types.

Only the topics that are asked for are decoded. What can be read of a damaged file is read.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, partial
from importlib import import_module
from io import BytesIO
from pathlib import Path
from struct import Struct
from types import SimpleNamespace
from typing import Any, NamedTuple

from understudy.addons.recordings.recorded_bytes import refuse_pointer
from understudy.errors import FileError, UnderstudyError
from understudy.extras import ExtraMissing
from understudy.records.messages import decode_message, list_message_fields, load_typestore

MCAP, SQLITE, ROS_1 = ".mcap", ".db3", ".bag"
REMEDY = "give an MCAP file, or a recording of ROS 1 or ROS 2"
ZSTANDARD = b"\x28\xb5\x2f\xfd"
"""How data begins that a recorder compressed by the message."""
MOST_BYTES = 2**30
"""The largest size of a record, so that a damaged length cannot fill the memory."""
RECORD, HEADER = Struct("<BQ"), Struct("<HIQQ")
"""The beginning of a record of MCAP, and of one that is a message: channel, number, and two times, ns."""
FOOTER_RECORD, SCHEMA_RECORD, CHANNEL_RECORD, MESSAGE_RECORD, CHUNK_RECORD = 2, 3, 4, 5, 6
MAGIC = b"\x89MCAP0\r\n"
ListFields = Callable[[str], Mapping[str, tuple[int, Any]]]


@dataclass(frozen=True, slots=True)
class RecordedTopic:
    """A topic of a recording.

    Attributes
    ----------
    name
        Its name.
    type
        The type of its messages.
    decode
        The function that decodes a message; it may raise any error on bytes that do not fit.
    list_fields
        The function that lists the fields of a type by name; None where messages bring the names of their fields.
    problem
        Why its messages cannot be decoded; empty if they can.
    """

    name: str
    type: str
    decode: Callable[[bytes], Any]
    list_fields: ListFields | None = None
    problem: str = ""


class RecordedMessage(NamedTuple):
    """A message of a topic, with the time at which it was recorded, ns since 1970."""

    topic: str
    time_ns: int
    data: bytes


@dataclass
class MessageFile:
    """A recording of messages.

    Attributes
    ----------
    path
        The file or folder, as the user named it.
    topics
        Its topics by name.
    iterate
        The function that yields the messages of some topics, in the order of the file; any error is raised after the
        last one that can be read.
    first_ns
        The time of the first message, ns since 1970; None before one was read.
    """

    path: Path
    topics: Mapping[str, RecordedTopic]
    iterate: Callable[[Collection[str]], Iterator[RecordedMessage]]
    first_ns: int | None = field(default=None)

    def read_messages(self, topics: Collection[str], omissions: list[str]) -> Iterator[RecordedMessage]:
        """Yield the messages of some topics; say what was left out of a damaged file."""
        count = 0
        try:
            for message in self.iterate(topics):
                count += 1
                yield message
        except UnderstudyError:
            raise
        except Exception as error:  # a reader can raise any error on incomplete or damaged bytes
            problem = _describe_damage(error)
            if not count:
                raise FileError(path=self.path, place="", problem=problem, remedy=REMEDY) from None
            omissions.append(f"{self.path} after message {count}: {problem}; what comes before is used")


def _describe_damage(error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        return "there is no such file"
    text = str(error) or type(error).__name__
    return f"it cannot be read ({text})"


def open_message_file(path: Path, omissions: list[str]) -> MessageFile:
    """Open a recording of messages, and list its topics; a folder may have several files, which follow each other."""
    if path.suffix.lower() == ROS_1 and path.is_file():
        return _open_ros_1(path)
    if not path.is_dir():
        return _open_file(path)
    files = [each for each in sorted(path.iterdir(), key=_sort_key) if _is_part(each)]
    if not files:
        names = ", ".join(sorted(each.name for each in path.iterdir())[:5]) or "nothing"
        problem = f"it has no {MCAP} or {SQLITE} file, but {names}"
        raise FileError(path=path, place="", problem=problem, remedy=REMEDY)
    if not (path / "metadata.yaml").exists():
        omissions.append(
            f"{path}: it has no metadata.yaml, as that of a recorder that was killed; its files are read"
        )
    parts = []
    for each in files:
        try:
            parts.append(_open_file(each))
        except FileError as error:
            if len(files) == 1:
                raise
            omissions.append(f"{each}: {error.problem}; left out")
    if not parts:
        raise FileError(path=path, place="", problem="none of its files can be read", remedy=REMEDY)
    whole = MessageFile(
        path, {name: topic for part in parts for name, topic in part.topics.items()}, lambda _: iter(())
    )

    def iterate(topics: Collection[str]) -> Iterator[RecordedMessage]:
        for part in parts:
            yield from part.read_messages(topics, omissions) if len(parts) > 1 else part.iterate(topics)
            if whole.first_ns is None:
                whole.first_ns = part.first_ns

    whole.iterate = iterate
    return whole


def _sort_key(path: Path) -> tuple[int, str]:
    """Sort drive_2.mcap before drive_10.mcap."""
    digits = "".join(each for each in path.name.partition(".")[0].rpartition("_")[2] if each.isdigit())
    return int(digits or 0), path.name


def _is_part(path: Path) -> bool:
    return any(each in {MCAP, SQLITE} for each in path.suffixes[-2:])


def _open_file(path: Path) -> MessageFile:
    try:
        with path.open("rb") as file:
            begin = file.read(64)
    except OSError as error:
        raise FileError(path=path, place="", problem=_describe_damage(error), remedy=REMEDY) from None
    refuse_pointer(path, begin)
    if begin.startswith(b"SQLite format 3"):
        return _open_sqlite(path)
    if begin[1:5] == b"MCAP" or MCAP in path.suffixes:
        return _open_mcap(path)
    if not begin.strip(b"\0"):
        raise FileError(path=path, place="", problem="it is empty", remedy=REMEDY)
    raise FileError(path=path, place="", problem="it cannot be read (it is no recording)", remedy=REMEDY)


def _open_mcap(path: Path) -> MessageFile:
    from mcap.records import Channel, Schema

    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}

    def take(record: Any) -> None:
        if isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            channels[record.id] = record

    damage = None
    for record in _list_mcap_channels(path):
        if isinstance(record, Exception):
            damage = record
        take(record)
    if damage is not None and not channels:
        raise FileError(path=path, place="", problem=_describe_damage(damage), remedy=REMEDY)
    topics = {each.topic: _make_topic(each, schemas.get(each.schema_id)) for each in channels.values()}
    opened = MessageFile(path, topics, lambda _: iter(()))

    def iterate(wanted: Collection[str]) -> Iterator[RecordedMessage]:
        names = {number: each.topic for number, each in channels.items() if each.topic in wanted}
        for code, data in _read_mcap_records(path):
            if code != MESSAGE_RECORD:
                continue
            channel, _number, time_ns, _sent_ns = HEADER.unpack_from(data)
            if opened.first_ns is None:
                opened.first_ns = time_ns
            if channel in names:
                yield RecordedMessage(names[channel], time_ns, data[HEADER.size :])

    opened.iterate = iterate
    return opened


def _list_mcap_channels(path: Path) -> Iterator[Any]:
    """Yield the schemas and channels of an MCAP file, from its summary or, if it was cut, from all of it.

    The error at which a damaged file ends is yielded last.
    """
    reader = _import("mcap.reader")
    try:
        with path.open("rb") as file:
            summary = reader.make_reader(file).get_summary()
        if summary is not None and summary.channels:
            yield from summary.schemas.values()
            yield from summary.channels.values()
            return
    except Exception:  # a reader can raise any error on damaged bytes; the file is walked instead
        pass
    try:
        for code, data in _read_mcap_records(path):
            if code in (SCHEMA_RECORD, CHANNEL_RECORD):
                yield _parse_record(code, data)
    except UnderstudyError:
        raise
    except Exception as error:  # what comes before the damage counts
        yield error


def _parse_record(code: int, data: bytes) -> Any:
    from mcap.data_stream import ReadDataStream
    from mcap.records import Channel, Schema

    return (Schema if code == SCHEMA_RECORD else Channel).read(ReadDataStream(BytesIO(data)))


def _read_mcap_records(path: Path) -> Iterator[tuple[int, bytes]]:
    """Yield the code and content of the records of an MCAP file that are schemas, channels and messages.

    Those in chunks are among them. Indices, which may be a third of a file of many topics, are skipped.
    """
    stream_reader = _import("mcap.stream_reader")
    from mcap.data_stream import ReadDataStream
    from mcap.records import Chunk

    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise ValueError("it does not begin as MCAP does")
        while True:
            begin = file.read(RECORD.size)
            if len(begin) < RECORD.size:
                raise EOFError("it ends in the middle of a record")
            code, length = RECORD.unpack(begin)
            if code == FOOTER_RECORD:
                return
            if length > MOST_BYTES:
                raise ValueError(f"a record says that it has {length} bytes")
            if code not in (SCHEMA_RECORD, CHANNEL_RECORD, MESSAGE_RECORD, CHUNK_RECORD):
                file.seek(length, 1)
                continue
            data = file.read(length)
            if len(data) < length:
                raise EOFError("it ends in the middle of a record")
            if code != CHUNK_RECORD:
                yield code, data
                continue
            chunk = Chunk.read(ReadDataStream(BytesIO(data)))
            stream, size = stream_reader.get_chunk_data_stream(chunk, validate_crc=True)
            yield from _list_chunk_records(stream.read(size))


def _list_chunk_records(chunk: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield the code and content of each record of a chunk."""
    at, size = 0, len(chunk)
    while at + RECORD.size <= size:
        code, length = RECORD.unpack_from(chunk, at)
        at += RECORD.size
        yield code, chunk[at : at + length]
        at += length


def _make_topic(channel: Any, schema: Any) -> RecordedTopic:
    """Describe a channel of an MCAP file, and how its messages are decoded."""
    encoding, kind = channel.message_encoding, "" if schema is None else schema.encoding
    type = "" if schema is None else schema.name
    if encoding == "json":
        return RecordedTopic(channel.topic, type, _decode_json)
    if encoding in ("cdr", "ros1") and kind in ("ros2msg", "ros1msg", "ros2idl", ""):
        return make_ros_topic(channel.topic, type, b"" if schema is None else schema.data, kind, encoding)
    problem = f"its messages are encoded as {encoding} with {kind or 'no schema'}"
    return RecordedTopic(channel.topic, type, bytes, problem=problem)


def make_ros_topic(name: str, type: str, definition: bytes, kind: str, encoding: str) -> RecordedTopic:
    """Describe a topic of ROS: its messages are decoded by the definition that comes with them, or as a common type."""
    ros_type = type if "/msg/" in type else "/msg/".join(type.split("/", 1))
    problem = ""
    if definition.strip():
        try:
            store = _load_types(definition.decode(), ros_type, kind)
            decode = partial(
                store.deserialize_ros1 if encoding == "ros1" else store.deserialize_cdr, typename=ros_type
            )
            return RecordedTopic(name, ros_type, decode, partial(_list_fields, store))
        except UnderstudyError:
            raise
        except Exception as error:  # a definition of another program can break any rule of the parser
            problem = f"the definition of its type {ros_type} cannot be read ({str(error).splitlines()[0]})"
    if ros_type in load_typestore().fielddefs:
        if encoding == "ros1":
            decode = partial(load_typestore().deserialize_ros1, typename=ros_type)
            return RecordedTopic(name, ros_type, decode, list_message_fields)
        return RecordedTopic(name, ros_type, partial(decode_message, ros_type), list_message_fields)
    problem = problem or f"its type {ros_type} is not a common one, and the recording has no definition of it"
    return RecordedTopic(name, ros_type, bytes, problem=problem)


@cache
def _load_types(definition: str, type: str, kind: str) -> Any:
    """Load the message types of a definition, such as an MCAP file has for each of its topics."""
    types = _import("rosbags.typesys")
    store = types.get_typestore(types.Stores.EMPTY)
    parse = types.get_types_from_idl if kind == "ros2idl" else partial(types.get_types_from_msg, name=type)
    store.register(parse(definition))
    return store


def _list_fields(store: Any, type: str) -> Mapping[str, tuple[int, Any]]:
    return {name: (int(node_type), of) for name, (node_type, of) in store.fielddefs[type][1]}


def _decode_json(data: bytes) -> Any:
    return json.loads(data, object_hook=lambda fields: SimpleNamespace(**fields))


def _open_sqlite(path: Path) -> MessageFile:
    """Open a .db3 file of ROS 2; older ones have no definitions of their types."""

    def connect() -> sqlite3.Connection:
        fixed = "" if path.with_name(f"{path.name}-wal").exists() else "&immutable=1"
        return sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro{fixed}", uri=True)

    try:
        connection = connect()
        rows = connection.execute("SELECT id, name, type, serialization_format FROM topics").fetchall()
        try:
            stored = connection.execute(
                "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
            ).fetchall()
        except sqlite3.Error:
            stored = []  # as ROS 2 wrote them before Iron
    except sqlite3.Error as error:
        raise FileError(path=path, place="", problem=_describe_damage(error), remedy=REMEDY) from None
    definitions = {type: (text.encode(), encoding) for type, encoding, text in stored}
    topics = {
        name: make_ros_topic(name, type, *definitions.get(type, (b"", "")), encoding)
        for _, name, type, encoding in rows
    }
    names = {number: name for number, name, *_ in rows}
    opened = MessageFile(path, topics, lambda _: iter(()))

    def iterate(wanted: Collection[str]) -> Iterator[RecordedMessage]:
        numbers = [number for number, name in names.items() if name in wanted]
        with connect() as database:
            opened.first_ns = database.execute("SELECT min(timestamp) FROM messages").fetchone()[0]
            query = f"SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN ({','.join('?' * len(numbers))})"
            for number, time_ns, data in database.execute(f"{query} ORDER BY timestamp", numbers):
                plain = _decompress(data) if data.startswith(ZSTANDARD) else data
                yield RecordedMessage(names[number], time_ns, plain)

    opened.iterate = iterate
    return opened


def _decompress(data: bytes) -> bytes:
    decompressed: bytes = _import("zstandard").ZstdDecompressor().decompressobj().decompress(data)
    return decompressed


def _open_ros_1(path: Path) -> MessageFile:
    """Open a .bag file of ROS 1."""
    with path.open("rb") as file:
        refuse_pointer(path, file.read(64))
    bags = _import("rosbags.rosbag1")
    try:
        with bags.Reader(path) as reader:
            topics = {
                each.topic: make_ros_topic(
                    each.topic, each.msgtype, each.msgdef.data.encode(), "ros1msg", "ros1"
                )
                for each in reader.connections
            }
            first_ns = reader.start_time
    except Exception as error:  # a reader can raise any error on incomplete or damaged bytes
        raise FileError(path=path, place="", problem=_describe_damage(error), remedy=REMEDY) from None

    def iterate(wanted: Collection[str]) -> Iterator[RecordedMessage]:
        with bags.Reader(path) as reader:
            chosen = [each for each in reader.connections if each.topic in wanted]
            for connection, time_ns, data in reader.messages(connections=chosen):
                yield RecordedMessage(connection.topic, time_ns, bytes(data))

    return MessageFile(path, topics, iterate, first_ns)


def _import(module: str) -> Any:
    try:
        return import_module(module)
    except ImportError:
        raise ExtraMissing(what="a recording of messages", extra="ros2") from None
