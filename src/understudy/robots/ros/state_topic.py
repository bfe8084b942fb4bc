"""Transitions as a topic: whenever a robot switches, one message says from which state to which.

It is text of JSON in a std_msgs/String, so that a rosbag keeps it and `ros2 topic echo` shows it where nobody has heard
of our types.
"""

from __future__ import annotations

from typing import NamedTuple

import msgspec

from understudy.robots.recording.message_types import TEXT, encode_text
from understudy.robots.ros.transport import Transport

TOPIC = "understudy/transitions"
"""Within the robot's namespace."""


class StateChange(NamedTuple):
    """The outermost level that switched (0 is the root), and its states; "" where there was none, or is none."""

    level: int
    before: str
    after: str


def detect_state_change(before: tuple[str, ...], after: tuple[str, ...]) -> StateChange | None:
    """What happened between two ticks with these states of all levels; None where nothing did."""
    if before == after:
        return None
    level = next(
        (level for level, (one, other) in enumerate(zip(before, after, strict=False)) if one != other),
        min(len(before), len(after)),
    )
    return StateChange(level, *("" if level >= len(path) else path[level] for path in (before, after)))


class StateChangePublisher:
    """Publishes the transitions of one robot; tell it the states after each tick."""

    def __init__(self, transport: Transport, *, namespace: str = "", robot: str = "") -> None:
        self._robot, self._path = robot, tuple[str, ...]()
        self._publish = transport.publisher(resolve_topic_name(namespace, TOPIC), TEXT)

    def publish_changes(self, time_s: float, path: tuple[str, ...]) -> None:
        """Publish what changed since the last tick, if anything did; time in s, as the body counts it."""
        changed = detect_state_change(self._path, path)
        if changed is None:
            return
        self._path = path
        told = {"time_s": time_s, "robot": self._robot, **changed._asdict(), "path": path}
        self._publish(encode_text(msgspec.json.encode(told).decode()))


def resolve_topic_name(namespace: str, topic: str) -> str:
    """The full name of a topic in a namespace."""
    return "/" + "/".join(part for part in (namespace.strip("/"), topic) if part)
