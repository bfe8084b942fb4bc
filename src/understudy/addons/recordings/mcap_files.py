"""MCAP files: their topics and messages, also of files that were cut or are damaged somewhere.

Only the messages of the topics that are asked for are taken apart.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Collection, Iterator, Sequence
from io import BytesIO
from pathlib import Path
from struct import Struct
from typing import IO, Any, NamedTuple

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
FOOTER_RECORD, SCHEMA_RECORD, CHANNEL_RECORD, MESSAGE_RECORD, CHUNK_RECORD, INDEX_RECORD = 2, 3, 4, 5, 6, 7
INDEX_HEAD, INDEX_ENTRY = 6, 16
"""The bytes of an index of messages before its entries, and those of each entry."""
MAGIC = b"\x89MCAP0\r\n"


class LostPart(NamedTuple):
    """A part of a file that cannot be read.

    `messages` is the number of its messages, and `first_ns` and `last_ns` the times of the first and last, None where
    the file does not say so.
    """

    problem: str
    messages: int | None = None
    first_ns: int | None = None
    last_ns: int | None = None


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

    damage, chunks = None, list[int]()
    for record in _list_mcap_channels(path, chunks):
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

        def note(lost: LostPart) -> None:
            omissions.append(f"{path}: {_describe_lost(lost, opened.first_ns)}; the rest is read")

        for code, data in _read_mcap_records(path, chunks, note):
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


def _describe_lost(lost: LostPart, began_ns: int | None) -> str:
    """Say what of a file is lost, in seconds since its first message."""
    messages = "messages" if lost.messages is None else f"{lost.messages} messages"
    if lost.first_ns is None or lost.last_ns is None:
        return f"{lost.problem}; {messages} are lost"
    first, last = (
        (each - (lost.first_ns if began_ns is None else began_ns)) * 1e-9
        for each in (lost.first_ns, lost.last_ns)
    )
    since = "its first message" if began_ns is not None else "its beginning"
    return f"{lost.problem}; {messages}, of {first:.1f} to {last:.1f} s after {since}, are lost"


def _list_mcap_channels(path: Path, chunks: list[int]) -> Iterator[Any]:
    """Yield the schemas and channels of an MCAP file, from its summary or, if it was cut, from all of it.

    The places of chunks are added to `chunks`, if there is a summary. The error at which a damaged file ends is yielded
    last.
    """
    reader = import_for_messages("mcap.reader")
    try:
        with path.open("rb") as file:
            summary = reader.make_reader(file).get_summary()
        if summary is not None:
            chunks += sorted(each.chunk_start_offset for each in summary.chunk_indexes)
        if summary is not None and summary.channels:
            yield from summary.schemas.values()
            yield from summary.channels.values()
            return
    except Exception:  # a reader can raise any error on damaged bytes; the file is walked instead
        pass
    try:
        for code, data in _read_mcap_records(path, (), lambda lost: None):
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


def _read_mcap_records(
    path: Path, chunks: Sequence[int], note: Callable[[LostPart], None]
) -> Iterator[tuple[int, bytes]]:
    """Yield the code and content of the records of an MCAP file that are schemas, channels and messages.

    Those in chunks are among them. Indices, which may be a third of a file of many topics, are skipped. A damaged chunk
    is noted and skipped; where even the length of a record is damaged, reading goes on at the next of the places of
    `chunks`. If there is none, an error is raised.
    """
    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise ValueError("it does not begin as MCAP does")
        at = len(MAGIC)
        while True:
            following = bisect_right(chunks, at)
            end = chunks[following] if following < len(chunks) else None
            try:
                code, data = _read_record(file, at, end)
            except (EOFError, ValueError) as error:
                if end is None:
                    raise
                note(LostPart(f"bytes {at} to {end} cannot be read ({error})"))
                at = end
                continue
            at = file.tell()
            if code == FOOTER_RECORD:
                return
            if code == CHUNK_RECORD:
                yield from _read_chunk(data, file, note)
            elif data:
                yield code, data


def _read_record(file: IO[bytes], at: int, end: int | None) -> tuple[int, bytes]:
    """Read the record at a place, which must not reach beyond the next chunk; return only the code of one not used."""
    file.seek(at)
    begin = file.read(RECORD.size)
    if len(begin) < RECORD.size:
        raise EOFError("it ends in the middle of a record")
    code, length = RECORD.unpack(begin)
    if code == FOOTER_RECORD:
        return code, b""
    if length > MOST_BYTES or (end is not None and at + RECORD.size + length > end):
        raise ValueError(f"a record says that it has {length} bytes")
    if code not in (SCHEMA_RECORD, CHANNEL_RECORD, MESSAGE_RECORD, CHUNK_RECORD):
        file.seek(length, 1)
        return code, b""
    data = file.read(length)
    if len(data) < length:
        raise EOFError("it ends in the middle of a record")
    return code, data


def _read_chunk(
    data: bytes, file: IO[bytes], note: Callable[[LostPart], None]
) -> Iterator[tuple[int, bytes]]:
    """Yield the records of a chunk; note it if it is damaged. `file` is at what follows it."""
    stream_reader = import_for_messages("mcap.stream_reader")
    from mcap.data_stream import ReadDataStream
    from mcap.records import Chunk

    chunk, count = None, 0
    try:
        chunk = Chunk.read(ReadDataStream(BytesIO(data)))
        stream, size = stream_reader.get_chunk_data_stream(chunk, validate_crc=True)
        for code, content in _list_chunk_records(stream.read(size)):
            yield code, content
            count += code == MESSAGE_RECORD
    except stream_reader.UnsupportedCompressionError:
        raise
    except Exception as error:  # a decompressor can raise any error on damaged bytes
        many = _count_indexed(file)
        is_sum = isinstance(error, stream_reader.CRCValidationError)
        problem = f"a chunk is damaged ({'its checksum is wrong' if is_sum else error})"
        left = None if many is None else many - count
        times = (None, None) if chunk is None else (chunk.message_start_time, chunk.message_end_time)
        note(LostPart(problem, left, *(times if not count else (None, None))))


def _count_indexed(file: IO[bytes]) -> int | None:
    """Count the messages that the indices after a chunk list; None if there are none. The file stays where it is."""
    place, count, is_indexed = file.tell(), 0, False
    while len(begin := file.read(RECORD.size)) == RECORD.size:
        code, length = RECORD.unpack(begin)
        if code != INDEX_RECORD or length > MOST_BYTES:
            break
        is_indexed, count = True, count + max(0, length - INDEX_HEAD) // INDEX_ENTRY
        file.seek(length, 1)
    file.seek(place)
    return count if is_indexed else None


def _list_chunk_records(chunk: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield the code and content of each record of a chunk."""
    at, size = 0, len(chunk)
    while at + RECORD.size <= size:
        code, length = RECORD.unpack_from(chunk, at)
        at += RECORD.size
        if length > size - at:
            raise ValueError(f"a record in it says that it has {length} bytes")
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
