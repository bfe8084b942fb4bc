"""A robot for tests: its file, a transport that carries nothing away, messages with numbers to check by hand."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from understudy.addons.robots.ros.transport import Answered, Publish, Publisher, Received, WireType
from understudy.records.messages import encode_message, make_message

RANGE, SCAN, ODOMETRY = "sensor_msgs/msg/Range", "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry"
TWIST, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"

ROVER = """
format = "understudy-robot/1"
name = "rover"
namespace = "/rover"
domain = 43
tick_s = 0.1

[limits]
speed_m_s = 0.5
turn_rad_s = 1.0

[readings.sonar_ahead]
topic = "sonar"
type = "sensor_msgs/msg/Range"
stale_s = 0.5
required = true

[readings.x]
topic = "odom"
type = "nav_msgs/msg/Odometry"
field = "pose.pose.position.x"
unit = "m"
stale_s = 1.0

[readings.heading]
topic = "odom"
type = "nav_msgs/msg/Odometry"
field = "pose.pose.orientation"
stale_s = 1.0

[commands]
drive_m_s = 0.4
turn_rad_s = 1.0
"""

TOO_BUSY = (
    "no command came",
    "this program stood still",
    "the watchdog",
    "a command was decided",
    "is absent",
    "no sign",
)
"""Parts of the causes that stop a robot whose computer is too busy, as may be where tests run."""


class Wire:
    """A transport in memory: `deliver` is the robot's side, `sent` what was published."""

    def __init__(self, peers: Sequence[Publisher] = ()) -> None:
        self.sent: list[tuple[str, bytes]] = []
        self.others = list(peers)
        self.closed = False
        self._received: dict[str, list[Received]] = {}

    def subscribe(self, topic: str, type: str, received: Received, *, kept: bool = False) -> None:
        self._received.setdefault(topic, []).append(received)

    def publisher(self, topic: str, type: str) -> Publish:
        return lambda data: self.sent.append((topic, data))

    def deliver(self, topic: str, data: bytes, at_s: float) -> None:
        for received in self._received[topic]:
            received(data, at_s)

    def call(
        self, service: str, type: WireType, request: bytes, answered: Answered, *, timeout_s: float
    ) -> None:
        """All services are there, and never answer."""
        self.sent.append((service, request))

    def watch(self, topic: str, type: WireType, received: Received) -> None:
        """Nothing comes."""

    def find_service_problem(self, service: str, type: WireType) -> str:
        return ""

    def peers(self) -> Sequence[Publisher]:
        return self.others

    def close(self) -> None:
        self.closed = True


def sonar(range_m: float) -> bytes:
    """A Range of a sonar that reaches from 0.1 to 3 m."""
    return encode_message(RANGE, make_message(RANGE, min_range=0.1, max_range=3.0, range=range_m))


def odometry(x: float, *, z: float = 0.0, w: float = 1.0) -> bytes:
    """An Odometry at (x, 0), turned about z as the quaternion says."""
    message: Any = make_message(ODOMETRY)
    message.pose.pose.position.x = x
    message.pose.pose.orientation.z, message.pose.pose.orientation.w = z, w
    return encode_message(ODOMETRY, message)
