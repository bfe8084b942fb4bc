"""Requests to services over DDS, as rmw_cyclonedds of ROS 2 sends them: an id of 16 bytes before the message.

Other implementations (Fast DDS, the default of most releases) carry the id beside the message, in inline QoS, which
Cyclone DDS for Python cannot write; a request as sent here can make such a server reserve all its memory. So a request
is only sent if every reader of its topic says in its user data that it is a service of rmw_cyclonedds (`serviceid=`).
"""

from __future__ import annotations

import os
import struct
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from threading import Lock
from typing import Any

from understudy.addons.robots.ros.transport import Answered, Received, WireType
from understudy.records.messages import convert_to_dds_name, convert_to_ros_name

PREFIX = "rq"
"""The prefix of topics of requests."""
ID = struct.Struct("<Qq")
"""The layout of the id: client, and sequence number. It follows the encapsulation header."""
HEAD = 4
"""The size of the encapsulation header in bytes."""
SERVICE = b"serviceid="
"""The beginning of the user data of services of rmw_cyclonedds."""
MOST = 4096
"""The largest number of endpoints that are read at once."""
DEPTH = 10
"""The number of messages that are stored, as for services in ROS 2."""
ELSEWHERE = "runs on another DDS than Cyclone, which would not understand a request"
REMEDY = 'start the robot with rmw_zenoh_cpp, and give transport = "zenoh"'


@dataclass
class ServiceEndpoints:
    """The writer of requests of one service, and those requests that are not answered: until when (s), and to whom."""

    writer: Any
    raw: Any
    pending: dict[int, tuple[float, Answered]] = field(default_factory=dict)


