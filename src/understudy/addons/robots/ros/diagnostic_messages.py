"""Diagnostics (REP 107): the statuses that a robot's drivers publish, and those that are published of it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

from understudy.addons.robots.ros.transport import Publish
from understudy.records.messages import MessageRefused, decode_message, encode_message, make_message

DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
"""The type of messages on /diagnostics."""
PERIOD_S = 1.0
"""The time between two messages with the same statuses, s."""


class StatusLevel(IntEnum):
    """The level of a status, as its type defines it."""

    OK, WARN, ERROR, STALE = range(4)


@dataclass(frozen=True)
class DiagnosticStatus:
    """One status: the name of its component, its level, a sentence, and values by name."""

    name: str
    level: StatusLevel
    message: str
    values: Mapping[str, str] = field(default_factory=dict)


class StatusListener:
    """The latest levels of some statuses.

    Parameters
    ----------
    names
        The names of the statuses; others are ignored.
    """

    def __init__(self, names: Collection[str]) -> None:
        self._names = frozenset(names)
        self.heard: dict[str, tuple[int, str]] = {}
        """The latest level and message of each status that has come."""

    def receive(self, data: bytes, at_s: float) -> None:
        """Take a message; it raises no errors."""
        try:
            message: Any = decode_message(DIAGNOSTICS, data)
        except MessageRefused:
            return
        for status in message.status:
            if status.name in self._names:
                self.heard[status.name] = int(status.level), str(status.message)

    def find_error(self, names: Sequence[str]) -> str | None:
        """Return the first of these statuses that has the level ERROR or STALE, with its message; None if none has."""
        for name in names:
            level, message = self.heard.get(name, (StatusLevel.OK, ""))
            if level >= StatusLevel.ERROR:
                sentence = message or ("ERROR" if level == StatusLevel.ERROR else "STALE")
                return f"diagnostics of {name!r:.80}: {sentence:.200}"
        return None


class StatusPublisher:
    """A publisher of statuses: once a second, and at once when a level or a sentence changes.

    Parameters
    ----------
    publish
        The function that sends a message.
    parts
        Functions that return the statuses.
    """

    def __init__(self, publish: Publish, parts: Sequence[Callable[[], DiagnosticStatus]]) -> None:
        self._publish, self.parts = publish, list(parts)
        self._said: list[tuple[str, StatusLevel, str]] = []
        self._due_s = 0.0

    def update(self, now: float, *, time_s: float) -> None:
        """Publish if that is due at `now` (s, monotonic); `time_s` is the time of the stamp, s since 1970."""
        statuses = [part() for part in self.parts]
        published = [(each.name, each.level, each.message) for each in statuses]
        if published == self._said and now < self._due_s:
            return
        self._said, self._due_s = published, now + PERIOD_S
        self._publish(encode_statuses(statuses, time_s=time_s))


def encode_statuses(statuses: Sequence[DiagnosticStatus], *, time_s: float) -> bytes:
    """Encode statuses as a message; `time_s` is the time of its stamp, s since 1970."""
    seconds = int(time_s)
    stamp = make_message("builtin_interfaces/msg/Time", sec=seconds, nanosec=int((time_s - seconds) * 1e9))
    messages = [
        make_message(
            "diagnostic_msgs/msg/DiagnosticStatus",
            level=int(each.level),
            name=each.name,
            message=each.message,
            values=[
                make_message("diagnostic_msgs/msg/KeyValue", key=key, value=value)
                for key, value in each.values.items()
            ],
        )
        for each in statuses
    ]
    header = make_message("std_msgs/msg/Header", stamp=stamp)
    return encode_message(DIAGNOSTICS, make_message(DIAGNOSTICS, header=header, status=messages))
