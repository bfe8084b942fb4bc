"""The Zenoh transport, compatible with rmw_zenoh of ROS 2 Jazzy, Kilted, Lyrical and Rolling, and of Humble.

Humble differs in that its types have no hash.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import struct
import time
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import blake2b
from threading import Event, RLock, Thread, main_thread
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

from understudy.addons.robots.ros.transport import (
    Answered,
    Publish,
    Publisher,
    Received,
    Unreachable,
    WireType,
)
from understudy.addons.robots.ros.zenoh_services import ServiceCalls, make_service_key
from understudy.clock import REAL_TIME, Clock
from understudy.extras import ExtraMissing
from understudy.records.messages import (
    LONGEST_IMAGE,
    convert_to_dds_name,
    convert_to_ros_name,
    list_type_releases,
    load_typestore,
    make_hashable,
)

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

    from understudy.addons.robots.robot_file import RobotFile

EndpointKind: TypeAlias = Literal["MP", "MS", "SS"]
"""The kind of endpoint that a liveliness token declares: a publisher of messages, a subscriber, or a service."""
KINDS: Sequence[EndpointKind] = ("MP", "MS", "SS")

SPACE = "@ros2_lv"
"""The first part of all liveliness tokens of ROS 2; wildcards in other keys do not match it."""
UNHASHED = "TypeHashNotSupported"
"""The placeholder for the hash of a type in ROS 2 Humble, where types have none."""
NAME = "understudy"
"""The name of our node in `ros2 node list`."""
NOTHING = "%"
"""The encoding of an empty enclave or namespace."""
PARTS = 13
"""The number of parts of the token of a publisher or subscriber."""
ATTACHED = struct.Struct("<qqB16s")
"""The layout of an attachment: sequence number, time (ns since 1970), length of the id, id."""


class Endpoint(NamedTuple):
    """A publisher, subscriber or service: its session, kind, topic (or name), type and hash of the type."""

    session: str
    kind: EndpointKind
    topic: str
    type: str
    hash: str


@dataclass(frozen=True, slots=True)
class ZenohSession:
    """A Zenoh session: its ROS 2 domain, and its id as Zenoh prints it."""

    domain: int
    id: str

    def node(self) -> str:
        """Return the liveliness token of the session's only node."""
        return "/".join((SPACE, str(self.domain), self.id, "0", "0", "NN", NOTHING, NOTHING, NAME))

    def token(self, number: int, kind: EndpointKind, *, topic: str, type: str, depth: int) -> str:
        """Return the liveliness token of a publisher or subscriber of this session.

        `number` is unique in the session. Its quality of service is ROS 2's default except for `depth`.
        """
        node = (SPACE, str(self.domain), self.id, "0", str(number), kind, NOTHING, NOTHING, NAME)
        return "/".join(
            (
                *node,
                mangle_name(topic),
                convert_to_dds_name(type),
                hash_type_definition(type),
                f"::,{depth}:,:,:,,",
            )
        )


def make_domain_key(domain: int) -> str:
    """Return the key expression that matches all liveliness tokens of a domain."""
    return f"{SPACE}/{domain}/**"


def make_topic_keys(domain: int, topic: str, type: str) -> Sequence[str]:
    """Return the keys of a topic: that of ROS 2 since Jazzy, then that of Humble."""
    before = f"{domain}/{topic.strip('/')}/{convert_to_dds_name(type)}"
    return tuple(f"{before}/{last}" for last in (hash_type_definition(type), UNHASHED))


def hash_type_definition(type: str, typestore: Typestore | None = None) -> str:
    """Compute the hash of a type's definition (REP 2016).

    The definition is taken from `typestore`; by default from the newest release that has the type.
    """
    text: str = make_hashable(typestore or load_typestore(list_type_releases(type)[0])).hash_rihs01(type)
    return text


def parse_liveliness_token(token: str) -> Endpoint | None:
    """Return the endpoint that a token declares, or None if it declares something else, such as a node."""
    parts = token.split("/")
    kind = next((each for each in KINDS if parts[5:6] == [each]), None)
    if len(parts) != PARTS or parts[0] != SPACE or kind is None:
        return None
    topic, type, last = (part.replace("%", "/") for part in parts[9:12])
    return Endpoint(parts[2], kind, topic, convert_to_ros_name(type), last)


def mangle_name(name: str) -> str:
    """Encode a name as one part of a key, by replacing slashes."""
    return name.replace("/", "%")