class DdsServices:
    """The services that a participant calls.

    `listen` makes a reader of a topic with a quality of service, and passes its messages on in the thread of the
    transport, which also calls `expire` several times a second.
    """

    def __init__(
        self,
        participant: Any,
        listen: Callable[[Any, Any, Received], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsSubscription

        self._participant, self._listen, self._clock = participant, listen, clock
        self._subscriptions = BuiltinDataReader(participant, BuiltinTopicDcpsSubscription)
        self._changes, self._gone, self._alive = make_conditions(self._subscriptions)
        self._readers: Sequence[Any] = ()
        self._asking = Lock()
        self._client, self._sent = int.from_bytes(os.urandom(8), "little"), 0
        self._endpoints: dict[str, ServiceEndpoints] = {}
        self._lock = Lock()

    def find_problem(self, service: str, type: WireType) -> str:
        """Return why requests cannot reach a service now; empty if they can. The first call connects to it."""
        endpoints = self._connect(service, type)
        topic = f"{PREFIX}{service}Request"
        readers = [end for end in self._list_readers() if end.topic_name == topic]
        if not readers:
            return f"nobody offers {service}"
        wanted = convert_to_dds_name(f"{type.name}_Request")
        for end in readers:
            if end.type_name != wanted:
                type_name = convert_to_ros_name(end.type_name).removesuffix("_Request")
                return f"{service} is of type {type_name}, not {type.name}"
            if not _read_user_data(end).startswith(SERVICE):
                return f"{service} {ELSEWHERE}; {REMEDY}"
        if not endpoints.writer.get_matched_subscriptions():
            return f"{service} is not connected yet"
        return ""

    def call(
        self, service: str, type: WireType, request: bytes, answered: Answered, *, timeout_s: float
    ) -> None:
        """Send a request to a service, and pass its answer to `answered`; None if there is none."""
        if self.find_problem(service, type):
            answered(None)
            return
        endpoints = self._connect(service, type)
        with self._lock:
            self._sent += 1
            number = self._sent
            endpoints.pending[number] = self._clock() + timeout_s, answered
        message = endpoints.raw.__new__(endpoints.raw)
        message.data = request[:HEAD] + ID.pack(self._client, number) + request[HEAD:]
        endpoints.writer.write(message)

    def expire(self, now: float) -> None:
        """Answer the requests with None whose time is over, or whose server has left."""
        for endpoints in list(self._endpoints.values()):
            if endpoints.pending:
                left = not endpoints.writer.get_matched_subscriptions()
                with self._lock:
                    over = [number for number, (due, _) in endpoints.pending.items() if left or now > due]
                    answers = [endpoints.pending.pop(number)[1] for number in over]
                for answered in answers:
                    answered(None)

    def close(self) -> None:
        """Release the entities of the domain."""
        self._endpoints.clear()
        del self._changes, self._gone, self._alive, self._subscriptions, self._participant

    def _list_readers(self) -> Sequence[Any]:
        """List the discovered readers of requests to services; the list is renewed if any came or left."""
        with self._asking:
            if self._changes.triggered:
                self._subscriptions.take(N=MOST, condition=self._gone)
                endpoints = self._subscriptions.read(N=MOST, condition=self._alive)
                self._readers = [end for end in endpoints if end.topic_name.startswith(PREFIX)]
            return self._readers

    def _connect(self, service: str, type: WireType) -> ServiceEndpoints:
        """Make the writer of requests and the reader of answers, once for each service."""
        from cyclonedds.core import Policy, Qos
        from cyclonedds.pub import DataWriter
        from cyclonedds.topic import Topic
        from cyclonedds.util import duration

        with self._lock:
            if service in self._endpoints:
                return self._endpoints[service]
            parts = ".".join(f"{byte:x}" for byte in self._client.to_bytes(16, "little"))
            quality = Qos(
                Policy.Reliability.Reliable(duration(milliseconds=100)),
                Policy.History.KeepLast(DEPTH),
                Policy.Userdata(data=f"clientid={parts};".encode()),
            )
            sent, heard = (
                make_raw_type(f"{type.name}_{part}", header=ID.size) for part in ("Request", "Response")
            )
            requests = Topic(self._participant, f"{PREFIX}{service}Request", sent)
            answers = Topic(self._participant, f"rr{service}Reply", heard)
            endpoints = ServiceEndpoints(DataWriter(self._participant, requests, qos=quality), sent)
            self._endpoints[service] = endpoints

        def came(data: bytes, at_s: float) -> None:
            client, number = ID.unpack_from(data, HEAD)
            with self._lock:
                request = endpoints.pending.pop(number, None) if client == self._client else None
            if request is not None:
                request[1](data[:HEAD] + data[HEAD + ID.size :])

        self._listen(answers, quality, came)
        return endpoints


def _read_user_data(endpoint: Any) -> bytes:
    from cyclonedds.core import Policy

    policy = endpoint.qos[Policy.Userdata]
    return b"" if policy is None else bytes(policy.data)


def make_conditions(reader: Any) -> tuple[Any, Any, Any]:
    """Make the read conditions for changes of a reader, for endpoints that are gone, and for those that are alive."""
    from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState

    gone = InstanceState.NotAliveDisposed | InstanceState.NotAliveNoWriters
    return (
        ReadCondition(reader, ViewState.Any | InstanceState.Any | SampleState.NotRead),
        ReadCondition(reader, ViewState.Any | gone | SampleState.Any),
        ReadCondition(reader, ViewState.Any | InstanceState.Alive | SampleState.Any),
    )


@cache
def make_raw_type(type: str, *, header: int) -> Any:
    """Make a DDS type whose messages are raw bytes in `data`, of which only the first `header` bytes are described.

    Endpoints of ROS 2 compare names of types only.
    """
    from cyclonedds.idl import make_idl_struct, types

    idl: Any = types
    name = convert_to_dds_name(type)
    fields = {"header": idl.array[idl.uint64, header // 8]}
    return carry_bytes(make_idl_struct(name.rpartition("::")[2], name, fields))


def carry_bytes(described: Any) -> Any:
    """Let messages of a DDS type be raw bytes in `data`, which are neither encoded nor decoded."""

    def serialize(self: Any, **_: Any) -> bytes:
        data: bytes = self.data
        return data

    def deserialize(cls: Any, data: bytes, /, **_: Any) -> Any:
        message = cls.__new__(cls)
        message.data = bytes(data)
        return message

    described.serialize = serialize
    described.deserialize = described.deserialize_key = classmethod(deserialize)
    return described
