"""Messages of our own in recordings: what was read, what states were taken, which transitions; as ROS 2 types.

Their definitions travel in each file, so that whatever opens MCAP of ROS 2 reads them, with nothing of ours installed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np

from understudy.extras import ExtraMissing
from understudy.model.features import ReadingKey
from understudy.model.kinds import Column
from understudy.robots.ros.messages import decode_message, encode_message, load_typestore, make_message

READING, READINGS = "understudy_msgs/msg/Reading", "understudy_msgs/msg/Readings"
STATES, TRANSITION = "understudy_msgs/msg/States", "understudy_msgs/msg/Transition"
TEXT = "std_msgs/msg/String"

DEFINITIONS: Mapping[str, str] = MappingProxyType(
    {
        READING: "string name\nfloat64 value\n",
        READINGS: f"float64 time_s\n{READING}[] readings\n",
        STATES: "float64 time_s\nstring[] path\n",
        TRANSITION: "float64 time_s\nstring robot\nint32 level\nstring before\nstring after\nstring[] path\n",
    }
)
"""Readings: all at one tick, NaN where absent. States: of each level after it, outermost first. Transition: of the
outermost level that switched, counted from 0; what was started below it is in `path`."""

HEAD = 4
"""Bytes of CDR before the content, which numbers are aligned to."""


@cache
def register_message_types() -> None:
    """Make our types known beside those of ROS 2."""
    try:
        from rosbags.typesys import get_types_from_msg
    except ImportError:
        raise ExtraMissing(what="a recording", extra="ros2") from None
    found: dict[str, Any] = {}
    for name, text in DEFINITIONS.items():
        found.update(get_types_from_msg(text, name))
    load_typestore().register(found)


def format_type_definition(type: str) -> str:
    """The definition of a type and of all it is made of, as rosbag2 writes them (`ros2msg`)."""
    register_message_types()
    return str(load_typestore().generate_msgdef(type, ros_version=2)[0])


def format_reading_label(key: ReadingKey) -> str:
    """What a reading is called: range, range(station)."""
    name, target = key
    return name if target is None else f"{name}({target})"


class ReadingsEncoder:
    """Readings of one agent as messages, tick after tick: the names stay, so only numbers are put into their places."""

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
        """The message of a tick; `values` [K] as the names are."""
        self._numbers[0] = time_s
        self._numbers[self._places] = values
        return bytes(self._message)

    def decode(self, data: bytes) -> tuple[float, Column] | None:
        """The time and values [K] of a message; None where it has other names."""
        if len(data) != len(self._blank):
            return None
        copy = bytearray(data)
        numbers = np.frombuffer(memoryview(copy)[HEAD : HEAD + 8 * len(self._numbers)], np.float64)
        time_s, values = float(numbers[0]), numbers[self._places]
        numbers[0] = 0.0
        numbers[self._places] = 0.0
        return (time_s, values) if copy == self._blank else None


def _places(names: Sequence[str]) -> Iterator[int]:
    """Where each value stands in a message, counted in numbers of 8 bytes after the head."""
    at = 12  # after the time and the count of readings
    for name in names:
        at = -(-at // 4) * 4 + 4 + len(name.encode()) + 1
        at = -(-at // 8) * 8
        yield at // 8
        at += 8


def decode_reading_names(data: bytes) -> tuple[str, ...]:
    """The names of the readings in a message; MessageRefused where it is none."""
    register_message_types()
    return tuple(each.name for each in decode_message(READINGS, data).readings)


class StatesEncoder:
    """States of one agent as messages: most ticks are in the same as the last, but for the time."""

    def __init__(self) -> None:
        register_message_types()
        self._path: tuple[str, ...] | None = None
        self._rest = b""

    def encode(self, time_s: float, path: tuple[str, ...]) -> bytes:
        """The message of a tick."""
        if path != self._path:
            self._path = path
            self._rest = encode_message(STATES, make_message(STATES, path=list(path)))
        return self._rest[:HEAD] + np.float64(time_s).tobytes() + self._rest[HEAD + 8 :]


def decode_states(data: bytes) -> tuple[float, tuple[str, ...]]:
    """The time and the states of a message; MessageRefused where it is none."""
    register_message_types()
    found = decode_message(STATES, data)
    return float(found.time_s), tuple(found.path)


def encode_text(content: str) -> bytes:
    """A std_msgs/String."""
    return encode_message(TEXT, make_message(TEXT, data=content))
