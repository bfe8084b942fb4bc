"""Topics and messages of recordings, and how messages are decoded, with or without a definition of their type.

Types of the common packages are known; those of others come with a recording.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, partial
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

from understudy.errors import FileError, UnderstudyError
from understudy.extras import ExtraMissing
from understudy.records.messages import (
    ARRAY,
    NAMED,
    SEQUENCE,
    decode_message,
    list_message_fields,
    load_typestore,
)

REMEDY = "give an MCAP file, or a recording of ROS 1 or ROS 2"
ROS_1 = "ros1"
"""The encoding of messages of ROS 1."""
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
            problem = describe_damage(error)
            if not count:
                raise FileError(path=self.path, place="", problem=problem, remedy=REMEDY) from None
            omissions.append(f"{self.path} after message {count}: {problem}; what comes before is used")


def describe_damage(error: Exception) -> str:
    """Say why a recording, or the rest of it, cannot be read."""
    if isinstance(error, FileNotFoundError):
        return "there is no such file"
    text = str(error) or type(error).__name__
    return f"it cannot be read ({text})"


def make_ros_topic(name: str, type: str, definition: bytes, kind: str, encoding: str) -> RecordedTopic:
    """Describe a topic of ROS: its messages are decoded by the definition that comes with them, or as a common type."""
    ros_type = type if "/msg/" in type else "/msg/".join(type.split("/", 1))
    problem = ""
    if definition.strip():
        try:
            store = _load_types(definition.decode(), ros_type, kind)
            decode = partial(
                store.deserialize_ros1 if encoding == ROS_1 else store.deserialize_cdr, typename=ros_type
            )
            return RecordedTopic(name, ros_type, decode, partial(_list_fields, store))
        except UnderstudyError:
            raise
        except Exception as error:  # a definition of another program can break any rule of the parser
            problem = (
                f"the definition of its type {ros_type} cannot be read ({' '.join(str(error).split()):.100})"
            )
    if encoding == ROS_1 and ros_type in (store := _load_ros_1_types()).fielddefs:
        decode = partial(store.deserialize_ros1, typename=ros_type)
        return RecordedTopic(name, ros_type, decode, partial(_list_fields, store))
    if encoding != ROS_1 and ros_type in load_typestore().fielddefs:
        return RecordedTopic(name, ros_type, partial(decode_message, ros_type), list_message_fields)
    problem = problem or f"its type {ros_type} is not a common one, and the recording has no definition of it"
    return RecordedTopic(name, ros_type, bytes, problem=problem)


@cache
def _load_ros_1_types() -> Any:
    """Load the common types as ROS 1 defines them: headers have a number there."""
    types = import_for_messages("rosbags.typesys")
    return types.get_typestore(types.Stores.ROS1_NOETIC)


@cache
def _load_types(definition: str, type: str, kind: str) -> Any:
    """Load the message types of a definition, such as an MCAP file has for each of its topics."""
    types = import_for_messages("rosbags.typesys")
    store = types.get_typestore(types.Stores.EMPTY)
    parse = types.get_types_from_idl if kind == "ros2idl" else partial(types.get_types_from_msg, name=type)
    store.register(parse(definition))
    _check_types(store, type)
    return store


def _check_types(store: Any, type: str) -> None:
    """Raise ValueError if a type that a definition names is not defined with it."""
    if type not in store.fielddefs:
        raise ValueError(f"it does not define {type}")
    for node_type, of in _list_fields(store, type).values():
        while node_type in (ARRAY, SEQUENCE):
            (node_type, of), _ = of
        if node_type == NAMED:
            _check_types(store, of)


def _list_fields(store: Any, type: str) -> Mapping[str, tuple[int, Any]]:
    return {name: (int(node_type), of) for name, (node_type, of) in store.fielddefs[type][1]}


def decode_json(data: bytes) -> Any:
    """Decode a message in JSON, whose fields become attributes."""
    return json.loads(data, object_hook=lambda fields: SimpleNamespace(**fields))


def import_for_messages(module: str) -> Any:
    """Import a module of the extra for messages."""
    try:
        return import_module(module)
    except ImportError:
        raise ExtraMissing(what="a recording of messages", extra="ros2") from None
