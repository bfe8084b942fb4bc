"""DDS: names and descriptions of types, bytes as rosbags writes them. Over a network: test_transport."""

from __future__ import annotations

import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")
pytest.importorskip("rosbags", reason="needs the extra ros2")

from tests.robots.rovers import ODOMETRY, RANGE, STAMPED, TWIST, odometry, sonar

from understudy.addons.robots.ros.dds import make_dds_type
from understudy.records.messages import (
    convert_to_dds_name,
    convert_to_ros_name,
    decode_message,
    encode_message,
    encode_twist,
    is_known_type,
    make_message,
)

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
