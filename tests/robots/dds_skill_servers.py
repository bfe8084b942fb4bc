"""The servers of `skill_servers` on Cyclone DDS, as rmw_cyclonedds runs them; or as those of another DDS look."""

from __future__ import annotations

import struct
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from threading import Event, Thread
from typing import Any

from cyclonedds.core import DDSException, Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from tests.robots.domains import own_domain
from tests.robots.skill_servers import Server

from understudy.addons.robots.ros.dds_services import make_raw_type

POLL_S = 0.005
DOMAIN = own_domain()


@dataclass(frozen=True)
class Query:
    """A request without its id, and how it is answered."""

    id: bytes
    payload: bytes
    writer: Any
    type: Any


class DdsServer(Server):
    """Servers in a domain of these tests; `user_data` is what their readers say of themselves."""

    user_data = b"serviceid= 1.10.b2.0.0.0.0.0.0.0.0.0.0.0.0.1;"

    def _open(self, endpoint: str) -> None:
        self._participant, self._ended = DomainParticipant(DOMAIN), Event()
        self._answers: list[tuple[Any, Any, Any, Callable[[Any], None]]] = []
        self.taken = 0
        """The number of requests that arrived."""
        self._thread = Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _shut(self) -> None:
        self._ended.set()
        self._thread.join()
        self._answers.clear()
        self._kept.clear()
        del self._publish, self._participant

    def _quality(self) -> Qos:
        return Qos(
            Policy.Reliability.Reliable(duration(milliseconds=100)),
            Policy.History.KeepLast(10),
            Policy.Userdata(data=self.user_data),
        )

    def _publisher(self, topic: str, type: str, hash: str) -> Callable[[bytes], None]:
        raw = make_raw_type(_ros(type), header=16)
        writer = DataWriter(
            self._participant, Topic(self._participant, f"rt{topic}", raw), qos=self._quality()
        )
        return lambda data: _write(writer, raw, data)

    def _serve(self, name: str, type: str, hash: str, answer: Any) -> None:
        asked, said = (make_raw_type(_ros(f"{type}{part}_"), header=16) for part in ("Request", "Response"))
        reader = DataReader(
            self._participant, Topic(self._participant, f"rq{name}Request", asked), qos=self._quality()
        )
        writer = DataWriter(
            self._participant, Topic(self._participant, f"rr{name}Reply", said), qos=self._quality()
        )
        self._answers.append((reader, writer, said, answer))

    def _listen(self) -> None:
        while not self._ended.wait(POLL_S):
            for reader, writer, said, answer in list(self._answers):
                with suppress(DDSException):
                    for message in reader.take(N=8):
                        if isinstance(message, reader.topic.data_type):
                            self.taken += 1
                            data = message.data
                            answer(Query(data[4:20], data[:4] + data[20:], writer, said))

    def _answer(self, query: Any, data: bytes) -> None:
        struct.unpack("<Qq", query.id)
        _write(query.writer, query.type, data[:4] + query.id + data[4:])


class OtherServer(DdsServer):
    """Servers on another DDS, whose readers say nothing of themselves."""

    user_data = b""


def _write(writer: Any, raw: Any, data: bytes) -> None:
    message = raw.__new__(raw)
    message.data = data
    writer.write(message)


def _ros(type: str) -> str:
    """The name of a type in ROS 2, of which the transport makes that in DDS."""
    package, sort, _, name = type.split("::")
    return f"{package}/{sort}/{name.removesuffix('_')}"
