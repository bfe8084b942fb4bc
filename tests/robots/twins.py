"""Robots of the arena and their twin, over wires in memory and by a clock that tests set."""

from __future__ import annotations

from dataclasses import dataclass, field

from tests.robots.rigs import Timed
from tests.robots.rovers import Wire, odometry

from understudy.addons.robots.fleet import Fleet
from understudy.addons.robots.robot import Robot
from understudy.addons.robots.robot_file import parse_robot
from understudy.addons.robots.twin import DigitalTwin
from understudy.records.messages import decode_message
from understudy.records.recorder import RunRecorder

ARENA = """
format = "understudy-robot/1"
name = "{name}"
world = "{world}"
namespace = "/{name}"
tick_s = 0.1

[limits]
speed_m_s = 0.5
turn_rad_s = 1.0
geofence = [-1, -2, 3, 2]

[readings]
x = {{ topic = "odom", type = "nav_msgs/msg/Odometry", field = "pose.pose.position.x" }}
y = {{ topic = "odom", type = "nav_msgs/msg/Odometry", field = "pose.pose.position.y" }}
heading = {{ topic = "odom", type = "nav_msgs/msg/Odometry", field = "pose.pose.orientation" }}

[targets.red_flag]
at = [2.0, 0.0]

[commands]
drive_m_s = 0.4
turn_rad_s = 1.0
"""


@dataclass
class Rig(Timed):
    """Two robots, each on a wire of its own, and their twin."""

    names: tuple[str, ...] = ("one", "two")
    world: str = "arena"
    wires: list[Wire] = field(default_factory=list)
    recorder: RunRecorder | None = None

    def __post_init__(self) -> None:
        self.wires = [Wire() for _ in self.names]
        self.robots = [
            Robot(parse_robot(ARENA.format(name=name, world=self.world)), wire, clock=self.clock)
            for name, wire in zip(self.names, self.wires, strict=True)
        ]
        self.twin = DigitalTwin(Fleet(self.robots), recorder=self.recorder)

    def hear(self, agent: int, data: bytes) -> None:
        self.last = data
        self.wires[agent].deliver(f"/{self.names[agent]}/odom", data, self.now)

    def sent(self, agent: int) -> tuple[float, float]:
        """What a robot was told last: m/s and rad/s; nothing is to stand still."""
        sent = [data for topic, data in self.wires[agent].sent if topic.endswith("/cmd_vel")]
        if not sent:
            return 0.0, 0.0
        twist = decode_message("geometry_msgs/msg/Twist", sent[-1])
        return twist.linear.x, twist.angular.z

    odometry = staticmethod(odometry)

    def send_odometry(self, data: bytes | None = None) -> None:
        """Odometry of all, at the origin if nothing else is said."""
        for agent in range(len(self.names)):
            self.hear(agent, data or odometry(0.0))