def make_attachment(number: int, time_ns: int, token: str) -> bytes:
    """Make the attachment of a publisher's message, which ROS 2 requires.

    `number` is the sequence number of the message, and `token` the liveliness token of the publisher.
    """
    return ATTACHED.pack(number, time_ns, 16, blake2b(token.encode(), digest_size=16).digest())


ROUTER = "tcp/localhost:7447"
"""The address of the ROS 2 router on the local machine."""
WAIT_MS = 3000
"""The time within which a router must answer, in ms."""
MOST_TOKENS = 4096
"""The largest number of other endpoints that are stored, so that a flood of tokens cannot fill the memory."""
BEAT_S = 0.2
"""The time between two checks whether the program has ended, in s."""
NEWEST = 1
"""The history depth that publishers declare; none is actually stored."""
WAITING = 4
"""The history depth that subscribers declare."""


class ZenohTransport:
    """A Zenoh session in a domain of ROS 2, whose messages arrive in threads of Zenoh.

    It connects to the given `router`, such as `tcp/192.168.0.5:7447`, or to that of this machine. With `listen`,
    others may connect to that endpoint directly, and no router of this machine is needed. Messages are stamped by
    `clock` on arrival. ExtraMissing is raised if Zenoh is not installed, and Unreachable if no router answers.
    """

    def __init__(
        self,
        domain: int = 0,
        router: str | None = None,
        *,
        listen: str | None = None,
        clock: Clock = REAL_TIME,
    ) -> None:
        try:
            import zenoh
        except ImportError:
            raise ExtraMissing(what="the transport zenoh", extra="ros2") from None
        self._zenoh: Any = zenoh
        try:
            self._session: Any = zenoh.open(_settings(zenoh, router, listen))
        except zenoh.ZError as error:
            where = router or ROUTER
            problem = str(error).split(" at /")[0]  # it tells where it was compiled
            remedy = "start it (ros2 run rmw_zenoh_cpp rmw_zenohd), or correct `router` in the robot's file"
            raise Unreachable(what=f"Zenoh's router {where}", problem=problem, remedy=remedy) from error
        self._domain, self._id = domain, str(self._session.zid())
        self._own = ZenohSession(domain, self._id)
        self._lock, self._closed = RLock(), False  # reentrant: a callback may publish
        self._left, self._clock = Event(), clock
        self._others: dict[str, Endpoint] = {}
        self._declared: list[Any] = []
        self._heard: list[Any] = []
        self._publishers: list[Any] = []
        self._calls = ServiceCalls(zenoh, self._session, domain)
        self._declare_token(self._own.node())
        watched = self._session.liveliness().declare_subscriber(
            make_domain_key(domain), self._appeared, history=True
        )
        self._heard.append(watched)
        atexit.register(self.close)
        Thread(target=self._listen_to_the_end, name="zenoh").start()

    def subscribe(self, topic: str, type: str, received: Received, *, kept: bool = False) -> None:
        """Pass each message of a topic to `received`, from any supported release of ROS 2.

        With `kept`, also those that publishers keep, which Humble's do not offer in the way of later releases.
        """
        for key in make_topic_keys(self._domain, topic, type):
            self._listen(key, received, kept=kept)
        self._declare_token(self._own.token(self._number(), "MS", topic=topic, type=type, depth=WAITING))

    def watch(self, topic: str, type: WireType, received: Received) -> None:
        """Pass each message of a topic to `received`; the message type is one that the robot's own files define."""
        for last in (type.hash, UNHASHED):
            self._listen(make_service_key(self._domain, topic, type.name, last), received)

    def _listen(self, key: str, received: Received, *, kept: bool = False) -> None:
        def came(sample: Any) -> None:
            if not self._closed and sample.kind == self._zenoh.SampleKind.PUT:
                received(bytes(sample.payload), self._clock())

        if kept:
            from zenoh import ext

            history = ext.HistoryConfig(detect_late_publishers=True)
            self._heard.append(ext.declare_advanced_subscriber(self._session, key, came, history=history))
        else:
            self._heard.append(self._session.declare_subscriber(key, came))

    def call(
        self, service: str, type: WireType, request: bytes, answered: Answered, *, timeout_s: float
    ) -> None:
        """Send a request to a service, and pass its answer to `answered`; None if there is none."""
        server = self._find_server(service)
        if server is None or self.find_service_problem(service, type):
            answered(None)
        else:
            key = make_service_key(self._domain, service, type.name, server.hash)
            self._calls.call(key, request, answered, timeout_s=timeout_s)

    def find_service_problem(self, service: str, type: WireType) -> str:
        """Return why requests of this type cannot reach a service now; empty if they can."""
        server = self._find_server(service)
        if server is None:
            return f"nobody offers {service}"
        if server.type != type.name:
            return f"{service} is of type {server.type}, not {type.name}"
        if server.hash not in (type.hash, UNHASHED):
            return f"{service} has another definition of {type.name} than the robot's file"
        return ""

    def _find_server(self, service: str) -> Endpoint | None:
        named = (each for each in list(self._others.values()) if each.topic == service)
        return next((each for each in named if each.kind == "SS"), None)

    def publisher(self, topic: str, type: str) -> Publish:
        """Make a function that publishes on a topic, for any supported release of ROS 2.

        Once the transport is closed, the function does nothing.
        """
        zenoh = self._zenoh
        token = self._own.token(self._number(), "MP", topic=topic, type=type, depth=NEWEST)
        # ROS 2 Humble knows other keys. Who listens to both gets nothing twice: its token has a hash.
        for_hashed, for_unhashed = (
            self._session.declare_publisher(
                key,
                congestion_control=zenoh.CongestionControl.DROP,  # a command that is late is worth nothing
                reliability=zenoh.Reliability.RELIABLE,
                express=True,
            )
            for key in make_topic_keys(self._domain, topic, type)
        )
        self._publishers += [for_hashed, for_unhashed]
        self._declare_token(token)
        sent = 0

        def publish(data: bytes) -> None:
            nonlocal sent
            with self._lock:
                if self._closed:
                    return
                sent += 1
                about = make_attachment(sent, time.time_ns(), token)
                for_hashed.put(data, attachment=about)
                if self._humble_listens(topic):
                    for_unhashed.put(data, attachment=about)

        return publish

    def peers(self) -> Sequence[Publisher]:
        """List all other publishers in the domain that have been discovered."""
        return [Publisher(each.topic, each.type) for each in list(self._others.values()) if each.kind == "MP"]

    def close(self) -> None:
        """Close the session; nothing is received afterwards."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
        self._left.set()
        atexit.unregister(self.close)
        self._calls.close()
        for each in (*self._heard, *self._publishers, *reversed(self._declared)):
            with contextlib.suppress(self._zenoh.ZError):
                each.undeclare()
        self._session.close()

    def _listen_to_the_end(self) -> None:
        """Undeclare the subscribers once the main thread ends; their callback threads would keep the program alive.

        Messages sent at the very end, such as a stop, still go out. If Zenoh called back in its receiving threads
        instead, they could deadlock with Python's global lock.
        """
        while main_thread().is_alive():
            if self._clock.wait(self._left, BEAT_S):
                return
        self._calls.cancel()
        for each in self._heard:
            with contextlib.suppress(self._zenoh.ZError):
                each.undeclare()

    def _number(self) -> int:
        return len(self._declared)

    def _declare_token(self, key: str) -> None:
        self._declared.append(self._session.liveliness().declare_token(key))

    def _appeared(self, sample: Any) -> None:
        """Update the list of other endpoints when one appears or leaves."""
        key = str(sample.key_expr)
        if sample.kind == self._zenoh.SampleKind.DELETE:
            self._others.pop(key, None)
        elif len(self._others) < MOST_TOKENS:
            endpoint = parse_liveliness_token(key)
            if endpoint is not None and endpoint.session != self._id:
                self._others[key] = endpoint

    def _humble_listens(self, topic: str) -> bool:
        return any(
            (each.kind, each.topic, each.hash) == ("MS", topic, UNHASHED)
            for each in list(self._others.values())
        )


def open_zenoh(file: RobotFile) -> ZenohTransport:
    """Join the domain of a robot by its router."""
    return ZenohTransport(file.domain, file.router)


def _settings(zenoh: Any, router: str | None, listen: str | None) -> Any:
    """Make the session's configuration with ROS 2's defaults: no multicast, direct connections to other nodes."""
    endpoints = [router] if router else [] if listen else [ROUTER]
    config = zenoh.Config()
    for key, value in {
        "mode": "client" if router and not listen else "peer",
        "connect/endpoints": endpoints,
        "connect/timeout_ms": WAIT_MS,
        "connect/exit_on_failure": True,
        "listen/endpoints": [listen] if listen else ["tcp/localhost:0"],
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": True,
        "transport/shared_memory/enabled": False,
        "transport/link/rx/max_message_size": LONGEST_IMAGE,
    }.items():
        config.insert_json5(key, json.dumps(value))
    return config
