"""Tables of messages: MCAP files, and recordings of ROS 1 and ROS 2 that rosbags reads.

A column is a topic and a field of its messages, such as /cmd_vel.linear.x or /scan.ranges.0. Each message of the topic
of the first command makes a row, with the last value of all other columns until then. The messages bring their
definitions with them, so types need not be known here.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from importlib import import_module
from math import nan
from pathlib import Path
from typing import Any, NamedTuple

from understudy.addons.recordings.mapping_file import RecordingMap
from understudy.addons.recordings.recorded_table import TIME, RecordedTable
from understudy.errors import FileError, UnderstudyError, join_names, suggest_known_name
from understudy.extras import ExtraMissing
from understudy.records.reader import iterate_records

MCAP = ".mcap"
REMEDY = "give an MCAP file, or a recording of ROS 1 or ROS 2"


class _Message(NamedTuple):
    """A message of a topic with the time at which it was recorded, ns."""

    topic: str
    time_ns: int
    decode: Callable[[], Any]


def read_messages(path: Path | str, mapping: RecordingMap | None) -> RecordedTable:
    """Read the columns that a mapping names; column time_s has the time in s since the first message.

    Values that are older than the mapping's `gap_s` are absent. If the file is damaged, what comes before is used.
    """
    path = Path(path)
    if mapping is None:
        raise FileError(
            path=path,
            place="",
            problem="it has messages, and no mapping file says which fields are readings and commands",
            remedy="give --map MAP.toml; a recording of `understudy run` with presses needs no --behaviors",
        )
    names = [*(each.column for each in mapping.commands), *(each.column for each in mapping.readings)]
    if mapping.time not in (None, TIME):
        names.append(mapping.time)
    columns = _group_by_topic(path, names)
    main = names[0].partition(".")[0]
    held, last_ns = dict.fromkeys(names, nan), dict.fromkeys(columns, -1)
    rows: list[list[float]] = []
    first, topics, omissions = None, set[str](), list[str]()
    for message in _iterate(path, omissions):
        topics.add(message.topic)
        first = message.time_ns if first is None else first
        if message.topic not in columns:
            continue
        last_ns[message.topic] = message.time_ns
        held.update(_read_fields(path, message, columns[message.topic]))
        if message.topic == main:
            for topic, at in last_ns.items():
                if message.time_ns - at > mapping.gap_s * 1e9:
                    held.update(dict.fromkeys(columns[topic], nan))
            rows.append([(message.time_ns - first) / 1e9, *(held[name] for name in names)])
    for topic, fields in columns.items():
        if topic not in topics:
            raise FileError(
                path=path,
                place=f"topic {topic!r}",
                problem=f"there is no message of it for column {next(iter(fields))!r}",
                remedy=f"{suggest_known_name(topic, sorted(topics))}the topics are {join_names(sorted(topics))}",
            )
    header, numbers = (TIME, *names), range(1, len(rows) + 1)
    return RecordedTable(path, header, numbers, rows, omissions, f"message of {main}", TIME)


def _group_by_topic(path: Path, names: list[str]) -> dict[str, dict[str, tuple[str, ...]]]:
    """Split names of columns, such as /odom.twist.linear.x, and return the fields of each, by topic and column name."""
    fields_by_topic: dict[str, dict[str, tuple[str, ...]]] = {}
    for name in names:
        topic, *fields = name.split(".")
        if not (topic and fields):
            raise FileError(
                path=path,
                place=f"column {name!r}",
                problem="it is no field of a message",
                remedy="write its topic and its field in the mapping file: /cmd_vel.linear.x",
            )
        fields_by_topic.setdefault(topic, {})[name] = tuple(fields)
    return fields_by_topic


def _read_fields(
    path: Path, message: _Message, columns: Mapping[str, tuple[str, ...]]
) -> Iterator[tuple[str, float]]:
    """Yield each column of a message with its value."""
    try:
        decoded = message.decode()
    except UnderstudyError:
        raise
    except Exception as error:  # a decoder can raise any error on bytes that do not fit their definition
        problem = f"a message cannot be decoded ({error.__class__.__name__}: {error})"
        raise FileError(path=path, place=f"topic {message.topic!r}", problem=problem, remedy=REMEDY) from None
    for name, fields in columns.items():
        value = decoded
        for field in fields:
            available = _list_fields(value)
            if field not in available:
                absent = isinstance(value, Mapping) or (available and field.isdecimal())
                if absent:  # such as a list that has fewer elements in this message
                    value = nan
                    break
                raise FileError(
                    path=path,
                    place=f"column {name!r}",
                    problem=f"its messages have no field {field!r}",
                    remedy=f"{suggest_known_name(field, available)}the fields are {join_names(available)}"
                    if available
                    else "name the field before it",
                )
            value = _get_field(value, field)
        yield name, _convert(path, name, value)


def _list_fields(value: Any) -> list[str]:
    """List the fields of a message or an object, or the numbers of the elements of a list."""
    if isinstance(value, Mapping):
        return list(value)
    if hasattr(value, "__dataclass_fields__"):
        return [each for each in value.__dataclass_fields__ if not each.startswith("__")]
    if hasattr(value, "__len__") and not isinstance(value, str):
        return [str(index) for index in range(len(value))]
    return []


def _get_field(value: Any, field: str) -> Any:
    if isinstance(value, Mapping):
        return value[field]
    return getattr(value, field) if hasattr(value, "__dataclass_fields__") else value[int(field)]


def _convert(path: Path, name: str, value: Any) -> float:
    """Convert a value to a number; a time of ROS becomes seconds."""
    if hasattr(value, "sec") and hasattr(value, "nanosec"):
        return float(value.sec + value.nanosec * 1e-9)
    if value is None:
        return nan
    try:
        return float(value)
    except (TypeError, ValueError):
        fields = _list_fields(value)
        remedy = f"name one of {join_names(fields)} in it" if fields else "map another column"
        raise FileError(
            path=path, place=f"column {name!r}", problem="it is no number", remedy=remedy
        ) from None


def _iterate(path: Path, omissions: list[str]) -> Iterator[_Message]:
    """Yield the messages in their order; say what was left out of a damaged file."""
    messages = _iterate_mcap(path) if path.suffix.lower() == MCAP and path.is_file() else _iterate_bag(path)
    count = 0
    try:
        for message in messages:
            count += 1
            yield message
    except UnderstudyError:
        raise
    except Exception as error:  # a reader can raise any error on incomplete or damaged bytes
        problem = (
            "there is no such file"
            if isinstance(error, FileNotFoundError)
            else f"it cannot be read ({error})"
        )
        if not count:
            raise FileError(path=path, place="", problem=problem, remedy=REMEDY) from None
        omissions.append(f"{path} after message {count}: {problem}; what comes before is used")


def _iterate_mcap(path: Path) -> Iterator[_Message]:
    from mcap.records import Channel, Message, Schema

    schemas: dict[int, Schema] = {}
    decoders: dict[int, tuple[str, Callable[[bytes], Any]]] = {}
    for record in iterate_records(path):
        if isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            decoder = _make_decoder(path, record, schemas.get(record.schema_id))
            decoders[record.id] = record.topic, decoder
        elif isinstance(record, Message):
            topic, decode = decoders[record.channel_id]
            yield _Message(topic, record.log_time, partial(decode, record.data))


def _make_decoder(path: Path, channel: Any, schema: Any) -> Callable[[bytes], Any]:
    """Return the function that decodes the messages of a channel of an MCAP file."""
    if channel.message_encoding == "json":
        return json.loads
    if channel.message_encoding == "cdr" and schema is not None and schema.encoding == "ros2msg":
        return partial(_decode_cdr, schema.data.decode(), schema.name)

    def refuse(_: bytes) -> Any:
        encoding = f"{channel.message_encoding} with {'no schema' if schema is None else schema.encoding}"
        raise FileError(
            path=path,
            place=f"topic {channel.topic!r}",
            problem=f"its messages are encoded as {encoding}",
            remedy="record it as JSON, or as CDR with ros2msg as ROS 2 does",
        )

    return refuse


def _decode_cdr(definition: str, type: str, data: bytes) -> Any:
    return _load_types(definition, type).deserialize_cdr(data, type)


@cache
def _load_types(definition: str, type: str) -> Any:
    """Load the message types of a definition, such as an MCAP file has for each of its topics."""
    types = _import_rosbags("typesys")
    store = types.get_typestore(types.Stores.EMPTY)
    store.register(types.get_types_from_msg(definition, type))
    return store


def _import_rosbags(module: str) -> Any:
    try:
        return import_module(f"rosbags.{module}")
    except ImportError:
        raise ExtraMissing(what="a recording of messages", extra="ros2") from None


def _iterate_bag(path: Path) -> Iterator[_Message]:
    """Yield the messages of a recording of ROS 1 (.bag) or ROS 2 (a folder, or .db3) in order of time."""
    with _import_rosbags("highlevel").AnyReader([path]) as reader:
        for connection, time_ns, data in reader.messages():
            yield _Message(connection.topic, time_ns, partial(reader.deserialize, data, connection.msgtype))
