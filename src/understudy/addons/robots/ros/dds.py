"""The DDS transport, compatible with ROS 2: topics are named `rt/NAME`, types `PKG::msg::dds_::NAME_`.

Messages are passed on as bytes, without decoding them.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Sequence
from functools import cache
from threading import Lock, Thread
from typing import TYPE_CHECKING, Any

from understudy.addons.robots.ros.dds_services import DdsServices, carry_bytes, make_conditions, make_raw_type
from understudy.addons.robots.ros.transport import (
    Answered,
    Publish,
    Publisher,
    Received,
    Unreachable,
    WireType,
)
from understudy.extras import ExtraMissing
from understudy.records.messages import (
    ARRAY,
    BASE,
    JAZZY,
    NAMED,
    convert_to_dds_name,
    convert_to_ros_name,
    list_message_fields,
    list_type_releases,
)

if TYPE_CHECKING:
    from understudy.addons.robots.robot_file import RobotFile

PREFIX = "rt"
"""The prefix of topic names in DDS, by which ROS 2 distinguishes topics from services."""
BEAT_S = 0.2
"""The time between two checks of the receiving thread whether it should end, in s."""
MOST = 4096
"""The largest number of publishers that are read at once."""
KEPT = 100
"""The number of messages that are kept of each topic whose last messages late subscribers receive, as in tf2."""
GOAL_ID = 16
"""The size of the id of a goal, with which feedback begins, in bytes."""
GRAVE = 1 | 2
"""The log categories that are kept: fatal and other errors.

Cyclone DDS would also warn of each invalid message.
"""


class DdsTransport:
    """A participant in a DDS domain, with a thread that passes on received messages.

    Messages are stamped with `clock` (s) on arrival, and answers of services are awaited by it. ExtraMissing is raised
    if Cyclone DDS is not installed, and Unreachable if the domain cannot be joined.
    """

    def __init__(self, domain: int = 0, *, clock: Callable[[], float] = time.monotonic) -> None:
        try:
            from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
            from cyclonedds.core import DDSException, WaitSet
            from cyclonedds.domain import DomainParticipant
        except ImportError:
            raise ExtraMissing(what="the transport dds", extra="ros2") from None
        try:
            _quieten()
            self._participant = DomainParticipant(domain)
        except DDSException as error:
            remedy = "check that the network is up, and that CYCLONEDDS_URI, if set, matches it"
            raise Unreachable(what=f"domain {domain} of DDS", problem=str(error), remedy=remedy) from error
        self._clock = clock
        self._publications = BuiltinDataReader(self._participant, BuiltinTopicDcpsPublication)
        self._changes, self._gone, self._alive = make_conditions(self._publications)
        self._others: Sequence[Publisher] = ()
        self._asking = Lock()
        self._waits = WaitSet(self._participant)
        self._readers: list[tuple[Any, Received, dict[int, int] | None]] = []
        self._kept: list[Any] = []  # conditions live as long as they are waited for
        self._writers: list[Any] = []
        self._services = DdsServices(self._participant, self._listen, clock)
        self._closed = False
        self._thread = Thread(target=self._receive, name="dds", daemon=True)

    def subscribe(self, topic: str, type: str, received: Received, *, kept: bool = False) -> None:
        """Pass the newest messages of a topic to `received`, from reliable and best-effort publishers.

        With `kept`, only from publishers that are reliable and keep their messages.
        """
        from cyclonedds.core import Policy, Qos
        from cyclonedds.util import duration

        quality = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(4))
        if kept:
            reliable = Policy.Reliability.Reliable(duration(milliseconds=100))
            quality = Qos(reliable, Policy.Durability.TransientLocal, Policy.History.KeepLast(KEPT))
        # Cyclone DDS hands on nothing that is shorter than its description, so each release's is listened for; and
        # what fits several comes more than once, which the times of each publisher's last tell.
        last_times: dict[int, int] | None = {} if len(list_type_releases(type)) > 1 else None
        for release in list_type_releases(type):
            self._listen(self._topic(topic, type, release), quality, received, last_times)

    def watch(self, topic: str, type: WireType, received: Received) -> None:
        """Pass each message of a topic to `received`; the message type is one that the robot's own files define."""
        from cyclonedds.core import Policy, Qos
        from cyclonedds.topic import Topic

        named = Topic(self._participant, f"{PREFIX}{topic}", make_raw_type(type.name, header=GOAL_ID))
        self._listen(named, Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(4)), received)

    def call(
        self, service: str, type: WireType, request: bytes, answered: Answered, *, timeout_s: float
    ) -> None:
        """Send a request to a service on Cyclone DDS, and pass its answer to `answered`; None if there is none."""
        if not self._closed:
            self._services.call(service, type, request, answered, timeout_s=timeout_s)

    def find_service_problem(self, service: str, type: WireType) -> str:
        """Return why requests of this type cannot reach a service now; empty if they can."""
        if self._closed:
            return f"the connection to {service} is closed"
        return self._services.find_problem(service, type)

    def _listen(
        self, topic: Any, quality: Any, received: Received, last_times: dict[int, int] | None = None
    ) -> None:
        from cyclonedds.core import InstanceState, ReadCondition, SampleState, ViewState
        from cyclonedds.sub import DataReader

        reader = DataReader(self._participant, topic, qos=quality)
        condition = ReadCondition(reader, ViewState.Any | InstanceState.Any | SampleState.NotRead)
        self._kept.append(condition)
        self._readers.append((reader, received, last_times))  # before the thread can wake for it
        self._waits.attach(condition)
        if not self._thread.is_alive():  # not before: waiting for nothing does not wait
            self._thread.start()

    def publisher(self, topic: str, type: str) -> Publish:
        """Make a function that publishes on a topic, with reliable delivery of the last message (ROS 2's default).

        Once the transport is closed, the function does nothing.
        """
        from cyclonedds.core import Policy, Qos
        from cyclonedds.pub import DataWriter
        from cyclonedds.util import duration

        quality = Qos(Policy.Reliability.Reliable(duration(milliseconds=100)), Policy.History.KeepLast(1))
        named = self._topic(topic, type)
        raw, writer = named.data_type, DataWriter(self._participant, named, qos=quality)
        number = len(self._writers)
        self._writers.append(writer)
        del writer  # a participant leaves when no reference to its writers is left

        def publish(data: bytes) -> None:
            if self._writers:
                message = raw.__new__(raw)
                message.data = data
                self._writers[number].write(message)

        return publish

    def peers(self) -> Sequence[Publisher]:
        """List all other publishers of ROS 2 topics that have been discovered."""
        with self._asking:
            # Asked several times a second: to go through the hundreds that a robot may have takes a tenth of that.
            if self._changes.triggered:
                self._publications.take(N=MOST, condition=self._gone)
                endpoints = self._publications.read(N=MOST, condition=self._alive)
                own = self._participant.guid
                self._others = [
                    Publisher(end.topic_name.removeprefix(PREFIX), convert_to_ros_name(end.type_name))
                    for end in endpoints
                    if end.topic_name.startswith(f"{PREFIX}/") and end.participant_key != own
                ]
            return self._others

    def close(self) -> None:
        """Leave the domain; nothing is received afterwards."""
        if self._closed:
            return
        self._closed = True
        if self._thread.is_alive():
            self._thread.join()
        self._readers.clear()
        self._kept.clear()
        self._writers.clear()
        self._services.close()
        del self._services, self._changes, self._gone, self._alive
        del self._waits, self._publications, self._participant

    def _topic(self, topic: str, type: str, release: str = JAZZY) -> Any:
        from cyclonedds.topic import Topic

        return Topic(self._participant, f"{PREFIX}{topic}", make_dds_type(type, release))

    def _receive(self) -> None:
        from cyclonedds.core import DDSException
        from cyclonedds.util import duration

        beat = duration(seconds=BEAT_S)
        while not self._closed:
            with contextlib.suppress(DDSException):
                self._waits.wait(beat)
            now = self._clock()
            self._services.expire(now)
            for reader, received, last_times in list(self._readers):
                with contextlib.suppress(DDSException):
                    for message in reader.take(N=16):
                        # If not, a publisher has gone.
                        if isinstance(message, reader.topic.data_type) and _new(
                            message.sample_info, last_times
                        ):
                            received(message.data, now)


