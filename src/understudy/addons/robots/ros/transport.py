"""The interface of transports, which carry messages to and from a robot, such as DDS."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, Protocol, TypeAlias, runtime_checkable

from understudy.entry_points import TRANSPORTS, list_entry_points
from understudy.errors import UnderstudyError

Received: TypeAlias = Callable[[bytes, float], None]
"""A function that receives a message and its arrival time (s, `time.monotonic`).

The message is CDR with encapsulation header. The function is called in another thread.
"""
Publish: TypeAlias = Callable[[bytes], None]
"""A function that sends a message, given as CDR with encapsulation header."""


Answered: TypeAlias = Callable[[bytes | None], None]
"""A function that receives the answer to a request, or None if there is none.

It is called once, in another thread.
"""


class WireType(NamedTuple):
    """A type that is known by its definition: its ROS 2 name, such as std_srvs/srv/Trigger, and its hash (REP 2016)."""

    name: str
    hash: str


class Publisher(NamedTuple):
    """A publisher of another process: its topic and message type."""

    topic: str
    type: str


@runtime_checkable
class Transport(Protocol):
    """The interface of a transport, which carries messages between this program and a robot.

    Topics (`/rover/odom`) and types (`nav_msgs/msg/Odometry`) are named as in ROS 2, and messages are CDR with
    encapsulation header. Methods may be called from several threads at once, and do not wait for the robot: what
    arrives is passed on in a thread of the transport. What cannot be sent is lost without an error. A transport is made
    by a function from a `RobotFile`, which raises `Unreachable` if it cannot be joined.
    """

    def subscribe(self, topic: str, type: str, received: Received, *, kept: bool = False) -> None:
        """Pass each message of a topic on, until the transport is closed.

        Parameters
        ----------
        topic
            Full name of the topic.
        type
            Name of the type of its messages.
        received
            Function that is called with each message and its arrival time, in a thread of the transport. It is quick.
        kept
            Whether messages count, too, that publishers sent before and keep for who comes late, as on /tf_static.
        """
        ...

    def publisher(self, topic: str, type: str) -> Publish:
        """Make a function that publishes on a topic.

        Parameters
        ----------
        topic
            Full name of the topic.
        type
            Name of the type of its messages.

        Returns
        -------
        Publish
            The function. It may be called in any thread, and after `close`, when it does nothing or raises an error.
        """
        ...

    def call(
        self, service: str, type: WireType, request: bytes, answered: Answered, *, timeout_s: float
    ) -> None:
        """Send a request to a service, and pass its answer on.

        Parameters
        ----------
        service
            Full name of the service.
        type
            Type of the request or of the service.
        request
            The request, CDR with encapsulation header.
        answered
            Function that is called once: with the answer, CDR with encapsulation header; or with None, at once if there
            is no server, when the server leaves, and after the timeout.
        timeout_s
            Longest time to wait for the answer, s.
        """
        ...

    def watch(self, topic: str, type: WireType, received: Received) -> None:
        """Pass each message of a topic on whose type is defined by the robot's own files.

        Parameters
        ----------
        topic
            Full name of the topic.
        type
            Type of its messages.
        received
            Function that is called with each message and its arrival time, in a thread of the transport.
        """
        ...

    def find_service_problem(self, service: str, type: WireType) -> str:
        """Find out why requests cannot reach a service now; the first call may begin to connect to it.

        Parameters
        ----------
        service
            Full name of the service.
        type
            Type of the request or of the service.

        Returns
        -------
        str
            The reason as a sentence; empty if they can reach it.
        """
        ...

    def peers(self) -> Sequence[Publisher]:
        """List the publishers of other processes that have been discovered.

        Returns
        -------
        sequence of Publisher
            An entry for each.
        """
        ...

    def close(self) -> None:
        """Disconnect; nothing is received afterwards. A second call does nothing."""
        ...


class TransportWrapper:
    """A transport that passes everything on to another one; subclasses do something besides."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport

    def subscribe(self, topic: str, type: str, received: Received, *, kept: bool = False) -> None:
        """Pass each message of a topic to `received` until the transport is closed."""
        self._transport.subscribe(topic, type, received, kept=kept)

    def publisher(self, topic: str, type: str) -> Publish:
        """Make a function that publishes on a topic."""
        return self._transport.publisher(topic, type)

    def call(
        self, service: str, type: WireType, request: bytes, answered: Answered, *, timeout_s: float
    ) -> None:
        """Send a request to a service, and pass its answer to `answered`; None if there is none."""
        self._transport.call(service, type, request, answered, timeout_s=timeout_s)

    def watch(self, topic: str, type: WireType, received: Received) -> None:
        """Pass each message of a topic to `received`; the message type is one that the robot's own files define."""
        self._transport.watch(topic, type, received)

    def find_service_problem(self, service: str, type: WireType) -> str:
        """Return why requests of this type cannot reach a service now; empty if they can."""
        return self._transport.find_service_problem(service, type)

    def peers(self) -> Sequence[Publisher]:
        """List the publishers of other processes that have been discovered."""
        return self._transport.peers()

    def close(self) -> None:
        """Disconnect; nothing is received afterwards."""
        self._transport.close()


class Unreachable(UnderstudyError, json_type="Unreachable"):
    """A transport that cannot be joined."""

    def __init__(self, *, what: str, problem: str, remedy: str) -> None:
        self.what, self.problem, self.remedy = what, problem, remedy
        super().__init__(f"{what} cannot be joined: {problem}; {remedy}")


BUILTIN_TRANSPORTS: Mapping[str, str] = {
    "dds": "understudy.addons.robots.ros.dds.open_dds",
    "zenoh": "understudy.addons.robots.ros.zenoh.open_zenoh",
}
"""The place of the function that opens each built-in transport, by its name in robot files."""


def list_transports() -> list[str]:
    """List the names that robot files may give for a transport: the built-in ones, and those of installed packages."""
    return list(dict.fromkeys([*BUILTIN_TRANSPORTS, *list_entry_points(TRANSPORTS)]))
