"""DDS: names and descriptions of types, bytes as rosbags writes them. What all transports do: test_transports."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from itertools import count
from typing import Any

import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import ODOMETRY, RANGE, STAMPED, TWIST, odometry, sonar

from understudy.robots.ros.dds import DdsTransport, make_dds_type
from understudy.robots.ros.messages import (
    convert_to_dds_name,
    convert_to_ros_name,
    decode_message,
    encode_message,
    encode_twist,
    is_known_type,
    make_message,
)
from understudy.robots.ros.transport import Publisher

NUMBERS = count()
NAMES = [
    ("sensor_msgs/msg/Range", "sensor_msgs::msg::dds_::Range_"),
    ("builtin_interfaces/msg/Time", "builtin_interfaces::msg::dds_::Time_"),
]
TYPES = [
    "sensor_msgs/msg/Range",
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/CompressedImage",
    "sensor_msgs/msg/BatteryState",
    "nav_msgs/msg/Odometry",
    "geometry_msgs/msg/Twist",
    "geometry_msgs/msg/TwistStamped",
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "std_msgs/msg/Bool",
    "std_msgs/msg/Empty",
    "std_msgs/msg/Float64",
    "std_msgs/msg/String",
]


BYTES = [
    (RANGE, sonar(1.5)),
    (ODOMETRY, odometry(2.0, z=0.6, w=0.8)),
    (TWIST, encode_twist(TWIST, speed_m_s=0.3, turn_rad_s=-0.2)),
    (STAMPED, encode_twist(STAMPED, speed_m_s=0.3, turn_rad_s=-0.2, frame="base", time_s=1.5)),
]


def wait_for(what: Callable[[], object], seconds: float = 10.0) -> None:
    until = time.monotonic() + seconds
    while not what():
        assert time.monotonic() < until, "it never came"
        time.sleep(0.01)


@pytest.fixture
def namespace() -> str:
    """One that no other test uses, of those that run beside this one."""
    return f"/rover_{os.getpid()}_{next(NUMBERS)}"


@pytest.mark.parametrize(("ros", "dds"), NAMES)
def test_types_are_named_as_ros_does(ros: str, dds: str) -> None:
    assert (convert_to_dds_name(ros), convert_to_ros_name(dds)) == (dds, ros)


@pytest.mark.parametrize("type", TYPES)
def test_every_type_can_be_described(type: str) -> None:
    assert is_known_type(type)
    assert make_dds_type(type).__idl_typename__.replace(".", "::") == convert_to_dds_name(type)
    assert decode_message(type, encode_message(type, make_message(type))) is not None


@pytest.mark.parametrize(("type", "data"), BYTES, ids=[type for type, _ in BYTES])
def test_bytes_are_those_that_cyclone_writes(type: str, data: bytes) -> None:
    """What rosbags encodes, Cyclone DDS encodes alike from its own description of the type."""
    assert (
        bytes(make_dds_type(type).__idl__.serialize(decode_message(type, data), use_version_2=False)) == data
    )


def test_a_plain_program_on_cyclone_reads_our_commands(namespace: str) -> None:
    """One that knows nothing of us: types written by hand, names as ROS 2 gives them."""
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.idl.types import float64
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    vector = make_idl_struct(
        "Vector3_", "geometry_msgs::msg::dds_::Vector3_", {"x": float64, "y": float64, "z": float64}
    )
    plain = make_idl_struct(
        "Twist_", "geometry_msgs::msg::dds_::Twist_", {"linear": vector, "angular": vector}
    )
    participant, ours = DomainParticipant(43), DdsTransport(43)
    try:
        reader = DataReader(participant, Topic(participant, f"rt{namespace}/cmd_vel", plain))
        publish, came = ours.publisher(f"{namespace}/cmd_vel", TWIST), list[Any]()

        def arrived() -> bool:
            publish(encode_twist(TWIST, speed_m_s=0.4, turn_rad_s=-0.5))
            came.extend(reader.take(N=1))
            return bool(came)

        wait_for(arrived)
        assert (came[0].linear.x, came[0].linear.y, came[0].angular.z) == (0.4, 0.0, -0.5)
    finally:
        ours.close()


def test_others_are_gone_through_only_when_one_comes_or_goes(monkeypatch: pytest.MonkeyPatch) -> None:
    """There may be hundreds, and they are asked for several times a second."""
    one, two = DdsTransport(65), DdsTransport(65)
    try:
        two.publisher("/a", TWIST)
        wait_for(lambda: one.peers() == [Publisher("/a", TWIST)])
        reads, read = list[int](), one._publications.read

        def counted(**asked: Any) -> Any:
            reads.append(1)
            return read(**asked)

        monkeypatch.setattr(one._publications, "read", counted)
        assert all(one.peers() == [Publisher("/a", TWIST)] for _ in range(20))
        assert not reads
        two.publisher("/b", TWIST)
        wait_for(lambda: {peer.topic for peer in one.peers()} == {"/a", "/b"})
        two.close()
        wait_for(lambda: not one.peers())
    finally:
        one.close()
        two.close()
