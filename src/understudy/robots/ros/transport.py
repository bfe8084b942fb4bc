"""The interface of transports, which carry messages to and from a robot, such as DDS."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol, TypeAlias

from understudy.errors import UnderstudyError

Received: TypeAlias = Callable[[bytes, float], None]
"""A function that receives a message and its arrival time (s, `time.monotonic`).

The message is CDR with encapsulation header. The function is called in another thread.
"""
Publish: TypeAlias = Callable[[bytes], None]
"""A function that sends a message, given as CDR with encapsulation header."""


class Publisher(NamedTuple):
    """A publisher of another process: its topic and message type."""

    topic: str
    type: str


class Transport(Protocol):
    """The interface of a transport.

    Topics (`/rover/odom`) and types (`nav_msgs/msg/Odometry`) are named as in ROS 2.
    """

    def subscribe(self, topic: str, type: str, received: Received) -> None:
        """Pass each message of a topic to `received` until the transport is closed."""
        ...

    def publisher(self, topic: str, type: str) -> Publish:
        """Make a function that publishes on a topic."""
        ...

    def peers(self) -> Sequence[Publisher]:
        """List the publishers of other processes that have been discovered, one entry for each."""
        ...

    def close(self) -> None:
        """Disconnect; nothing is received afterwards."""
        ...


class Unreachable(UnderstudyError, json_type="Unreachable"):
    """A transport that cannot be joined."""

    def __init__(self, *, what: str, problem: str, remedy: str) -> None:
        self.what, self.problem, self.remedy = what, problem, remedy
        super().__init__(f"{what} cannot be joined: {problem}; {remedy}")
