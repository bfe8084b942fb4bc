"""What carries messages between a robot and us: DDS, or anything else that knows topics."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol, TypeAlias

from understudy.errors import UnderstudyError

Received: TypeAlias = Callable[[bytes, float], None]
"""Given a message as CDR with its encapsulation, and when it came (s, `time.monotonic`); called in another thread."""
Publish: TypeAlias = Callable[[bytes], None]
"""Sends a message as CDR with its encapsulation."""


class Publisher(NamedTuple):
    """Somebody else who publishes: on which topic, which type."""

    topic: str
    type: str


class Transport(Protocol):
    """Topics (`/rover/odom`) and types (`nav_msgs/msg/Odometry`), as ROS 2 calls them."""

    def subscribe(self, topic: str, type: str, received: Received) -> None:
        """Hand each message of a topic to `received`, until closed."""
        ...

    def publisher(self, topic: str, type: str) -> Publish:
        """What publishes on a topic."""
        ...

    def peers(self) -> Sequence[Publisher]:
        """All others who publish, as far as they were discovered; one for each publisher."""
        ...

    def close(self) -> None:
        """Leave; nothing is received afterwards."""
        ...


class Unreachable(UnderstudyError, json_type="Unreachable"):
    """A transport that cannot be joined."""

    def __init__(self, *, what: str, problem: str, remedy: str) -> None:
        self.what, self.problem, self.remedy = what, problem, remedy
        super().__init__(f"{what} cannot be joined: {problem}; {remedy}")
