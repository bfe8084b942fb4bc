"""MCAP files: their topics and messages, also of files that were cut.

Only the messages of the topics that are asked for are taken apart.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from io import BytesIO
from pathlib import Path
from struct import Struct
from typing import Any

from understudy.addons.recordings.recorded_topics import (
    REMEDY,
    ROS_1,
    MessageFile,
    RecordedMessage,
    RecordedTopic,
    decode_json,
    describe_damage,
    import_for_messages,
    make_ros_topic,
)
from understudy.errors import FileError, UnderstudyError

MOST_BYTES = 2**30
"""The largest size of a record, so that a damaged length cannot fill the memory."""
RECORD, HEADER = Struct("<BQ"), Struct("<HIQQ")
"""The beginning of a record of MCAP, and of one that is a message: channel, number, and two times, ns."""
FOOTER_RECORD, SCHEMA_RECORD, CHANNEL_RECORD, MESSAGE_RECORD, CHUNK_RECORD = 2, 3, 4, 5, 6
MAGIC = b"\x89MCAP0\r\n"


def open_mcap(path: Path | str, omissions: list[str]) -> MessageFile:
    """Open an MCAP file, and list its topics."""
    from mcap.records import Channel, Schema

    path = Path(path)
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
        raise FileError(path=path, place="", problem=describe_damage(damage), remedy=REMEDY)
    topics: dict[str, RecordedTopic] = {}
    for number, channel in list(channels.items()):
        topic = _make_topic(channel, schemas.get(channel.schema_id))
        first = topics.setdefault(channel.topic, topic)
        if topic.type != first.type:
            del channels[number]
            omissions.append(
                f"{path} at topic {first.name!r}: messages are {first.type}; those of {topic.type} are left out"
            )
    opened = MessageFile(path, topics, lambda _: iter(()))

    def iterate(wanted: Collection[str]) -> Iterator[RecordedMessage]:
        names = {number: each.topic for number, each in channels.items() if each.topic in wanted}
        for code, data in _read_mcap_records(path):
            if code != MESSAGE_RECORD:
                continue
            channel, _number, time_ns, sent_ns = HEADER.unpack_from(data)
            time_ns = time_ns or sent_ns  # some programs fill in only one
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
    reader = import_for_messages("mcap.reader")
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
    stream_reader = import_for_messages("mcap.stream_reader")
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
        return RecordedTopic(channel.topic, type, decode_json)
    if encoding in ("cdr", ROS_1) and kind in ("ros2msg", "ros1msg", "ros2idl", ""):
        return make_ros_topic(channel.topic, type, b"" if schema is None else schema.data, kind, encoding)
    problem = f"its messages are encoded as {encoding} with {kind or 'no schema'}"
    return RecordedTopic(channel.topic, type, bytes, problem=problem)