def open_dds(file: RobotFile) -> DdsTransport:
    """Join the domain of a robot."""
    return DdsTransport(file.domain)


@cache
def _quieten() -> None:
    """Suppress Cyclone DDS's warnings of invalid messages, with which anybody could fill a disk."""
    from cyclonedds.internal import DDS as Library

    library = getattr(Library, "_dll_handle", None)
    if library is not None and "CYCLONEDDS_URI" not in os.environ:
        library.dds_set_log_mask(GRAVE)


def _new(info: Any, last_times: dict[int, int] | None) -> bool:
    """Return whether a message is later than all earlier ones of its publisher."""
    if last_times is None:
        return True
    if info.source_timestamp <= last_times.get(info.publication_handle, -1):
        return False
    last_times[info.publication_handle] = info.source_timestamp
    return True


@cache
def make_dds_type(type: str, release: str = JAZZY) -> Any:
    """Make the DDS type of a topic: with its true description, but messages are raw bytes in `data`."""
    return carry_bytes(_described(type, release))


def _described(type: str, release: str) -> Any:
    """Make the DDS type that has the fields of a ROS 2 type."""
    from cyclonedds.idl import make_idl_struct, types

    idl: Any = types
    # What ROS 2 calls uint8, Cyclone DDS 0.10, which systems ship, calls a byte; other endpoints compare names only.
    numbers = {"bool": bool, "byte": idl.byte, "char": idl.byte, "uint8": idl.byte, "string": str}

    def one(node_type: int, of: Any) -> Any:
        if node_type == NAMED:
            return _described(of, release)
        if node_type == BASE:
            name, bound = of
            if name == "string" and bound:
                return idl.bounded_str[bound]
            return numbers[name] if name in numbers else getattr(idl, name)
        inner, length = of
        if node_type == ARRAY:
            return idl.array[one(*inner), length]
        return idl.sequence[one(*inner), length] if length else idl.sequence[one(*inner)]

    # ROS 2 gives a type without fields one, since IDL knows none such.
    inside = {name: one(*of) for name, of in list_message_fields(type, release).items()}
    inside = inside or {"structure_needs_at_least_one_member": idl.uint8}
    return make_idl_struct(f"{type.rpartition('/')[2]}_", convert_to_dds_name(type), inside)
