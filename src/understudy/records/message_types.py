"""Our own message types in recordings, as ROS 2 types: readings, states and transitions.

Their definitions are stored in each recording, so that any program that opens MCAP files of ROS 2 can read them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from understudy.extras import ExtraMissing
from understudy.model.value_kinds import Column
from understudy.records.messages import decode_message, encode_message, load_typestore, make_message

READING, READINGS = "understudy_msgs/msg/Reading", "understudy_msgs/msg/Readings"
STATES, TRANSITION = "understudy_msgs/msg/States", "understudy_msgs/msg/Transition"
TEAM_MESSAGE, DUTY = "understudy_msgs/msg/TeamMessage", "understudy_msgs/msg/Duty"
TEXT = "std_msgs/msg/String"

DEFINITIONS: Mapping[str, str] = MappingProxyType(
    {
        READING: "string name\nfloat64 value\n",
        READINGS: f"float64 time_s\n{READING}[] readings\n",
        STATES: "float64 time_s\nstring[] path\n",
        TRANSITION: "float64 time_s\nstring robot\nint32 level\nstring before\nstring after\nstring[] path\n",
        TEAM_MESSAGE: "string key\nuint8[] data\n",
        DUTY: (
            "float64 time_s\nstring leader\nint64 term\nint64 number\nbool alone\nstring behavior\n"
            "string[] parameters\nstring[] targets\nstring frames\n"
        ),
    }
)
"""The definitions of the message types.

Readings has all readings at one tick, NaN where absent. States has the states of all levels after a tick, outermost
first. Transition has the outermost level that switched, counted from 0, and the new states of all levels in `path`.
TeamMessage is a message between the agents of a team, with its key, as it was sent. Duty says what an agent begins
before a tick: what the order (term, number) of a leader tells it, nothing if `behavior` is empty, or, if `alone`, what
it runs without an order. Without an order and `alone`, `leader` drives it to train it. A coordinator that takes over
goes on from `frames`, the run state of the former one as JSON.
"""

HEAD = 4
"""The size of the CDR header in bytes; numbers are aligned relative to its end."""


@cache
def register_message_types() -> None:
    """Add our message types to the definitions of ROS 2."""
    try:
        from rosbags.typesys import get_types_from_msg
    except ImportError:
        raise ExtraMissing(what="a recording", extra="ros2") from None
    definitions: dict[str, Any] = {}
    for name, text in DEFINITIONS.items():
        definitions.update(get_types_from_msg(text, name))
    load_typestore().register(definitions)


def format_type_definition(type: str) -> str:
    """Return the definition of a type and of all types that it contains, in the format of rosbag2 (`ros2msg`)."""
    register_message_types()
    return str(load_typestore().generate_msgdef(type, ros_version=2)[0])


class ReadingsEncoder:
    """An encoder of one agent's readings with fixed names.

    It replaces only the numbers in a prepared message, which is fast.
    """

    def __init__(self, names: Sequence[str]) -> None:
        register_message_types()
        self.names = tuple(names)
        blank = [make_message(READING, name=name) for name in self.names]
        self._message = bytearray(encode_message(READINGS, make_message(READINGS, readings=blank)))
        content = memoryview(self._message)[HEAD:]
        self._numbers = np.frombuffer(content[: len(content) // 8 * 8], np.float64)
        self._places = np.array(list(_places(self.names)), np.intp)
        self._blank = bytes(self._message)

    def encode(self, time_s: float, values: Column) -> bytes:
        """Encode the readings of a tick; `values` [K] are in the order of the names."""
        self._numbers[0] = time_s
        self._numbers[self._places] = values
        return bytes(self._message)

    def decode(self, data: bytes) -> tuple[float, Column] | None:
        """Decode a message to its time (s) and values [K]; return None if it has other names."""
        if len(data) != len(self._blank):
            return None
        copy = bytearray(data)
        numbers = np.frombuffer(memoryview(copy)[HEAD : HEAD + 8 * len(self._numbers)], np.float64)
        time_s, values = float(numbers[0]), numbers[self._places]
        numbers[0] = 0.0
        numbers[self._places] = 0.0
        return (time_s, values) if copy == self._blank else None


def _places(names: Sequence[str]) -> Iterator[int]:
    """Yield the position of each value in a message, counted in numbers of 8 bytes after the header."""
    at = 12  # after the time and the count of readings
    for name in names:
        at = -(-at // 4) * 4 + 4 + len(name.encode()) + 1
        at = -(-at // 8) * 8
        yield at // 8
        at += 8


def decode_reading_names(data: bytes) -> tuple[str, ...]:
    """Decode the names of the readings in a message; raise MessageRefused if it is none."""
    register_message_types()
    return tuple(each.name for each in decode_message(READINGS, data).readings)


class StatesEncoder:
    """An encoder of one agent's states.

    It encodes the states again only when they change; otherwise it replaces the time.
    """

    def __init__(self) -> None:
        register_message_types()
        self._path: tuple[str, ...] | None = None
        self._rest = b""

    def encode(self, time_s: float, path: tuple[str, ...]) -> bytes:
        """Encode the states of all levels after a tick, outermost first."""
        if path != self._path:
            self._path = path
            self._rest = encode_message(STATES, make_message(STATES, path=list(path)))
        return self._rest[:HEAD] + np.float64(time_s).tobytes() + self._rest[HEAD + 8 :]


def decode_states(data: bytes) -> tuple[float, tuple[str, ...]]:
    """Decode a message to its time (s) and states; raise MessageRefused if it is none."""
    register_message_types()
    message = decode_message(STATES, data)
    return float(message.time_s), tuple(message.path)


def encode_team_message(key: str, message: bytes) -> bytes:
    """Encode a message between agents with its key."""
    data = np.frombuffer(message, np.uint8)
    return encode_message(TEAM_MESSAGE, make_message(TEAM_MESSAGE, key=key, data=data))


def decode_team_message(data: bytes) -> tuple[str, bytes]:
    """Decode a recorded message between agents to its key and its content; raise MessageRefused if it is none."""
    register_message_types()
    message = decode_message(TEAM_MESSAGE, data)
    return message.key, bytes(message.data)


def encode_text(content: str) -> bytes:
    """Encode a text as a std_msgs/String."""
    return encode_message(TEXT, make_message(TEXT, data=content))


class StateChange(NamedTuple):
    """A change of states: the outermost level that switched (0 is the root), and its states before and after.

    A state is "" if the level did not exist.
    """

    level: int
    before: str
    after: str


def detect_state_change(before: tuple[str, ...], after: tuple[str, ...]) -> StateChange | None:
    """Return the change between the states of all levels in two ticks, or None if they are equal."""
    if before == after:
        return None
    level = next(
        (level for level, (one, other) in enumerate(zip(before, after, strict=False)) if one != other),
        min(len(before), len(after)),
    )
    return StateChange(level, *("" if level >= len(path) else path[level] for path in (before, after)))


def resolve_topic_name(namespace: str, topic: str) -> str:
    """Return the full name of a topic in a namespace."""
    return "/" + "/".join(part for part in (namespace.strip("/"), topic) if part)
